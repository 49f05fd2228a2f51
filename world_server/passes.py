"""Visits on a polyline: who passed which end or middle of a segment, judged by the world from positions."""

from collections.abc import Iterable, Sequence

import numpy as np

from world_server.path_following import Point

AT_SITE_M = 1e-6
IN_BAND_LANES = 1.5
"""Line and passing lane count, the queue behind them does not."""
LEFT, NEITHER, RIGHT = -1, 0, 1

Visit = tuple[int, int]
"""Row of a robot and number of a site."""


class Places:
    """Arc and aside of many positions at once: what `Line.locate` says, as columns."""

    def __init__(self, points_m: Sequence[Point]) -> None:
        points = np.array(points_m, dtype=float)
        self._first, legs = points[:-1], np.diff(points, axis=0)
        self._lengths_m = np.hypot(legs[:, 0], legs[:, 1])
        self._ways = legs / self._lengths_m[:, None]
        self._starts_m = np.concatenate([[0.0], np.cumsum(self._lengths_m)[:-1]])

    def locate(self, positions_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Arcs and asides of positions (n, 2), each (n,)."""
        away = positions_m[:, None, :] - self._first
        along = (away * self._ways).sum(axis=2)
        left = self._ways[:, 0] * away[..., 1] - self._ways[:, 1] * away[..., 0]
        inside = np.minimum(np.maximum(along, 0.0), self._lengths_m)
        beyond = along - inside
        apart = left * left + beyond * beyond
        rows, leg = np.arange(len(positions_m)), apart.argmin(axis=1)
        aside = np.copysign(np.sqrt(apart[rows, leg]), left[rows, leg])
        return self._starts_m[leg] + inside[rows, leg], aside


class Passes:
    """Follows every robot along the line, through the surroundings of the sites that it comes by.

    A site is visited by who comes to it. Who leaves it again on the side from which it came has turned there,
    which is a second visit; who rests there and goes on has visited once. A robot counts while its centre is
    on the line or the passing lane. It is at a site within `near_m`: with exact motion no more than rounding.
    With noise a body turns a little before or after the end of its segment, as it drives there askew; half a
    step of a tick is more than that, and less than what the world can tell apart in time.
    """

    def __init__(self, sites_m: Sequence[float], near_m: float, lane_m: float, robots: int) -> None:
        order = np.argsort(sites_m, kind="stable")
        self._numbers = order.tolist()
        arcs = np.array(sites_m, dtype=float)[order]
        self._from_m, self._to_m = arcs - near_m, arcs + near_m
        self._band_m = IN_BAND_LANES * lane_m
        self._came_from: list[dict[int, int]] = [{} for _ in range(robots)]
        self._reached = self._behind = np.zeros(robots, dtype=np.int64)
        self._inside = np.zeros(robots, dtype=bool)

    def follow(
        self, arcs_m: np.ndarray, asides_m: np.ndarray, turns_m: dict[int, list[float]]
    ) -> tuple[list[Visit], list[Visit]]:
        """One tick: from where all were to where they are now. `turns_m`: arcs passed in between, by row.

        Returns the departures from sites at which robots stood when the tick began, and the arrivals.
        """
        reached = self._from_m.searchsorted(arcs_m, "right")
        behind = self._to_m.searchsorted(arcs_m, "left")
        inside = np.abs(asides_m) <= self._band_m
        changed = (reached != self._reached) | (behind != self._behind) | (inside != self._inside)
        rows = set(turns_m)
        if changed.any():
            rows.update(np.flatnonzero(changed).tolist())
        departures, arrivals = [], []
        for row in sorted(rows):
            one = self._one(row, arcs_m, inside, turns_m.get(row, []))
            departures += one[0]
            arrivals += one[1]
        self._reached, self._behind, self._inside = reached, behind, inside
        return departures, arrivals

    def _one(
        self, row: int, arcs_m: np.ndarray, inside: np.ndarray, turns_m: list[float]
    ) -> tuple[list[Visit], list[Visit]]:
        """Departures and arrivals of one robot in one tick."""
        came_from = self._came_from[row]
        if not inside[row]:
            came_from.clear()
            return [], []
        if not self._inside[
            row
        ]:  # it comes from beside the line: whatever is here, it is at, from neither side
            reached, behind = self._place(arcs_m[row])
            came_from |= dict.fromkeys(range(behind, reached), NEITHER)
            return [], self._visits(row, came_from)
        stood_at = set(came_from)
        place, turned, come = (self._reached[row], self._behind[row]), [], []
        for arc_m in (*turns_m, arcs_m[row]):
            after = self._place(arc_m)
            come += _entered(came_from, place, after)
            turned += _left(came_from, place, after)
            place = after
        departures = [site for site in turned if site in stood_at]
        arrivals = come + [site for site in turned if site not in stood_at]
        return self._visits(row, departures), self._visits(row, arrivals)

    def _visits(self, row: int, sites: Iterable[int]) -> list[Visit]:
        return [(row, self._numbers[site]) for site in sites]

    def _place(self, arc_m: float) -> tuple[int, int]:
        """How many sites it has reached from the first point of the line, and how many it has behind it."""
        reached = int(self._from_m.searchsorted(arc_m, "right"))
        return reached, int(self._to_m.searchsorted(arc_m, "left"))


def _entered(came_from: dict[int, int], before: tuple[int, int], after: tuple[int, int]) -> list[int]:
    """Sites whose surroundings were entered, noted with the side from which."""
    from_left, from_right = range(before[0], after[0]), range(after[1], before[1])
    came_from |= dict.fromkeys(from_left, LEFT) | dict.fromkeys(from_right, RIGHT)
    return [*from_left, *from_right]


def _left(came_from: dict[int, int], before: tuple[int, int], after: tuple[int, int]) -> list[int]:
    """Sites that were left on the side from which they were entered; those that were left are forgotten."""
    to_right, to_left = range(before[1], after[1]), range(after[0], before[0])
    turned = [site for site in to_right if came_from.pop(site, NEITHER) == RIGHT]
    return turned + [site for site in to_left if came_from.pop(site, NEITHER) == LEFT]
