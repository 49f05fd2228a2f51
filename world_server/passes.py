"""Visits on a polyline: who passed which end or middle of a segment, judged by the world from positions."""

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence

AT_SITE_M = 1e-6
IN_BAND_LANES = 1.5
"""Line and passing lane count, the queue behind them does not."""
LEFT, NEITHER, RIGHT = -1, 0, 1

Between = tuple[int, int]
"""How many sites a robot has reached, seen from the first point of the line, and how many lie behind it."""
NO_VISITS: tuple[list[int], list[int]] = ([], [])


class Passes:
    """Follows every robot along the line, through the surroundings of the sites that it comes by.

    A site is visited by who comes to it. Who leaves it again on the side from which it came has turned there,
    which is a second visit; who rests there and goes on has visited once. A robot counts while its centre is
    on the line or the passing lane. It is at a site within `near_m`: with exact motion no more than rounding.
    With noise a body turns a little before or after the end of its segment, as it drives there askew; half a
    step of a tick is more than that, and less than what the world can tell apart in time.
    """

    def __init__(self, sites_m: Sequence[float], near_m: float, lane_m: float, robots: int) -> None:
        self._numbers = sorted(range(len(sites_m)), key=lambda site: sites_m[site])
        self._from_m = [sites_m[site] - near_m for site in self._numbers]
        self._to_m = [sites_m[site] + near_m for site in self._numbers]
        self._band_m = IN_BAND_LANES * lane_m
        self._came_from: list[dict[int, int]] = [{} for _ in range(robots)]
        self._last: list[Between | None] = [None] * robots

    def follow(
        self, row: int, arc_m: float, aside_m: float, turns_m: Sequence[float] = ()
    ) -> tuple[list[int], list[int]]:
        """One robot's motion in one tick: to where it is now, by the way of the arcs in `turns_m`.

        Returns the departures from sites at which it stood when the tick began, and the arrivals.
        """
        if abs(aside_m) > self._band_m:
            self._came_from[row].clear()
            self._last[row] = None
            return NO_VISITS
        before, after = self._last[row], self._between(arc_m)
        self._last[row] = after
        if before == after and not turns_m:
            return NO_VISITS
        came_from = self._came_from[row]
        if before is None:  # it comes from beside the line: whatever is here, it is at, from neither side
            reached, behind = after
            came_from |= dict.fromkeys(range(behind, reached), NEITHER)
            return [], self._named(came_from)
        stood_at, turned, come = set(came_from), [], []
        for place in (*map(self._between, turns_m), after):
            come += _entered(came_from, before, place)
            turned += _left(came_from, before, place)
            before = place
        departures = [site for site in turned if site in stood_at]
        arrivals = come + [site for site in turned if site not in stood_at]
        return self._named(departures), self._named(arrivals)

    def _between(self, arc_m: float) -> Between:
        """Between which sites an arc is."""
        return bisect_right(self._from_m, arc_m), bisect_left(self._to_m, arc_m)

    def _named(self, sites: Iterable[int]) -> list[int]:
        return [self._numbers[site] for site in sites]


def _entered(came_from: dict[int, int], before: Between, after: Between) -> list[int]:
    """Sites whose surroundings were entered, noted with the side from which."""
    from_left, from_right = range(before[0], after[0]), range(after[1], before[1])
    came_from |= dict.fromkeys(from_left, LEFT) | dict.fromkeys(from_right, RIGHT)
    return [*from_left, *from_right]


def _left(came_from: dict[int, int], before: Between, after: Between) -> list[int]:
    """Sites that were left on the side from which they were entered; those that were left are forgotten."""
    to_right, to_left = range(before[1], after[1]), range(after[0], before[0])
    turned = [site for site in to_right if came_from.pop(site, NEITHER) == RIGHT]
    return turned + [site for site in to_left if came_from.pop(site, NEITHER) == LEFT]
