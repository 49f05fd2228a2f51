"""Mean, spread and extremes of durations, kept in whole ticks so that nothing is lost on the way."""

import math
import statistics
from collections.abc import Sequence


class Spread:
    """A growing set of durations in ticks, of which only count, sums and the largest are kept."""

    def __init__(self) -> None:
        self.count, self.most = 0, 0
        self._sum, self._squares = 0, 0

    def add(self, ticks: int) -> None:
        """Take in one duration."""
        self.count += 1
        self.most = max(self.most, ticks)
        self._sum += ticks
        self._squares += ticks * ticks

    def mean_s(self, tick_s: float) -> float | None:
        """The mean; None of nothing."""
        return self._sum / self.count * tick_s if self.count else None

    def sd_s(self, tick_s: float) -> float | None:
        """The standard deviation of the whole set (the population's); None of nothing."""
        if not self.count:
            return None
        return math.sqrt(self.count * self._squares - self._sum**2) / self.count * tick_s

    def most_s(self, tick_s: float) -> float | None:
        """The largest; None of nothing."""
        return self.most * tick_s if self.count else None


def span(ticks: Sequence[int], tick_s: float) -> dict[str, float | int | None]:
    """Smallest, median and largest of some durations in seconds, and how many there are."""
    if not ticks:
        return {"min": None, "median": None, "max": None, "count": 0}
    middle = statistics.median(ticks)
    return {
        "min": min(ticks) * tick_s,
        "median": middle * tick_s,
        "max": max(ticks) * tick_s,
        "count": len(ticks),
    }
