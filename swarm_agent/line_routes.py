"""Ways along a patrolled line: over a segment and past what lies on it, out to a segment, and home.

Robots under way use the passing lane and change between lane and line within the approach region; who moves
out to the next segment just crosses the gap.
"""

from collections.abc import Collection, Iterable

from wire.line import Line, Point

CLEARANCE = 1.25
"""How far around a body a way stays on the passing lane, in body distances."""


class Routes:
    """The ways of one robot. `row`: its place in the queue; `body_m`: the distance that bodies keep."""

    def __init__(self, line: Line, row: int, body_m: float) -> None:
        self._line = line
        self._slot = line.slot(row)
        self._clear_m = CLEARANCE * body_m

    def over(self, from_m: float, to_m: float, obstacles: Collection[float] = ()) -> list[Point]:
        """From one arc to another on the line, and on the passing lane around obstacles at these arcs."""
        low, high = min(from_m, to_m), max(from_m, to_m)
        turns = {arc + by * self._clear_m for arc in obstacles for by in (-2, -1, 1, 2)}
        stops = {arc for arc in turns if low < arc < high} | set(self._line.bends(from_m, to_m)) | {to_m}
        path = [
            self._line.point(arc, self._aside_m(arc, obstacles))
            for arc in sorted(stops, reverse=to_m < from_m)
        ]
        aside_m = self._aside_m(from_m, obstacles)
        return [self._line.point(from_m, aside_m), *path] if aside_m > 0 else path

    def out(self, position: Point, from_queue: bool, number: int) -> list[Point]:
        """To the near end of a segment, from anywhere: across a gap, or by the passing lane."""
        line, near_m = self._line, self._line.segment(number).near_m
        arc_m, aside_m = line.locate(position)
        on_line = not from_queue and abs(aside_m) <= line.lane_m / 2
        if on_line and not self._is_segment_between(arc_m, near_m):
            return self.over(arc_m, near_m)
        arc_m = line.tower_arc_m if from_queue else arc_m
        entry_m = _towards(near_m, line.tower_arc_m, line.approach_m)
        exit_m = _towards(arc_m, entry_m, line.approach_m) if on_line else arc_m
        start = [line.point(exit_m, line.lane_m)]
        return start + line.along(exit_m, entry_m, line.lane_m) + [line.point(near_m)]

    def home(self, position: Point, sidestep: bool = False) -> list[Point]:
        """To the robot's place in the queue; `sidestep` leaves the line at once, since something is ahead."""
        line = self._line
        arc_m, aside_m = line.locate(position)
        on_line = abs(aside_m) <= line.lane_m / 2 and not sidestep
        exit_m = _towards(arc_m, line.tower_arc_m, line.approach_m if on_line else 0.0)
        start = [line.point(exit_m, line.lane_m)]
        return start + line.along(exit_m, line.tower_arc_m, line.lane_m) + [self._slot]

    def _aside_m(self, arc_m: float, obstacles: Iterable[float]) -> float:
        """How far from the line the way past obstacles runs at an arc: the lane's distance next to one."""
        if self._clear_m == 0:
            return 0.0
        room = max((2 - abs(arc_m - one) / self._clear_m for one in obstacles), default=0.0)
        return self._line.lane_m * max(0.0, min(1.0, room))

    def _is_segment_between(self, from_m: float, to_m: float) -> bool:
        low, high = min(from_m, to_m), max(from_m, to_m)
        slack_m = self._line.lane_m / 2
        return any(one.left_m < high - slack_m and one.right_m > low + slack_m for one in self._line.segments)


def _towards(from_m: float, to_m: float, by_m: float) -> float:
    return from_m + max(-by_m, min(by_m, to_m - from_m))
