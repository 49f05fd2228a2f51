"""The referee: where an intruder of any speed can still be, exactly; only the world knows it.

Contaminated is the part C of the floor plan E where an unseen intruder may stand. In a tick, L is what
some robot sees without a break, D what some robot sees at its end. Then C becomes the union of those
components of E - L that meet C, without D. Before the first tick C is E without D.

Why this is sound: where a robot moves straight, a point that is in sight and range at both ends of the tick
is so all the time: the distance to a moving point is convex, and the triangle of the three lies in E as long
as no island is inside it, for which the island must be narrower than the robot's way is long. So nobody
crosses L; who is in another component than every part of C cannot have been reached; who stands in D at the
end is caught.
"""

import math
from collections.abc import Sequence
from functools import reduce
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from world_server.plan_checks import narrowest_island_m
from world_server.sight import Sight

NOTHING_M2 = 1e-7

Place = tuple[float, float]
Places = Sequence[Place]
Corners = Sequence[Places]
"""Where each robot's way through a tick was not straight; empty: all were."""


class Verdict(NamedTuple):
    """What a tick has changed, in square metres.

    `recontaminated_m2` was clear before and is not now. Of this `given_up_m2` was in sight of some robot
    until this tick: a line that moves back loses only such ground. The rest was lost behind a barrier that
    opened.
    """

    contaminated_m2: float
    recontaminated_m2: float
    given_up_m2: float

    @property
    def cleared(self) -> bool:
        """Is there no place left for an intruder?"""
        return self.contaminated_m2 < NOTHING_M2

    @property
    def breached_m2(self) -> float:
        """What was lost without having been in sight."""
        return self.recontaminated_m2 - self.given_up_m2


class Watch:
    """When a robot's way through a tick was one that can be judged: straight, in free space, round no island.

    Any other is a jump, and who jumps has seen nothing without a break.
    """

    def __init__(self, plan: shapely.Polygon) -> None:
        self._plan, self._longest_m = plan, narrowest_island_m(plan)
        shapely.prepare(plan)

    def unbroken(self, before: Place, after: Place) -> bool:
        """Can a robot have gone straight from one place to the other, watching?"""
        if before == after:
            return True
        short = math.dist(before, after) < self._longest_m
        return short and self._plan.covers(shapely.LineString((before, after)))


def unbroken_ways(
    watch: Watch,
    before_m: Places,
    after_m: Places,
    alive_before: Sequence[bool],
    alive_after: Sequence[bool],
    corners_m: Corners,
) -> list[Places]:
    """The ways of all robots that live at both ends and do not jump, as their points; at rest that is one."""
    ways = []
    lives = zip(alive_before, alive_after, strict=True)
    for robot, (before, after, alive) in enumerate(zip(before_m, after_m, lives, strict=True)):
        way = (before, *(corners_m[robot] if corners_m else ()), after)
        if all(alive) and all(watch.unbroken(*leg) for leg in pairwise(way)):
            ways.append((before,) if len(set(way)) == 1 else way)
    return ways


class Referee:
    """Keeps the contaminated part of a plan, as polygons; robots see `detect_m` far, not through walls."""

    def __init__(
        self, plan: shapely.Polygon, detect_m: float, places_m: Places, alive: Sequence[bool]
    ) -> None:
        self._plan = plan
        self._sight, self._watch = Sight(plan, detect_m), Watch(plan)
        self._seen: dict[Place, shapely.Polygon] = {}
        self._lit = self._look(places_m, alive)
        self.contaminated = plan.difference(self._lit)

    @property
    def verdict(self) -> Verdict:
        """The state, as a verdict in which nothing has changed."""
        return Verdict(self.contaminated.area, 0.0, 0.0)

    def step(
        self,
        before_m: Places,
        after_m: Places,
        alive_before: Sequence[bool],
        alive_after: Sequence[bool],
        corners_m: Corners = (),
    ) -> Verdict:
        """One tick in which each robot went from one place to another; all in the same order of robots.

        A robot watches without a break if it lives at both ends, comes from where somebody kept watch at the
        end of the tick before, and does not jump. So nothing watched was contaminated: each part of what was
        lies in one component of the rest, and one point of it shows in which.
        """
        seen, lit = self._seen, self._lit
        self._lit = self._look(after_m, alive_after)
        ways = unbroken_ways(self._watch, before_m, after_m, alive_before, alive_after, corners_m)
        watched = shapely.union_all([self._along(seen, way) for way in ways if way[0] in seen])
        components = shapely.get_parts(self._plan.difference(watched))
        sources = [part.representative_point() for part in _sizeable(self.contaminated)]
        reached, _ = shapely.STRtree(sources).query(components, predicate="intersects")
        still_m2 = self.contaminated.area - self.contaminated.intersection(self._lit).area
        reached = shapely.MultiPolygon(components[np.unique(reached)].tolist())
        self.contaminated = reached.difference(self._lit)
        contaminated_m2 = self.contaminated.area
        lost_m2 = max(0.0, contaminated_m2 - still_m2)
        given_up_m2 = self.contaminated.intersection(lit).area if lost_m2 > NOTHING_M2 else 0.0
        return Verdict(contaminated_m2, lost_m2, given_up_m2)

    def shape(self) -> shapely.Geometry:
        """What is contaminated."""
        return self.contaminated

    def _along(self, seen: dict[Place, shapely.Polygon], way: Places) -> shapely.Polygon:
        """What is seen all along a way from where somebody stood before."""
        if len(way) == 1:
            return seen[way[0]]
        corners = [self._sight.seen_from(corner) for corner in way[1:-1]]
        return reduce(shapely.intersection, corners, seen[way[0]].intersection(self._seen[way[-1]]))

    def _look(self, places_m: Places, alive: Sequence[bool]) -> shapely.Geometry:
        """What living robots see; each place's view is kept until the next tick."""
        known, self._seen = self._seen, {}
        for place, lives in zip(places_m, alive, strict=True):
            if lives:
                self._seen[place] = known[place] if place in known else self._sight.seen_from(place)
        return shapely.union_all(list(self._seen.values()))


def _sizeable(geometry: shapely.Geometry) -> list[shapely.Polygon]:
    return [part for part in shapely.get_parts(geometry) if part.area > NOTHING_M2]
