"""The same seed gives the same run, whatever the processes do; an unfair behaviour does not."""

import random
import subprocess
import sys

from deploy.compare import compare
from deploy.launcher import Launcher
from deploy.scenario_file import load_scenario
from tests.live_runs import as_processes, command, fault, rehearsed, run_hash, small
from tests.one_byte import OneByte

FAULTS = (
    fault(60, "kill", "r5")
    + fault(80, "freeze", "r3", "r1")
    + fault(100, "restart", "r5", memory="lost")
    + fault(110, "kill", "r4")
    + fault(130, "thaw", "r1", "r3")
    + fault(150, "restart", "r4", memory="kept")
)


class ShuffledLauncher(Launcher):
    """Starts nodes in another order, with another seed for the hashes of strings."""

    def start_order(self) -> list[str]:
        return random.Random(7).sample(self._scenario.node_ids, len(self._scenario.node_ids))


def test_processes_and_rehearsal_give_one_hash_with_every_kind_of_fault(tmp_path):
    path = small(tmp_path, faults=FAULTS)
    rehearsal = rehearsed(tmp_path, path)
    first, second = as_processes(tmp_path, path, "first"), as_processes(tmp_path, path, "second")
    assert run_hash(first) == run_hash(second) == run_hash(rehearsal)
    assert compare(first, rehearsal)[0]


def test_load_start_order_and_hash_seed_do_not_matter(tmp_path, monkeypatch):
    path = small(tmp_path, faults=FAULTS)
    monkeypatch.setenv("PYTHONHASHSEED", "4711")
    burners = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2)]
    try:
        loaded = as_processes(tmp_path, path, "loaded", ShuffledLauncher)
    finally:
        for burner in burners:
            burner.kill()
            burner.wait()
    assert run_hash(loaded) == run_hash(rehearsed(tmp_path, path))


def test_another_seed_gives_another_hash(tmp_path):
    path = small(tmp_path)
    assert run_hash(rehearsed(tmp_path, path)) != run_hash(rehearsed(tmp_path, path, "other", seed=2))


def test_a_behaviour_that_depends_on_the_order_of_arrival_is_found_out(tmp_path):
    hashes = []
    for name, run in (("rehearsal", rehearsed), ("live", as_processes)):
        shared = tmp_path / f"{name}.shared"
        path = small(
            tmp_path,
            duration_s=40,
            behaviour="tests.arrival:Arrival",
            parameters=f'parameters = {{ path = "{shared}" }}',
        )
        hashes.append(run(tmp_path, path, name))
    equal, text = compare(*hashes)
    assert not equal
    assert "they part at tick" in text


def test_a_kill_by_hand_is_repeated_with_faults_from(tmp_path):
    path = small(tmp_path, duration_s=400)
    with command(path, tmp_path / "by-hand", "--clock", "paced", "--rate", "10") as run:
        run.ask("pause")
        for verb, node in (("kill", "r4"), ("freeze", "r3"), ("thaw", "r3"), ("restart", "r4")):
            assert run.ask(verb, node, memory="kept").accepted
            run.ask("step", value=20)
        run.ask("speed", value=0)
        run.ask("resume")
        assert run.wait() == 0
    by_hand = run.folder
    again = subprocess.run(
        [
            sys.executable,
            "-m",
            "deploy",
            "run",
            str(path),
            "--faults-from",
            str(by_hand),
            "--dashboard",
            "off",
            "--out",
            str(tmp_path / "again"),
            "--in-process",
        ],
        check=True,
        capture_output=True,
        text=True,
    )
    assert run_hash(by_hand) in again.stdout
    assert compare(by_hand, next((tmp_path / "again").iterdir()))[0]


def test_compare_names_the_first_tick_and_node_where_one_byte_differs(tmp_path, monkeypatch):
    path = small(tmp_path, duration_s=60, behaviour="tests.one_byte:OneByte")
    plain = rehearsed(tmp_path, path)
    monkeypatch.setattr(OneByte, "other_at", ("r4", 37))
    equal, text = compare(plain, rehearsed(tmp_path, path, "other"))
    assert not equal
    assert "tick 37" in text and "r4 answered something else: outbox" in text


def test_the_hash_does_not_know_the_fault_plan_only_what_happened(tmp_path):
    path = small(tmp_path, faults=fault(150, "kill", "r3"))
    early = load_scenario(path)
    assert early.faults
    assert run_hash(rehearsed(tmp_path, path)) != run_hash(rehearsed(tmp_path, path, "none", faults=[]))
