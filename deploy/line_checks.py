"""What a line patrol needs beyond any scenario: that line, segments, bodies, batteries and thresholds fit.

Parameters are those of `line_patrol` and `line_keeper`; of other behaviours nothing is asked.
"""

import math
from itertools import pairwise
from typing import Any

from deploy.mistake import Mistake
from wire.fields import Polyline
from wire.line import Line
from wire.scenario import BatterySection, Range, Scenario

SHARPEST_TURN_DEG = 120.0
FARTHEST_M = 1e6
ON_THE_LINE = 1e-6  # of its length
ROUNDING_M = 1e-9
RESERVE = 1.5  # of the charge for a last lap and the way home
SLACK = 1.1  # of the time for the laps between two reports
HOME_V, SWAP_BELOW_V, REPORT_LAPS = 8.5, 8.7, 10  # as in line_patrol
LOW_V, MARGIN_V, READY_V, SILENCE_S, DISPATCH_S = 8.5, 0.1, 8.7, 300.0, 10.0  # as in line_keeper


def check_line(scenario: Scenario) -> None:
    """Raises Mistake for the first part of a line patrol that does not fit."""
    field = scenario.field
    _check_points(field)
    length_m = math.fsum(math.dist(one, other) for one, other in pairwise(field.points_m))
    _check_segments(field, length_m)
    line = Line(field, (scenario.tower.x_m, scenario.tower.y_m))
    _check_approach(field, line)
    _check_tower(scenario, line)
    _check_robots(scenario, line)
    _check_queue(scenario, line)
    if scenario.battery is not None:
        _check_battery(scenario, scenario.battery, line)
    _check_silence(scenario, line)
    _check_deployment(scenario, line)


def _check_points(field: Polyline) -> None:
    points = field.points_m
    if len(points) < 2:
        raise Mistake(f"field.points_m must have at least 2 points, got {len(points)}")
    for number, point in enumerate(points):
        if max(map(abs, point)) > FARTHEST_M:
            raise Mistake(f"field.points_m[{number}] must be within {FARTHEST_M:g} m, got {_at(point)}")
    legs = list(pairwise(points))
    for number, (one, other) in enumerate(legs):
        if one == other:
            raise Mistake(
                f"field.points_m[{number + 1}] must differ from the point before it, got {_at(one)}"
            )
    for number, ((start, bend), (_, end)) in enumerate(pairwise(legs), start=1):
        turn_deg = abs(math.degrees(_turn_rad(start, bend, end)))
        if turn_deg > SHARPEST_TURN_DEG + 1e-6:
            most = f"{SHARPEST_TURN_DEG:.0f} degrees"
            raise Mistake(
                f"field.points_m[{number}]: the line must turn by at most {most}, got {turn_deg:.1f}"
            )
    _check_lane(field)


def _check_lane(field: Polyline) -> None:
    """A lane beside the line is shorter than it on the inner side of bends; something must be left of it."""
    points = field.points_m
    turns_rad = [0.0, *(_turn_rad(*points[number : number + 3]) for number in range(len(points) - 2)), 0.0]
    for number, (one, other) in enumerate(pairwise(points)):
        cut = math.tan(turns_rad[number] / 2) + math.tan(turns_rad[number + 1] / 2)
        if field.lane_m * cut >= math.dist(one, other):
            most = f"{math.dist(one, other) / cut:.4g}"
            between = f"field.points_m[{number}] and [{number + 1}]"
            raise Mistake(
                f"field.lane_m must be < {most} to fit into the bends at {between}, got {field.lane_m}"
            )


def _check_segments(field: Polyline, length_m: float) -> None:
    if isinstance(field.segments, int):
        if (field.segments - 1) * field.gap_m >= length_m:
            room = f"{field.segments} segments on a line of {length_m:.4g} m"
            raise Mistake(f"field.gap_m must leave some length for {room}, got {field.gap_m}")
        return
    if not field.segments:
        raise Mistake("field.segments must have at least one segment, got none")
    last_m = 0.0
    for number, (start_m, end_m) in enumerate(field.segments):
        place, got = f"field.segments[{number}]", f"got {_at((start_m, end_m))}"
        if end_m <= start_m:
            raise Mistake(f"{place} must end after its start, {got}")
        if start_m < 0 or end_m > length_m + ROUNDING_M:
            raise Mistake(f"{place} must lie on the line, between 0 and {length_m:.6g} m, {got}")
        if start_m < last_m - ROUNDING_M:
            raise Mistake(f"{place} must start at or after the end of the one before ({last_m:g} m), {got}")
        last_m = end_m


def _check_approach(field: Polyline, line: Line) -> None:
    """Where there are gaps, a robot changes lanes within them; without, on its neighbour's segment."""
    for left, right in pairwise(line.segments):
        gap_m = right.left_m - left.right_m
        if ROUNDING_M < gap_m < field.approach_m - ROUNDING_M:
            between = f"between segments {left.number} and {right.number}"
            raise Mistake(
                f"field.approach_m must be <= the gap {between} ({gap_m:.4g} m), got {field.approach_m}"
            )


def _check_tower(scenario: Scenario, line: Line) -> None:
    tower_m = (scenario.tower.x_m, scenario.tower.y_m)
    away_m = math.dist(tower_m, line.point(line.tower_arc_m))
    if away_m > ON_THE_LINE * line.length_m:
        got = f"{_at(tower_m)}, {away_m:.4g} m off it"
        raise Mistake(f"tower.x_m and tower.y_m must be a place on the line, got {got}")


def _check_robots(scenario: Scenario, line: Line) -> None:
    robots, tick_s = scenario.robots, scenario.tick_s
    if len(scenario.robot_ids) < len(line.segments):
        most = len(scenario.robot_ids)
        raise Mistake(f"field.segments must be at most as many as robots ({most}), got {len(line.segments)}")
    if line.lane_m < robots.body_m:
        raise Mistake(f"field.lane_m must be >= robots.body_m ({robots.body_m}), got {line.lane_m}")
    step_m = robots.max_speed_m_s * tick_s
    if 0 < robots.body_m <= step_m:
        least = f"robots.max_speed_m_s * tick_s ({step_m:.4g} m), or bodies jump over each other"
        raise Mistake(f"robots.body_m must be 0 or > {least}, got {robots.body_m}")
    for number, fault in enumerate(scenario.faults):
        if fault.place == "queue" and fault.verb != "restart":
            raise Mistake(
                f"faults[{number}].place must be here for {fault.verb}, got queue; only a restart moves"
            )


def _check_queue(scenario: Scenario, line: Line) -> None:
    """Who waits in the queue hears the tower itself: nobody there passes anything on."""
    range_m, tower_m = _range_m(scenario), (scenario.tower.x_m, scenario.tower.y_m)
    farthest_m = max(math.dist(tower_m, line.slot(row)) for row in range(len(scenario.robot_ids)))
    if "line_patrol" in scenario.robots.behaviour and range_m < farthest_m:
        what = "for the tower to be heard in the whole queue"
        raise Mistake(f"radio.rules: range_m must be >= {_up(farthest_m)} {what}, got {range_m}")


def _check_battery(scenario: Scenario, battery: BatterySection, line: Line) -> None:
    full_v, empty_v = battery.full_v, battery.empty_v
    if empty_v >= full_v:
        raise Mistake(f"battery.empty_v must be < full_v ({full_v}), got {empty_v}")
    low_v, margin_v = _of_tower(scenario, "low_v", LOW_V), _of_tower(scenario, "margin_v", MARGIN_V)
    home_v = _of_robots(scenario, "home_v", HOME_V)
    thresholds = {
        "tower.parameters.low_v": low_v,
        "tower.parameters.ready_v": _of_tower(scenario, "ready_v", READY_V),
        "robots.parameters.home_v": home_v,
        "robots.parameters.swap_below_v": _of_robots(scenario, "swap_below_v", SWAP_BELOW_V),
    }
    for name, volts in thresholds.items():
        if volts is not None and not empty_v <= volts <= full_v:
            within = f"battery.empty_v ({empty_v}) and full_v ({full_v})"
            raise Mistake(f"{name} must be between {within}, got {volts}")
    if low_v is not None and margin_v is not None and low_v + margin_v > full_v:
        most = f"battery.full_v - low_v ({full_v - low_v:.4g})"
        raise Mistake(f"tower.parameters.margin_v must be <= {most}, got {margin_v}")
    if home_v is None:
        return
    least_v = empty_v + RESERVE * _last_way_v(scenario, battery, line)
    if home_v < least_v:
        what = f"to finish a lap and drive home from the end of the line with {RESERVE} times the charge"
        raise Mistake(f"robots.parameters.home_v must be >= {_up(least_v)} {what}, got {home_v}")


def _last_way_v(scenario: Scenario, battery: BatterySection, line: Line) -> float:
    """The charge for a lap of the longest segment and the way home from the farther end of the line."""
    far_m = max(line.tower_arc_m, line.length_m - line.tower_arc_m)
    home_s = far_m / scenario.robots.max_speed_m_s
    return (_lap_s(scenario, line) * battery.patrolling_v_h + home_s * battery.travelling_v_h) / 3600


def _check_silence(scenario: Scenario, line: Line) -> None:
    """The tower must not take a robot for lost between two of its reports."""
    laps = _of_robots(scenario, "report_laps", REPORT_LAPS)
    silence_s = _of_tower(scenario, "silence_s", SILENCE_S)
    if laps is None or silence_s is None:
        return
    least_s = SLACK * laps * _lap_s(scenario, line)
    if silence_s < least_s:
        why = f"robots report every {laps:g} laps of up to {_lap_s(scenario, line):.4g} s"
        raise Mistake(
            f"tower.parameters.silence_s must be >= {math.ceil(least_s)}, as {why}, got {silence_s}"
        )


def _check_deployment(scenario: Scenario, line: Line) -> None:
    """The outermost robots leave first. Where the tower cannot hear them, they may be silent until the last
    ones have come to their segments, and must not count as lost before.
    """
    silence_s = _of_tower(scenario, "silence_s", SILENCE_S)
    interval_s = _of_tower(scenario, "dispatch_interval_s", DISPATCH_S)
    tower_m = (scenario.tower.x_m, scenario.tower.y_m)
    far_m = max(math.dist(tower_m, line.point(one.far_m)) for one in line.segments)
    if silence_s is None or interval_s is None or far_m <= _range_m(scenario):
        return
    way_m = max(abs(one.near_m - line.tower_arc_m) for one in line.segments)
    least_s = len(line.segments) * interval_s + way_m / scenario.robots.max_speed_m_s
    if silence_s < least_s:
        why = "until all robots are out the tower may not hear the outermost ones"
        raise Mistake(
            f"tower.parameters.silence_s must be >= {math.ceil(least_s)}, as {why}, got {silence_s}"
        )


def _range_m(scenario: Scenario) -> float:
    """How far the radio reaches."""
    return min((one.range_m for one in scenario.radio.rules if isinstance(one, Range)), default=math.inf)


def _lap_s(scenario: Scenario, line: Line) -> float:
    """A lap of the longest segment at full speed, with its two turns unless robots need not turn."""
    robots = scenario.robots
    turns_s = 0.0 if robots.parameters.get("backwards") is True else 2 * math.pi / robots.max_turn_rad_s
    return 2 * max(one.length_m for one in line.segments) / robots.max_speed_m_s + turns_s


def _of_robots(scenario: Scenario, name: str, default: float) -> float | None:
    return _parameter(scenario.robots, "line_patrol", name, default)


def _of_tower(scenario: Scenario, name: str, default: float) -> float | None:
    return _parameter(scenario.tower, "line_keeper", name, default)


def _parameter(section: Any, behaviour: str, name: str, default: float) -> float | None:
    """A number among the raw parameters of one behaviour; None where there is none to judge."""
    if behaviour not in section.behaviour:
        return None
    value = section.parameters.get(name, default)
    return value if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def _turn_rad(start: tuple[float, float], bend: tuple[float, float], end: tuple[float, float]) -> float:
    """By how much the way turns at a point, to the left if positive."""
    before_x, before_y = bend[0] - start[0], bend[1] - start[1]
    after_x, after_y = end[0] - bend[0], end[1] - bend[1]
    return math.atan2(before_x * after_y - before_y * after_x, before_x * after_x + before_y * after_y)


def _up(volts: float) -> float:
    """Rounded up, so that what is told would do."""
    return math.ceil(volts * 1000) / 1000


def _at(place: tuple[float, float]) -> str:
    return f"[{place[0]:g}, {place[1]:g}]"
