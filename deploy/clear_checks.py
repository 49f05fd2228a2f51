"""What clearing a floor plan needs beyond any scenario: robots that can clear it, and hear each other.

`obstacle_m` and `follow_m` are parameters of the robots' behaviour, judged where they are given.
"""

import math

import shapely

from deploy.mistake import Mistake
from deploy.plan_file import polygon_of
from wire.scenario import Cluster, Poses, Range, Scenario, Sensors
from world_server.deployment import cluster_places
from world_server.floorplan import PlanError
from world_server.plan_checks import check_plan, narrowest_island_m

OBSTACLE_M = 0.25
SECOND_M = 0.06
"""Two hops of a robust line must be a link, with room for a step and for rounding."""
WIDEST_M, MOST_WALLS_M = 300.0, 5000.0
OTHER_TOWERS = ("base_station", "line_keeper")


def check_clear(scenario: Scenario) -> None:
    """Raises Mistake for the first part of a clearing that does not fit."""
    detect_m = (scenario.sensors or Sensors()).detect_m
    if scenario.tower.behaviour in OTHER_TOWERS:
        raise Mistake(f"tower.behaviour must be one for mission clear, got {scenario.tower.behaviour}")
    _check_body(scenario)
    _check_ranges(scenario, detect_m)
    plan = polygon_of(scenario.field.rings_m)
    _check_size(plan)
    _check_islands(plan, scenario.robots.max_speed_m_s * scenario.tick_s)
    try:
        check_plan(plan, obstacle_m(scenario), detect_m)
    except PlanError as error:
        raise Mistake(f"field: {error}") from None
    _check_start(scenario, plan)


def obstacle_m(scenario: Scenario) -> float:
    """How far robots stay from walls."""
    return _parameter(scenario, "obstacle_m", OBSTACLE_M)


def _check_size(plan: shapely.Polygon) -> None:
    """Millimetres taken for metres would keep the checks and the referee busy for hours."""
    west_m, south_m, east_m, north_m = plan.bounds
    size_m = max(east_m - west_m, north_m - south_m)
    if size_m > WIDEST_M:
        raise Mistake(f"field must be at most {WIDEST_M:g} m wide and high, got {size_m:.4g} m")
    if plan.length > MOST_WALLS_M:
        raise Mistake(f"field must have at most {MOST_WALLS_M:g} m of walls, got {plan.length:.4g} m")


def _check_islands(plan: shapely.Polygon, step_m: float) -> None:
    """Round an island narrower than its step a robot may pass on either side: nobody knows what it saw."""
    narrowest_m = narrowest_island_m(plan)
    if narrowest_m <= step_m:
        right = f"wider than robots go in a tick ({step_m:.4g} m)"
        raise Mistake(f"field: islands must be {right}, got {narrowest_m:.4g} m")


def _check_body(scenario: Scenario) -> None:
    body_m, keep_m = scenario.robots.body_m, obstacle_m(scenario)
    if scenario.robots.noise_sd > 0:
        got = scenario.robots.noise_sd
        raise Mistake(f"robots.noise_sd must be 0 for mission clear, whose noise is in sensors, got {got}")
    if body_m <= 0:
        raise Mistake(f"robots.body_m must be > 0 for mission clear, got {body_m}")
    if body_m >= 2 * keep_m:
        right = f"< 2 obstacle_m ({2 * keep_m:g}), how far robots stay from walls"
        raise Mistake(f"robots.body_m must be {right}, got {body_m:g}")


def _check_ranges(scenario: Scenario, detect_m: float) -> None:
    """Neighbours on a line are up to two detection ranges apart, and must hear each other."""
    ranges_m = [rule.range_m for rule in scenario.radio.rules if isinstance(rule, Range)]
    least = f"2 sensors.detect_m ({2 * detect_m:g})"
    if not ranges_m:
        raise Mistake(f"radio.rules must have a range > {least} for mission clear, got none")
    if min(ranges_m) <= 2 * detect_m:
        raise Mistake(f"radio.rules: range_m must be > {least}, got {min(ranges_m):g}")
    follow_m = _parameter(scenario, "follow_m", 0.0)
    if follow_m > 2 * detect_m:
        raise Mistake(f"robots.parameters.follow_m must be <= {least}, got {follow_m:g}")
    most_m = detect_m - SECOND_M
    if scenario.robots.parameters.get("spacing") == "robust" and follow_m > most_m + 1e-9:
        right = f'<= sensors.detect_m - {SECOND_M:g} ({most_m:g}) where spacing is "robust"'
        raise Mistake(f"robots.parameters.follow_m must be {right}, got {follow_m:g}")


def _check_start(scenario: Scenario, plan: shapely.Polygon) -> None:
    start, body_m = scenario.robots.start, scenario.robots.body_m
    if isinstance(start, Cluster):
        try:
            cluster_places(plan, (start.x_m, start.y_m), len(scenario.robot_ids), body_m)
        except PlanError as error:
            raise Mistake(f"robots.start: {error}") from None
    else:
        _check_places(start, plan, body_m)


def _check_places(start: Poses, plan: shapely.Polygon, body_m: float) -> None:
    """Bodies that overlap, or stand in a wall, are none."""
    room = plan.buffer(-body_m / 2)
    for number, (x_m, y_m, _) in enumerate(start.poses):
        place, got = f"robots.start.poses[{number}]", f"got [{x_m:g}, {y_m:g}]"
        if not shapely.intersects_xy(room, x_m, y_m):
            raise Mistake(f"{place} must be in the plan, {body_m / 2:g} m from its walls, {got}")
        for other, (other_x_m, other_y_m, _) in enumerate(start.poses[:number]):
            if math.hypot(x_m - other_x_m, y_m - other_y_m) < body_m:
                raise Mistake(f"{place} must be at least {body_m:g} m from pose {other}, {got}")


def _parameter(scenario: Scenario, name: str, default: float) -> float:
    value = scenario.robots.parameters.get(name, default)
    return value if isinstance(value, int | float) and math.isfinite(value) else default
