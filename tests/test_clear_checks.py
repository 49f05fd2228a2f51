"""What does not fit in a clearing is told in one line: the field, what would be right, and the value."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
import tomli_w
from PIL import Image

from deploy.clear_checks import obstacle_m
from deploy.__main__ import OPERATOR_MISTAKE, carry_out
from deploy.scenario_file import ScenarioError, load_scenario, shipped_scenarios, to_toml
from tests.clear_builders import ELL, WANDERING
from tests.test_line_checks import changed
from wire.fields import FloorPlan
from wire.scenario import Scenario, Sensors
from world_server.random_plans import random_plan

GOOD: dict[str, Any] = {
    "mission": "clear",
    "duration_s": 100,
    "tick_s": 0.25,
    "field": {"kind": "plan", "rings_m": [list(map(list, ELL))]},
    "robots": {
        "count": 4,
        "behaviour": WANDERING,
        "start": {"kind": "cluster", "x_m": 5.0, "y_m": 1.0},
        "max_speed_m_s": 0.2,
        "body_m": 0.2,
        "parameters": {"follow_m": 1.0, "obstacle_m": 0.25},
    },
    "tower": {"behaviour": "swarm_agent.behaviours.stand_still:StandStill"},
    "radio": {"rules": [{"kind": "range", "range_m": 2.0}]},
}
AREA = {
    "mission": "area",
    "duration_s": 100,
    "robots": {"count": 4, "behaviour": "lr_pt"},
    "field": {"kind": "grid"},
}
NARROW = [[0, 0], [6, 0], [6, 2], [3.2, 2], [3.2, 1.6], [2.8, 1.6], [2.8, 2], [2, 2], [2, 6], [0, 6]]
NECK = [
    [0, 0],
    [2, 0],
    [2, 0.8],
    [3, 0.8],
    [3, 0],
    [6, 0],
    [6, 2],
    [3, 2],
    [3, 1.2],
    [2, 1.2],
    [2, 2],
    [0, 2],
]


TEETH = [
    (x_m, y_m) for step in range(100) for x_m, y_m in ((2 * step, 1), (2 * step, 260), (2 * step + 1, 260))
]
COMB = [[0, 0], *([x_m + 0.5, y_m] for x_m, y_m in TEETH), [250, 1], [250, 0]]


def loaded(folder: Path, document: dict[str, Any], *settings: str) -> Scenario:
    (folder / "mine.toml").write_text(tomli_w.dumps(document))
    return load_scenario(folder / "mine.toml", list(settings))


def complaint(folder: Path, document: dict[str, Any], *settings: str) -> str:
    with pytest.raises(ScenarioError) as caught:
        loaded(folder, document, *settings)
    said = str(caught.value)
    assert said.startswith("mine.toml: ") and "\n" not in said
    return said.removeprefix("mine.toml: ")


def test_a_good_one_loads_whole_and_comes_back(tmp_path):
    scenario = loaded(tmp_path, GOOD)
    assert (scenario.tower.x_m, scenario.tower.y_m) == (5.0, 1.0), (
        "the tower is where the robots are deployed"
    )
    assert scenario.sensors == Sensors()
    (tmp_path / "again.toml").write_text(to_toml(scenario))
    assert load_scenario(tmp_path / "again.toml") == scenario


def test_the_tower_stands_where_it_is_told(tmp_path):
    tower = loaded(tmp_path, changed(GOOD, tower__x_m=1.0)).tower
    assert (tower.x_m, tower.y_m) == (1.0, 0.0)


def poses(*places: tuple[float, float]) -> dict[str, Any]:
    return {"kind": "poses", "poses": [[*place, 0.0] for place in places]}


KILL = {"verb": "kill", "nodes": ["r2"]}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"radio__rules": [{"kind": "range", "range_m": 1.4}]},
            "radio.rules: range_m must be > 2 sensors.detect_m (1.4), got 1.4",
        ),
        (
            {"radio__rules": [{"kind": "loss", "probability": 0.1}]},
            "radio.rules must have a range > 2 sensors.detect_m (1.4) for mission clear, got none",
        ),
        (
            {"robots__parameters__follow_m": 1.41},
            "robots.parameters.follow_m must be <= 2 sensors.detect_m (1.4), got 1.41",
        ),
        ({"robots__count": 200}, "robots.start: at most 118 robots fit within 2 m of it, got 200"),
        (
            {"robots__start": {"kind": "cluster", "x_m": 3, "y_m": 3}},
            "robots.start: must be a point of the plan, got [3, 3]",
        ),
        (
            {"robots__start": {"kind": "fan"}},
            "robots.start.kind must be cluster or poses for mission clear, got fan",
        ),
        (
            {"robots__start": {"kind": "queue"}},
            "robots.start.kind must be cluster or poses for mission clear, got queue",
        ),
        (
            {"robots__start": [1, 2, 3, 4]},
            "robots.start must be cluster or poses for mission clear, got a list of sites",
        ),
        (
            {"robots__start": poses((1, 1), (1, 1.3), (1, 1.45), (1, 2))},
            "robots.start.poses[2] must be at least 0.2 m from pose 1, got [1, 1.45]",
        ),
        (
            {"robots__start": poses((1, 1), (1, 1.3), (1.95, 3), (1, 2))},
            "robots.start.poses[2] must be in the plan, 0.1 m from its walls, got [1.95, 3]",
        ),
        (
            {"robots__noise_sd": 0.1},
            "robots.noise_sd must be 0 for mission clear, whose noise is in sensors, got 0.1",
        ),
        (
            {"field__rings_m": [[*map(list, ELL)], [[1, 1], [1, 1.04], [1.5, 1.04], [1.5, 1]]]},
            "field: islands must be wider than robots go in a tick (0.05 m), got 0.04 m",
        ),
        ({"robots__body_m": 0.0}, "robots.body_m must be > 0 for mission clear, got 0.0"),
        (
            {"robots__body_m": 0.6},
            "robots.body_m must be < 2 obstacle_m (0.5), how far robots stay from walls, got 0.6",
        ),
        ({"tower__behaviour": None}, "tower.behaviour must be one for mission clear, got base_station"),
        ({"field": {"kind": "grid"}}, "field.kind must be plan for mission clear, got grid"),
        ({"battery": {}}, "battery is for mission line only"),
        ({"robots__shared_last_visit": True}, "robots.shared_last_visit is for mission area only"),
        (
            {"faults": [{"at_s": 5, "verb": "kill", "nodes": ["r2"]} | {"place": "queue"}]},
            "faults[0].place must be here for mission clear, got queue",
        ),
        ({"sensors": {"rays": 45}}, "sensors.rays must be a whole number >= 90, got 45"),
        (
            {"field__rings_m": [NECK]},
            "field: no passage may be narrower than 0.5 m (robots stay 0.25 m from walls), but no robot can "
            "come from [1.048, 1.003] to [4.452, 1.003]",
        ),
        ({"field__rings_m": [[[0, 0], [1, 0]]]}, "field.rings_m: must be the rings of a polygon"),
        ({"field__rings_m": [[[0, 0], [4, 4], [4, 0], [0, 3]]]}, "field: the polygon must be valid"),
        (
            {"field__rings_m": [[[0, 0], [6000, 0], [6000, 4000], [0, 4000]]]},
            "field must be at most 300 m wide and high, got 6000 m",
        ),
        ({"field__rings_m": [COMB]}, "field must have at most 5000 m of walls, got 5.216e+04 m"),
        ({"field__rings_m": None}, "field must have one of plan, random and rings_m, got none"),
        ({"field__plan": "cave"}, "field must have one of plan, random and rings_m, got plan and rings_m"),
        ({"field__metres_per_px": 0.1}, "field.metres_per_px is for a picture as plan only"),
        (
            {"field": {"kind": "plan", "plan": "caves"}},
            "field.plan: caves: must end in .wkt, .geojson, .json",
        ),
        ({"field": {"kind": "plan", "plan": "a.wkt"}}, "field.plan: a.wkt: cannot be read: No such file"),
        (
            {"field": {"kind": "plan", "random": {"columns": 2, "rows": 1, "islands": 3}}},
            "field.random: islands must be from 0 to 0 for 2 x 1 rooms, got 3",
        ),
        ({"field": {"kind": "plan", "random": {"columns": 0}}}, "field.random.columns must be"),
        ({"faults": [{**KILL}]}, "faults[0] needs either at_s or when_cleared_share, got neither"),
        (
            {"faults": [{**KILL, "at_s": 1, "when_cleared_share": 0.5}]},
            "faults[0] needs either at_s or when_cleared_share, got both",
        ),
        (
            {"faults": [{**KILL, "at_s": 1, "role": "x"}]},
            "faults[0] needs either nodes, highest_ids_share or role",
        ),
        (
            {"faults": [{"verb": "kill", "at_s": 1}]},
            "faults[0] needs either nodes, highest_ids_share or role",
        ),
        ({"faults": [{"at_s": 1, "role": "x"}]}, "faults[0].verb is missing"),
        ({"faults": [{**KILL, "when_cleared_share": 1.5}]}, "faults[0].when_cleared_share must be"),
        ({"faults": [{**KILL, "at_s": 1, "every": 5}]}, "faults[0].every is for slow, got 5 for kill"),
        ({"faults": [{**KILL, "at_s": 1, "verb": "slow", "every": 0}]}, "faults[0].every must be"),
        (
            {"faults": [{**KILL, "when_cleared_share": 0.5, "nodes": ["r9"]}]},
            "faults[0].nodes: there is no node r9",
        ),
    ],
)
def test_what_does_not_fit_is_told_in_one_line(tmp_path, changes, said):
    found = complaint(tmp_path, changed(GOOD, **changes))
    assert found.startswith(said), found


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"sensors": {}}, "sensors is for mission clear only"),
        (
            {"robots__start": {"kind": "cluster", "x_m": 1, "y_m": 1}},
            "robots.start.kind must be fan or poses for mission area, got cluster",
        ),
        ({"field": {"kind": "plan"}}, "field must have one of plan, random and rings_m, got none"),
        ({"field": GOOD["field"]}, "field.kind must be grid or graph for mission area, got plan"),
        ({"faults": [{"at_s": 1, "verb": "kill", "role": "x"}]}, "faults[0].role is for mission clear only"),
        (
            {"faults": [{**KILL, "when_cleared_share": 0.1}]},
            "faults[0].when_cleared_share is for mission clear only",
        ),
        ({"faults": [{**KILL}]}, "faults[0].at_s is missing"),
        ({"field": {"kind": "unseen"}}, "field.kind must be grid or graph or polyline or plan, got 'unseen'"),
    ],
)
def test_what_is_of_this_mission_is_refused_in_another(tmp_path, changes, said):
    assert complaint(tmp_path, changed(AREA, **changes)) == said


def test_the_command_line_says_so_and_exits_with_2(tmp_path, capsys):
    (tmp_path / "mine.toml").write_text(tomli_w.dumps(changed(GOOD, robots__parameters__follow_m=1.5)))
    given = ["run", str(tmp_path / "mine.toml"), "--in-process", "--out", str(tmp_path)]
    assert carry_out(given) == OPERATOR_MISTAKE == 2
    said = capsys.readouterr()
    assert said.out == "" and said.err == (
        "picket: mine.toml: robots.parameters.follow_m must be <= 2 sensors.detect_m (1.4), got 1.5\n"
    )


def test_how_far_robots_stay_from_walls_is_asked_of_their_parameters(tmp_path):
    """A passage of 0.8 m is too narrow for who stays 0.45 m from walls."""
    neck = [[x_m, 1 + 2 * (y_m - 1)] if 2 <= x_m <= 3 and 0 < y_m < 2 else [x_m, y_m] for x_m, y_m in NECK]
    wide = changed(GOOD, field__rings_m=[neck])
    assert obstacle_m(loaded(tmp_path, wide)) == 0.25
    assert complaint(tmp_path, wide, "robots.parameters.obstacle_m=0.45").startswith("field: no passage")


def test_a_plan_comes_from_a_file_beside_the_scenario_or_by_the_name_of_a_shipped_one(tmp_path):
    (tmp_path / "ell.wkt").write_text(shapely.Polygon(ELL).wkt)
    grey = np.zeros((70, 70), dtype=np.uint8)
    grey[5:65, 5:65] = 255
    Image.fromarray(grey).save(tmp_path / "hall.png")
    beside = changed(GOOD, field={"kind": "plan", "plan": "ell.wkt"})
    scenario = loaded(tmp_path, beside)
    assert shapely.Polygon(scenario.field.rings_m[0]).equals(shapely.Polygon(ELL))
    assert scenario.field == FloorPlan(rings_m=scenario.field.rings_m), "and nothing needs the file again"
    picture = {"kind": "plan", "plan": "hall.png", "metres_per_px": 0.1}
    field = loaded(tmp_path, changed(GOOD, field=picture)).field
    assert shapely.Polygon(field.rings_m[0]).bounds == pytest.approx((0.5, 0.5, 6.5, 6.5))
    cave = changed(
        GOOD, field={"kind": "plan", "plan": "cave"}, robots__start__x_m=1.6, robots__start__y_m=1.4
    )
    assert shapely.Polygon(loaded(tmp_path, cave).field.rings_m[0]).area == pytest.approx(109.4, abs=0.1)


def test_a_random_plan_is_the_generators_and_can_be_turned(tmp_path):
    drawn = {"kind": "plan", "random": {"seed": 3, "columns": 2, "rows": 2, "islands": 1}, "turned_rad": 0.5}
    start = {"kind": "cluster", "x_m": 2.4, "y_m": 2.4}
    scenario = loaded(tmp_path, changed(GOOD, field=drawn, robots__start=start))
    plan = random_plan(3, (2, 2), 1)
    assert len(scenario.field.rings_m) == 2 and scenario.field.turned_rad == 0.5
    shell, hole = scenario.field.rings_m
    assert shapely.Polygon(shell, [hole]).equals(plan)


@pytest.mark.parametrize("name", [name for name in shipped_scenarios() if name.startswith("clear")])
def test_the_parts_of_every_shipped_clearing_fit(name):
    """Whoever clears them; that their behaviour exists is for the test of all shipped scenarios."""
    scenario = load_scenario(shipped_scenarios()[name], [f"robots.behaviour={WANDERING}"])
    assert scenario.robots.body_m == 0.2 and scenario.robots.max_speed_m_s * scenario.tick_s == 0.05
    assert set(scenario.robots.parameters) >= {"follow_m", "obstacle_m"}
