"""Bodies on one line: they stop short of each other, and the world notes who came too close all the same."""

import math
from collections.abc import Sequence

from wire.line import Line
from world_server.nodes import DEAD, Node
from world_server.path_following import NEAR_M, PathBody, Point, State


class Traffic:
    """Moves the robots, one after the other in order of their numbers.

    Reflex: a body on the line, at most half a lane from it, makes no step that would bring it within `body_m`
    of another robot on the line, living or not, while it approaches it or comes from beside the line. It
    stands still, and goes on by itself once the way is clear. Each is judged against where the others are by
    then, so no step breaks the distance. Passing lane and queue know no such rule.
    """

    def __init__(self, line: Line, body_m: float, robots: Sequence[Node]) -> None:
        self._line = line
        self._body_m = body_m
        self._robots = robots
        self._bodies: list[PathBody] = [robot.body for robot in robots]
        self._places: list[Point] = []
        self._close: set[tuple[int, int]] = set()

    def move(self, tick_s: float, draws: Sequence[Point]) -> list[int]:
        """One tick of all bodies. `draws`: what chance adds to speed and heading of each.

        Returns the rows of those that were on their way.
        """
        moving = []
        self._places = [(body.x_m, body.y_m) for body in self._bodies]
        for row, (robot, body, draw) in enumerate(zip(self._robots, self._bodies, draws, strict=True)):
            if body.at_rest:
                robot.blocked_by = None
                continue
            moving.append(row)
            before, arrived = body.state, body.arrived
            body.advance(tick_s, draw)
            if self._body_m > 0:
                self._stop_short(row, before)
            if body.arrived and not arrived:
                robot.arrival_pending = True
        return moving

    def incidents(self, on_line: Sequence[bool]) -> tuple[tuple[str, str], ...]:
        """Pairs, not both dead, that are closer on the line than bodies may be and were not a tick ago."""
        if self._body_m == 0:
            return ()
        robots = self._robots
        there = [(row, body.x_m, body.y_m) for row, body in enumerate(self._bodies) if on_line[row]]
        closest_m, found = self._body_m - NEAR_M, set()
        for place, (row, x_m, y_m) in enumerate(there):
            for other, other_x_m, other_y_m in there[place + 1 :]:
                near = (
                    abs(x_m - other_x_m) < closest_m
                    and math.hypot(x_m - other_x_m, y_m - other_y_m) < closest_m
                )
                if near and not robots[row].mode == robots[other].mode == DEAD:
                    found.add((row, other))
        new, self._close = sorted(found - self._close), found
        return tuple([(robots[row].name, robots[other].name) for row, other in new])

    def on_line(self, position_m: Point) -> bool:
        """Is this place on the line itself, not beside it?"""
        return abs(self._line.locate(position_m)[1]) <= self._line.lane_m / 2

    def _stop_short(self, row: int, before: State) -> None:
        """Undo a robot's step if it leads too near to somebody."""
        robot, body, stood = self._robots[row], self._bodies[row], self._places[row]
        place = (body.x_m, body.y_m)
        if place == stood:
            return
        blocker = self._in_the_way(row, stood, place)
        robot.hold_up(blocker, self._body_m)
        if blocker is None:
            self._places[row] = place
        else:
            body.put_back(before)

    def _in_the_way(self, row: int, before: Point, after: Point) -> str | None:
        """The nearest robot that forbids a robot the step from `before` to `after`."""
        reach_m = self._body_m + math.dist(before, after)
        x_m, y_m = after
        found: list[tuple[float, int]] = []
        for other, place in enumerate(self._places):
            if other == row or abs(place[0] - x_m) > reach_m or abs(place[1] - y_m) > reach_m:
                continue
            apart_m = _passing_m(before, after, place)
            if apart_m < self._body_m - NEAR_M and self.on_line(after) and self.on_line(place):
                approaching = apart_m < math.dist(before, place) - NEAR_M
                if approaching or not self.on_line(before):
                    found.append((apart_m, other))
        return self._robots[min(found)[1]].name if found else None


def _passing_m(before: Point, after: Point, place: Point) -> float:
    """The least distance to a place on the straight way between two others."""
    way_x, way_y = after[0] - before[0], after[1] - before[1]
    along = (place[0] - before[0]) * way_x + (place[1] - before[1]) * way_y
    share = max(0.0, min(1.0, along / (way_x * way_x + way_y * way_y)))
    return math.hypot(before[0] + share * way_x - place[0], before[1] + share * way_y - place[1])
