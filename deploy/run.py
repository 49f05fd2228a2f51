"""`picket run`: from a scenario to a run folder with its summary and recording."""

import argparse
import asyncio
import json
import os
import time
from pathlib import Path
from typing import Any

from deploy.launcher import Launcher, free_port, roll_entry
from deploy.process import on_interrupt_now
from deploy.recorder import deaths, summarise
from deploy.rehearsal import Rehearsal, rehearse
from deploy.report import ProgressLine, console_for, print_result
from deploy.run_folder import find_folder, new_folder
from deploy.scenario_file import ScenarioError, find_scenario, load_scenario, to_toml
from deploy.viewer import choose_mode
from wire.scenario import Scenario
from world_server.journal import commits
from world_server.records import Commit

INTERRUPTED = 130


def run_scenario(given: argparse.Namespace) -> int:
    """Carry out `picket run`; returns the exit code."""
    path = find_scenario(given.scenario)
    scenario = load_scenario(path, _settings(given), **_overrides(given))
    last_tick = _last_tick(scenario, given.until)
    if not given.in_process:
        free_port(scenario.wire.port)  # a taken port is to be told before there is a folder
    folder = new_folder(path.stem, given.out)
    (folder / "scenario.toml").write_text(to_toml(scenario), "utf-8")
    console = console_for(given.json)
    console.print(
        f"run {folder.name}: {len(scenario.node_ids)} nodes, {last_tick * scenario.tick_s:.0f} s, "
        f"seed {scenario.seed}",
        highlight=False,
    )
    began = time.monotonic()
    with ProgressLine(console, scenario, last_tick) as progress:
        if given.in_process:
            processes, interrupted = _rehearse(scenario, folder, last_tick, progress), False
        else:
            processes, interrupted = _launch(scenario, folder, last_tick, progress, given.dashboard, console)
    summary = summarise(folder, scenario, path.stem, time.monotonic() - began, processes)
    if given.dashboard != "off":
        from deploy.dashboard import record  # rerun takes most of a second to import

        record(folder)
    if given.json:
        print(json.dumps(summary, indent=2))
    else:
        print_result(console, summary, str(folder), deaths(folder))
    return INTERRUPTED if interrupted else 0


def _settings(given: argparse.Namespace) -> list[str]:
    options = {"seed": given.seed, "clock.kind": given.clock, "clock.rate": given.rate}
    return given.settings + [f"{name}={value}" for name, value in options.items() if value is not None]


def _overrides(given: argparse.Namespace) -> dict[str, Any]:
    """The fault plan of `--faults-from`: all that befell that run, planned or not, and nothing else."""
    if given.faults_from is None:
        return {}
    folder = find_folder(given.faults_from)
    tick_s = load_scenario(folder / "scenario.toml").tick_s
    faults = [fault for commit in commits(folder / "journal") for fault in commit.facts.faults]
    plan = [
        {
            "at_s": one.tick * tick_s,
            "verb": one.verb,
            "nodes": [one.node],
            "memory": one.memory,
            "place": one.place,
            "every": one.every,
        }
        for one in faults
    ]
    return {"faults": plan}


def _last_tick(scenario: Scenario, until_s: float | None) -> int:
    if until_s is None:
        return scenario.last_tick
    if not 0 < until_s <= scenario.duration_s:
        raise ScenarioError(f"--until must be > 0 and <= duration_s ({scenario.duration_s}), got {until_s}")
    return scenario.tick_of(until_s)


def _rehearse(scenario: Scenario, folder: Path, last_tick: int, progress: ProgressLine) -> list[dict]:
    stop = on_interrupt_now()

    def watch(commit: Commit, swarm: Rehearsal) -> None:
        progress.show(commit.facts)
        swarm.finishing = stop()

    rehearse(scenario, to_toml(scenario), folder, last_tick, watch)
    roles = {node: "tower" if node == scenario.tower.id else "robot" for node in scenario.node_ids}
    return [roll_entry(node, role, os.getpid(), 0, 0) for node, role in roles.items()]


def _launch(
    scenario: Scenario, folder: Path, last_tick: int, progress: ProgressLine, dashboard: str, console: Any
) -> tuple[list[dict], bool]:
    launcher = Launcher(scenario, folder, last_tick, progress.show)
    mode = None if dashboard in ("off", "file") else choose_mode(dashboard)
    asyncio.run(
        launcher.run(mode, lambda line: console.print(f"dashboard {line}", highlight=False, soft_wrap=True))
    )
    return launcher.roll(), launcher.interrupted
