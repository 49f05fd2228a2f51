"""Real runs for tests: a small scenario, as processes or by the command line, and what came of it."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil

from deploy.launcher import Launcher
from deploy.operate import request
from deploy.recorder import events
from deploy.rehearsal import rehearse
from deploy.run_folder import RunError, live_runs
from deploy.scenario_file import load_scenario, to_toml
from wire.messages import Reply, Request
from wire.scenario import Scenario
from world_server.journal import read

SMALL = """
mission = "area"
duration_s = {duration_s}

[field]
kind = "grid"
columns = 6
rows = 6

[robots]
count = {robots}
behaviour = "{behaviour}"
spares = 1
{parameters}

[[radio.rules]]
kind = "range"
range_m = 90
"""

DEADLINE_S = 60.0


def small(
    folder: Path,
    *settings: str,
    duration_s: int = 200,
    robots: int = 4,
    behaviour: str = "lr_pt",
    faults: str = "",
    parameters: str = "",
) -> Path:
    """A scenario file: four robots and a tower on 6 x 6 cells."""
    path = folder / "small.toml"
    text = SMALL.format(duration_s=duration_s, robots=robots, behaviour=behaviour, parameters=parameters)
    path.write_text(text + faults)
    return path


def fault(at_s: int, verb: str, *nodes: str, memory: str = "lost") -> str:
    """One planned fault, as TOML."""
    return f'\n[[faults]]\nat_s = {at_s}\nverb = "{verb}"\nnodes = {json.dumps(nodes)}\nmemory = "{memory}"\n'


def run_folder(parent: Path, name: str, scenario: Scenario) -> Path:
    """An empty run folder with its scenario."""
    folder = parent / name
    (folder / "logs").mkdir(parents=True)
    (folder / "scenario.toml").write_text(to_toml(scenario))
    return folder


def rehearsed(parent: Path, path: Path, name: str = "rehearsal", **overrides: Any) -> Path:
    """The folder of a rehearsal of a scenario file."""
    scenario = load_scenario(path, **overrides)
    folder = run_folder(parent, name, scenario)
    rehearse(scenario, to_toml(scenario), folder, scenario.last_tick)
    return folder


def as_processes(parent: Path, path: Path, name: str = "live", launcher: type[Launcher] = Launcher) -> Path:
    """The folder of a run of a scenario file with one process per node."""
    return launched(parent, load_scenario(path), name, launcher)


def launched(
    parent: Path, scenario: Scenario, name: str = "live", launcher: type[Launcher] = Launcher
) -> Path:
    """The folder of a run of a scenario with one process per node."""
    folder = run_folder(parent, name, scenario)
    asyncio.run(launcher(scenario, folder, scenario.last_tick, lambda facts: None).run(None, print))
    return folder


def run_hash(folder: Path) -> str:
    """The hash of a run that came to its end."""
    *_, end = read(folder / "journal")
    return end.run_hash


def until(condition: Callable[[], Any], what: str) -> Any:
    """Wait for a condition and return its value; fails with `what` when it does not come."""
    limit = time.monotonic() + DEADLINE_S
    while not (value := condition()):
        assert time.monotonic() < limit, f"waited {DEADLINE_S} s for {what}"
        time.sleep(0.01)
    return value


class Command:
    """`picket run` in a process of its own, as a user starts it."""

    def __init__(self, path: Path, out: Path, *options: str) -> None:
        command = [sys.executable, "-m", "deploy", "run", str(path), "--out", str(out), "--dashboard", "off"]
        self.output = (out.parent / f"{out.name}.txt").open("w+")
        self._popen = subprocess.Popen(
            [*command, *options], stdout=self.output, stderr=self.output, stdin=subprocess.DEVNULL
        )
        self.pid = self._popen.pid
        self._out = out

    @property
    def folder(self) -> Path:
        """The run's folder, as soon as there is one."""
        found = until(lambda: list(self._out.glob("*/scenario.toml")), "a run folder")
        return found[0].parent

    def ready(self) -> "Command":
        """Wait until the run answers an operator."""
        until(lambda: any(Path(one.folder) == self.folder.resolve() for one in live_runs()), "a live run")
        until(lambda: (self.status() or {"tick": 0})["tick"] > 0, "the first tick")
        return self

    def ask(self, verb: str, node: str = "", value: float = 0.0, memory: str = "lost") -> Reply:
        """An operator's request, as `picket kill` and its like make it."""
        return request(str(self.folder), Request(verb, node, memory, value))

    def status(self) -> dict[str, Any] | None:
        """How the run stands; None when it does not answer."""
        try:
            return self.ask("status").data
        except RunError:
            return None

    def event(self, kind: str, node: str = "") -> dict[str, Any]:
        """Wait for an event of a kind."""
        return until(
            lambda: next(
                (one for one in events(self.folder) if one["kind"] == kind and node in ("", one["node"])),
                None,
            ),
            f"event {kind} {node}",
        )

    def signal(self, number: int) -> None:
        """Send the launcher a signal."""
        os.kill(self.pid, number)

    def wait(self) -> int:
        """Wait for the launcher's end; returns its exit code."""
        return self._popen.wait(DEADLINE_S)

    def said(self) -> str:
        """What the launcher has printed."""
        self.output.flush()
        return Path(self.output.name).read_text()

    def processes(self) -> list[psutil.Process]:
        """The launcher's children and theirs."""
        return psutil.Process(self.pid).children(recursive=True)

    def summary(self) -> dict[str, Any]:
        """The run's summary."""
        return json.loads((self.folder / "summary.json").read_text())


@contextmanager
def command(path: Path, out: Path, *options: str) -> Iterator[Command]:
    """`picket run` that is ready, and ended if the test has not."""
    started = Command(path, out, *options)
    try:
        yield started.ready()
    finally:
        if started._popen.poll() is None:
            started.signal(signal.SIGTERM)
            started.wait()
        started.output.close()


def gone(process: psutil.Process) -> bool:
    """Has it ended? A zombie has: it only waits for somebody to ask."""
    try:
        return process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True
