"""How mission clear begins: the floor plan as a polygon, and where robots stand in it, with which fronts.

Where the field is turned, all of this is turned about the origin, after it was worked out.
"""

import math

import numpy as np
import shapely

from wire.channels import number_of
from wire.fields import FloorPlan, Point
from wire.messages import Pose
from wire.scenario import Cluster, Scenario
from world_server import chance
from world_server.floorplan import PlanError
from world_server.motion import first_poses, wrapped

SPARE_M = 0.02  # between bodies in a cluster, and between them and walls
NEARBY_M = 2.0


def plan_of(field: FloorPlan) -> shapely.Polygon:
    """The free space of a loaded field, before it is turned."""
    shell, *holes = field.rings_m
    return shapely.Polygon(shell, holes)


def turned(geometry: shapely.Geometry, angle_rad: float) -> shapely.Geometry:
    """A geometry turned about the origin."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return shapely.transform(geometry, lambda points_m: points_m @ np.array([[cos, sin], [-sin, cos]]))


def turned_point(point: Point, angle_rad: float) -> Point:
    """A point turned about the origin."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return cos * point[0] - sin * point[1], sin * point[0] + cos * point[1]


def deployed(scenario: Scenario) -> dict[str, Pose]:
    """Where every node begins, turned. The front of each robot is drawn, whatever pose the scenario gives."""
    start, robots = scenario.robots.start, scenario.robot_ids
    if isinstance(start, Cluster):
        plan, point = plan_of(scenario.field), (start.x_m, start.y_m)
        places_m = cluster_places(plan, point, len(robots), scenario.robots.body_m)
    else:
        poses = first_poses(scenario)
        places_m = [(poses[node].x_m, poses[node].y_m) for node in robots]
    places = dict(zip(robots, places_m, strict=True))
    places[scenario.tower.id] = (scenario.tower.x_m, scenario.tower.y_m)
    return {node: _posed(scenario, node, places[node]) for node in scenario.node_ids}


def cluster_places(plan: shapely.Polygon, point: Point, count: int, body_m: float) -> list[Point]:
    """The places of a hexagonal packing nearest to a point of the plan, nearest first. Raises PlanError."""
    if not shapely.intersects_xy(plan, *point):
        raise PlanError(f"must be a point of the plan, got [{point[0]:g}, {point[1]:g}]")
    apart_m = body_m + SPARE_M
    around = shapely.Point(point).buffer(NEARBY_M)
    room = plan.buffer(-body_m / 2 - SPARE_M).intersection(around)
    parts = [part for part in shapely.get_parts(room) if part.area > 0]
    part = min(parts, key=lambda one: one.distance(shapely.Point(point)), default=shapely.Polygon())
    lattice = _lattice(apart_m) + point
    fits = lattice[shapely.intersects_xy(part, *lattice.T)] if len(lattice) else lattice
    if len(fits) < count:
        raise PlanError(f"at most {len(fits)} robots fit within {NEARBY_M:g} m of it, got {count}")
    return [(x_m, y_m) for x_m, y_m in fits[:count].tolist()]


def _lattice(apart_m: float) -> np.ndarray:
    """A hexagonal lattice around the origin, (points, 2), nearest first, equally near ones by angle."""
    most = math.ceil(NEARBY_M / (apart_m * math.sqrt(0.75)))
    row, column = np.mgrid[-most : most + 1, -2 * most : 2 * most + 1].reshape(2, -1)
    points = np.stack((apart_m * (column + row / 2), apart_m * math.sqrt(0.75) * row), axis=1)
    away_m = np.round(np.hypot(*points.T), 9)
    angles = np.round(np.mod(np.arctan2(points[:, 1], points[:, 0]), 2 * np.pi), 9)
    order = np.lexsort((angles, away_m))
    return points[order][away_m[order] <= NEARBY_M]


def _posed(scenario: Scenario, node: str, place_m: Point) -> Pose:
    """A node at a place, with a front drawn by chance; all turned."""
    angle_rad = scenario.field.turned_rad
    drawn_rad = chance.generator(scenario.seed, "front", number_of(node)).random() * 2 * math.pi
    return Pose(*turned_point(place_m, angle_rad), wrapped(drawn_rad + angle_rad))
