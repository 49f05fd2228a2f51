"""Runs of the pursuit study that never ran, with what came of them as a test wants it."""

from collections.abc import Mapping
from typing import Any

from deploy.studies.pursuit.plan import Extent, Study, Trial, study
from deploy.studies.pursuit.runs import Between, Run, Runs

EXTENT = Extent(2, 6, 8, 2, 3600.0, 3, (6, 7), 1800.0)
"""Two places; 6 to 8 robots on the cave, and 6 and 7 on three random plans, the third with an island."""
CLEARED: dict[str, Any] = {"cleared": True, "claim": "done", "contaminated_area_m2": 0.0}
LEFT: dict[str, Any] = {
    "cleared": False, "claim": "failed", "clear_time_s": None, "contaminated_area_m2": 50.0
}  # fmt: skip


def run(trial: Trial, deaths: tuple[str, ...] = (), raster_end_m2: float | None = None, **found: Any) -> Run:
    """One run that clears after 100 s for each robot, unless `found` says otherwise."""
    metrics = {
        **CLEARED,
        "clear_time_s": 100.0 * trial.robots,
        "recontaminated_m2": {"kill": 0.0, "release": 1.0, "retreat": 0.5, "breach": 0.0},
        "breaches": 0,
        "robots_deployed": trial.robots,
        "robots_on_lines_peak": trial.robots - 1,
        "splits": 2,
        "searches": 1,
        "searches_failed": 0,
        "dissolved": 3,
        "graph": {"vertices": trial.robots, "edges": 5, "cycle_edges": 0},
    } | found
    summary = {"metrics": metrics, "sim_s": 1000.0, "wall_s": 36.0, "run_hash": trial.name, "commit": "abc"}
    end_m2 = 0.0 if metrics["cleared"] else 50.0
    return Run(trial, summary, Between(0.2, -0.01, 0.1, raster_end_m2 or end_m2), deaths)


def runs(outcomes: Mapping[tuple[str, int, int], dict[str, Any]], plan: Study | None = None) -> Runs:
    """All runs, and the larger teams too; `outcomes` by plan, place and robots, the others clear."""
    plan = plan or study(EXTENT)

    def made_up(trials: list[Trial]) -> list[Run]:
        return [run(one, **outcomes.get((one.ground.name, one.place, one.robots), {})) for one in trials]

    found = made_up(plan.every_team())
    return Runs([*found, *made_up(plan.larger_teams(Runs(found).fewest()))])
