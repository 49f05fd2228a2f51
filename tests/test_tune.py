"""`picket tune`: it finds, goes on after a kill without doing anything twice, and says what is wrong."""

import json
import math
import signal
import subprocess
import sys

import pytest

from deploy import sweep
from deploy.__main__ import carry_out
from deploy.scenario_file import load_scenario
from tests.live_runs import small, until

KEY = "robots.parameters.pause_ticks"
SEEDS = ["--seeds", "101", "102"]
WALK = [8, 3, 13, 6, 10, 4, 2, 5]
"""From 8 within 1..21: 5 down and up, both refused; 2 down and up, then on from 6; from 4 1 down and up."""


@pytest.fixture
def path(tmp_path):
    """Four robots that only sleep and wake, for 40 s."""
    return small(tmp_path, duration_s=40, behaviour="tests.pausing:Pausing")


@pytest.fixture
def rehearsed(monkeypatch):
    """The names of the rehearsals that are run, in the order in which they begin."""
    names, really = [], sweep._Sweep._carry_out

    async def counted(self, folder, scenario, processes):
        names.append(folder.name)
        await really(self, folder, scenario, processes)

    monkeypatch.setattr(sweep._Sweep, "_carry_out", counted)
    return names


def tuning(path, out, *more):
    """A command line: as many grants as there can be."""
    wanted = ["--parameter", f"{KEY}:1..21", "--metric", "grants", "--maximise"]
    return ["tune", str(path), *wanted, *SEEDS, "--out", str(out), *more]


def record(out):
    return json.loads((out / "tuning.json").read_text())


def runs_of(*pauses):
    """Names of the rehearsals of these values: two for each but 13, which is refused before it runs."""
    return sorted(
        f"point{WALK.index(one) + 1:03}-seed{seed}" for one in pauses if one != 13 for seed in (101, 102)
    )


def test_it_finds_the_best_and_goes_on_with_a_larger_budget_without_doing_anything_twice(
    path, tmp_path, rehearsed, capfd
):
    """Less sleep is more grants, down to the 4 ticks that no robot dies of. What failed is tried again."""
    out = tmp_path / "out"
    assert carry_out(tuning(path, out, "--evaluations", "3")) == 0
    assert [one["values"][KEY] for one in record(out)["points"]] == WALK[:3]
    assert sorted(rehearsed) == runs_of(*WALK[:3])
    rehearsed.clear()
    assert carry_out(tuning(path, out)) == 0
    assert sorted(rehearsed) == sorted(runs_of(3) + runs_of(*WALK[3:]))
    rehearsed.clear()
    found = record(out)
    assert [one["values"][KEY] for one in found["points"]] == WALK
    grants = {one["values"][KEY]: one["score"] for one in found["points"] if not one["refused"]}
    assert grants == {pause: 4 * (40 // pause + 1) for pause in (8, 6, 10, 4, 5)}
    assert found["best"]["values"] == {KEY: 4}
    assert found["best_settings"] == [f"{KEY}=4"]
    refused = {one["values"][KEY]: one["refused"] for one in found["points"] if one["refused"]}
    assert refused[13] == "small.toml: robots.parameters: 13 brings bad luck"
    assert refused[3] == "point002-seed101: walked out"
    assert refused[2] == "point007-seed101: r2 died: exit code 1: RuntimeError: no time to breathe"
    capfd.readouterr()
    assert carry_out(tuning(path, out)) == 0
    assert rehearsed == runs_of(3)
    assert record(out) == found
    said = capfd.readouterr()
    assert said.out.endswith(f"--set {KEY}=4\n")
    assert (said.out.count(" best"), said.out.count("refused:")) == (1, 3)
    assert "8 of 40 evaluations, best 44" in said.err


def test_after_kill_9_the_same_command_goes_on_and_comes_to_the_same_record(path, tmp_path, rehearsed):
    out, whole = tmp_path / "out", tmp_path / "whole"
    assert carry_out(tuning(path, whole)) == 0
    rehearsed.clear()
    command = [sys.executable, "-m", "deploy", *tuning(path, out)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as running:
        until(lambda: len(list(out.glob("*/summary.json"))) >= 3, "three rehearsals")
        running.send_signal(signal.SIGKILL)
    done = {one.parent.name for one in out.glob("*/summary.json")}
    assert not (out / "point008-seed102" / "summary.json").exists(), "killed in the middle"
    assert carry_out(tuning(path, out)) == 0
    assert sorted(rehearsed) == sorted(set(runs_of(*WALK)) - done)
    assert (out / "tuning.json").read_bytes() == (whole / "tuning.json").read_bytes()


def test_of_several_metrics_each_is_over_its_value_at_the_start_and_means_are_over_seeds(tmp_path):
    """Speed, a parameter of the schema, and a whole one of the behaviour; all figures from the summaries."""
    path, out = small(tmp_path, duration_s=200), tmp_path / "out"
    metrics = ["normalised_graph_idleness_s", "normalised_worst_idleness_s"]
    wanted = [
        "--parameter",
        "robots.max_speed_m_s:0.5..2.5",
        "--parameter",
        "robots.parameters.items_per_tick=8:1..36",
    ]
    command = ["tune", str(path), *wanted, *SEEDS, "--out", str(out), "--evaluations", "4", "--until", "150"]
    assert carry_out([*command, "--metric", metrics[0], "--metric", metrics[1]]) == 0
    points = record(out)["points"]
    assert [list(one["values"].values()) for one in points] == [[1.5, 8], [1.0, 8], [2.0, 8], [1.5, 1]]
    for one in points:
        folders = [out / f"point{one['number']:03}-seed{seed}" for seed in (101, 102)]
        for seed, folder in zip((101, 102), folders, strict=True):
            ran = load_scenario(folder / "scenario.toml")
            assert (ran.seed, ran.duration_s) == (seed, 150)
            assert [ran.robots.max_speed_m_s, ran.robots.parameters["items_per_tick"]] == list(
                one["values"].values()
            )
        summaries = [json.loads((folder / "summary.json").read_text())["metrics"] for folder in folders]
        for metric in metrics:
            assert math.isclose(one["metrics"][metric], (summaries[0][metric] + summaries[1][metric]) / 2)
        parts = [one["metrics"][metric] / points[0]["metrics"][metric] for metric in metrics]
        assert math.isclose(one["score"], sum(parts))
    assert points[0]["score"] == 2
    assert record(out)["best"] == min(points, key=lambda one: one["score"])
    assert points[2]["score"] < points[0]["score"] < points[1]["score"], "who goes faster comes by more often"


FAN = ["--set", "robots.start={kind='fan'}", "--parameter", "robots.start.radius_m:1..20"]
FORM = "--parameter: must be key.path[=START]:LOW..HIGH in finite numbers, got "
PARAMETERS = [
    ([f"{KEY}:1..20", f"{KEY}:1..9"], f"--parameter {KEY}: is given twice"),
    (["seed:1..20"], "--parameter seed: is nothing to tune; --seeds says which are run"),
    (["robots.parameters.pause:1..20"], "robots.parameters.pause is not a field; did you mean pause_ticks?"),
    (
        ["robots.parameters.pause=3:1..20"],
        "robots.parameters.pause is not a field; did you mean pause_ticks?",
    ),
    (["robots.parameters.mood:0..1"], "mood: must be a number to be tuned, is 'calm' in the scenario"),
    (["robots.parameters.mood=1:0..2"], "robots.parameters.mood must be text, got 1"),
    (["radio.rules.3.range_m:1..20"], "radio.rules.3.range_m=1: there is no such place in the scenario"),
    ([f"{KEY}=21:1..20"], f"--parameter {KEY}: the start 21 must be within its bounds 1..20"),
    ([f"{KEY}:9..20"], f"--parameter {KEY}: the start 8 must be within its bounds 9..20"),
    ([f"{KEY}:20..1"], f"--parameter: the lower bound must be below the upper one, got '{KEY}:20..1'"),
    ([f"{KEY}:8..8"], "--parameter: the lower bound must be below the upper one"),
    ([f"{KEY}:0.5..20"], "bounds must be whole numbers, as the parameter is, got 0.5..20"),
    ([f"{KEY}=8.5:1..20"], f"{KEY} must be a whole number, got 8.5"),
    ([f"{KEY}=13:1..20"], "small.toml: robots.parameters: 13 brings bad luck"),
    ([f"{KEY}:1..inf"], f"{FORM}'{KEY}:1..inf'"),
    ([f"{KEY}=8"], FORM),
    ([f"{KEY}=:1..20"], FORM),
    ([":1..20"], FORM),
]


@pytest.mark.parametrize(("parameters", "words"), PARAMETERS)
def test_a_wrong_parameter_is_one_clear_line_and_leaves_nothing(path, tmp_path, capsys, parameters, words):
    given = [word for one in parameters for word in ("--parameter", one)]
    out = ["--out", str(tmp_path / "out")]
    refused(["tune", str(path), *given, "--metric", "grants", *SEEDS, *out], words, capsys)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--evaluations", "0"], "--evaluations: must be a whole number >= 1, got '0'"),
        (["--seeds", "101", "7"], "--seeds: must be a whole number >= 101, as `picket reproduce` reports on"),
        (["--seeds", "101", "101"], "--seeds 101: is given twice"),
        (["--metric", "grant"], "there is no such metric; did you mean grants? known are graph_idleness_s, "),
        (["--metric", "visits.max"], "--metric visits.max: there is no such metric"),
        (["--metric", "grants"], "--metric grants: is given twice"),
        (["--step", "0"], "--step: must be a number from 1e-06 to 1, got '0'"),
        (["--smallest-step", "0.3"], "--smallest-step must be <= --step (0.25), got 0.3"),
        (["--until", "41"], "--until must be <= duration_s (40.0), got 41.0"),
        (["--until", "nan"], "--until: must be a number > 0, got 'nan'"),
        (FAN, "the scenario has no value; give a start, robots.start.radius_m=START:LOW..HIGH"),
        (["--set", "robots.cuont=3"], "robots.cuont is not a field; did you mean count?"),
        (["--out", "/proc/nowhere"], "--out /proc/nowhere: cannot keep a tuning there: "),
    ],
)
def test_a_wrong_option_is_one_clear_line_and_leaves_nothing(path, tmp_path, capsys, more, words):
    refused(tuning(path, tmp_path / "out", *more), words, capsys)
    assert not (tmp_path / "out").exists()


def test_what_is_missing_is_one_clear_line(path, capsys):
    refused(
        ["tune", str(path)], "the following arguments are required: --parameter, --metric, --seeds", capsys
    )
    refused(["tune", "nosuch", *tuning(path, "out")[2:]], "nosuch: no such file and no such scenario", capsys)


@pytest.mark.parametrize(
    ("parameter", "metric", "words"),
    [
        (f"{KEY}=2:1..20", "grants", "point001-seed101: r2 died: exit code 1: RuntimeError: no time to"),
        (f"{KEY}=3:1..20", "grants", "point001-seed101: walked out"),
        (f"{KEY}=8:1..20", "node_interval_max_s", "node_interval_max_s was not measured"),
    ],
)
def test_a_start_point_that_cannot_be_measured_is_a_mistake(path, tmp_path, capsys, parameter, metric, words):
    command = ["tune", str(path), "--parameter", parameter, "--metric", metric, *SEEDS]
    refused([*command, "--out", str(tmp_path / "out")], f"the start point is refused: {words}", capsys)


def test_several_metrics_cannot_be_relative_to_nothing(path, tmp_path, capsys):
    words = "the start point is refused: visits is 0.0, no score can be relative to it"
    refused(tuning(path, tmp_path / "out", "--metric", "visits"), words, capsys)


def test_a_folder_is_for_one_question_and_a_damaged_record_is_told(path, tmp_path, capsys):
    out = tmp_path / "out"
    assert carry_out(tuning(path, out, "--evaluations", "1")) == 0
    capsys.readouterr()
    other = tuning(path, out, "--until", "30", "--step", "0.5")
    refused(other, f"--out {out}: holds a tuning with other until_s and step; give another folder", capsys)
    (out / "tuning.json").write_text('{"scenario": ')
    refused(tuning(path, out), f"{out}/tuning.json: is damaged: ", capsys)


def refused(command, words, capsys):
    """Exit code 2 and one line that has these words."""
    assert carry_out(command) == 2
    said = capsys.readouterr()
    assert words in said.err and said.err.count("\n") == 1, said.err
    assert said.out == ""
