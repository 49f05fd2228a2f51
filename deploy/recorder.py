"""The recorder: folds a run's journal into `summary.json`. The journal is complete, so the summary is too.

What takes more than numbers to say (visits by robot and site, curves over time) goes to `area.npz` beside it.
To the metrics of its mission it adds `grants`, how often robots were asked, and `robot_ticks`, how often they
would have been if every robot were asked at every tick.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from deploy.metrics import MISSIONS
from deploy.process import commit
from wire.messages import Facts
from wire.scenario import Scenario
from world_server.journal import read
from world_server.records import Commit, End

RADIO = ("sent", "delivered", "out_of_range", "lost", "oversize", "bytes")


class Fold:
    """What a run amounts to, commit by commit."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._metrics = MISSIONS[scenario.mission](scenario)
        self._radio, self._ticks, self._grants = [0] * len(RADIO), -1, 0
        self._faults: list[dict[str, Any]] = []

    def take(self, commit: Commit) -> None:
        """Take in the next commit."""
        self._metrics.feed(commit.facts)
        self._ticks = commit.tick
        self._faults += _happened(commit.facts)
        self._grants += sum(grant.node != self._scenario.tower.id for grant in commit.grants)
        self._radio = [total + one for total, one in zip(self._radio, commit.facts.radio, strict=True)]

    def write(
        self, folder: Path, end: End | None, name: str, wall_s: float, processes: list[dict]
    ) -> dict[str, Any]:
        """Write all that is folded to `folder`, `summary.json` last: where it is, all is. Returns it."""
        scenario, ticks = self._scenario, self._ticks
        asked = {"grants": self._grants, "robot_ticks": (ticks + 1) * len(scenario.robot_ids)}
        faults = self._faults + [_refused(event) for event in events(folder) if _is_refused(event)]
        summary = {
            "run": folder.name,
            "scenario": name,
            "mission": scenario.mission,
            "seed": scenario.seed,
            "commit": commit(),
            "ticks": max(ticks, 0),
            "sim_s": max(ticks, 0) * scenario.tick_s,
            "wall_s": round(wall_s, 3),
            "completed": end is not None and end.completed,
            "run_hash": "" if end is None else end.run_hash,
            "processes": processes,
            "faults": sorted(faults, key=lambda fault: fault["tick"]),
            "radio": dict(zip(RADIO, self._radio, strict=True)),
            "metrics": self._metrics.summary() | asked,
        }
        if tables := self._metrics.tables():
            np.savez_compressed(folder / f"{scenario.mission}.npz", **tables)
        _write_whole(folder / "summary.json", json.dumps(summary, indent=2) + "\n")
        return summary


def summarise(
    folder: Path, scenario: Scenario, name: str, wall_s: float, processes: list[dict]
) -> dict[str, Any]:
    """Fold the journal and the event log of a run, write `summary.json`, and return it."""
    fold, end = Fold(scenario), None
    for record in read(folder / "journal"):
        if isinstance(record, Commit):
            fold.take(record)
        elif isinstance(record, End):
            end = record
    return fold.write(folder, end, name, wall_s, processes)


def _write_whole(path: Path, text: str) -> None:
    """All of it or nothing, whenever this process is killed: who finds a summary finds a finished run."""
    part = path.with_suffix(".part")
    part.write_text(text, "utf-8")
    part.replace(path)


def events(folder: Path) -> list[dict[str, Any]]:
    """All events of a run that were written whole."""
    lines = (folder / "events.jsonl").read_text("utf-8").splitlines(keepends=True)
    return [json.loads(line) for line in lines if line.endswith("\n")]


def deaths(folder: Path) -> list[dict[str, Any]]:
    """The events of nodes that died by themselves or by a hand from outside."""
    return [event for event in events(folder) if event["kind"] == "death"]


def _happened(facts: Facts) -> list[dict[str, Any]]:
    """Faults that are part of the run, each of which was seen to have happened."""
    return [{"tick": one.tick, "verb": one.verb, "node": one.node, "confirmed": True} for one in facts.faults]


def _is_refused(event: dict[str, Any]) -> bool:
    return event["kind"] == "fault" and not event["data"]["confirmed"]


def _refused(event: dict[str, Any]) -> dict[str, Any]:
    return {"tick": event["tick"], "verb": event["data"]["verb"], "node": event["node"], "confirmed": False}
