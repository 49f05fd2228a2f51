"""Failures are real: signals, crashes, hangs, and what is left when the launcher goes."""

import os
import signal

import psutil
import pytest

from deploy.metrics.area import AreaMetrics
from deploy.recorder import events
from deploy.scenario_file import load_scenario
from tests.live_runs import as_processes, command, fault, gone, rehearsed, run_hash, small, until
from world_server.journal import commits

PACED = ("--clock", "paced", "--rate", "10")


def test_sa_delay_grows_by_one_second_per_second_while_the_tower_process_is_stopped(tmp_path):
    path = small(tmp_path, duration_s=900, faults=fault(250, "freeze", "r1") + fault(850, "thaw", "r1"))
    folder = as_processes(tmp_path, path)
    metrics = AreaMetrics(load_scenario(path))
    course = [metrics.feed(commit.facts) for commit in commits(folder / "journal")]
    frozen = course[250:850]
    for before, after in zip(course[249:849], frozen, strict=True):
        assert after.mean_sa_delay_s == pytest.approx(before.mean_sa_delay_s + 1)
        assert after.worst_sa_delay_s == before.worst_sa_delay_s + 1
    assert course[850].mean_sa_delay_s < frozen[-1].mean_sa_delay_s - 100  # it hears what was kept for it
    assert min(one.graph_idleness_s for one in frozen) < 100  # the robots patrolled all the time


def test_a_kill_from_another_terminal_is_confirmed_and_the_run_goes_on(tmp_path):
    path = small(tmp_path, duration_s=300)
    with command(path, tmp_path / "out", *PACED) as run:
        pid = run.status()["pids"]["r4"]
        reply = run.ask("kill", "r4")
        assert reply.accepted and "r4" not in reply.data["alive"]
        assert not psutil.pid_exists(pid) or gone(psutil.Process(pid))
        assert not run.ask("kill", "r4").accepted
        assert not run.ask("kill", "r77").accepted
        run.ask("speed", value=0)
        assert run.wait() == 0
        told = run.event("fault", "r4")
        assert told["data"]["confirmed"] and told["data"]["pause_ms"] > 0
        ended = {one["node"]: one["exit"] for one in run.summary()["processes"]}
        assert ended["r4"] == -signal.SIGKILL
        assert {ended[node] for node in ("world", "r1", "r2", "r3", "r5")} == {0}


def test_a_robot_stopped_from_outside_is_named_and_waited_for(tmp_path):
    path = small(tmp_path, duration_s=300)
    with command(path, tmp_path / "out", *PACED, "--set", "watchdog.budget_s=0.05") as run:
        pid = run.status()["pids"]["r3"]
        os.kill(pid, signal.SIGSTOP)
        late = run.event("watchdog", "r3")
        assert late["data"]["pid"] == pid and late["data"]["waited_s"] >= 0.05
        until(lambda: told(run.folder, "watchdog", "r3") >= 3, "three warnings")
        assert run.status()["waiting_for"] == ["r3"]
        os.kill(pid, signal.SIGCONT)
        run.ask("speed", value=0)
        assert run.wait() == 0
    assert run_hash(run.folder) == run_hash(rehearsed(tmp_path, path))


def test_a_robot_that_is_declared_dead_is_dead_and_the_run_goes_on_without_it(tmp_path):
    path = small(tmp_path, duration_s=300)
    settings = ("--set", "watchdog.budget_s=0.5", "--set", "watchdog.policy=declare_dead")
    with command(path, tmp_path / "out", *PACED, *settings) as run:
        process = psutil.Process(run.status()["pids"]["r3"])
        process.suspend()
        run.event("fault", "r3")
        until(lambda: gone(process), "the end of r3")
        run.ask("speed", value=0)
        assert run.wait() == 0
        assert [one["verb"] for one in run.summary()["faults"]] == ["kill"]


def test_a_watchdog_that_aborts_ends_the_run_and_says_why(tmp_path):
    path = small(tmp_path, duration_s=300)
    settings = ("--set", "watchdog.budget_s=0.5", "--set", "watchdog.policy=abort")
    with command(path, tmp_path / "out", *PACED, *settings) as run:
        psutil.Process(run.status()["pids"]["r3"]).suspend()
        processes = run.processes()
        assert run.wait() == 1
        assert "no answer from r3" in run.said()
        assert all(gone(process) for process in processes)


def test_an_exception_in_a_behaviour_is_that_robots_death(tmp_path):
    path = small(tmp_path, duration_s=60, behaviour="tests.crashing:Crashing")
    with command(path, tmp_path / "out", "--clock", "paced", "--rate", "0.5") as run:
        run.ask("speed", value=0)
        assert run.wait() == 0
        death = run.event("death", "r3")
        assert death["tick"] == 20 and "the wheel fell off" in death["data"]["last_lines"]
        assert "the wheel fell off" in run.said()
        assert "the wheel fell off" in (run.folder / "logs" / "r3.log").read_text()
        assert run.summary()["completed"]
    assert run_hash(run.folder) == run_hash(rehearsed(tmp_path, path))


def test_control_c_writes_the_summary_and_leaves_nothing(tmp_path):
    path = small(tmp_path, duration_s=10_000)
    with command(path, tmp_path / "out", *PACED) as run:
        processes, ports = run.processes(), listening(run.processes())
        assert len(processes) >= 6 and len(ports) == 1
        run.signal(signal.SIGINT)
        assert run.wait() == 130
        assert all(gone(process) for process in processes)
        assert not ports & listening(psutil.process_iter())
        assert not run.summary()["completed"] and run.summary()["run_hash"] == run_hash(run.folder)


def test_control_c_ends_a_run_that_waits_for_a_stopped_robot(tmp_path):
    path = small(tmp_path, duration_s=10_000)
    with command(path, tmp_path / "out", *PACED, "--set", "watchdog.budget_s=0.05") as run:
        processes = run.processes()
        psutil.Process(run.status()["pids"]["r3"]).suspend()
        run.event("watchdog", "r3")
        run.signal(signal.SIGINT)
        assert run.wait() == 130
        assert all(gone(process) for process in processes)
        assert run.summary()["run_hash"] == run_hash(run.folder)


def test_kill_9_of_the_launcher_leaves_no_process_and_no_port(tmp_path):
    path = small(tmp_path, duration_s=10_000)
    with command(path, tmp_path / "out", *PACED) as run:
        processes, ports = run.processes(), listening(run.processes())
        assert len(processes) >= 6 and len(ports) == 1
        run.signal(signal.SIGKILL)
        run.wait()
        until(lambda: all(gone(process) for process in processes), "the end of all children")
        assert not ports & listening(psutil.process_iter())
        assert list(commits(run.folder / "journal")), "the journal can be read up to the last commit"


def test_time_can_be_stopped_stepped_and_let_go_on(tmp_path):
    path = small(tmp_path, duration_s=400)
    with command(path, tmp_path / "out", *PACED) as run:
        run.ask("pause")
        before = run.status()
        assert before["paused"]
        run.ask("step", value=3)
        until(lambda: run.status()["tick"] == before["tick"] + 3, "three more ticks")
        run.ask("resume")
        run.ask("speed", value=0)
        assert run.wait() == 0
    assert run_hash(run.folder) == run_hash(rehearsed(tmp_path, path))


def told(folder, kind: str, node: str) -> int:
    """How many events of a kind there are about a node."""
    return sum(one["kind"] == kind and one["node"] == node for one in events(folder))


def listening(processes) -> set[int]:
    """Ports that these processes listen on."""
    ports = set()
    for process in processes:
        try:
            found = process.net_connections("tcp")
        except psutil.Error:
            continue
        ports |= {one.laddr.port for one in found if one.status == psutil.CONN_LISTEN}
    return ports
