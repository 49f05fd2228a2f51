"""Which runs the study has: floor plans, places where teams begin, team sizes, seeds.

Ours: the paper has one plan, whose bitmap is not public, two places and a few runs. Here are the cave that
comes with Picket, as large as the paper's plan, and random plans; places all around each; every team size.

Every run is judged by both referees. That costs a fifth more than one, and leaves nothing to be looked at
again: the exact one decides.
"""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import NamedTuple

import shapely

from deploy.clear_checks import obstacle_m
from deploy.scenario_file import SHIPPED, ScenarioError, load_scenario
from deploy.studies.pursuit.places import places_around
from deploy.studies.trial import contains
from wire.fields import Point, RandomPlan
from wire.scenario import Scenario, Sensors
from world_server.deployment import plan_of
from world_server.floorplan import PlanError
from world_server.random_plans import random_plan

MAIN, RANDOM = "clear-cave", "clear-random"
KINDS = ((2, 2, 0), (2, 3, 0), (2, 2, 1), (2, 3, 0))
"""Columns, rows and islands of random plans, taken in turn."""


class Extent(NamedTuple):
    """How much there is of everything. `beyond`: how many robots more than the fewest that clear are tried.

    `teams`: sizes on random plans; on the main one they are all from `fewest` to `most`.
    """

    places: int
    fewest: int
    most: int
    beyond: int
    main_s: float
    plans: int
    teams: tuple[int, ...]
    random_s: float


FULL = Extent(8, 6, 13, 3, 5400.0, 32, (5, 6, 7, 8), 1800.0)
QUICK = Extent(2, 10, 10, 0, 600.0, 3, (6, 8), 600.0)


class Ground(NamedTuple):
    """A floor plan to be cleared, as a shipped scenario has it, or drawn at random in its place."""

    name: str
    base: str
    duration_s: float
    teams: tuple[int, ...]
    beyond: int
    places: int
    random: RandomPlan | None = None

    @property
    def kind(self) -> str:
        """Grounds of one kind are told together."""
        if self.random is None:
            return self.name
        islands = {0: "", 1: ", an island"}.get(self.random.islands, f", {self.random.islands} islands")
        return f"{self.random.columns} x {self.random.rows} rooms{islands}"


@cache
def polygon(ground: Ground) -> shapely.Polygon:
    """The free space. Raises ScenarioError."""
    scenario = load_scenario(SHIPPED / f"{ground.base}.toml")
    if (drawn := ground.random) is None:
        return plan_of(scenario.field)
    detect_m, rooms = (scenario.sensors or Sensors()).detect_m, (drawn.columns, drawn.rows)
    try:
        return random_plan(drawn.seed, rooms, drawn.islands, obstacle_m(scenario), detect_m)
    except PlanError as error:
        raise ScenarioError(f"{ground.name}: {error}") from None


@cache
def places(ground: Ground) -> tuple[Point, ...]:
    """Where teams begin. Raises ScenarioError."""
    try:
        return tuple(places_around(polygon(ground), ground.places))
    except PlanError as error:
        raise ScenarioError(f"{ground.name}: {error}") from None


class Trial(NamedTuple):
    """One run: so many robots from one of the places, numbered from 1."""

    ground: Ground
    place: int
    robots: int
    seed: int

    @property
    def name(self) -> str:
        """Of its folder."""
        return f"{self.ground.name}-start{self.place}-n{self.robots}-seed{self.seed}"

    def scenario(self) -> Scenario:
        """The complete scenario. Raises ScenarioError."""
        ground, (x_m, y_m) = self.ground, places(self.ground)[self.place - 1]
        settings = [
            "faults=[]",
            f"seed={self.seed}",
            f"duration_s={ground.duration_s}",
            f"robots.count={self.robots}",
            f'robots.start={{kind="cluster", x_m={x_m}, y_m={y_m}}}',
            "sensors.referee=both",
        ]
        if (drawn := ground.random) is not None:
            told = (f"{name} = {getattr(drawn, name)}" for name in ("seed", "columns", "rows", "islands"))
            settings.append(f"field.random={{{', '.join(told)}}}")
        return load_scenario(SHIPPED / f"{ground.base}.toml", settings)


Fewest = Mapping[tuple[str, int], int]
"""How many robots it takes, by the name of a ground and the place, where they clear it at all."""


class Study(NamedTuple):
    """All grounds, and how many runs there are of each kind, with seeds 1, 2, ..."""

    grounds: tuple[Ground, ...]
    seeds: int = 1
    only: str = ""

    def every_team(self) -> list[Trial]:
        """The runs that are there whatever comes of them. Raises ScenarioError where there is none."""
        found = self._chosen(
            Trial(ground, place, robots, seed)
            for ground in self.grounds
            for seed in range(1, self.seeds + 1)
            for robots in ground.teams
            for place in range(1, ground.places + 1)
        )
        if not found:
            example = Trial(self.grounds[0], 1, self.grounds[0].teams[0], 1).name
            raise ScenarioError(f"--only {self.only}: no run has this in its name; one is called {example}")
        return found

    def larger_teams(self, fewest: Fewest) -> list[Trial]:
        """The runs with more robots than are tried everywhere, where few less are the fewest that clear."""
        return self._chosen(
            Trial(ground, place, robots, seed)
            for ground in self.grounds
            for place in range(1, ground.places + 1)
            for robots in range(ground.teams[-1] + 1, fewest.get((ground.name, place), 0) + ground.beyond + 1)
            for seed in range(1, self.seeds + 1)
        )

    def _chosen(self, trials: Iterator[Trial]) -> list[Trial]:
        return [one for one in trials if contains(one.name, self.only)]


def study(extent: Extent, most: int | None = None, plans: int | None = None) -> Study:
    """The main plan with teams of at most `most`, and so many random ones. Raises ScenarioError."""
    most = extent.most if most is None else most
    if most < extent.fewest:
        raise ScenarioError(
            f"--most {most}: must be at least {extent.fewest}, the smallest team of the study"
        )
    teams = tuple(range(extent.fewest, most + 1))
    main = Ground(MAIN.removeprefix("clear-"), MAIN, extent.main_s, teams, extent.beyond, extent.places)
    numbers = range(extent.plans if plans is None else plans)
    return Study((main, *(_drawn(number, extent) for number in numbers)))


def _drawn(number: int, extent: Extent) -> Ground:
    """The random plans from 0 on: the kinds in turn, each with seeds 1, 2, ..."""
    columns, rows, islands = KINDS[number % len(KINDS)]
    same = [place for place, kind in enumerate(KINDS) if kind == KINDS[number % len(KINDS)]]
    seed = number // len(KINDS) * len(same) + same.index(number % len(KINDS)) + 1
    name = f"rooms{columns}x{rows}{f'-islands{islands}' if islands else ''}-plan{seed}"
    drawn = RandomPlan(seed=seed, columns=columns, rows=rows, islands=islands)
    return Ground(name, RANDOM, extent.random_s, extent.teams, 0, extent.places, drawn)
