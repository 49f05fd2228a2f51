"""A line patrol with every kind of fault: processes do as the rehearsal, and another seed is another run."""

import contextlib
import io

import msgspec

from deploy.__main__ import carry_out
from deploy.compare import compare
from deploy.scenario_file import load_scenario, to_toml
from tests.line_courses import line_run, rehearsed_line, run_of
from tests.live_runs import command, launched, run_hash, small
from wire.scenario import PlannedFault, Scenario

FAULTS = (
    PlannedFault(150, "kill", ("r3",)),
    PlannedFault(200, "freeze", ("r4", "r6")),
    PlannedFault(260, "kill", ("r1",)),
    PlannedFault(300, "thaw", ("r6", "r4")),
    PlannedFault(330, "restart", ("r1",)),
    PlannedFault(360, "restart", ("r3",), place="queue"),
    PlannedFault(400, "kill", ("r2",)),
    PlannedFault(430, "restart", ("r2",), memory="kept"),
    PlannedFault(450, "kill", ("r1", "r5")),
    PlannedFault(480, "restart", ("r1",), memory="kept"),
    PlannedFault(500, "restart", ("r5",)),
)


def eventful(seed: int = 1) -> Scenario:
    """Ten minutes."""
    return line_run("6r4s", 600, 9.0, seed=seed, faults=FAULTS)


def test_processes_and_rehearsal_give_one_hash_and_another_seed_another(tmp_path):
    rehearsal = rehearsed_line(tmp_path / "rehearsal", eventful())
    again = rehearsed_line(tmp_path / "again", eventful())
    first, other = launched(tmp_path, eventful(), "first"), launched(tmp_path, eventful(2), "other")
    assert run_hash(first) == run_hash(rehearsal.folder) == run_hash(again.folder)
    assert run_hash(other) == run_hash(rehearsed_line(tmp_path / "same", eventful(2)).folder)
    assert run_hash(other) != run_hash(first)
    befell = [(fault.verb, fault.node) for one in rehearsal.facts for fault in one.faults]
    assert befell == [(one.verb, node) for one in FAULTS for node in one.nodes], "nothing was refused"


def said_by(*arguments: str) -> tuple[int, str]:
    """The exit code of a command and what it prints, complaints included."""
    with contextlib.redirect_stderr(io.StringIO()) as said, contextlib.redirect_stdout(said):
        status = carry_out(list(arguments))
    return status, said.getvalue()


def test_a_robot_is_carried_to_the_queue_of_a_live_run_that_stands_still(tmp_path):
    given, path = line_run("6r4s", 300, 9.0), tmp_path / "line.toml"
    path.write_text(to_toml(given))
    with command(path, tmp_path / "out", "--clock", "paced", "--rate", "50") as run:
        run.ask("pause")
        folder = str(run.folder)
        assert said_by("kill", folder, "r3")[0] == 0
        status, said = said_by("restart", folder, "r1", "--place", "queue")
        assert (status, said.count("\n")) == (2, 1)
        assert said_by("restart", folder, "r3", "--place", "queue")[0] == 0
        run.ask("speed", value=0)
        run.ask("resume")
        assert run.wait() == 0
    facts = run_of(given, run.folder).facts
    faults = [fault for one in facts for fault in one.faults]
    assert [(one.verb, one.node, one.place) for one in faults] == [
        ("kill", "r3", "here"),
        ("restart", "r3", "queue"),
    ]
    again = [PlannedFault(float(one.tick), one.verb, (one.node,), place=one.place) for one in faults]
    same = msgspec.structs.replace(load_scenario(path), faults=tuple(again))
    assert compare(run.folder, rehearsed_line(tmp_path / "again", same).folder)[0]


def test_an_area_patrol_has_no_queue_to_restart_in(tmp_path):
    with command(small(tmp_path), tmp_path / "out", "--clock", "paced", "--rate", "20") as run:
        folder = str(run.folder)
        assert said_by("kill", folder, "r3")[0] == 0
        status, said = said_by("restart", folder, "r3", "--place", "queue")
        assert status == 2
        assert said == (
            "picket: cannot restart r3 in the queue: only robots of a line patrol have a place there\n"
        )
        assert said_by("restart", folder, "r3")[0] == 0
        run.ask("speed", value=0)
        assert run.wait() == 0
