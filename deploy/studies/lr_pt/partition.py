"""Do robots share the field out among themselves? Numbers for what the paper shows as heat maps.

Source: Kobayashi et al. 2025, section V-D: maps of visits differ from robot to robot, reporters near the base
station and explorers far away, and their sum over robots has no bias. The numbers are ours:

    overlap    of two robots: sum over cells of the smaller of their shares of visits. 1: alike, 0: apart
    variation  of the sum over robots: standard deviation over cells / mean over cells. 0: uniform
    reach      of a robot: mean distance of its visits from the tower

Few visits differ by chance alone. So each has its chance beside it: overlap and reach if every visit of the
team had been made by a robot drawn at random, variation if the cells of visits had been.
"""

import math
from itertools import combinations
from typing import NamedTuple

import numpy as np

from deploy.studies.outcomes import Outcome

DRAWS = 20
APART = 0.90
"""Maps differ where they overlap less than this part of what chance gives."""
VARIATION = 0.25
"""About uniform: a coefficient of variation of at most this."""


class Partition(NamedTuple):
    """The numbers of one trial: measured, and by chance. Reach: lowest and highest of the team, in metres."""

    overlap: float
    overlap_by_chance: float
    variation: float
    variation_by_chance: float
    reach_m: tuple[float, float]
    reach_by_chance_m: tuple[float, float]


def partition(visits: np.ndarray, away_m: np.ndarray) -> Partition | None:
    """`visits`: (robots, cells). `away_m`: (cells,), distance from the tower. None without enough visits."""
    team = visits.sum(axis=0)
    if len(visits) < 2 or not visits.sum(axis=1).all():
        return None
    chance = np.random.Generator(np.random.Philox(1))  # the same for everybody: numbers must not vary
    shares = visits.sum(axis=1) / team.sum()
    dealt = [_deal(chance, team, shares) for _ in range(DRAWS)]
    thrown = [chance.multinomial(team.sum(), np.full(len(team), 1 / len(team))) for _ in range(DRAWS)]
    reaches = np.array([_reach_m(one, away_m) for one in dealt])
    return Partition(
        _overlap(visits),
        float(np.mean([_overlap(one) for one in dealt])),
        _variation(team),
        float(np.mean([_variation(one) for one in thrown])),
        _reach_m(visits, away_m),
        (float(reaches[:, 0].mean()), float(reaches[:, 1].mean())),
    )


def partition_of(outcome: Outcome) -> Partition | None:
    """The numbers of a trial, over all its phases."""
    tower = outcome.scenario.tower
    away_m = np.array([math.dist(one, (tower.x_m, tower.y_m)) for one in outcome.scenario.field.sites_m()])
    return partition(outcome.tables["visits"].sum(axis=0), away_m)


def _deal(chance: np.random.Generator, team: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """The team's visits given to robots at random, in proportion to what each has done."""
    return np.stack([chance.multinomial(int(count), shares) for count in team], axis=1)


def _overlap(visits: np.ndarray) -> float:
    shares = visits / np.maximum(visits.sum(axis=1, keepdims=True), 1)
    pairs = combinations(range(len(shares)), 2)
    return float(np.mean([np.minimum(shares[one], shares[other]).sum() for one, other in pairs]))


def _variation(team: np.ndarray) -> float:
    return float(team.std() / team.mean())


def _reach_m(visits: np.ndarray, away_m: np.ndarray) -> tuple[float, float]:
    reach_m = visits @ away_m / np.maximum(visits.sum(axis=1), 1)
    return float(reach_m.min()), float(reach_m.max())
