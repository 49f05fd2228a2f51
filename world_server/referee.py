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
from collections.abc import Iterable, Sequence
from functools import reduce
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from world_server.plan_checks import narrowest_island_m
from world_server.sight import BEYOND_WALL_M, Sight

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
    """Keeps the contaminated part of a plan, as polygons; robots see `detect_m` far, not through walls.

    Only robots that see to where contamination is, or comes, are looked at: what others watch it never meets.
    """

    def __init__(
        self, plan: shapely.Polygon, detect_m: float, places_m: Places, alive: Sequence[bool]
    ) -> None:
        self._plan, self._reach_m = plan, detect_m + BEYOND_WALL_M
        self._sight, self._watch = Sight(plan, detect_m), Watch(plan)
        self._views: dict[Place, shapely.Polygon] = {}
        self._places = living(places_m, alive)
        self.contaminated = plan.difference(self._seen_from(self._places))
        self.lost = shapely.Polygon()
        """What was lost in the last step and had not been in sight."""

    @property
    def verdict(self) -> Verdict:
        """The state, as a verdict in which nothing has changed."""
        return Verdict(self.contaminated.area, 0.0, 0.0)

    @property
    def shape(self) -> shapely.Geometry:
        """What is contaminated."""
        return self.contaminated

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
        end of the tick before, and does not jump. So nothing watched was contaminated.
        """
        contaminated, places = self.contaminated, self._places
        ways = unbroken_ways(self._watch, before_m, after_m, alive_before, alive_after, corners_m)
        reached = self._spread([way for way in ways if way[0] in places])
        self._places = living(after_m, alive_after)
        self.contaminated = reached.difference(self._seen_from(self._near(reached, self._places)))
        verdict = self._verdict(reached, contaminated, places)
        self._views = {place: view for place, view in self._views.items() if place in self._places}
        return verdict

    def _spread(self, ways: Sequence[Places]) -> shapely.MultiPolygon:
        """Where contamination can come in a tick in which robots watch along these ways.

        Each part of it lies in one component of what is not watched, and one point of it shows in which.
        """
        sources = [part.representative_point() for part in _sizeable(self.contaminated)]
        reached, met = self.contaminated, -1
        watching: list[Places] = []
        while True:
            near = set(self._near(reached, [way[0] for way in ways]))
            watching = [way for way in ways if way[0] in near]
            if len(watching) == met:
                return reached
            met = len(watching)
            watched = shapely.union_all([self._seen_along(way) for way in watching])
            components = shapely.get_parts(self._plan.difference(watched))
            found, _ = shapely.STRtree(sources).query(components, predicate="intersects")
            reached = shapely.MultiPolygon(components[np.unique(found)].tolist())

    def _verdict(
        self, reached: shapely.Geometry, contaminated: shapely.Geometry, places: Iterable[Place]
    ) -> Verdict:
        """What has changed. `contaminated` was so before, when robots stood at `places`."""
        left_m2, self.lost = self.contaminated.area, shapely.Polygon()
        if reached.area - contaminated.area < NOTHING_M2:
            return Verdict(left_m2, 0.0, 0.0)
        lost = self.contaminated.difference(contaminated)
        if lost.area < NOTHING_M2:
            return Verdict(left_m2, 0.0, 0.0)
        self.lost = lost.difference(self._seen_from(self._near(lost, places)))
        return Verdict(left_m2, lost.area, lost.area - self.lost.area)

    def _near(self, geometry: shapely.Geometry, places: Iterable[Place]) -> list[Place]:
        """The places from which one may see a part of a geometry."""
        places = list(places)
        points = shapely.points(np.array(places).reshape(-1, 2))
        near = shapely.dwithin(points, geometry, self._reach_m).tolist()
        return [place for place, is_near in zip(places, near, strict=True) if is_near]

    def _seen_along(self, way: Places) -> shapely.Polygon:
        """What is seen all along a way."""
        return reduce(shapely.intersection, [self._view(place) for place in way])

    def _seen_from(self, places: Iterable[Place]) -> shapely.Geometry:
        """What is seen from any of these places."""
        return shapely.union_all([self._view(place) for place in places])

    def _view(self, place: Place) -> shapely.Polygon:
        view = self._views.get(place)
        if view is None:
            view = self._views[place] = self._sight.seen_from(place)
        return view


def living(places_m: Places, alive: Sequence[bool]) -> dict[Place, None]:
    """The places of living robots, in their order."""
    return dict.fromkeys(place for place, lives in zip(places_m, alive, strict=True) if lives)


def _sizeable(geometry: shapely.Geometry) -> list[shapely.Polygon]:
    return [part for part in shapely.get_parts(geometry) if part.area > NOTHING_M2]
