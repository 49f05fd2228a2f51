"""One trial of a sweep in a process of its own: `python -m deploy.trial FOLDER --parent-pid P`.

The folder holds `scenario.toml`; all else is written beside it. With `--processes` the trial is a run of real
processes, else a rehearsal; the run's hash is the same. With `--lean` a rehearsal leaves no journal: it is
large, and the same scenario gives it again.
"""

import argparse
import asyncio
import os
import sys
import time
from pathlib import Path
from typing import Any

from deploy.launcher import Launcher, LaunchError
from deploy.recorder import Fold, summarise
from deploy.rehearsal import rehearse
from deploy.run_folder import RunError
from deploy.scenario_file import load_scenario
from wire.credentials import die_with_parent
from wire.scenario import Scenario

INTERRUPTED = 130


def main() -> None:
    """Carry out the trial in a folder."""
    parser = argparse.ArgumentParser(description="A trial of a sweep; started by the sweep.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--processes", action="store_true")
    parser.add_argument("--lean", action="store_true")
    parser.add_argument("--parent-pid", type=int, required=True)
    given = parser.parse_args()
    die_with_parent(given.parent_pid)
    sys.path.insert(0, os.getcwd())  # behaviours of third parties, here as in the node processes
    folder: Path = given.folder
    scenario, began = load_scenario(folder / "scenario.toml"), time.monotonic()
    if given.processes:
        processes = _launch(scenario, folder)
        summarise(folder, scenario, folder.name, time.monotonic() - began, processes)
    else:
        fold, journalled = Fold(scenario), not given.lean or _keeps_memory(scenario)
        toml = (folder / "scenario.toml").read_text("utf-8")
        end = rehearse(scenario, toml, folder, scenario.last_tick, lambda one, _: fold.take(one), journalled)
        fold.write(folder, end, folder.name, time.monotonic() - began, [])
    sys.stdout.flush()
    os._exit(0)  # Zenoh's threads may outlive a closed session


def _keeps_memory(scenario: Scenario) -> bool:
    """Must a mind that restarts live through what the journal says?"""
    return any(fault.verb == "restart" and fault.memory == "kept" for fault in scenario.faults)


def _launch(scenario: Scenario, folder: Path) -> list[dict[str, Any]]:
    """Run as processes to the end; a run that was cut short leaves no summary."""
    try:
        launcher = Launcher(scenario, folder, scenario.last_tick, lambda facts: None)
        asyncio.run(launcher.run(None, print))
    except (LaunchError, RunError) as error:
        sys.exit(str(error))
    if launcher.interrupted:
        sys.exit(INTERRUPTED)
    return launcher.roll()


if __name__ == "__main__":
    main()
