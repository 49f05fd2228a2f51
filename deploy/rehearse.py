"""One rehearsal in a process of its own: `python -m deploy.rehearse FOLDER --parent-pid P`.

The folder holds `scenario.toml`; the journal, the events and the summary are written beside it.
"""

import argparse
import time
from pathlib import Path

from deploy.recorder import summarise
from deploy.rehearsal import rehearse
from deploy.scenario_file import load_scenario
from wire.credentials import die_with_parent


def main() -> None:
    """Rehearse the scenario in a folder."""
    parser = argparse.ArgumentParser(description="A rehearsal of a sweep; started by the sweep.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--parent-pid", type=int, required=True)
    given = parser.parse_args()
    die_with_parent(given.parent_pid)
    path = given.folder / "scenario.toml"
    scenario, began = load_scenario(path), time.monotonic()
    rehearse(scenario, path.read_text("utf-8"), given.folder, scenario.last_tick)
    summarise(given.folder, scenario, given.folder.name, time.monotonic() - began, [])


if __name__ == "__main__":
    main()
