"""Idleness and delay of situation awareness, folded from facts.

Source: Kobayashi et al. 2025, equations 1-9. For site k at tick t, idleness is t minus the last true visit;
SA delay is t minus the last visit that the tower process has reported to know.

    graph idleness  = mean over time of (mean over sites of idleness)      worst = max over time of (max)
    mean SA delay   = mean over time of (mean over sites of SA delay)      worst = max over time of (max)
    normalised      = value * (N - 1) / K, N nodes with the tower, K sites

Means are over the ticks from `metrics_from_s` on. The paper prints 1/T where it sums T - t0 + 1 terms; we
divide by the number of terms. A site counts as visited at tick 0. Idleness as other papers define it is in
intervals.py, how long the tower waits for word of a visit in word_of_visits.py. `tables` gives what takes
more than numbers: visits by robot and site (visit_map.py) and the four metrics over time (curves.py).
"""

import numpy as np

from deploy.metrics.curves import Curves, Instant
from deploy.metrics.intervals import Intervals
from deploy.metrics.visit_map import VisitMap
from deploy.metrics.word_of_visits import WordOfVisits
from swarm_agent.knowledge import merge_news
from tower.base_station import Awareness
from wire import codec
from wire.messages import Facts
from wire.scenario import Scenario

NAMES = ("graph_idleness_s", "worst_idleness_s", "mean_sa_delay_s", "worst_sa_delay_s")


class AreaMetrics:
    """The fold. Feed it facts in order; ask for the metrics at any time."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        sites = len(scenario.field.sites_m())
        self.visited_tick = np.zeros(sites, dtype=np.int64)
        self.known_tick = np.zeros(sites, dtype="<u4")
        self._from_tick = scenario.tick_of(scenario.metrics_from_s)
        self._intervals = Intervals(sites, self._from_tick)
        self._words = WordOfVisits(sites, self._from_tick)
        self._map = VisitMap(scenario)
        self._curves = Curves(scenario)
        self._next_tick = 0
        self._terms = 0
        self._sums = np.zeros(2)
        self._worst = np.zeros(2)

    def feed(self, facts: Facts) -> Instant:
        """Take in one tick. Ticks between this and the last one are filled in: nothing happened in them."""
        for tick in range(self._next_tick, facts.tick):
            self._measure(tick)
        if facts.visits:
            self._intervals.feed(facts.tick, [site for _, site in facts.visits])
            self._map.feed(facts.tick, facts.visits)
        for _, site in facts.visits:
            self.visited_tick[site] = facts.tick
            self._words.visit(facts.tick, site)
        for node, report in facts.reports:
            if node == self._scenario.tower.id:
                self._learn(facts.tick, report)
        self._curves.see(facts.modes)
        self._next_tick = facts.tick + 1
        return self._measure(facts.tick)

    def summary(self) -> dict[str, float | int | None]:
        """The run's metrics, raw and normalised, and those of intervals.py and word_of_visits.py.

        None where the run ended before `metrics_from_s`.
        """
        if self._terms == 0:
            values = dict.fromkeys(NAMES)
        else:
            means = self._sums / self._terms
            values = dict(zip(NAMES, (means[0], self._worst[0], means[1], self._worst[1]), strict=True))
        share = len(self._scenario.robot_ids) / len(self.visited_tick)
        normalised = {f"normalised_{name}": _times(value, share) for name, value in values.items()}
        last_tick, tick_s = self._next_tick - 1, self._scenario.tick_s
        others = self._intervals.summary(last_tick, tick_s) | self._words.summary(last_tick, tick_s)
        return {name: _times(value, 1.0) for name, value in values.items()} | normalised | others

    def tables(self) -> dict[str, np.ndarray]:
        """What `area.npz` holds: the tables of visit_map.py, curves.py and word_of_visits.py."""
        return self._map.tables() | self._curves.tables() | self._words.tables()

    def _learn(self, tick: int, report: bytes) -> None:
        try:
            awareness = codec.decode(Awareness, report)
        except codec.Malformed:  # a tower with other words for observers: nothing is known of what it knows
            return
        if awareness.whole:
            self.known_tick[:] = 0
        before = self.known_tick.copy()
        merge_news(self.known_tick, awareness.news)
        for site in np.flatnonzero(self.known_tick > before).tolist():
            self._words.learn(tick, site, int(self.known_tick[site]))

    def _measure(self, tick: int) -> Instant:
        tick_s = self._scenario.tick_s
        sites = len(self.visited_tick)
        graph_idle = (tick - self.visited_tick.sum() / sites) * tick_s
        mean_delay = (tick - self.known_tick.sum(dtype=np.int64) / sites) * tick_s
        worst_idle = (tick - self.visited_tick.min()) * tick_s
        worst_delay = (tick - int(self.known_tick.min())) * tick_s
        if tick >= self._from_tick:
            self._terms += 1
            self._sums += (graph_idle, mean_delay)
            self._worst = np.maximum(self._worst, (worst_idle, worst_delay))
        instant = Instant(tick, float(graph_idle), float(worst_idle), float(mean_delay), float(worst_delay))
        self._curves.feed(instant)
        return instant


def _times(value: float | None, factor: float) -> float | None:
    return None if value is None else float(value) * factor
