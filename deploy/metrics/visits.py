"""How often the sites of a line are visited, from the end of deployment on.

Source: papers/line-patrol.txt, section III-B: uniformity (variance of the frequency over the sites), maximal
average frequency, maximal minimum frequency; intervals between visits as in its Figure 6.

    interval     time between two consecutive visits of a site; two in one tick give an interval of 0
    frequency    visits of a site / time from the end of deployment to the last tick
    longest gap  longest time without a visit, also before the first one and after the last one

The variance is the population's, over all sites. Visits before the end of deployment do not count.
"""

import statistics
from typing import Any

from deploy.metrics.spread import Spread

PLACES = ("end_left", "mid", "end_right")


class Visits:
    """The visits of all sites; sites 3 (segment - 1) + 0, 1, 2 are left end, middle and right end."""

    def __init__(self, segments: int) -> None:
        sites = len(PLACES) * segments
        self._begin_tick: int | None = None
        self._counts = [0] * sites
        self._last_ticks = [0] * sites
        self._longest = [0] * sites
        self._intervals = [Spread() for _ in range(sites)]

    def begin(self, tick: int) -> None:
        """From this tick on visits count."""
        self._begin_tick = tick
        self._last_ticks = [tick] * len(self._last_ticks)

    def add(self, tick: int, site: int) -> None:
        """Take in one visit."""
        if self._begin_tick is None:
            return
        waited = tick - self._last_ticks[site]
        if self._counts[site]:
            self._intervals[site].add(waited)
        self._longest[site] = max(self._longest[site], waited)
        self._counts[site] += 1
        self._last_ticks[site] = tick

    def longest_gaps_s(self, last_tick: int, tick_s: float) -> list[float | None]:
        """The longest gap of the worst site of each segment."""
        if self._begin_tick is None:
            return [None] * (len(self._counts) // len(PLACES))
        gaps = [
            max(longest, last_tick - visited_tick) * tick_s
            for longest, visited_tick in zip(self._longest, self._last_ticks, strict=True)
        ]
        return [max(gaps[first : first + len(PLACES)]) for first in range(0, len(gaps), len(PLACES))]

    def intervals_s(self, tick_s: float) -> dict[str, dict[str, dict[str, float | None]]]:
        """Mean, standard deviation and largest interval of every site, by segment and place."""
        told: dict[str, dict[str, Any]] = {}
        for site, one in enumerate(self._intervals):
            segment, place = divmod(site, len(PLACES))
            told.setdefault(str(segment + 1), {})[PLACES[place]] = {
                "mean": one.mean_s(tick_s),
                "sd": one.sd_s(tick_s),
                "max": one.most_s(tick_s),
            }
        return told

    def frequency_hz(self, last_tick: int, tick_s: float) -> dict[str, float | None]:
        """Mean, smallest and variance of the frequency over the sites."""
        if self._begin_tick is None or last_tick <= self._begin_tick:
            return {"mean": None, "min": None, "variance": None}
        watched_s = (last_tick - self._begin_tick) * tick_s
        each = [count / watched_s for count in self._counts]
        return {"mean": statistics.fmean(each), "min": min(each), "variance": statistics.pvariance(each)}
