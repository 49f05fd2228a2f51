"""Who visited what how often: visits by phase, robot and site, for maps of a team's work.

A phase begins at `metrics_from_s` and at every planned fault after it, so that the maps of a run with
failures show the team before, during and after them (Kobayashi et al. 2025, Figures 9-14 and 21-24).
"""

from bisect import bisect_right
from collections.abc import Iterable

import numpy as np

from wire.scenario import Scenario


class VisitMap:
    """The fold. Feed it the ticks that have visits, in order."""

    def __init__(self, scenario: Scenario) -> None:
        from_tick = scenario.tick_of(scenario.metrics_from_s)
        struck = {scenario.tick_of(fault.at_s) for fault in scenario.faults}
        self.phase_ticks = [from_tick, *sorted(tick for tick in struck if tick > from_tick)]
        self._row = {robot: row for row, robot in enumerate(scenario.robot_ids)}
        shape = (len(self.phase_ticks), len(self._row), len(scenario.field.sites_m()))
        self.visits = np.zeros(shape, dtype=np.uint32)

    def feed(self, tick: int, visits: Iterable[tuple[str, int]]) -> None:
        """Take in the visits of one tick: (robot, site) of each."""
        phase = bisect_right(self.phase_ticks, tick) - 1
        if phase < 0:
            return
        for robot, site in visits:
            self.visits[phase, self._row[robot], site] += 1

    def tables(self) -> dict[str, np.ndarray]:
        """`phase_ticks`: when each phase begins, (phases,). `visits`: (phases, robots, sites)."""
        return {"phase_ticks": np.array(self.phase_ticks), "visits": self.visits}
