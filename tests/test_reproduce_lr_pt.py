"""`picket reproduce lr-pt` from the command line: run, gone on with, a guest's behaviour, and mistakes."""

import json
import re
import sys
from pathlib import Path

import pytest
from pyarrow import parquet

from deploy.__main__ import carry_out
from deploy.studies.lr_pt import plan, report
from deploy.studies.lr_pt.claims import verdicts
from deploy.studies.lr_pt.figures import draw
from deploy.studies.outcomes import Outcomes, collect
from deploy.studies.trial import Scale, guest
from tests.made_up_outcomes import SCALE, outcomes

README = (Path(__file__).parent.parent / "README.md").read_text("utf-8")


@pytest.fixture
def tiny(monkeypatch, tmp_path):
    """A study of one algorithm and one size, minutes long, with the README's behaviour at hand."""
    monkeypatch.setattr(plan, "QUICK", Scale(180, 60, 360, 1))
    monkeypatch.setattr(plan, "ALGORITHMS", (plan.LR_PT,))
    monkeypatch.setattr(plan, "SIZES", (5,))
    monkeypatch.setattr(plan, "VARIANTS", plan.VARIANTS[:1])
    (tmp_path / "wanderer.py").write_text(re.search(r"```python\n(.*?)```", README, re.DOTALL).group(1))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{Path(__file__).parent.parent}")
    yield tmp_path / "out"
    sys.modules.pop("wanderer", None)


def reproduce(out: Path, *options: str) -> int:
    return carry_out(["reproduce", "lr-pt", "--quick", "--out", str(out), *options])


def stamps(folder: Path) -> dict[str, int]:
    """When each trial was finished."""
    return {one.parent.name: one.stat().st_mtime_ns for one in folder.glob("*/summary.json")}


def test_a_whole_study_with_a_guest_and_its_gaps_filled_in(tiny, capfd):
    """Everything once; a campaign that was killed goes on with what is missing, and with that only."""
    options = ("--behaviour", "wanderer:Wanderer")
    assert reproduce(tiny, *options) == 0
    folder = tiny / "lr-pt-quick"
    rows = {row["name"]: row for row in parquet.read_table(folder / "trials.parquet").to_pylist()}
    guest = next(name for name in rows if name.startswith("wanderer.Wanderer-") and "processes" not in name)
    assert set(rows) == {
        "lr_pt-n5-seed1",
        "lr_pt-n5-seed1-processes",
        "lr_pt-s8-n5-seed1",
        "lr_pt-failures-kept-n5-seed1",
        "lr_pt-failures-lost-n5-seed1",
        guest,
        f"{guest}-processes",
    }
    for name in ("lr_pt-n5-seed1", guest):
        again = rows[f"{name}-processes"]
        assert (rows[name]["how"], again["how"]) == ("rehearsed", "processes")
        assert rows[name]["run_hash"] == again["run_hash"]
    said = (folder / "report.md").read_text()
    assert "THIS IS A QUICK RUN" in said and "| 5 | wanderer:Wanderer |" in said
    assert said.count("| yes |") == 2 and "**NO**" not in said
    assert re.search(r"\| 5 \| lost \| r5 \(\d+\) \|", said), "the process that was killed"
    for name in re.findall(r"!\[.*?\]\((.*?)\)", said):
        assert (folder / name).read_bytes().startswith(b"\x89PNG"), name
    assert not (folder / guest / "journal").exists() and (folder / f"{guest}-processes" / "journal").exists()

    before = stamps(folder)
    (folder / "lr_pt-s8-n5-seed1" / "summary.json").unlink()
    (folder / guest / "summary.json").write_text('{"metrics": {')  # torn
    assert reproduce(tiny, *options) == 0
    after = stamps(folder)
    assert {name for name in after if after[name] != before[name]} == {"lr_pt-s8-n5-seed1", guest}
    assert {
        row["name"]: row["run_hash"] for row in parquet.read_table(folder / "trials.parquet").to_pylist()
    }[guest] == rows[guest]["run_hash"]
    capfd.readouterr()


def test_only_some_trials_and_a_scenario_spelt_otherwise_is_the_same(tiny, capfd):
    assert reproduce(tiny, "--only", "lr_pt-s8") == 0
    assert "no report" in capfd.readouterr().out
    folder = tiny / "lr-pt-quick"
    assert list(stamps(folder)) == ["lr_pt-s8-n5-seed1"] and not (folder / "report.md").exists()
    before, toml = stamps(folder), folder / "lr_pt-s8-n5-seed1" / "scenario.toml"
    lines = toml.read_text().splitlines()
    toml.write_text("\n".join(["# a comment", *(one for one in lines if not one.startswith("seed"))]))
    assert reproduce(tiny, "--only", "lr_pt-s8") == 0
    assert stamps(folder) == before, "seed 1 is the default"
    toml.write_text("seed = 2\n" + toml.read_text())
    assert reproduce(tiny, "--only", "lr_pt-s8") == 0
    assert stamps(folder) != before
    assert "seed = 1" in toml.read_text()


def test_processes_are_not_rehearsed_and_a_rehearsal_will_not_do_for_them(tiny, capfd):
    assert reproduce(tiny, "--only", "lr_pt-s8") == 0
    summary = tiny / "lr-pt-quick" / "lr_pt-s8-n5-seed1" / "summary.json"
    rehearsed = json.loads(summary.read_text())
    assert reproduce(tiny, "--only", "lr_pt-s8", "--processes") == 0
    live = json.loads(summary.read_text())
    assert live["processes"] and not rehearsed["processes"] and live["run_hash"] == rehearsed["run_hash"]
    before = stamps(tiny / "lr-pt-quick")
    assert reproduce(tiny, "--only", "lr_pt-s8") == 0
    assert stamps(tiny / "lr-pt-quick") == before, "but a run of processes is as good as a rehearsal"
    capfd.readouterr()


def test_a_guest_that_raises_is_said_to_have_died(tiny, tmp_path, capfd):
    text = "from swarm_agent.behaviour import Behaviour\nclass Bad(Behaviour):\n"
    (tmp_path / "bad_guest.py").write_text(
        text + "    def step(self, percept, heard):\n        raise ValueError('no idea')\n"
    )
    bad = guest("bad_guest:Bad", ())
    assert reproduce(tiny, "--behaviour", "bad_guest:Bad", "--only", f"{bad.name}-n5-seed1") == 0
    trials = [one for one in plan.trials(plan.QUICK, 1, [bad]) if one.algorithm == bad]
    folder = tiny / "lr-pt-quick"
    summaries = {one.name: json.loads((folder / one.name / "summary.json").read_text()) for one in trials}
    said = report.write(collect(trials, summaries, folder), [], plan.QUICK, True, [])
    assert "**8 nodes died that nobody had planned to kill:**" in said, "four rehearsed, four as processes"
    assert said.count("ValueError: no idea") == 8
    capfd.readouterr()


def test_a_report_of_the_whole_study_renders(tmp_path):
    everything = outcomes({("main", "dtap", 5): (13.0, 75, 20, 99)}, count=3).all
    found = Outcomes(one for one in everything if one.trial.nodes == 5)
    figures = [path.name for path in draw(found, tmp_path)]
    said = report.write(
        found, verdicts(found), SCALE._replace(duration_s=43200, metrics_from_s=10000), False, figures
    )
    assert "QUICK" not in said
    assert "0.7685 of ours" in said, "33201 terms divided by 43200"
    assert (
        "| I_G of LR-PT is 20% to 30% lower than DTAP's, at every N | **reproduced** | -23.1% (N = 5)" in said
    )
    assert "| 5 | DTAP | 13.0 [13.0..13.0] | 75.0 [75.0..75.0] |" in said
    assert f"{len(found.all)} of {len(found.all)} trials.\n" in said, "no delay is shorter than idleness"
    for name in figures:
        assert f"({name})" in said and (tmp_path / name).stat().st_size > 10_000


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--trials", "0"], "--trials: must be a whole number >= 1, got '0'"),
        (
            ["--behaviour", "nowhere:Thing"],
            "--behaviour nowhere:Thing: there is no behaviour 'nowhere:Thing'",
        ),
        (["--behaviour", "lr_pt"], "--behaviour lr_pt: is in the comparison already"),
        (["--behaviour", "gbs", "--behaviour", "gbs"], "--behaviour gbs: is in the comparison already"),
        (["--only", "no-such"], "--only no-such: no trial has this in its name"),
        (["--out", "{file}"], "cannot make a folder there: Not a directory"),
        (["--out", "/proc/nowhere"], "--out /proc/nowhere: cannot make a folder there"),
    ],
)
def test_a_mistake_is_one_clear_line(options, words, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    options = [one.format(file=tmp_path / "file") for one in options]
    assert carry_out(["reproduce", "lr-pt", "--only", "lr_pt-n5-seed1", *options]) == 2
    said = capsys.readouterr().err
    assert words in said and said.count("\n") == 1
