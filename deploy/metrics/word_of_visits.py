"""How long it takes until the tower has word of a visit, if ever.

A visit is told of when the tower first reports to know of it or of a later one to the same site. The SA delay
of area.py cannot tell a site that is rarely visited from one whose visits are never told of; this can.

    word_mean_s   mean time from a visit to the word of it, over visits that were told of
    word_worst_s  longest such time; a visit untold at the end counts with the time it has waited by then

Only visits from `metrics_from_s` on count. None stands for nothing to measure.
"""

from collections import deque

import numpy as np

NAMES = ("word_mean_s", "word_worst_s")


class WordOfVisits:
    """The fold."""

    def __init__(self, sites: int, from_tick: int) -> None:
        self._from_tick = from_tick
        self._untold: list[deque[int]] = [deque() for _ in range(sites)]
        self._told = 0
        self._waited_ticks = 0
        self._longest_ticks = 0

    def visit(self, tick: int, site: int) -> None:
        """A robot visited a site."""
        if tick >= self._from_tick:
            self._untold[site].append(tick)

    def learn(self, tick: int, site: int, known_tick: int) -> None:
        """The tower reports at `tick` that a site was visited at `known_tick`."""
        untold = self._untold[site]
        while untold and untold[0] <= known_tick:
            waited_ticks = tick - untold.popleft()
            self._told += 1
            self._waited_ticks += waited_ticks
            self._longest_ticks = max(self._longest_ticks, waited_ticks)

    def summary(self, last_tick: int, tick_s: float) -> dict[str, float | None]:
        """Both figures for a run that ends at `last_tick`."""
        still = max((last_tick - untold[0] for untold in self._untold if untold), default=-1)
        measured = self._told or still >= 0
        mean_s = self._waited_ticks / self._told * tick_s if self._told else None
        worst_s = max(self._longest_ticks, still) * tick_s if measured else None
        return dict(zip(NAMES, (mean_s, worst_s), strict=True))

    def tables(self) -> dict[str, np.ndarray]:
        """`untold_tick`: the first visit of each site that the tower has no word of, or -1: (sites,)."""
        return {"untold_tick": np.array([untold[0] if untold else -1 for untold in self._untold])}
