"""Many rehearsals, as many at a time as there are processors. What is there already is not run again."""

import asyncio
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from deploy.process import Child, on_interrupt
from deploy.scenario_file import to_toml
from wire.scenario import Scenario


class SweepError(Exception):
    """A rehearsal that failed; the text says which, with its last lines. `status`: as of its process."""

    def __init__(self, text: str, status: int) -> None:
        super().__init__(text)
        self.status = status


def sweep(
    jobs: Mapping[str, Scenario],
    parent: Path,
    show: Callable[[int, int], None],
    failed: dict[str, SweepError] | None = None,
) -> dict[str, dict[str, Any]]:
    """Rehearse every job in a folder of its own below `parent`; returns the summaries by name.

    `show` is told how many of how many are done. A folder whose scenario is the same and that has a summary
    is taken as it is. Raises SweepError, and KeyboardInterrupt on Ctrl-C. Given `failed`, a rehearsal that
    ends by itself with an error is put there, has no summary, and the others go on.
    """
    return asyncio.run(_sweep(jobs, parent, show, failed))


async def _sweep(
    jobs: Mapping[str, Scenario],
    parent: Path,
    show: Callable[[int, int], None],
    failed: dict[str, SweepError] | None,
) -> dict[str, dict[str, Any]]:
    waiting = {name: scenario for name, scenario in jobs.items() if not _is_done(parent / name, scenario)}
    names, done = iter(waiting), len(jobs) - len(waiting)
    show(done, len(jobs))

    async def work() -> None:
        nonlocal done
        for name in names:
            try:
                await _rehearse(parent / name, waiting[name])
            except SweepError as error:
                if failed is None or error.status < 0:  # killed: nothing that the scenario is to blame for
                    raise
                failed[name] = error
            done += 1
            show(done, len(jobs))

    workers = [asyncio.ensure_future(work()) for _ in range(len(os.sched_getaffinity(0)))]
    everything, interrupted = asyncio.gather(*workers), []

    def stop() -> None:
        interrupted.append(True)
        everything.cancel()

    on_interrupt(stop)
    try:
        await everything
    except asyncio.CancelledError:
        raise KeyboardInterrupt from None
    finally:
        for worker in workers:
            worker.cancel()
        await asyncio.gather(*workers, return_exceptions=True)
    return {name: _summary(parent / name) for name in jobs if name not in (failed or {})}


async def _rehearse(folder: Path, scenario: Scenario) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "summary.json").unlink(missing_ok=True)
    for left in folder.glob("ledger.sqlite*"):
        left.unlink()
    (folder / "scenario.toml").write_text(to_toml(scenario), "utf-8")
    child = Child(folder.name, "deploy.rehearse", [str(folder)], folder / "rehearsal.log")
    child.watch(lambda ended: None)
    try:
        await child.ended.wait()
    finally:
        await child.end()
    if child.status != 0:
        text = f"{folder}: the rehearsal ended with {child.status}:\n{child.last_lines()}"
        raise SweepError(text, child.status)


def _is_done(folder: Path, scenario: Scenario) -> bool:
    toml = folder / "scenario.toml"
    same = toml.is_file() and toml.read_text("utf-8") == to_toml(scenario)
    return same and (folder / "summary.json").is_file()


def _summary(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "summary.json").read_text("utf-8"))
