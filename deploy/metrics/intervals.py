"""Idleness as others publish it: at events only, and by the intervals between visits of a node.

"Average idleness" means three things in print. `graph_idleness_s` of area.py is a mean over all ticks; here
are the other two. A node is a site. Measuring begins at tick f, that of `metrics_from_s`; e is the last tick.
Formulas are in ticks, results in seconds.

At events (source: M2Bench, arXiv 2605.09633, and its code, whose values for CR and HCR on its map cumberland
these definitions give). An event is a tick with visits, and so is the last tick. i_k is the tick
minus the last visit of site k BEFORE the visits of that tick; all sites count as visited at tick 0.

    instantaneous_graph_idleness_s  = mean over k of i_k(e)
    instantaneous_worst_idleness_s  = max over k of i_k(e)
    worst_idleness_at_events_s      = max over events, and over k, of i_k
    average_graph_idleness_s        = sum over events of (mean over k of i_k) * (time since the event before)
                                      / (e - f)

So every stretch is given the idleness at its end: more than the mean over time, and the more so the rarer
visits are; and the worst at events is a tick more than `worst_idleness_s` of area.py where a visit ends it,
as that is taken after visits. M2Bench ends at an event (`ends_with_visit` does so too). That a run ends where
it ends, and that the first stretch begins at f, is our choice; it changes nothing where a run ends with a
visit and is measured from 0.

By intervals (source: the monitor of patrolling_sim, github davidbsp/patrolling_sim). An interval is the time
between two consecutive visits of one node. The time before the first visit is none, nor is that after the
last one. J_k intervals of node k, I_kj long:

    node_interval_mean_s            = mean over nodes of M_k,  M_k = (sum over j of I_kj) / J_k
    node_interval_worst_mean_s      = max over nodes of M_k
    node_interval_max_s             = max over all intervals
    visits                          = sum of J_k: visits that ended an interval; so the monitor counts them

Its "go" is f: earlier visits end and begin nothing. Our choices: nodes without an interval are left out of
the mean (the runs it published end when every node has at least ten); two visits in one tick are an interval
of 0, as two messages are; no node counts as visited at the start, since robots here start at places, not at
nodes.

None stands for what was not measured: everything where a run ends before f, the average where it ends at f,
means and max of no intervals.
"""

from collections.abc import Sequence

import numpy as np

NAMES = (
    "instantaneous_graph_idleness_s",
    "average_graph_idleness_s",
    "instantaneous_worst_idleness_s",
    "worst_idleness_at_events_s",
    "node_interval_mean_s",
    "node_interval_worst_mean_s",
    "node_interval_max_s",
    "visits",
)


class Intervals:
    """The fold. Feed it the ticks that have visits, in order; ticks without them cost nothing."""

    def __init__(self, sites: int, from_tick: int) -> None:
        self._from_tick = from_tick
        self._visited_tick = np.zeros(sites, dtype=np.int64)
        self._event_tick = from_tick
        self._worst_ticks = 0
        self._idle_ticks = 0  # summed over sites and time, up to the last event
        self._before = (0, 0, 0)  # tick of the last visits, and sum and largest of the idleness before them
        self._visits = np.zeros(sites, dtype=np.int64)
        self._interval_ticks = np.zeros(sites, dtype=np.int64)
        self._longest_ticks = 0

    def feed(self, tick: int, visited: Sequence[int]) -> None:
        """Take in the visits of one tick: a site for each of them."""
        idle_ticks, worst_ticks = self._idle(tick)
        self._before = (tick, idle_ticks, worst_ticks)
        if tick >= self._from_tick:
            self._idle_ticks += idle_ticks * (tick - self._event_tick)
            self._event_tick = tick
            self._worst_ticks = max(self._worst_ticks, worst_ticks)
            for site in visited:
                self._close(tick, site)
        self._visited_tick[list(visited)] = tick

    def summary(self, last_tick: int, tick_s: float) -> dict[str, float | int | None]:
        """All of `NAMES` for a run that lasts until `last_tick`, which is not before the last one fed."""
        if last_tick < self._from_tick:
            return dict.fromkeys(NAMES)
        fed_tick, idle_ticks, worst_ticks = self._before
        if fed_tick != last_tick:
            idle_ticks, worst_ticks = self._idle(last_tick)
        sites, watched_ticks = len(self._visited_tick), last_tick - self._from_tick
        total_ticks = self._idle_ticks + idle_ticks * (last_tick - self._event_tick)
        closed = np.maximum(self._visits - 1, 0)
        means = self._interval_ticks[closed > 0] / closed[closed > 0]
        values = (
            idle_ticks / sites * tick_s,
            total_ticks / (sites * watched_ticks) * tick_s if watched_ticks else None,
            worst_ticks * tick_s,
            max(self._worst_ticks, worst_ticks) * tick_s,
            float(means.mean()) * tick_s if len(means) else None,
            float(means.max()) * tick_s if len(means) else None,
            self._longest_ticks * tick_s if len(means) else None,
            int(closed.sum()),
        )
        return dict(zip(NAMES, values, strict=True))

    def _idle(self, tick: int) -> tuple[int, int]:
        """Sum and largest of the idleness of all sites."""
        visited = self._visited_tick
        return tick * len(visited) - int(visited.sum()), tick - int(visited.min())

    def _close(self, tick: int, site: int) -> None:
        if self._visits[site]:
            waited_ticks = tick - int(self._visited_tick[site])
            self._interval_ticks[site] += waited_ticks
            self._longest_ticks = max(self._longest_ticks, waited_ticks)
        self._visits[site] += 1
        self._visited_tick[site] = tick
