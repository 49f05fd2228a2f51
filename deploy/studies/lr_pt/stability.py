"""Do the curves stay where they were while robots fail and come back?

Source: Kobayashi et al. 2025, section V-F, Figures 19 and 20: normalised by the robots that are active, graph
idleness and mean SA delay "remained stable".
"""

from typing import NamedTuple

import numpy as np

from deploy.metrics.curves import Instant
from deploy.studies.outcomes import Outcome

STABLE = 0.15
"""Stable: the mean of a phase lies within so much of that before the failure."""
COLUMNS = {"graph_idleness_s": "graph idleness", "mean_sa_delay_s": "mean SA delay"}


class Phases(NamedTuple):
    """Means of a normalised curve, in seconds: before the failure, during it, after the recovery."""

    before_s: float
    during_s: float
    after_s: float

    @property
    def change(self) -> float:
        """The larger of the two departures from what was before, as a part of it."""
        departures = (self.during_s / self.before_s - 1, self.after_s / self.before_s - 1)
        return max(departures, key=abs)


def curve(outcome: Outcome, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Times in seconds and a curve normalised by the robots active then, in seconds: (samples,) each."""
    samples = outcome.tables["curves"]
    sites = len(outcome.scenario.field.sites_m())
    column = samples[:, Instant._fields.index(name)]
    return samples[:, 0] * outcome.scenario.tick_s, column * samples[:, -1] / sites


def phases(outcome: Outcome, name: str) -> Phases:
    """The means of the three phases. What each begins with, as long as `metrics_from_s`, is left out: the
    normalisation changes at once, idleness only with time.
    """
    time_s, value_s = curve(outcome, name)
    faults_s = [0.0, *(fault.at_s for fault in outcome.scenario.faults), np.inf]
    settling_s = outcome.scenario.metrics_from_s
    within = [
        (time_s >= begin_s + settling_s) & (time_s < end_s)
        for begin_s, end_s in zip(faults_s, faults_s[1:], strict=False)
    ]
    return Phases(*(float(value_s[one].mean()) for one in within))
