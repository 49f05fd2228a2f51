"""Scenarios: what is right loads and comes back; a mistake is one line that an operator can act on."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from deploy.scenario_file import ScenarioError, find_scenario, load_scenario, shipped_scenarios, to_toml
from wire.scenario import Loss, Range

GOOD = """
mission = "area"
duration_s = 100
metrics_from_s = 10

[field]
kind = "grid"
columns = 5
rows = 4

[robots]
count = 4
behaviour = "lr_pt"

[robots.parameters]
lock_breaker = "none"

[[radio.rules]]
kind = "range"
range_m = 180

[[radio.rules]]
kind = "loss"
probability = 0.5

[[faults]]
at_s = 20
verb = "kill"
nodes = ["r3"]

[[faults]]
at_s = 40
verb = "restart"
nodes = ["r3"]
memory = "kept"
"""


@pytest.fixture
def good(tmp_path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text(GOOD)
    return path


def complaint(path: Path, *settings: str, text: str | None = None, **overrides) -> str:
    """The error of a scenario, changed by `--set` options or given as text; it must be one line."""
    if text is not None:
        path.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path, list(settings), **overrides)
    said = str(caught.value)
    assert said.strip() == said
    assert len(said.splitlines()) == 1
    return said


SWEEPS = find_spec("swarm_agent.behaviours.sweep_line") is not None
PLAYABLE = [name for name in shipped_scenarios() if SWEEPS or not name.startswith("clear-")]


@pytest.mark.parametrize("name", PLAYABLE)
def test_every_shipped_scenario_loads_and_comes_back(name, tmp_path):
    scenario = load_scenario(find_scenario(name))
    (tmp_path / "again.toml").write_text(to_toml(scenario))
    assert load_scenario(tmp_path / "again.toml") == scenario
    assert to_toml(load_scenario(tmp_path / "again.toml")) == to_toml(scenario)


def test_scenarios_are_shipped():
    assert {"area-patrol", "area-patrol-failures", "area-patrol-n5"} <= set(shipped_scenarios())


def test_a_good_scenario_is_completed(good):
    scenario = load_scenario(good)
    assert scenario.robot_ids == ("r2", "r3", "r4", "r5")
    assert scenario.radio.rules == (Range(180.0), Loss(0.5))
    assert scenario.robots.parameters["spread_m"] == 356.0
    assert scenario.robots.parameters["lock_breaker"] == "none"
    assert scenario.last_tick == 100


def test_settings_and_overrides_change_a_scenario(good):
    settings = [
        "robots.count=9",
        "radio.rules.0.range_m=90",
        "robots.behaviour=stand_still",
        "robots.parameters={}",
    ]
    scenario = load_scenario(good, [*settings, "tower.x_m=3.5"], seed=7)
    assert len(scenario.robot_ids) == 9
    assert scenario.radio.rules[0] == Range(90.0)
    assert (scenario.robots.behaviour, scenario.tower.x_m, scenario.seed) == ("stand_still", 3.5, 7)


@pytest.mark.parametrize(
    ("setting", "wanted"),
    [
        ("duration=5", ["mine.toml", "duration is not a field", "did you mean duration_s?"]),
        (
            "robots.behaviour=gbs",
            [
                "robots.parameters.",
                "is not a field",
                "--set robots.parameters={} drops those of the scenario",
            ],
        ),
        ("robots.behavior=lr_pt", ["robots.behavior is not a field", "did you mean behaviour?"]),
        ("field.colums=3", ["field.colums is not a field", "did you mean columns?"]),
        ("radio.rules.0.rangem=3", ["radio.rules[0].rangem is not a field", "did you mean range_m?"]),
        ("faults.1.memori='kept'", ["faults[1].memori is not a field", "did you mean memory?"]),
        (
            "robots.parameters.lockbreaker='none'",
            ["robots.parameters.lockbreaker is not a field", "did you mean lock_breaker?"],
        ),
        (
            "robots.start={kind='fan', radius=3}",
            ["robots.start.radius is not a field", "did you mean radius_m?"],
        ),
        ("zzz=1", ["zzz is not a field", "known are", "mission"]),
        ("duration_s='long'", ["duration_s must be a number, got 'long'"]),
        ("duration_s=0", ["duration_s must be a number > 0.0", "got 0"]),
        ("radio.rules.0.range_m=-3", ["radio.rules[0].range_m must be a number > 0.0", "got -3"]),
        ("radio.rules.1.probability=1.5", ["radio.rules[1].probability", "<= 1.0", "1.5"]),
        ("robots.count=0", ["robots.count", ">= 1", "got 0"]),
        ("robots.count=2.5", ["robots.count", "2.5"]),
        ("robots.parameters.lock_breaker='any'", ["robots.parameters.lock_breaker", "'any'"]),
        ("robots.parameters.spread_m=-1", ["robots.parameters.spread_m", "> 0.0", "-1"]),
        ("mission='tea'", ["mission must be", "area", "got 'tea'"]),
        ("field.kind='disc'", ["field.kind", "'disc'"]),
        ("clock.kind='slow'", ["clock.kind must be lockstep or paced, got 'slow'"]),
        ("robots.behaviour='lr_ptt'", ["robots.behaviour", "'lr_ptt'", "must be a file of"]),
        ("robots.behaviour=':X'", ["robots.behaviour", "':X'"]),
        ("tower.behaviour='lr_pt'", ["tower.behaviour", "'lr_pt'"]),
        ("robots.count=6", ["robots.parameters", "takeover_discount", "5, 10, 15", "7"]),
        ("faults.0.nodes=['r9']", ["faults[0].nodes", "no node r9", "r1, r2, r3, r4, r5"]),
        ("faults.0.nodes=['R3']", ["faults[0].nodes[0]", "'R3'"]),
        ("faults.1.verb='kill'", ["faults[1]", "cannot kill r3 at 40.0 s", "dead"]),
        ("faults.0.verb='thaw'", ["faults[0]", "cannot thaw r3", "alive"]),
        ("faults.0.nodes=['r2','r2']", ["faults[0]", "cannot kill r2", "dead"]),
        ("faults.1.at_s=101", ["faults[1].at_s", "<= duration_s (100.0)", "101"]),
        ("faults.0.nodes=[]", ["faults[0] needs either nodes or highest_ids_share"]),
        ("faults.0.highest_ids_share=0.2", ["faults[0] needs either nodes or highest_ids_share"]),
        ("metrics_from_s=101", ["metrics_from_s must be <= duration_s (100.0)", "101"]),
        ("robots.ids=['r2']", ["robots needs either count or ids"]),
        ("robots.start={kind='poses', poses=[[0,0,0]]}", ["robots.start.poses", "4 robots", "got 1"]),
        ("robots.start={kind='poses', poses=[[0,0]]}", ["robots.start.poses[0]", "length"]),
        (
            "radio.rules.0={kind='partition', groups=[['r2','r8']]}",
            ["radio.rules[0].groups", "no node r8", "r5"],
        ),
        ("radio.rules.0={kind='fog'}", ["radio.rules[0].kind must be", "range or", "partition", "got 'fog'"]),
        ("radio.rules.0={range_m=3}", ["radio.rules[0].kind is missing"]),
        ("duration_s=inf", ["duration_s", "finite", "inf"]),
        ("duration_s=nan", ["duration_s", "nan"]),
        ("radio.rules.0.range_m=inf", ["radio.rules[0].range_m", "finite", "inf"]),
        ("robots.start={kind='poses', poses=[[nan,0,0]]}", ["robots.start.poses[0][0]", "finite", "nan"]),
        ("robots.parameters.spread_m=inf", ["robots.parameters.spread_m", "finite", "inf"]),
        ("duration_s=1e11", ["duration_s", "4294967295 ticks"]),
        ("tick_s=1e-9", ["duration_s", "4294967295 ticks"]),
        ("field={kind='grid', columns=1000, rows=1000}", ["field", "65536"]),
        ("seed=-1", ["seed", ">= 0", "-1"]),
        ("seed=1979-05-27", ["seed", "a whole number"]),
    ],
)
def test_a_mistake_is_named_with_its_place_value_and_remedy(good, setting, wanted):
    said = complaint(good, setting)
    for words in ["mine.toml", *wanted]:
        assert words in said, said


def test_a_missing_field_is_named(good):
    assert "duration_s is missing" in complaint(good, text=GOOD.replace("duration_s = 100", ""))
    assert "robots.behaviour is missing" in complaint(good, text=GOOD.replace('behaviour = "lr_pt"', ""))


def test_two_nodes_with_one_number_are_refused(good):
    both = GOOD.replace("count = 4", 'ids = ["r2", "r3", "scout3"]')
    assert "scout3 and r3 share the number 3" in complaint(good, text=both)
    tower = GOOD.replace("count = 4", 'ids = ["r3", "scout1"]')
    assert "scout1 and r1 share the number 1" in complaint(good, text=tower)


def test_a_team_without_a_size_is_refused(good):
    assert "robots needs either count or ids" in complaint(good, text=GOOD.replace("count = 4", ""))


def test_ids_beyond_four_digits_are_refused(good):
    many = GOOD.replace("count = 4", 'ids = ["r2", "r3", "r9999"]\nspares = 1').replace(
        '"lr_pt"', '"stand_still"'
    )
    assert "robots.spares" in complaint(good, text=many.replace('lock_breaker = "none"', ""))


@pytest.mark.parametrize(
    "setting", ["seed", "=3", "", "duration_s.x=1", "faults.9.at_s=1", "faults.x.at_s=1", "mission.a.b=1"]
)
def test_a_setting_that_has_no_place_is_named(good, setting):
    assert f"--set {setting}" in complaint(good, setting)


@pytest.mark.parametrize("setting", ["..=1", "a..b=1", "robots..count=1", "faults.=1"])
def test_a_setting_with_an_empty_step_is_refused(good, setting):
    complaint(good, setting)


def test_a_setting_that_is_no_toml_is_taken_as_words(good):
    assert "'much'" in complaint(good, "seed=much")


def test_a_fault_between_the_last_tick_and_the_end_is_refused(good):
    """It would silently never happen: 100.4 s end at tick 100, and 100.2 s would be tick 101."""
    said = complaint(good, "duration_s=100.4", "faults.1.at_s=100.2")
    assert "faults[1].at_s" in said


def test_a_file_that_is_not_there_is_named_with_what_may_be_meant():
    with pytest.raises(ScenarioError, match="area-patroll: no such file.*did you mean area-patrol"):
        find_scenario("area-patroll")
    with pytest.raises(ScenarioError, match="xyzzy: no such file"):
        find_scenario("xyzzy")


def test_a_directory_is_no_scenario(tmp_path):
    with pytest.raises(ScenarioError, match="is a directory"):
        find_scenario(str(tmp_path))
    with pytest.raises(ScenarioError, match="cannot be read"):
        load_scenario(tmp_path)


@pytest.mark.parametrize("name", ["a\0b", "x" * 5000])
def test_an_impossible_file_name_is_an_error_like_any_other(name):
    with pytest.raises(ScenarioError):
        find_scenario(name)


def test_a_file_that_is_not_text_is_named(good):
    good.write_bytes(b"mission = '\xff\xfe'")
    assert "mine.toml: not UTF-8 text (byte 11)" in complaint(good)


def test_broken_toml_is_named_with_its_line(good):
    said = complaint(good, text="mission = \n")
    assert "mine.toml: not valid TOML" in said
    assert "line 1" in said


def test_toml_nested_beyond_reason_is_an_error_like_any_other(good):
    complaint(good, text="a = " + "[" * 5000 + "]" * 5000)
    good.write_text(GOOD)
    complaint(good, "seed=" + "[" * 5000 + "]" * 5000)
