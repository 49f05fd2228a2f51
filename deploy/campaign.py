"""Many trials on the way to a report: a sweep with its progress told, and how long it will take."""

import sys
import time
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from deploy.run_folder import RunError
from deploy.sweep import sweep
from wire.scenario import Scenario

INTERRUPTED = 130
PROCESSES_COST = 5.0
"""How much longer a run of processes takes than its rehearsal, measured on two processors."""


def make_folder(out: Path | None, study: str) -> Path:
    """The folder of a study. Raises RunError."""
    folder = (out or Path("reproductions")) / study
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"--out {out}: cannot make a folder there: {error.strerror}") from None
    return folder


class Campaign:
    """Trials weighted by what they cost: ticks x nodes, and more for real processes."""

    def __init__(
        self,
        jobs: Mapping[str, Scenario],
        folder: Path,
        as_processes: Collection[str] = (),
        lean: bool = True,
    ) -> None:
        self._jobs, self._folder, self._as_processes, self._lean = jobs, folder, as_processes, lean
        self._cost = {
            name: one.last_tick * len(one.node_ids) * (PROCESSES_COST if name in as_processes else 1.0)
            for name, one in jobs.items()
        }
        self._total = sum(self._cost.values())
        self._there = self._spent = 0.0
        self._ended = 0
        self._began = time.monotonic()

    def run(self) -> dict[str, dict[str, Any]] | None:
        """The summaries of all trials by name; None after Ctrl-C. Raises SweepError."""
        console = Console(stderr=True)
        columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[words]}"))
        with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
            task = bar.add_task(self._folder.name, total=self._total, words="")

            def ended(name: str, was_there: bool) -> None:
                words = self._note(name, was_there)
                bar.update(task, completed=self._there + self._spent, words=words)
                if not console.is_terminal and not was_there:
                    console.print(f"{words}: {name}", highlight=False, soft_wrap=True)

            def show(done: int, total: int) -> None:
                if done < total and not console.is_terminal and not self._spent:
                    console.print(f"{done} of {total} trials are there already", highlight=False)

            try:
                return sweep(self._jobs, self._folder, show, self._as_processes, self._lean, ended)
            except KeyboardInterrupt:
                line = f"interrupted; the same command goes on with what is missing in {self._folder}"
                print(line, file=sys.stderr)
                return None

    def _note(self, name: str, was_there: bool) -> str:
        """Take note of the end of a trial; returns how the campaign stands, in words."""
        self._ended += 1
        stands = f"{self._ended} of {len(self._jobs)} trials"
        if was_there:
            self._there += self._cost[name]
            self._began = time.monotonic()
            return stands
        self._spent += self._cost[name]
        left_s = (self._total - self._there - self._spent) * (time.monotonic() - self._began) / self._spent
        return f"{stands}, {_words(left_s)} left"


def _words(time_s: float) -> str:
    if time_s < 90:
        return f"{time_s:.0f} s"
    if time_s < 90 * 60:
        return f"{time_s / 60:.0f} min"
    return f"{time_s / 3600:.1f} h"
