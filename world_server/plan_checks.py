"""What a floor plan needs so that robots which follow its walls can clear it of intruders.

An intruder is a point and can be wherever there is space; a robot keeps a distance from walls. So every point
of the plan must be seen from where robots can be, and these places must be one piece.
"""

import math
from functools import lru_cache

import numpy as np
import shapely

from world_server.floorplan import PlanError
from world_server.sight import Sight

CORNER_MARGIN_M = 0.06  # of the detection range: what a tick of motion and rounding may cost
LOOK_EVERY_M, LOOK_CLOSELY_M = 0.25, 0.01
UNSEEN_M2 = 1e-3  # what is left between two places from which the plan is looked at


@lru_cache(maxsize=256)
def check_plan(plan: shapely.Polygon, obstacle_m: float, detect_m: float) -> None:
    """Raises PlanError for the first reason why robots cannot clear a plan.

    `obstacle_m` is how far robots stay from walls, `detect_m` how far they see. A study has hundreds of runs
    on one plan, so a plan that passed is not looked at again.
    """
    if not plan.is_valid:
        raise PlanError(f"the polygon must be valid, but: {shapely.is_valid_reason(plan)}")
    reachable = plan.buffer(-obstacle_m)
    _check_connected(reachable, obstacle_m)
    _check_corners(plan, reachable, obstacle_m, detect_m)
    _check_seen(plan, reachable, obstacle_m, detect_m)


def unseen(plan: shapely.Polygon, obstacle_m: float, detect_m: float) -> shapely.Geometry:
    """The part of a plan that no robot which stays `obstacle_m` from walls sees within `detect_m`.

    Who looks out of the reachable part looks across its boundary, so it is enough to look from there: first
    from few places, then from many around what they do not see.
    """
    reachable = plan.buffer(-obstacle_m)
    sight = Sight(plan, detect_m)
    hidden = plan.difference(reachable)
    for every_m in (LOOK_EVERY_M, LOOK_CLOSELY_M):
        near = reachable.boundary.intersection(hidden.buffer(detect_m))
        places = shapely.get_coordinates(_places(near, every_m)).tolist()
        hidden = hidden.difference(shapely.union_all([sight.seen_from((x_m, y_m)) for x_m, y_m in places]))
    return hidden


def _places(lines: shapely.Geometry, every_m: float) -> np.ndarray:
    """Points on lines, at most so far apart, with both ends of each line."""
    lines = shapely.get_parts(shapely.line_merge(lines) if lines.geom_type == "MultiLineString" else lines)
    shares = [np.linspace(0, 1, math.ceil(line.length / every_m) + 1) for line in lines]
    points = [
        shapely.line_interpolate_point(line, share, normalized=True)
        for line, share in zip(lines, shares, strict=True)
    ]
    return np.concatenate(points) if points else np.array([])


def _check_connected(reachable: shapely.Geometry, obstacle_m: float) -> None:
    if reachable.is_empty:
        raise PlanError(f"there must be a place at least {obstacle_m:g} m from all walls, but there is none")
    parts = shapely.get_parts(reachable)
    if len(parts) > 1:
        one, other = (_at(part.representative_point()) for part in parts[:2])
        width = (
            f"no passage may be narrower than {2 * obstacle_m:g} m (robots stay {obstacle_m:g} m from walls)"
        )
        raise PlanError(f"{width}, but no robot can come from {one} to {other}")


def _check_corners(
    plan: shapely.Polygon, reachable: shapely.Geometry, obstacle_m: float, detect_m: float
) -> None:
    """A robot that follows the walls must see into every corner with a margin to spare.

    In a corner between two long walls it comes as near as obstacle_m / sin(angle / 2). A notch so small that
    robots pass it by is no corner in this sense, however sharp: what counts is how near they come.
    """
    within_m = detect_m - CORNER_MARGIN_M
    points = shapely.get_coordinates(plan)
    away_m = shapely.distance(shapely.points(points), reachable)
    worst = int(away_m.argmax())
    if away_m[worst] > within_m:
        sharpest = math.degrees(2 * math.asin(min(1.0, obstacle_m / within_m)))
        raise PlanError(
            f"no corner may be sharper than {sharpest:.0f} degrees (robots {obstacle_m:g} m from walls must "
            f"come within {within_m:.4g} m of it), but they come no nearer than {away_m[worst]:.3g} m to "
            f"{_at(shapely.Point(points[worst]))}"
        )


def _check_seen(
    plan: shapely.Polygon, reachable: shapely.Geometry, obstacle_m: float, detect_m: float
) -> None:
    hidden = max(shapely.get_parts(unseen(plan, obstacle_m, detect_m)), key=shapely.area, default=None)
    if hidden is not None and hidden.area > UNSEEN_M2:
        raise PlanError(
            f"every point must be seen from within {detect_m:g} m by a robot {obstacle_m:g} m from walls, "
            f"but {hidden.area:.3g} m2 at {_at(hidden.representative_point())} are not"
        )


def narrowest_island_m(plan: shapely.Polygon) -> float:
    """The least width of all islands, each the distance of the closest parallel lines around it."""
    return min((_width_m(shapely.Polygon(ring)) for ring in plan.interiors), default=math.inf)


def _width_m(island: shapely.Polygon) -> float:
    corners = shapely.get_coordinates(island.convex_hull)
    ways = np.diff(corners, axis=0)
    aside = (corners[None] - corners[:-1, None]) @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    distances = np.abs((aside * ways[:, None]).sum(axis=2)) / np.linalg.norm(ways, axis=1)[:, None]
    return float(distances.max(axis=1).min())


def _at(point: shapely.Point) -> str:
    return f"[{point.x:.4g}, {point.y:.4g}]"
