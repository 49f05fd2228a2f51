"""An operator's mistake ends with exit code 2 and one clear line, and leaves nothing behind."""

import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from deploy.__main__ import OPERATOR_MISTAKE, carry_out
from tests.live_runs import command, rehearsed, small

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that has ended, as an operator finds it."""
    place = tmp_path_factory.mktemp("finished")
    return rehearsed(place, small(place, duration_s=10))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, finished: Path) -> Iterator[Path]:
    """A working directory with good and bad files; what was not there before must not be there after."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "private").mkdir(mode=0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "private"))
    small(tmp_path)
    (tmp_path / "latin.toml").write_bytes("mission = 'Gel\u00e4nde'".encode("latin-1"))
    (tmp_path / "torn.toml").write_text('mission = "area')
    (tmp_path / "folder").mkdir()
    (tmp_path / "a_file").write_text("")
    (tmp_path / "their_behaviours.py").write_text("raise RuntimeError('not\\nyet')\n")
    monkeypatch.syspath_prepend(tmp_path)
    shutil.copytree(finished, tmp_path / "sound")
    damaged_copies(tmp_path / "sound")
    before, children = set(tmp_path.rglob("*")), psutil.Process().children()
    yield tmp_path
    after = {one for one in tmp_path.rglob("*") if "__pycache__" not in one.parts}
    assert after - before - {tmp_path / "private" / f"picket-{psutil.Process().uids().real}"} == set()
    assert psutil.Process().children() == children


def damaged_copies(sound: Path) -> None:
    """Runs next to a sound one: one bit wrong, no journal in the journal, an empty one, a torn summary."""
    data = (sound / "journal").read_bytes()
    bent = bytearray(data)
    bent[len(data) // 2] ^= 4
    for name, journal in {"bent": bytes(bent), "alien": b"not a journal", "empty": b""}.items():
        shutil.copytree(sound, sound.parent / name)
        (sound.parent / name / "journal").write_bytes(journal)
    shutil.copytree(sound, sound.parent / "torn_summary")
    (sound.parent / "torn_summary" / "summary.json").write_text('{"run": ')


RUN = ["--dashboard", "off", "--out", "folder"]
TOWER_AND_TEAM = "r1, r2, r3, r4, r5"
MISTAKES = {
    "run nosuch": "nosuch: no such file and no such scenario; `picket scenarios` lists the shipped ones",
    "run area-patrol-n6": "did you mean area-patrol-n5?",
    "run ''": "the name of the scenario is empty",
    "run folder": "folder: is a directory; give a scenario file",
    "run latin.toml": "latin.toml: not UTF-8 text (byte 14); a scenario is TOML",
    "run torn.toml": "torn.toml: not valid TOML",
    "run small.toml --set robots.cuont=3": "robots.cuont is not a field; did you mean count?",
    "run small.toml --set duration_s='long'": "duration_s must be a number, got 'long'",
    "run small.toml --set robots.count=2.5": "robots.count must be a whole number, got 2.5",
    "run small.toml --set radio.rules.0.range_m=-3": "radio.rules[0].range_m must be a number > 0.0, got -3",
    "run small.toml --set radio.rules.0.range_m=nan": "radio.rules[0].range_m must be finite, got nan",
    "run small.toml --set robots.behaviour=lr_tp": "robots.behaviour: there is no behaviour 'lr_tp'",
    "run small.toml --set robots.behaviour=their_behaviours:Mine": "RuntimeError: not yet",
    "run small.toml --set clock.kind=slow": "clock.kind must be lockstep or paced, got 'slow'",
    "run small.toml --set faults=[{at_s=3,verb='kill',nodes=['r9']}]": "faults[0].nodes: there is no node r9",
    "run small.toml --set radio.rules.7.range_m=3": "--set radio.rules.7.range_m=3: there is no such place",
    "run small.toml --set seed": "--set seed: must be key.path=value",
    "run small.toml --until 0": "--until: must be a number > 0, got '0'",
    "run small.toml --until 201": "--until must be > 0 and <= duration_s (200.0), got 201.0",
    "run small.toml --until soon": "--until: must be a number > 0, got 'soon'",
    "run small.toml --until nan": "--until: must be a number > 0, got 'nan'",
    "run small.toml --rate -1": "--rate: must be a number > 0, got '-1'",
    "run small.toml --seed -1": "--seed: must be a whole number >= 0, got '-1'",
    "run small.toml --clock slow": "--clock: invalid choice: 'slow'",
    "run small.toml --faults-from nosuch": "nosuch: no such run; give a run folder, or the id of",
    "run small.toml --faults-from alien": "alien/journal: not a journal",
    "run small.toml --out a_file": "--out a_file: cannot make a run folder there: Not a directory",
    "run small.toml --sed 3": "unrecognized arguments: --sed 3",
    "kill nosuch r2": "nosuch: no such run; give a run folder, or the id of",
    "kill sound r2": "sound: is not running",
    "kill sound": "the following arguments are required: NODE",
    "restart sound r2 --memory some": "--memory: invalid choice: 'some'",
    "restart sound r2 --place there": "--place: invalid choice: 'there'",
    "step sound 0": "TICKS: must be a whole number >= 1, got '0'",
    "step sound nan": "TICKS: must be a whole number >= 1, got 'nan'",
    "speed sound -1": "X: must be a number >= 0, got '-1'",
    "speed sound inf": "X: must be a number >= 0, got 'inf'",
    "status nosuch": "nosuch: no such run",
    "status torn_summary": "torn_summary/summary.json: is damaged",
    "compare nosuch sound": "nosuch: no such run",
    "compare sound bent": "bent/journal: ",
    "compare alien sound": "alien/journal: not a journal",
    "compare sound empty": "empty/journal: has no beginning: it is empty or no journal",
    "dashboard nosuch": "nosuch: no such run",
    "nonsense": "COMMAND: invalid choice: 'nonsense'",
    "": "the following arguments are required: COMMAND",
}


def split(line: str) -> list[str]:
    """A command line as a list; quotes stay, but for an empty word."""
    words = ["" if word == "''" else word for word in line.split()]
    wants_folder = words[:1] == ["run"] and "--out" not in words
    return words + (RUN if wants_folder else [])


@pytest.mark.parametrize("line", MISTAKES)
def test_a_mistake_is_one_clear_line_and_leaves_nothing(
    here: Path, line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    status = carry_out(split(line))
    out, said = capsys.readouterr()
    assert status == OPERATOR_MISTAKE
    assert out == ""
    assert said.startswith("picket: ")
    assert len(said.splitlines()) == 1, said
    assert MISTAKES[line] in said, said


def test_two_robots_with_one_name_are_refused(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenario = here / "small.toml"
    scenario.write_text(scenario.read_text().replace("count = 4", 'ids = ["r2", "r3", "r2", "r4"]'))
    assert carry_out(split("run small.toml")) == OPERATOR_MISTAKE
    said = "picket: small.toml: robots.ids: there are two nodes r2; ids are unique\n"
    assert capsys.readouterr() == ("", said)


def test_a_port_in_use_is_told_before_there_is_a_run_folder(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert carry_out(split(f"run small.toml --set wire.port={port}")) == OPERATOR_MISTAKE
    said = f"picket: wire.port {port}: address already in use; choose another, or 0 for any free one\n"
    assert capsys.readouterr() == ("", said)


@pytest.mark.parametrize("line", ["run nosuch", "compare sound bent", "step sound never"])
def test_the_real_command_says_the_same(here: Path, line: str) -> None:
    picket = [sys.executable, "-m", "deploy", *split(line)]
    ended = subprocess.run(
        picket, cwd=here, env=with_the_project(), capture_output=True, text=True, check=False
    )
    assert (ended.returncode, ended.stdout, len(ended.stderr.splitlines())) == (OPERATOR_MISTAKE, "", 1)
    assert ended.stderr.startswith("picket: ")


def with_the_project() -> dict[str, str]:
    """An environment in which `python -m deploy` is found from anywhere."""
    return os.environ | {"PYTHONPATH": str(ROOT)}


def test_a_live_run_answers_a_wish_it_cannot_grant_with_the_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    paced = ["--clock", "paced", "--rate", "20"]
    with command(small(tmp_path, duration_s=2000), tmp_path / "out", *paced) as run:
        wishes = {
            "kill nobody1": f"there is no node nobody1; nodes are {TOWER_AND_TEAM}",
            "thaw r2": "cannot thaw r2: it is alive",
            "kill r6": f"there is no node r6; nodes are {TOWER_AND_TEAM}",
        }
        for wish, why in wishes.items():
            verb, node = wish.split()
            assert carry_out([verb, str(run.folder), node]) == OPERATOR_MISTAKE
            assert capsys.readouterr() == ("", f"picket: {why}\n")
        assert len(run.status()["alive"]) == 5
