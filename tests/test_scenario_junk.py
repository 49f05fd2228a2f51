"""Whatever an operator writes, it loads or is refused in one line."""

import copy
import tomllib
from pathlib import Path

import pytest
import tomli_w
from hypothesis import example, given
from hypothesis import strategies as st

from deploy.scenario_file import ScenarioError, load_scenario, to_toml
from tests.test_clear_checks import GOOD as CLEARING
from tests.test_scenario import GOOD

names = st.sampled_from(
    [
        "mission",
        "duration_s",
        "field",
        "robots",
        "tower",
        "radio",
        "faults",
        "rules",
        "kind",
        "nodes",
        "groups",
        "behaviour",
        "parameters",
        "count",
        "ids",
        "start",
        "poses",
        "at_s",
        "verb",
        "memory",
        "range_m",
        "seed",
    ]
) | st.text(max_size=6)
values = st.recursive(
    st.booleans()
    | st.integers(-(2**65), 2**65)
    | st.floats()
    | st.text(max_size=6)
    | st.dates()
    | st.datetimes()
    | st.sampled_from(["area", "grid", "lr_pt", "r2", "range", "partition", "kill", "fan", "poses"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(names, inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(names, values, max_size=5))
@example({"mission\nx": 1})
@example({"robots": {"a`b": 1}})
def test_any_document_loads_or_is_refused_in_one_line(tmp_path, junk):
    (tmp_path / "junk.toml").write_text(tomli_w.dumps(junk), "utf-8")
    loads_or_is_refused(tmp_path / "junk.toml")


@pytest.mark.parametrize("good", [tomllib.loads(GOOD), CLEARING], ids=["area", "clear"])
@given(data=st.data())
def test_a_damaged_good_document_loads_or_is_refused_in_one_line(tmp_path, good, data):
    document = copy.deepcopy(good)
    place = document
    while True:
        keys = list(range(len(place))) if isinstance(place, list) else sorted(place)
        if not keys:
            break
        key = data.draw(st.sampled_from(keys))
        if not isinstance(place[key], (dict, list)) or data.draw(st.booleans()):
            place[key] = data.draw(values)
            break
        place = place[key]
    (tmp_path / "junk.toml").write_text(tomli_w.dumps(document), "utf-8")
    loads_or_is_refused(tmp_path / "junk.toml")


@given(st.text(max_size=40))
def test_any_setting_is_taken_or_refused_in_one_line(tmp_path, setting):
    (tmp_path / "junk.toml").write_text(GOOD)
    loads_or_is_refused(tmp_path / "junk.toml", setting)
    loads_or_is_refused(tmp_path / "junk.toml", "robots." + setting)
    loads_or_is_refused(tmp_path / "junk.toml", "seed=" + setting)


@given(st.binary(max_size=60))
def test_any_file_loads_or_is_refused_in_one_line(tmp_path, data):
    (tmp_path / "junk.toml").write_bytes(data)
    loads_or_is_refused(tmp_path / "junk.toml")


def loads_or_is_refused(path: Path, *settings: str) -> None:
    try:
        scenario = load_scenario(path, list(settings))
    except ScenarioError as error:
        assert len(str(error).splitlines()) == 1, str(error)
    else:
        assert tomllib.loads(to_toml(scenario))
        assert scenario.last_tick >= 0
