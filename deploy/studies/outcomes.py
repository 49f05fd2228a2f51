"""What came of the trials: looked up by kind, algorithm and size, and saved as one table."""

import json
import statistics
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from deploy.recorder import deaths
from deploy.studies.trial import Algorithm, Trial
from wire.scenario import Scenario

METRICS = {
    "graph_idleness_s": "graph idleness",
    "worst_idleness_s": "worst idleness",
    "mean_sa_delay_s": "mean SA delay",
    "worst_sa_delay_s": "worst SA delay",
}
"""Name and words of the paper's four metrics: I_G, I_W, D_MSA, D_WSA."""


class Outcome(NamedTuple):
    """One finished trial. `tables`: its `area.npz`. `deaths`: of nodes that nobody killed by plan."""

    trial: Trial
    scenario: Scenario
    summary: dict[str, Any]
    tables: Mapping[str, np.ndarray]
    deaths: tuple[dict[str, Any], ...] = ()

    @property
    def how(self) -> str:
        """Was it rehearsed, or a run of processes?"""
        return "processes" if self.summary["processes"] else "rehearsed"

    @property
    def share(self) -> float:
        """(N - 1) / K: what seconds are multiplied by to be normalised."""
        return len(self.scenario.robot_ids) / len(self.scenario.field.sites_m())

    def row(self) -> dict[str, Any]:
        """The trial as a row of `trials.parquet`: what it was, every metric, how it ran."""
        return {
            "name": self.trial.name,
            "kind": self.trial.kind,
            "algorithm": self.trial.algorithm.name,
            "parameters": json.dumps(self.scenario.robots.parameters),
            "nodes": self.trial.nodes,
            "seed": self.trial.seed,
            **self.summary["metrics"],
            "run_hash": self.summary["run_hash"],
            "commit": self.summary.get("commit"),
            "wall_s": self.summary["wall_s"],
            "how": self.how,
            "unplanned_deaths": len(self.deaths),
        }


class Outcomes:
    """All finished trials of a study."""

    def __init__(self, everything: Iterable[Outcome]) -> None:
        self.all = list(everything)

    def of(self, kind: str, algorithm: str = "lr_pt", nodes: int | None = None) -> list[Outcome]:
        """The trials of one kind and algorithm, of one size or of all, in order of seeds within a size."""
        return [
            one
            for one in self.all
            if (one.trial.kind, one.trial.algorithm.name) == (kind, algorithm)
            and nodes in (None, one.trial.nodes)
        ]

    def values(self, metric: str, nodes: int, algorithm: str = "lr_pt", kind: str = "main") -> list[float]:
        """A metric of every trial in which it was measured."""
        found = [one.summary["metrics"][metric] for one in self.of(kind, algorithm, nodes)]
        return [value for value in found if value is not None]

    def median(self, metric: str, nodes: int, algorithm: str = "lr_pt", kind: str = "main") -> float | None:
        """The median over trials; None where there is none."""
        values = self.values(metric, nodes, algorithm, kind)
        return statistics.median(values) if values else None

    def algorithms(self) -> list[Algorithm]:
        """The algorithms that have been compared, in the order of the comparison."""
        return list({one.trial.algorithm.name: one.trial.algorithm for one in self.all}.values())

    def sizes(self) -> list[int]:
        """The team sizes that there are."""
        return sorted({one.trial.nodes for one in self.all})


def collect(trials: Iterable[Trial], summaries: Mapping[str, dict[str, Any]], folder: Path) -> Outcomes:
    """Read what the trials left behind."""
    return Outcomes(
        Outcome(
            trial,
            trial.scenario(),
            summaries[trial.name],
            dict(np.load(folder / trial.name / "area.npz")),
            tuple(deaths(folder / trial.name)),
        )
        for trial in trials
    )


def save(outcomes: Outcomes, path: Path) -> None:
    """Write one row for each trial as Parquet."""
    import pyarrow  # a quarter of a second to import, and only needed here
    from pyarrow import parquet

    parquet.write_table(pyarrow.Table.from_pylist([one.row() for one in outcomes.all]), path)
