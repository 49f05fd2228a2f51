"""Where teams begin: places around the ring of walls of a floor plan, equally far apart along it."""

from itertools import accumulate

import shapely

from wire.fields import Point
from world_server.floorplan import PlanError

OFF_WALLS_M = 0.4


def places_around(plan: shapely.Polygon, count: int, off_walls_m: float = OFF_WALLS_M) -> list[Point]:
    """So many places along the outer wall, `off_walls_m` from it, in metres to the millimetre.

    The first is the one nearest to the lower left corner of the plan's bounds; the others follow
    anticlockwise. Where the way along the wall falls into several rings, because the plan is too narrow in
    between, they are gone along one after the other. Raises PlanError where all of the plan is too narrow.
    """
    parts = [part for part in shapely.get_parts(plan.buffer(-off_walls_m)) if part.area > 0]
    rings = sorted((_begun_at_lower_left(part, plan) for part in parts), key=_lower_left)
    if not rings:
        raise PlanError(f"nowhere are robots {off_walls_m:g} m from the walls")
    ends_m = list(accumulate(ring.length for ring in rings))
    places = []
    for number in range(count):
        along_m = ends_m[-1] * number / count
        which = next(place for place, end_m in enumerate(ends_m) if along_m < end_m)
        point = rings[which].interpolate(along_m - ends_m[which] + rings[which].length)
        places.append((round(point.x, 3), round(point.y, 3)))
    return places


def _begun_at_lower_left(part: shapely.Polygon, plan: shapely.Polygon) -> shapely.LineString:
    """The outer ring of a part, anticlockwise, from its corner that is nearest to the plan's lower left."""
    corner = shapely.Point(plan.bounds[:2])
    points = shapely.get_coordinates(shapely.orient_polygons(part).exterior)[:-1]
    first = min(range(len(points)), key=lambda number: corner.distance(shapely.Point(points[number])))
    return shapely.LineString([*points[first:], *points[: first + 1]])


def _lower_left(ring: shapely.LineString) -> Point:
    x_m, y_m = ring.coords[0]
    return x_m + y_m, x_m
