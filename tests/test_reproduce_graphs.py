"""`picket reproduce graphs`: rules on maps given as files, and what is wrong with some."""

import re
from pathlib import Path

import pytest
from pyarrow import parquet

from deploy.__main__ import carry_out
from deploy.studies import graphs

TRIANGLE = """
nodes_m = [[0, 0], [6, 0], [0, 8]]
edges = [[0, 1], [1, 2], [0, 2]]
"""


@pytest.fixture
def tiny(monkeypatch, tmp_path) -> Path:
    monkeypatch.setattr(graphs, "QUICK", (120.0, 20.0, 1))
    monkeypatch.setattr(graphs, "TEAMS", (1, 2, 8))
    monkeypatch.setattr(graphs, "RULES", graphs.RULES[:2])
    (tmp_path / "triangle.toml").write_text(TRIANGLE)
    return tmp_path


def reproduce(folder: Path, *options: str) -> int:
    return carry_out(["reproduce", "graphs", "--quick", "--out", str(folder / "out"), *options])


def test_every_rule_and_team_on_every_map_that_is_large_enough(tiny, capfd):
    files = [str(tiny / "triangle.toml"), str(graphs.SHIPPED / "graphs" / "grid.toml")]
    assert reproduce(tiny, *files, "--behaviour", "sebs") == 0
    folder = tiny / "out" / "graphs-quick"
    rows = {row["name"]: row for row in parquet.read_table(folder / "trials.parquet").to_pylist()}
    teams = {"triangle": (1, 2), "grid": (1, 2, 8)}
    rules = {re.sub(r"(-[0-9a-f]{8})?-r\d-seed1$", "", name) for name in rows}
    assert rules == {
        f"{one}-{rule}" for one in teams for rule in ("random", "conscientious_reactive", "sebs")
    }
    assert len(rows) == 3 * (2 + 3), "eight robots do not fit on three nodes"
    alone = rows["triangle-conscientious_reactive-r1-seed1"]
    assert alone["node_interval_mean_s"] == pytest.approx(24.0, abs=0.5), "round and round, 24 m at 1 m/s"
    assert alone["node_interval_max_s"] == pytest.approx(24.0, abs=0.5)
    said = (folder / "report.md").read_text()
    assert "QUICK RUN" in said and "## triangle" in said and "## grid" in said
    assert re.search(r"\| 1 \| CR \| \d+\.\d \| 24\.\d \|", said)
    for name in teams:
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    before = {one: one.stat().st_mtime_ns for one in folder.glob("*/summary.json")}
    assert reproduce(tiny, *files, "--behaviour", "sebs") == 0
    assert {one: one.stat().st_mtime_ns for one in folder.glob("*/summary.json")} == before
    capfd.readouterr()


def test_the_same_start_for_every_rule_and_another_for_another_seed():
    found = graphs.trials([], graphs.RULES, 2, 60.0, 0.0)
    starts = {}
    for one in found:
        starts.setdefault((one.nodes, one.seed), set()).add(one.scenario().robots.start)
    assert all(len(each) == 1 for each in starts.values())
    assert starts[5, 1] != starts[5, 2]
    assert len(found) == 8 * 3 * 2 and len({one.name for one in found}) == len(found)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["nowhere.graph"], "field.graph: nowhere.graph cannot be read: No such file or directory"),
        (["{damaged}"], "damaged.toml"),
        (["{map}", "{map}"], "triangle: there are two maps of this name"),
        (["--trials", "0"], "--trials: must be a whole number >= 1, got '0'"),
        (["--behaviour", "gbs"], "--behaviour gbs: is in the comparison already"),
        (["--out", "{map}"], "cannot make a folder there: Not a directory"),
    ],
)
def test_a_mistake_is_one_clear_line(options, words, tmp_path, capsys):
    (tmp_path / "triangle.toml").write_text(TRIANGLE)
    (tmp_path / "damaged.toml").write_text("nodes_m = [[0, 0]")
    places = {"map": tmp_path / "triangle.toml", "damaged": tmp_path / "damaged.toml"}
    assert carry_out(["reproduce", "graphs", *(one.format(**places) for one in options)]) == 2
    said = capsys.readouterr().err
    assert words in said and said.count("\n") == 1
