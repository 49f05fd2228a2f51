"""Every delivery, position and visit is what an independent oracle says; a world that errs is caught."""

import re
from collections import Counter
from pathlib import Path
from typing import Any

import msgspec
import pytest

from deploy.recorder import events
from deploy.rehearsal import rehearse
from deploy.scenario_file import load_scenario, to_toml
from tests.oracle import Oracle
from wire.scenario import Latency, Loss, Partition, Range, Scenario

TICKS = 300
SOUND = """
mission = "area"
duration_s = 300
seed = 5
field = { kind = "grid", columns = 8, rows = 8, cell_m = 30 }
robots = { count = 6, behaviour = "tests.wanderer:Wanderer", max_speed_m_s = 4.0 }
tower = { behaviour = "tests.wanderer:Wanderer", x_m = 100, y_m = 100 }
"""
RULES = {
    "all four rules": """
[[radio.rules]]
kind = "range"
range_m = 90
[[radio.rules]]
kind = "partition"
groups = [["r1", "r2", "r3"], ["r4"]]
from_s = 100
until_s = 180
[[radio.rules]]
kind = "loss"
probability = 0.2
[[radio.rules]]
kind = "latency"
ticks = 3
""",
    "the default latency": """
[[radio.rules]]
kind = "range"
range_m = 90
""",
}
FAULTS = "".join(
    f'[[faults]]\nat_s = {at_s}\nverb = "{verb}"\nnodes = ["{node}"]\nmemory = "{memory}"\n'
    for at_s, verb, node, memory in (
        (40, "kill", "r2", "lost"),
        (60, "freeze", "r4", "lost"),
        (75, "thaw", "r4", "lost"),
        (90, "restart", "r2", "lost"),
        (110, "kill", "r1", "lost"),
        (111, "kill", "r5", "lost"),
        (150, "restart", "r5", "kept"),
        (190, "freeze", "r3", "lost"),
        (200, "kill", "r3", "lost"),
    )
)


def make(folder: Path, text: str) -> Scenario:
    """A scenario of wanderers."""
    (folder / "wandering.toml").write_text(text)
    return load_scenario(folder / "wandering.toml")


def judged(folder: Path, world: Scenario, oracle: Scenario) -> Counter:
    """Rehearse what the world was given, and let the oracle judge it by what it was given."""
    rehearse(world, to_toml(world), folder, TICKS)
    return Oracle(oracle).check(folder / "journal")


@pytest.mark.parametrize("faults", ["", FAULTS], ids=["nobody fails", "with faults"])
@pytest.mark.parametrize("rules", RULES)
def test_every_delivery_position_and_visit_is_what_the_oracle_says(
    tmp_path: Path, rules: str, faults: str
) -> None:
    scenario = make(tmp_path, SOUND + RULES[rules] + faults)
    counts = judged(tmp_path, scenario, scenario)
    happened = {"delivered": 500, "heard": 500, "out of range": 500, "visits": 10}
    happened |= {"lost by chance": 100, "lost by partition": 100} if rules == "all four rules" else {}
    happened |= {"kill": 4, "freeze": 2, "thaw": 1, "restart": 2} if faults else {}
    assert {what: counts[what] for what, least in happened.items() if counts[what] < least} == {}


def test_frames_beyond_the_bytes_of_a_tick_are_not_delivered(tmp_path: Path) -> None:
    scenario = make(tmp_path, SOUND + RULES["the default latency"] + "[radio]\nbytes_per_tick = 50\n")
    assert judged(tmp_path, scenario, scenario)["oversize"] > 100
    told = [one for one in events(tmp_path) if one["kind"] == "oversize"]
    assert {one["node"] for one in told} == set(scenario.node_ids)
    assert {one["data"]["count"] for one in told} <= {1, 10, 100}


def wrong(scenario: Scenario, kind: type, **fields: Any) -> Scenario:
    """The scenario with one of its radio rules changed."""
    rules = tuple(
        msgspec.structs.replace(rule, **fields) if isinstance(rule, kind) else rule
        for rule in scenario.radio.rules
    )
    return changed(scenario, radio=msgspec.structs.replace(scenario.radio, rules=rules))


def changed(scenario: Any, **fields: Any) -> Any:
    """A Struct with some fields changed."""
    return msgspec.structs.replace(scenario, **fields)


ERRORS = {
    "a range that is a metre too large": lambda one: wrong(one, Range, range_m=91.0),
    "a range that is a metre too small": lambda one: wrong(one, Range, range_m=89.0),
    "a latency that is a tick too long": lambda one: wrong(one, Latency, ticks=4),
    "a latency that is a tick too short": lambda one: wrong(one, Latency, ticks=2),
    "too little loss": lambda one: wrong(one, Loss, probability=0.19),
    "a partition that begins a tick late": lambda one: wrong(one, Partition, from_s=101.0),
    "a partition that ends a tick early": lambda one: wrong(one, Partition, until_s=179.0),
    "robots that are a little too fast": lambda one: changed(
        one, robots=changed(one.robots, max_speed_m_s=4.001)
    ),
    "visits from a metre too far": lambda one: changed(one, field=changed(one.field, visit_within_m=4.0)),
}


@pytest.mark.parametrize("error", ERRORS)
def test_a_world_that_errs_is_caught(tmp_path: Path, error: str) -> None:
    scenario = make(tmp_path, SOUND + RULES["all four rules"])
    erring = ERRORS[error](scenario)
    assert erring != scenario
    with pytest.raises(AssertionError, match=re.compile("^tick")):
        judged(tmp_path, erring, scenario)
