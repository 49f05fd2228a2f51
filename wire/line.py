"""The geometry of a patrolled polyline: places along it, its passing lane, its segments, and the queue.

An `arc` is a distance in metres along the line from its first point; `aside` is a distance to the left of it.
Pure and without numpy: robots, tower, world and metrics all lay out the same line.
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple

from wire.fields import Polyline

Point = tuple[float, float]
QUEUE_DEPTH = 10
"""How many places of the queue stand one behind the other; further ones stand in files beside these."""


class Segment(NamedTuple):
    """One patrolled stretch. `near_m` is the end closer to the tower along the line, `far_m` the other."""

    number: int
    left_m: float
    right_m: float
    near_m: float
    far_m: float

    @property
    def length_m(self) -> float:
        """Its length along the line."""
        return self.right_m - self.left_m

    @property
    def mid_m(self) -> float:
        """The arc of its middle."""
        return (self.left_m + self.right_m) / 2


class Line:
    """A field and the tower's position on it, laid out."""

    def __init__(self, field: Polyline, tower_m: Point) -> None:
        self.lane_m, self.approach_m, self._slot_m = field.lane_m, field.approach_m, field.slot_m
        self._points = field.points_m
        legs = list(zip(field.points_m, field.points_m[1:], strict=False))
        self._lengths = [math.dist(one, other) for one, other in legs]
        self._ways = [
            ((other[0] - one[0]) / length, (other[1] - one[1]) / length)
            for (one, other), length in zip(legs, self._lengths, strict=True)
        ]
        self._starts = [math.fsum(self._lengths[:leg]) for leg in range(len(self._lengths))]
        self.length_m = math.fsum(self._lengths)
        self.tower_arc_m, _ = self.locate(tower_m)
        self.segments = [
            Segment(number, left, right, *self._near_first(left, right))
            for number, (left, right) in enumerate(_stretches(field, self.length_m), start=1)
        ]

    def segment(self, number: int) -> Segment:
        """The segment with this number."""
        return self.segments[number - 1]

    def side(self, number: int) -> int:
        """On which side of the tower a segment lies: -1 towards the first point of the line, or 1."""
        return -1 if self.segment(number).mid_m < self.tower_arc_m else 1

    def inward(self, number: int) -> list[int]:
        """The segments between this one and the tower, on its side, the nearest to this one first."""
        step = -self.side(number)
        between, one = [], number + step
        while 1 <= one <= len(self.segments) and self.side(one) == self.side(number):
            between.append(one)
            one += step
        return between

    def sites_m(self) -> list[float]:
        """Arcs of left end, middle and right end of every segment: sites 3 (number - 1) + 0, 1, 2."""
        return [arc for one in self.segments for arc in (one.left_m, one.mid_m, one.right_m)]

    def point(self, arc_m: float, aside_m: float = 0.0) -> Point:
        """The position at an arc, and `aside_m` to the left of the line; at a bend on its bisector."""
        leg = self._leg(arc_m)
        along = arc_m - self._starts[leg]
        if leg and along == 0:
            return self._corner(leg, aside_m)
        (x_m, y_m), (way_x, way_y) = self._points[leg], self._ways[leg]
        return (x_m + along * way_x - aside_m * way_y, y_m + along * way_y + aside_m * way_x)

    def locate(self, position_m: Point) -> tuple[float, float]:
        """Arc and aside of the nearest place on the line; beyond the ends `aside` is the distance."""
        best = (math.inf, 0.0, 0.0)
        for leg, (way_x, way_y) in enumerate(self._ways):
            away_x, away_y = position_m[0] - self._points[leg][0], position_m[1] - self._points[leg][1]
            along = max(0.0, min(away_x * way_x + away_y * way_y, self._lengths[leg]))
            off_x, off_y = away_x - along * way_x, away_y - along * way_y
            distance = math.hypot(off_x, off_y)
            if distance < best[0] - 1e-12:
                left = way_x * away_y - way_y * away_x
                best = (distance, self._starts[leg] + along, math.copysign(distance, left))
        return best[1], best[2]

    def along(self, from_m: float, to_m: float, aside_m: float = 0.0) -> list[Point]:
        """The way from one arc to another, bends included, without its first point and with its last."""
        return [self.point(arc, aside_m) for arc in (*self.bends(from_m, to_m), to_m)]

    def bends(self, from_m: float, to_m: float) -> list[float]:
        """Arcs of the bends strictly between two arcs, in the order in which one comes to them."""
        low, high = min(from_m, to_m), max(from_m, to_m)
        between = [start for start in self._starts[1:] if low < start < high]
        return between if from_m <= to_m else between[::-1]

    def slot(self, row: int) -> Point:
        """The place of the robot with this row in the queue: behind the passing lane, at the tower.

        A long queue stands in files beside each other, so that the last one is not far from the tower.
        """
        file, place = divmod(row, QUEUE_DEPTH)
        along_m = (file + 1) // 2 * self._slot_m * (1 if file % 2 else -1)
        x_m, y_m = self.point(self.tower_arc_m, 2 * self.lane_m + place * self._slot_m)
        way_x, way_y = self._ways[self._leg(self.tower_arc_m)]
        return (x_m + along_m * way_x, y_m + along_m * way_y)

    def _leg(self, arc_m: float) -> int:
        """The leg of the line that an arc is on."""
        return max(0, min(bisect_right(self._starts, arc_m) - 1, len(self._ways) - 1))

    def _corner(self, leg: int, aside_m: float) -> Point:
        """Where two legs of the line, or of a parallel to it, meet."""
        (one_x, one_y), (other_x, other_y) = self._ways[leg - 1], self._ways[leg]
        x_m, y_m = self._points[leg]
        stretch = aside_m / (1 + one_x * other_x + one_y * other_y)
        return (x_m - stretch * (one_y + other_y), y_m + stretch * (one_x + other_x))

    def _near_first(self, left_m: float, right_m: float) -> tuple[float, float]:
        if abs(left_m - self.tower_arc_m) <= abs(right_m - self.tower_arc_m):
            return left_m, right_m
        return right_m, left_m


def _stretches(field: Polyline, length_m: float) -> Sequence[tuple[float, float]]:
    if not isinstance(field.segments, int):
        return field.segments
    each = (length_m - (field.segments - 1) * field.gap_m) / field.segments
    starts = [number * (each + field.gap_m) for number in range(field.segments)]
    return [(start, start + each) for start in starts]
