"""Bodies on one line: they stop short of each other, and the world notes who came too close all the same."""

import math
from collections.abc import Sequence

import numpy as np

from wire.line import Line
from world_server.nodes import DEAD, Node
from world_server.path_following import NEAR_M, PathBody, Point, State


class Traffic:
    """Moves the robots, one after the other in order of their numbers.

    Reflex: a body on the line, at most half a lane from it, makes no step that would bring it within `body_m`
    of another robot on the line, living or not, while it approaches it or comes from beside the line: it
    stands still and goes on by itself once the way is clear. Each is judged against where the others are by
    then, so no step breaks the distance. Passing lane and queue know no such rule.
    """

    def __init__(self, line: Line, body_m: float, robots: Sequence[Node]) -> None:
        self._line = line
        self._body_m = body_m
        self._robots = robots
        self._bodies: list[PathBody] = [robot.body for robot in robots]
        self._pairs = np.triu_indices(len(robots), 1)
        self._close: set[tuple[int, int]] = set()

    def move(self, tick_s: float, draws: Sequence[Point]) -> None:
        """One tick of all bodies. `draws`: what chance adds to speed and heading of each."""
        for robot, body, draw in zip(self._robots, self._bodies, draws, strict=True):
            if body.at_rest:
                robot.blocked_by = None
                continue
            before, arrived = body.state, body.arrived
            body.advance(tick_s, draw)
            if self._body_m > 0:
                self._stop_short(robot, body, before)
            if body.arrived and not arrived:
                robot.arrival_pending = True

    def incidents(self, positions_m: np.ndarray, on_line: np.ndarray) -> tuple[tuple[str, str], ...]:
        """Pairs, not both dead, that are closer on the line than bodies may be and were not a tick ago."""
        if self._body_m == 0:
            return ()
        one, other = self._pairs
        away = positions_m[one] - positions_m[other]
        close = (away * away).sum(axis=1) < (self._body_m - NEAR_M) ** 2
        found = set()
        for pair in np.flatnonzero(close).tolist() if close.any() else ():
            rows = int(one[pair]), int(other[pair])
            alive = any(self._robots[row].mode != DEAD for row in rows)
            if alive and on_line[rows[0]] and on_line[rows[1]]:
                found.add(rows)
        new, self._close = sorted(found - self._close), found
        return tuple((self._robots[row].name, self._robots[another].name) for row, another in new)

    def on_line(self, position_m: Point) -> bool:
        """Is this place on the line itself, not beside it?"""
        return abs(self._line.locate(position_m)[1]) <= self._line.lane_m / 2

    def _stop_short(self, robot: Node, body: PathBody, before: State) -> None:
        """Undo the step if it leads too near to somebody."""
        stepped = (body.x_m, body.y_m) != (before.x_m, before.y_m)
        blocker = self._in_the_way(body, (before.x_m, before.y_m)) if stepped else None
        if blocker is not None:
            body.put_back(before)
        if stepped:
            robot.hold_up(blocker, self._body_m)

    def _in_the_way(self, body: PathBody, before: Point) -> str | None:
        """The nearest robot that forbids the step from `before` to where the body is now."""
        x_m, y_m = after = (body.x_m, body.y_m)
        reach_m = self._body_m + math.dist(before, after)
        found: list[tuple[float, int]] = []
        for row, other in enumerate(self._bodies):
            if other is body or abs(other.x_m - x_m) > reach_m or abs(other.y_m - y_m) > reach_m:
                continue
            place = (other.x_m, other.y_m)
            apart_m = _passing_m(before, after, place)
            if apart_m < self._body_m - NEAR_M and self.on_line(after) and self.on_line(place):
                approaching = apart_m < math.dist(before, place) - NEAR_M
                if approaching or not self.on_line(before):
                    found.append((apart_m, row))
        return self._robots[min(found)[1]].name if found else None


def _passing_m(before: Point, after: Point, place: Point) -> float:
    """The least distance to a place on the straight way between two others."""
    way_x, way_y = after[0] - before[0], after[1] - before[1]
    along = (place[0] - before[0]) * way_x + (place[1] - before[1]) * way_y
    share = max(0.0, min(1.0, along / (way_x * way_x + way_y * way_y)))
    return math.hypot(before[0] + share * way_x - place[0], before[1] + share * way_y - place[1])
