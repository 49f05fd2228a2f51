"""Round bodies that go any way without turning, stop at what is in their way, and slide along walls.

A body keeps its radius from every wall and its width from every other body. Where it would come nearer, it
goes as far as it can; what is left of its step it goes along the wall, once more round a corner, and no more.
"""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from wire.fields import Point
from wire.messages import GoTo, Motion, Pose, Shift
from world_server.motion import Body
from world_server.walls import Walls

LEGS = 3
GAP_M = 1e-9  # is kept from what is in the way, so that rounding never leads into it
GRAZE_M = 1e-12  # who comes no nearer than this in a step goes along


class Contact(NamedTuple):
    """What stops a step: after which share of it, with which normal towards the body, and is it a wall?"""

    share: float
    normal: Point
    is_wall: bool


class Disc(Body):
    """A disc; its front never turns. Of all motions it knows only Shift: any other is Stay."""

    def __init__(self, pose: Pose, max_speed_m_s: float) -> None:
        super().__init__(pose, max_speed_m_s, 0.0)
        self._forward = (math.cos(pose.heading_rad), math.sin(pose.heading_rad))

    def command(self, motion: Motion | None) -> bool:
        """Take over a motion; None keeps the present one. True when it is already where it is sent."""
        if motion is None:
            return False
        self.goal = None
        if isinstance(motion, Shift):
            away_x, away_y = self.outward(motion.x_m, motion.y_m)
            self.goal = GoTo(self.x_m + away_x, self.y_m + away_y)
        return self.arrived

    def outward(self, x_m: float, y_m: float) -> Point:
        """A vector from the body's frame in the field's."""
        cos, sin = self._forward
        return cos * x_m - sin * y_m, sin * x_m + cos * y_m

    def inward(self, x_m: float, y_m: float) -> Point:
        """A vector from the field's frame in the body's."""
        cos, sin = self._forward
        return cos * x_m + sin * y_m, cos * y_m - sin * x_m

    def drive(self, tick_s: float, walls: Walls, others_m: Iterable[Point], width_m: float) -> list[Point]:
        """One tick among walls and other bodies. Returns the corners and the end of its way."""
        if self.at_rest:
            return []
        step_m = self._max_speed_m_s * tick_s
        away = (self.goal.x_m - self.x_m, self.goal.y_m - self.y_m)
        distance_m = math.hypot(*away)
        share = 1.0 if distance_m <= step_m + GAP_M else step_m / distance_m
        reach_m = width_m + step_m + 2 * GAP_M
        near = [one for one in others_m if math.hypot(one[0] - self.x_m, one[1] - self.y_m) <= reach_m]
        here = (self.x_m, self.y_m)
        segments = walls.near(*here).tolist()
        way = way_of(here, (share * away[0], share * away[1]), segments, near, width_m)
        if way:
            self.x_m, self.y_m = way[-1]
            if share == 1.0 and math.hypot(self.goal.x_m - self.x_m, self.goal.y_m - self.y_m) < GAP_M:
                self.x_m, self.y_m = way[-1] = (self.goal.x_m, self.goal.y_m)
        return way


def way_of(
    here: Point, step: Point, segments: Sequence[Sequence[float]], others_m: Sequence[Point], width_m: float
) -> list[Point]:
    """The corners and the end of the way of a body that wants to go one step; each leg is straight."""
    way: list[Point] = []
    normals: list[Point] = []
    for _ in range(LEGS):
        length_m = math.hypot(*step)
        if length_m < GAP_M or any(_dot(step, normal) < -GRAZE_M for normal in normals):
            break
        contact = first_contact(here, step, segments, others_m, width_m)
        share = 1.0 if contact is None else max(0.0, contact.share - GAP_M / length_m)
        if share * length_m >= GAP_M:
            here = (here[0] + share * step[0], here[1] + share * step[1])
            way.append(here)
        if contact is None or not contact.is_wall:
            break
        rest = ((1 - share) * step[0], (1 - share) * step[1])
        into = _dot(rest, contact.normal)
        step = (rest[0] - into * contact.normal[0], rest[1] - into * contact.normal[1])
        normals.append(contact.normal)
    return way


def first_contact(
    here: Point, step: Point, segments: Sequence[Sequence[float]], others_m: Sequence[Point], width_m: float
) -> Contact | None:
    """What a body meets first on its way straight along a step, if anything."""
    first: Contact | None = None
    for start_x, start_y, end_x, end_y in segments:
        for found in (
            _meet_side(here, step, (start_x, start_y), (end_x, end_y), width_m / 2),
            _meet_point(here, step, (start_x, start_y), width_m / 2, True),
        ):
            if found is not None and (first is None or found.share < first.share):
                first = found
    for other in others_m:
        found = _meet_point(here, step, other, width_m, False)
        if found is not None and (first is None or found.share < first.share):
            first = found
    return first


def _meet_side(here: Point, step: Point, start: Point, end: Point, keep_m: float) -> Contact | None:
    """Meet the side of a wall between its ends, from either side of it."""
    way_x, way_y = end[0] - start[0], end[1] - start[1]
    length_m = math.hypot(way_x, way_y)
    if length_m == 0:
        return None
    along = (way_x / length_m, way_y / length_m)
    from_start = (here[0] - start[0], here[1] - start[1])
    aside_m = along[0] * from_start[1] - along[1] * from_start[0]
    side = 1.0 if aside_m >= 0 else -1.0
    normal = (-side * along[1], side * along[0])
    nearing_m = -_dot(step, normal)
    if nearing_m <= GRAZE_M:
        return None
    share = max(0.0, (abs(aside_m) - keep_m) / nearing_m)
    if share >= 1:
        return None
    foot_m = _dot(from_start, along) + share * _dot(step, along)
    return Contact(share, normal, True) if 0 <= foot_m <= length_m else None


def _meet_point(here: Point, step: Point, point: Point, keep_m: float, is_wall: bool) -> Contact | None:
    """Come within a distance of a point: the end of a wall, or the middle of another body.

    The share solves |here + share step - point| = keep_m, in the form that does not cancel close by.
    """
    from_point = (here[0] - point[0], here[1] - point[1])
    nearing = -_dot(from_point, step)
    if nearing <= GRAZE_M * keep_m:
        return None
    length2, over = _dot(step, step), _dot(from_point, from_point) - keep_m**2
    discriminant = nearing**2 - length2 * over
    if discriminant <= 0:
        return None
    share = max(0.0, over / (nearing + math.sqrt(discriminant)))
    if share >= 1:
        return None
    normal = (from_point[0] + share * step[0], from_point[1] + share * step[1])
    size = math.hypot(*normal)
    return Contact(share, (normal[0] / size, normal[1] / size), is_wall)


def _dot(one: Point, other: Point) -> float:
    return one[0] * other[0] + one[1] * other[1]
