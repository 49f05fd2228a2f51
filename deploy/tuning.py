"""What `picket tune` asks: parameters with bounds, metrics, seeds; checked before anything runs."""

import difflib
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import msgspec

from deploy.metrics import MISSIONS
from deploy.pattern_search import Axis, Point
from deploy.scenario_file import ScenarioError, find_scenario, load_scenario
from wire.scenario import Scenario

Number = int | float
SHOWN_DEPTH = 2
OF_EVERY_RUN = ("grants", "robot_ticks")
"""Metrics that the recorder adds to those of the mission."""


class Wish(msgspec.Struct, frozen=True):
    """A parameter as the operator gave it; no `start`: as the scenario has it."""

    key: str
    low: Number
    high: Number
    start: Number | None


class Parameter(msgspec.Struct, frozen=True):
    """A parameter of the scenario that is tuned, and its bounds."""

    key: str
    start: Number
    low: Number
    high: Number
    whole: bool

    @property
    def axis(self) -> Axis:
        """The same in exact fractions; decimal figures are meant as they are written."""
        return Axis(*(Fraction(str(one)) for one in (self.start, self.low, self.high)), self.whole)

    def value(self, coordinate: Fraction) -> Number:
        """A coordinate as the scenario takes it."""
        return int(coordinate) if self.whole else float(coordinate)


class Question(msgspec.Struct, frozen=True):
    """What is asked. A folder is for one question; `step` is the first step, as a share of each range."""

    scenario: str
    settings: tuple[str, ...]
    until_s: float | None
    parameters: tuple[Parameter, ...]
    metrics: tuple[str, ...]
    maximise: bool
    seeds: tuple[int, ...]
    step: float

    @property
    def start(self) -> Point:
        """Where the search begins."""
        return tuple(one.axis.start for one in self.parameters)

    def load(self, point: Point, seed: int) -> Scenario:
        """The scenario of one rehearsal. Raises ScenarioError, also for what a behaviour refuses."""
        ending = [] if self.until_s is None else [f"duration_s={self.until_s}"]
        return load_scenario(
            find_scenario(self.scenario),
            [*self.settings, *ending, f"seed={seed}", *settings_of(self.values(point))],
        )

    def values(self, point: Point) -> dict[str, Number]:
        """A point as values of the parameters."""
        return {one.key: one.value(at) for one, at in zip(self.parameters, point, strict=True)}


def settings_of(values: dict[str, Number]) -> list[str]:
    """Values of parameters as `--set` takes them."""
    return [f"{key}={value}" for key, value in values.items()]


def settle(wishes: list[Wish], path: Path, settings: list[str]) -> tuple[Scenario, tuple[Parameter, ...]]:
    """The scenario at the start point, and the parameters, complete. Raises ScenarioError."""
    keys = [wish.key for wish in wishes]
    for key in keys:
        if keys.count(key) > 1:
            raise ScenarioError(f"--parameter {key}: is given twice")
        if key == "seed":
            raise ScenarioError("--parameter seed: is nothing to tune; --seeds says which are run")
    given = [*settings, *settings_of({one.key: one.start for one in wishes if one.start is not None})]
    scenario = load_scenario(path, given)
    return scenario, tuple(_settled(wish, scenario, path, given) for wish in wishes)


def _settled(wish: Wish, scenario: Scenario, path: Path, settings: list[str]) -> Parameter:
    start, place = value_at(msgspec.to_builtins(scenario), wish.key), f"--parameter {wish.key}"
    if start is None:
        load_scenario(path, [*settings, f"{wish.key}={wish.low}"])  # says so when there is no such key
        raise ScenarioError(f"{place}: the scenario has no value; give a start, {wish.key}=START:LOW..HIGH")
    if isinstance(start, bool) or not isinstance(start, Number):
        raise ScenarioError(f"{place}: must be a number to be tuned, is {start!r} in the scenario")
    whole = isinstance(start, int)
    if whole and not (isinstance(wish.low, int) and isinstance(wish.high, int)):
        bounds = f"{wish.low}..{wish.high}"
        raise ScenarioError(f"{place}: bounds must be whole numbers, as the parameter is, got {bounds}")
    if not wish.low <= start <= wish.high:
        raise ScenarioError(f"{place}: the start {start} must be within its bounds {wish.low}..{wish.high}")
    return Parameter(wish.key, start, wish.low, wish.high, whole)


def value_at(document: Any, key: str) -> Any:
    """What stands at a key path, None where nothing does."""
    for step in key.split("."):
        if isinstance(document, dict):
            document = document.get(step)
        elif isinstance(document, (list, tuple)) and step.isdecimal() and int(step) < len(document):
            document = document[int(step)]
        else:
            return None
    return document


def check_metrics(names: list[str], scenario: Scenario) -> None:
    """Raises ScenarioError for a metric that a run of this scenario does not have."""
    unmeasured = MISSIONS[scenario.mission](scenario).summary() | dict.fromkeys(OF_EVERY_RUN)
    known = list(_leaves(unmeasured))
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean {near[0]}? " if near else ""
            shown = ", ".join(one for one in known if one.count(".") < SHOWN_DEPTH)
            raise ScenarioError(f"--metric {name}: there is no such metric; {hint}known are {shown}")


def _leaves(metrics: dict[str, Any], above: str = "") -> Iterator[str]:
    for name, value in metrics.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{above}{name}.")
        else:
            yield f"{above}{name}"
