"""Outcomes of trials that never ran, with the numbers that a test wants."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from deploy.studies.lr_pt import plan
from deploy.studies.outcomes import METRICS, Outcome, Outcomes
from deploy.studies.trial import Scale, Trial

SITES, SCALE = 400, Scale(3000, 1000, 6000, 1)
Values = tuple[float, float, float, float]


@cache
def every_trial(count: int = 1) -> tuple[Trial, ...]:
    return tuple(plan.trials(SCALE, count))


def metrics(values: Values) -> dict[str, Any]:
    """I_G, I_W, D_MSA, D_WSA, normalised and, as if it were the same, raw."""
    raw = dict(zip(METRICS, values, strict=True))
    return (
        raw
        | {f"normalised_{name}": value for name, value in raw.items()}
        | dict(word_mean_s=1.0, word_worst_s=2.0, visits=9)
    )


def tables(
    robots: int, apart: bool = True, level: Mapping[str, float] | None = None
) -> dict[str, np.ndarray]:
    """Each robot has cells of its own, or all have all. Curves: normalised seconds by phase, constant."""
    visits = np.zeros((3, robots, SITES), dtype=np.uint32)
    for robot in range(robots):
        visits[:, robot, slice(robot, None, robots) if apart else slice(None)] = 20
    time_s = np.arange(0, 6000, 60.0)
    phase = (time_s >= 2000).astype(int) + (time_s >= 4000)
    active = np.array([robots, robots - 1, robots])[phase]
    values = np.array([(level or {}).get(one, 10.0) for one in ("before", "during", "after")])[phase]
    seconds = values * SITES / active
    columns = (time_s, seconds, seconds, seconds, seconds, active)
    untold = np.full(SITES, -1)
    return {"visits": visits, "curves": np.stack(columns, axis=1), "untold_tick": untold}


def outcome(trial: Trial, values: Values, **fields: Any) -> Outcome:
    """One trial with these four metrics; `fields` as those of Outcome."""
    killed = [{"node": "r9", "role": "robot", "pid": 7, "incarnation": 0, "exit": -9}]
    summary = {
        "metrics": metrics(values),
        "processes": killed if trial.as_processes else [],
        "run_hash": f"{trial.algorithm.name}{trial.nodes}{trial.seed}",
        "commit": "abc",
        "wall_s": 1.0,
        "ticks": 3000,
    }
    told = {"tables": tables(trial.nodes - 1)} | fields
    return Outcome(trial, trial.scenario(), summary, **told)


def outcomes(
    values: Mapping[tuple[str, str, int], Values],
    count: int = 1,
    default: Values = (10, 60, 15, 80),
    **fields: Any,
) -> Outcomes:
    """All trials of the study; `values` by kind, algorithm and size, `default` for the others."""
    return Outcomes(
        outcome(one, values.get((one.kind, one.algorithm.name, one.nodes), default), **fields)
        for one in every_trial(count)
    )
