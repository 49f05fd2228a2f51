"""`picket reproduce`: every run of a study once, its tables and figures; and what goes wrong."""

import pytest
from msgspec.structs import replace as changed

from deploy.__main__ import carry_out
from deploy.scenario_file import find_scenario, load_scenario
from deploy.studies import line_patrol
from deploy.sweep import SweepError, sweep


def test_the_study_of_the_line_runs_everything_once_and_says_it_beside_the_paper(
    tmp_path, capfd, monkeypatch
):
    monkeypatch.setattr(line_patrol, "TEAMS", {"6/4": "line-6r4s", "10/6": "line-10r6s"})
    monkeypatch.setattr(line_patrol, "RULES", ("base", "leapfrog"))
    command = ["reproduce", "line-patrol", "--seeds", "1", "--hours", "0.1", "--out", str(tmp_path)]
    assert carry_out(command) == 0
    folder = tmp_path / "line-patrol"
    tables = (folder / "tables.txt").read_text()
    for words in ("Lap time in s", "19.22 ± 1.27", "Return time in s", "65, 47, 1.38", "Recovery in s"):
        assert words in tables, words
    assert "Recovery in s" in capfd.readouterr().out
    for name in ("figure-5", "figure-6"):
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    journals = {path: path.stat().st_mtime_ns for path in folder.glob("*/journal")}
    assert len(journals) == 4
    assert carry_out(command) == 0
    assert {path: path.stat().st_mtime_ns for path in folder.glob("*/journal")} == journals, "nothing twice"


def test_a_sweep_says_which_rehearsal_failed_and_why(tmp_path):
    given = load_scenario(find_scenario("line-6r4s"), ["duration_s=20"])
    given = changed(given, robots=changed(given.robots, behaviour="tests.no_such:Thing"))
    with pytest.raises(SweepError, match="broken: the rehearsal ended with 1"):
        sweep({"broken": given}, tmp_path, lambda done, total: None)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nothing"], "invalid choice: 'nothing'"),
        (["line-patrol", "--seeds", "0"], "must be a whole number >= 1, got '0'"),
        (["line-patrol", "--hours", "-1"], "must be a number > 0, got '-1'"),
        (["line-patrol", "--hours", "nan"], "must be a number > 0, got 'nan'"),
        (["line-patrol", "--out", "/proc/nowhere"], "--out /proc/nowhere: cannot make a folder there"),
    ],
)
def test_a_mistake_is_one_clear_line(arguments, words, capsys):
    assert carry_out(["reproduce", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said and said.count("\n") == 1
