"""Many trials, as many at a time as there are processors. What is there already is not run again."""

import asyncio
import json
import os
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

from deploy.process import Child, on_interrupt
from deploy.scenario_file import ScenarioError, load_scenario, to_toml
from wire.scenario import Scenario

LEFT_BY_A_RUN = ("summary.json", "*.npz", "journal", "events.jsonl", "ledger.sqlite*", "logs/*.log")


class SweepError(Exception):
    """A trial that failed; the text says which, with its last lines. `status`: as of its process."""

    def __init__(self, text: str, status: int) -> None:
        super().__init__(text)
        self.status = status


def sweep(
    jobs: Mapping[str, Scenario],
    parent: Path,
    show: Callable[[int, int], None],
    as_processes: Collection[str] = (),
    lean: bool = False,
    ended: Callable[[str, bool], None] = lambda name, was_there: None,
    failed: dict[str, SweepError] | None = None,
) -> dict[str, dict[str, Any]]:
    """Carry out every job in a folder of its own below `parent`; returns the summaries by name.

    Jobs are rehearsals but those named in `as_processes`, which are runs of real processes, one at a time.
    `lean`: rehearsals leave no journal. `show` is told how many of how many are done, `ended` the name of
    each job that is done, and whether it was there already. A folder whose scenario is the same and that has
    a summary is taken as it is. Raises SweepError, and KeyboardInterrupt on Ctrl-C. Given `failed`, a trial
    that ends by itself with an error is put there, has no summary, and the others go on.
    """
    return asyncio.run(_Sweep(jobs, parent, show, as_processes, lean, ended, failed).run())


class _Sweep:
    """One sweep: what still waits, and whether a run of processes is under way."""

    def __init__(
        self,
        jobs: Mapping[str, Scenario],
        parent: Path,
        show: Callable[[int, int], None],
        as_processes: Collection[str],
        lean: bool,
        ended: Callable[[str, bool], None],
        failed: dict[str, SweepError] | None,
    ) -> None:
        self._jobs, self._parent, self._as_processes, self._lean = jobs, parent, set(as_processes), lean
        self._show, self._ended, self._failed = show, ended, failed
        self._done = 0
        self._waiting: list[str] = []
        self._processes_run = False

    async def run(self) -> dict[str, dict[str, Any]]:
        """Everything that is not there, with a worker for each processor."""
        for name, scenario in self._jobs.items():
            if _is_done(self._parent / name, scenario, name in self._as_processes):
                self._end(name, was_there=True)
            else:
                self._waiting.append(name)
        self._show(self._done, len(self._jobs))
        workers = [asyncio.ensure_future(self._work()) for _ in range(len(os.sched_getaffinity(0)))]
        everything = asyncio.gather(*workers)
        on_interrupt(lambda: _cancel(everything))
        try:
            await everything
        except asyncio.CancelledError:
            raise KeyboardInterrupt from None
        finally:
            for worker in workers:
                worker.cancel()
            await asyncio.gather(*workers, return_exceptions=True)
        return {
            name: _summary(self._parent / name) for name in self._jobs if name not in (self._failed or {})
        }

    async def _work(self) -> None:
        while name := self._next():
            processes = name in self._as_processes
            if processes:
                self._processes_run = True
            try:
                await self._carry_out(self._parent / name, self._jobs[name], processes)
            except SweepError as error:
                if self._failed is None or error.status < 0:  # killed: the scenario is not to blame
                    raise
                self._failed[name] = error
            if processes:
                self._processes_run = False
            self._end(name, was_there=False)
            self._show(self._done, len(self._jobs))

    def _next(self) -> str | None:
        """The first that waits and may begin: two runs of processes would fight for the processors."""
        for place, name in enumerate(self._waiting):
            if not (self._processes_run and name in self._as_processes):
                return self._waiting.pop(place)
        return None

    def _end(self, name: str, was_there: bool) -> None:
        self._done += 1
        self._ended(name, was_there)

    async def _carry_out(self, folder: Path, scenario: Scenario, processes: bool) -> None:
        (folder / "logs").mkdir(parents=True, exist_ok=True)
        for pattern in LEFT_BY_A_RUN:
            for left in folder.glob(pattern):
                left.unlink()
        (folder / "scenario.toml").write_text(to_toml(scenario), "utf-8")
        options = ["--processes"] * processes + ["--lean"] * self._lean
        child = Child(folder.name, "deploy.trial", [str(folder), *options], folder / "logs" / "trial.log")
        child.watch(lambda ended: None)
        try:
            await child.ended.wait()
        finally:
            await child.end()
        if child.status != 0:
            kind = "run" if processes else "rehearsal"
            text = f"{folder}: the {kind} ended with {child.status}:\n{child.last_lines()}"
            raise SweepError(text, child.status)


def _cancel(everything: asyncio.Future) -> None:
    everything.cancel()


def _is_done(folder: Path, scenario: Scenario, as_processes: bool) -> bool:
    """Is this very scenario there with all that came of it? Compared as read: files may spell it otherwise.

    A run of processes will do for a rehearsal, but not the other way round.
    """
    try:
        same = load_scenario(folder / "scenario.toml") == scenario
        summary = _summary(folder)
    except (ScenarioError, OSError, ValueError):
        return False
    folded = scenario.mission != "area" or (folder / "area.npz").is_file()
    return same and folded and (bool(summary["processes"]) or not as_processes)


def _summary(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "summary.json").read_text("utf-8"))
