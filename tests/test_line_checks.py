"""What does not fit in a line patrol is told in one line: the field, what would be right, and the value."""

import tomllib
from typing import Any

import msgspec
import pytest

from deploy.mistake import Mistake
from deploy.scenario_checks import check
from deploy.scenario_file import ScenarioError, load_scenario, shipped_scenarios
from wire.scenario import Scenario
from world_server.fault_plan import FaultPlan
from world_server.world import World

GOOD: dict[str, Any] = {
    "mission": "line",
    "duration_s": 1000,
    "field": {
        "kind": "polyline",
        "points_m": [[-6, -8], [0, 0], [10, 0]],
        "segments": 4,
        "gap_m": 0.4,
        "approach_m": 0.2,
    },
    "robots": {
        "count": 5,
        "behaviour": "line_patrol",
        "start": {"kind": "queue"},
        "max_speed_m_s": 0.5,
        "max_turn_rad_s": 3.1416,
        "body_m": 0.19,
    },
    "tower": {"behaviour": "line_keeper"},
    "tick_s": 0.25,
    "battery": {},
}
AREA: dict[str, Any] = {
    "mission": "area",
    "duration_s": 1000,
    "field": {"kind": "grid"},
    "robots": {"count": 4, "behaviour": "lr_pt"},
}
KILL = {"at_s": 10, "verb": "kill", "nodes": ["r3"]}
BACK = {"at_s": 20, "verb": "restart", "nodes": ["r3"], "place": "queue"}


def changed(document: dict[str, Any], **changes: Any) -> dict[str, Any]:
    """A document with other values at places such as field__gap_m; None takes one out."""
    new = msgspec.msgpack.decode(msgspec.msgpack.encode(document))
    for place, value in changes.items():
        *path, last = place.split("__")
        table = new
        for name in path:
            table = table.setdefault(name, {})
        table.pop(last, None)
        if value is not None:
            table[last] = value
    return new


def complaint(document: dict[str, Any], **changes: Any) -> str:
    """The one mistake that is found in a changed document."""
    with pytest.raises(Mistake) as caught:
        check(msgspec.convert(changed(document, **changes), Scenario))
    return str(caught.value)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"field__segments": [[0, 1], [1, 4], [4.5, 8]]},
        {"field__gap_m": 0, "field__approach_m": 3},
        {"field__segments": 5},
        {"tower__x_m": -3, "tower__y_m": -4},
        {"tower__x_m": 10},
        {"robots__body_m": 0, "tick_s": 3},
        {"battery": None, "robots__parameters__home_v": 1},
        {"faults": [KILL, BACK]},
        {"tower__parameters__silence_s": 229},
        {"robots__parameters__report_laps": 13},
        {"robots__parameters__home_v": 8.1, "tower__parameters__low_v": 8.9},
        {"robots__parameters__home_v": "high", "tower__parameters__silence_s": True},
        {"robots__behaviour": "stand_still", "robots__parameters__home_v": 99},
        {"field__points_m": [[-6, -8], [0, 0], [10, 0], [5, 8.6603]], "tower__parameters__silence_s": 400},
    ],
)
def test_what_fits_is_accepted(changes):
    check(msgspec.convert(changed(GOOD, **changes), Scenario))


MISTAKES = [
    ({"field": {"kind": "grid"}}, "field.kind must be polyline for mission line, got grid"),
    ({"field__points_m": [[0, 0]]}, "field.points_m must have at least 2 points, got 1"),
    ({"field__points_m": []}, "field.points_m must have at least 2 points, got 0"),
    (
        {"field__points_m": [[0, 0], [10, 0], [10, 0], [20, 0]]},
        "field.points_m[2] must differ from the point before it, got [10, 0]",
    ),
    ({"field__points_m": [[0, 0], [1e300, 0]]}, "field.points_m[1] must be within 1e+06 m, got [1e+300, 0]"),
    (
        {"field__points_m": [[-10, 0], [10, 0], [0, 1]]},
        "field.points_m[1]: the line must turn by at most 120 degrees, got 174.3",
    ),
    (
        {"field__points_m": [[-10, 0], [0, 0], [0, 0.5], [-10, 0.5]]},
        "field.lane_m must be < 0.25 to fit into the bends at field.points_m[1] and [2], got 0.3",
    ),
    ({"field__gap_m": 7}, "field.gap_m must leave some length for 4 segments on a line of 20 m, got 7.0"),
    ({"field__segments": []}, "field.segments must have at least one segment, got none"),
    ({"field__segments": [[0, 4], [6, 6]]}, "field.segments[1] must end after its start, got [6, 6]"),
    ({"field__segments": [[4, 0]]}, "field.segments[0] must end after its start, got [4, 0]"),
    (
        {"field__segments": [[-1, 4]]},
        "field.segments[0] must lie on the line, between 0 and 20 m, got [-1, 4]",
    ),
    (
        {"field__segments": [[0, 4], [5, 20.1]]},
        "field.segments[1] must lie on the line, between 0 and 20 m, got [5, 20.1]",
    ),
    (
        {"field__segments": [[0, 4], [3, 8]]},
        "field.segments[1] must start at or after the end of the one before (4 m), got [3, 8]",
    ),
    (
        {"field__approach_m": 0.5},
        "field.approach_m must be <= the gap between segments 1 and 2 (0.4 m), got 0.5",
    ),
    (
        {"field__segments": [[0, 4], [5, 8], [8.1, 9]]},
        "field.approach_m must be <= the gap between segments 2 and 3 (0.1 m), got 0.2",
    ),
    ({"tower__y_m": 3}, "tower.x_m and tower.y_m must be a place on the line, got [0, 3], 3 m off it"),
    ({"tower__x_m": 11}, "tower.x_m and tower.y_m must be a place on the line, got [11, 0], 1 m off it"),
    ({"tower__x_m": 1e308}, "tower.x_m and tower.y_m must be a place on the line, got [1e+308, 0], "),
    ({"robots__start": None}, "robots.start.kind must be queue or poses for mission line, got fan"),
    ({"field__segments": 6}, "field.segments must be at most as many as robots (5), got 6"),
    ({"field__lane_m": 0.1}, "field.lane_m must be >= robots.body_m (0.19), got 0.1"),
    (
        {"tick_s": 1},
        "robots.body_m must be 0 or > robots.max_speed_m_s * tick_s (0.5 m), or bodies jump over each "
        "other, got 0.19",
    ),
    (
        {"faults": [KILL | {"place": "queue"}]},
        "faults[0].place must be here for kill, got queue; only a restart moves",
    ),
    ({"battery__empty_v": 9.5}, "battery.empty_v must be < full_v (9.0), got 9.5"),
    (
        {"tower__parameters__low_v": 9.2},
        "tower.parameters.low_v must be between battery.empty_v (8.0) and full_v (9.0), got 9.2",
    ),
    (
        {"robots__parameters__home_v": 7},
        "robots.parameters.home_v must be between battery.empty_v (8.0) and full_v (9.0), got 7",
    ),
    (
        {"battery": {"full_v": 4.2, "empty_v": 3}},
        "tower.parameters.low_v must be between battery.empty_v (3.0) and full_v (4.2), got 8.5",
    ),
    (
        {"tower__parameters__ready_v": 9.5},
        "tower.parameters.ready_v must be between battery.empty_v (8.0) and full_v (9.0), got 9.5",
    ),
    (
        {"tower__parameters__margin_v": 0.6},
        "tower.parameters.margin_v must be <= battery.full_v - low_v (0.5), got 0.6",
    ),
    (
        {"battery__patrolling_v_h": 60, "battery__travelling_v_h": 36},
        "robots.parameters.home_v must be >= 8.82 to finish a lap and drive home from the end of the line "
        "with 1.5 times the charge, got 8.5",
    ),
    (
        {"field__segments": [[0, 16]]},
        "tower.parameters.silence_s must be >= 726, as robots report every 10 laps of up to 66 s, got 300.0",
    ),
    (
        {"robots__parameters__report_laps": 30},
        "tower.parameters.silence_s must be >= 687, as robots report every 30 laps of up to 20.8 s, "
        "got 300.0",
    ),
    (
        {"radio__rules": [{"kind": "range", "range_m": 1.5}]},
        "radio.rules: range_m must be >= 2.013 for the tower to be heard in the whole queue, got 1.5",
    ),
    (
        {"radio__rules": [{"kind": "range", "range_m": 5}], "tower__parameters__dispatch_interval_s": 80},
        "tower.parameters.silence_s must be >= 331, as until all robots are out the tower may not hear the "
        "outermost ones, got 300.0",
    ),
]


@pytest.mark.parametrize(("changes", "said"), MISTAKES)
def test_a_mistake_is_one_clear_line(changes, said):
    told = complaint(GOOD, **changes)
    assert told.startswith(said)
    assert len(told.splitlines()) == 1


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"field": {"kind": "polyline", "points_m": [[0, 0], [9, 0]], "segments": 3}},
            "field.kind must be grid or graph for mission area, got polyline",
        ),
        (
            {"robots__start": {"kind": "queue"}},
            "robots.start.kind must be fan or poses for mission area, got queue",
        ),
        ({"battery": {}}, "battery is for mission line only"),
        ({"faults": [KILL, BACK]}, "faults[1].place must be here for mission area, got queue"),
    ],
)
def test_parts_of_a_line_patrol_have_no_place_in_an_area_patrol(changes, said):
    assert complaint(AREA, **changes) == said


def test_the_least_voltage_that_is_told_would_do():
    """Source: none; half as much again as a lap and the way home take."""
    drains = {"battery__patrolling_v_h": 60, "battery__travelling_v_h": 36}
    check(msgspec.convert(changed(GOOD, robots__parameters__home_v=8.82, **drains), Scenario))
    assert "home_v" in complaint(GOOD, robots__parameters__home_v=8.819, **drains)


def test_a_robot_that_drives_backwards_saves_its_turns():
    """Source: none; two half turns in a lap, at the full rate of turn."""
    reports = {"robots__parameters__report_laps": 14, "tower__parameters__silence_s": 300}
    assert "laps of up to 20.8 s" in complaint(GOOD, **reports)
    check(msgspec.convert(changed(GOOD, robots__parameters__backwards=True, **reports), Scenario))


def test_a_file_with_a_mistake_is_refused_by_its_name(tmp_path):
    lines = """
        mission = "line"
        duration_s = 10
        field = { kind = "polyline", points_m = [[0, 0]], segments = 1 }
        robots = { count = 1, behaviour = "stand_still", start = { kind = "queue" } }
        """
    (tmp_path / "mine.toml").write_text(lines)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(tmp_path / "mine.toml")
    assert str(caught.value) == "mine.toml: field.points_m must have at least 2 points, got 1"
    kept = ["field.points_m=[[-1, 0], [1, 0]]", "tower.behaviour=stand_still"]
    with pytest.raises(ScenarioError):
        load_scenario(tmp_path / "mine.toml", [*kept, "tower.y_m=1"])


@pytest.mark.parametrize("name", [name for name in shipped_scenarios() if name.startswith("line")])
def test_the_parts_of_every_shipped_line_scenario_fit(name):
    """The check alone; that their behaviours exist is for the test of all shipped scenarios."""
    check(msgspec.convert(tomllib.loads(shipped_scenarios()[name].read_text("utf-8")), Scenario))


def test_a_planned_restart_says_where():
    plan = FaultPlan(World(msgspec.convert(changed(GOOD, faults=[KILL, BACK]), Scenario))).due(10**6)
    assert [(one.verb, one.place) for one in plan] == [("kill", "here"), ("restart", "queue")]
