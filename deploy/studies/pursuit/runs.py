"""What came of the runs: looked up by ground, place and team, and saved as one table."""

import statistics
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from deploy.metrics.clear import CAUSES, NOTHING_M2, Instant
from deploy.recorder import deaths
from deploy.studies.pursuit.plan import Ground, Trial, places, polygon
from world_server.clear import CLAIMED_S

COUNTS = ("splits", "searches", "searches_failed", "dissolved", "robots_on_lines_peak", "breaches")


class Between(NamedTuple):
    """How far the raster referee's area lies above the exact one's, in square metres, over a run.

    `end_m2` is the raster's own area at the end.
    """

    most_m2: float
    least_m2: float
    mean_m2: float
    end_m2: float


class Run(NamedTuple):
    """One finished run. `deaths`: the last words of robots that died by themselves, which none should."""

    trial: Trial
    summary: dict[str, Any]
    between: Between
    deaths: tuple[str, ...] = ()

    @property
    def metrics(self) -> dict[str, Any]:
        """Those of `summary.json`."""
        return self.summary["metrics"]

    @property
    def clears(self) -> bool:
        """Is nothing left, and does the team know it?"""
        return self.metrics["cleared"] and self.metrics["claim"] == "done" and not self.is_false

    @property
    def is_false(self) -> bool:
        """Did the team say DONE while an intruder could still be there?

        The run goes on for a while behind the claim; where its time was up before, only its end counts.
        """
        found = self.metrics
        if found["claim"] != "done" or not found["cleared"]:
            return found["claim"] == "done"
        claimed_s = self.summary["sim_s"] - CLAIMED_S
        ran_out = self.summary["sim_s"] >= self.trial.ground.duration_s
        return not ran_out and found["clear_time_s"] > claimed_s

    @property
    def disagree(self) -> bool:
        """Do the referees differ on whether all is clear in the end?"""
        return self.metrics["cleared"] != (self.between.end_m2 < NOTHING_M2)

    def row(self) -> dict[str, Any]:
        """The run as a row of `runs.parquet`."""
        trial, found, drawn = self.trial, self.metrics, self.trial.ground.random
        x_m, y_m = places(trial.ground)[trial.place - 1]
        lost = {f"recontaminated_{cause}_m2": found["recontaminated_m2"][cause] for cause in CAUSES}
        return {
            "name": trial.name,
            "ground": trial.ground.name,
            "plan_seed": None if drawn is None else drawn.seed,
            "islands": len(polygon(trial.ground).interiors),
            "area_m2": polygon(trial.ground).area,
            "place": trial.place,
            "x_m": x_m,
            "y_m": y_m,
            "robots": trial.robots,
            "seed": trial.seed,
            "clears": self.clears,
            "false_claim": self.is_false,
            **{name: found[name] for name in ("cleared", "claim", "clear_time_s", "contaminated_area_m2")},
            **lost,
            **{name: found[name] for name in COUNTS},
            **{f"graph_{name}": value for name, value in found["graph"].items()},
            **{f"raster_{name}": value for name, value in self.between._asdict().items()},
            **{name: self.summary[name] for name in ("sim_s", "wall_s", "run_hash")},
            "commit": self.summary.get("commit"),
            "unplanned_deaths": len(self.deaths),
        }


class Runs:
    """All finished runs of a study."""

    def __init__(self, everything: Iterable[Run]) -> None:
        self.all = list(everything)
        self._by_place: dict[tuple[str, int], dict[int, list[Run]]] = defaultdict(lambda: defaultdict(list))
        for run in self.all:
            self._by_place[run.trial.ground.name, run.trial.place][run.trial.robots].append(run)

    @property
    def grounds(self) -> list[Ground]:
        """The plans, in order."""
        return list(dict.fromkeys(run.trial.ground for run in self.all))

    def teams(self, ground: Ground, place: int) -> dict[int, list[Run]]:
        """The runs from a place, by the number of robots, which rises."""
        return dict(sorted(self._by_place[ground.name, place].items()))

    def fewest(self) -> dict[tuple[str, int], int]:
        """The smallest team with which every run from a place clears; none where there is none."""
        found = {}
        for place, teams in self._by_place.items():
            enough = [robots for robots, runs in teams.items() if all(run.clears for run in runs)]
            if enough:
                found[place] = min(enough)
        return found

    def fewest_of(self, ground: Ground) -> list[int | None]:
        """As `fewest`, place after place."""
        found = self.fewest()
        return [found.get((ground.name, place)) for place in range(1, ground.places + 1)]

    def of(self, grounds: Iterable[Ground], robots: int) -> list[Run]:
        """All runs with so many robots on these plans."""
        names = {ground.name for ground in grounds}
        return [run for run in self.all if run.trial.ground.name in names and run.trial.robots == robots]

    def best(self, ground: Ground) -> list[Run]:
        """From each place the fastest run of the smallest team that clears."""
        found = []
        for place, robots in enumerate(self.fewest_of(ground), start=1):
            if robots is not None:
                runs = self.teams(ground, place)[robots]
                found.append(min(runs, key=lambda run: run.metrics["clear_time_s"]))
        return found


def collect(trials: Iterable[Trial], summaries: Mapping[str, dict[str, Any]], folder: Path) -> Runs:
    """Read what the runs left behind."""
    return Runs(
        Run(
            one,
            summaries[one.name],
            between(curve(folder, one)),
            tuple(map(_last_words, deaths(folder / one.name))),
        )
        for one in trials
    )


def _last_words(death: dict[str, Any]) -> str:
    lines = death["data"].get("last_lines", "").strip().splitlines()
    return f"{death['text']} at {death['sim_s']:.0f} s: {lines[-1] if lines else 'no last words'}"


def curve(folder: Path, trial: Trial) -> np.ndarray:
    """The state after each tick in which anything happened: (ticks, fields of Instant)."""
    with np.load(folder / trial.name / "clear.npz") as tables:
        return tables["curve"]


def between(samples: np.ndarray) -> Between:
    """How far the referees differ over a run."""
    exact_m2, raster_m2 = (
        samples[:, Instant._fields.index(name)] for name in ("contaminated_m2", "raster_m2")
    )
    above_m2 = raster_m2 - exact_m2
    return Between(
        *(float(each) for each in (above_m2.max(), above_m2.min(), above_m2.mean(), raster_m2[-1]))
    )


def median(values: Iterable[float]) -> float | None:
    """None of nothing."""
    return statistics.median(found) if (found := list(values)) else None


def save(runs: Runs, path: Path) -> None:
    """Write one row for each run as Parquet."""
    import pyarrow  # a quarter of a second to import, and only needed here
    from pyarrow import parquet

    parquet.write_table(pyarrow.Table.from_pylist([run.row() for run in runs.all]), path)
