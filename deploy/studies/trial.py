"""A trial of a study: one algorithm, one team, one seed."""

import hashlib
import importlib
import inspect
import json
import re
from collections.abc import Sequence
from typing import Any, NamedTuple

from deploy.scenario_file import SHIPPED, ScenarioError, load_scenario
from swarm_agent.behaviour import BehaviourError, find_behaviour
from wire.scenario import Scenario


class Algorithm(NamedTuple):
    """One row of the comparison: its name in folders, its name for readers, the behaviour, its parameters."""

    name: str
    label: str
    behaviour: str
    parameters: dict[str, Any]


class Scale(NamedTuple):
    """How long trials are, and how many there are unless the user says otherwise."""

    duration_s: float
    metrics_from_s: float
    failures_s: float
    trials: int


class Trial(NamedTuple):
    """One trial: what it is of (`kind`: main, a variant, a map, ...), and how it is run."""

    name: str
    kind: str
    algorithm: Algorithm
    nodes: int
    seed: int
    as_processes: bool
    base: str
    settings: tuple[str, ...]

    def scenario(self) -> Scenario:
        """The complete scenario. Raises ScenarioError."""
        return load_scenario(SHIPPED / f"{self.base}.toml", list(self.settings))


def guest(behaviour: str, taken: Sequence[Algorithm]) -> Algorithm:
    """A user's behaviour as one more algorithm. Raises ScenarioError.

    The name has a fingerprint of its source file, so that trials of an earlier version are not taken for it.
    """
    try:
        module = importlib.import_module(find_behaviour(behaviour, "swarm_agent.behaviours").__module__)
    except BehaviourError as error:
        raise ScenarioError(f"--behaviour {behaviour}: {error}") from None
    if any(behaviour in (one.behaviour, one.label) for one in taken):
        raise ScenarioError(f"--behaviour {behaviour}: is in the comparison already")
    fingerprint = hashlib.blake2b(inspect.getsource(module).encode(), digest_size=4).hexdigest()
    name = re.sub(r"[^A-Za-z0-9_]+", ".", behaviour)
    return Algorithm(f"{name}-{fingerprint}", behaviour, behaviour, {})


def settings_of(section: str, given: dict[str, Any]) -> tuple[str, ...]:
    """A behaviour's parameters as `--set` takes them; `section` is robots or tower."""
    return tuple(f"{section}.parameters.{name}={json.dumps(value)}" for name, value in given.items())


def contains(name: str, text: str) -> bool:
    """Has a trial's name this in it? A number stands for itself, not for the beginning of a longer one."""
    before = r"(?<!\d)" if text[:1].isdigit() else ""
    behind = r"(?!\d)" if text[-1:].isdigit() else ""
    return re.search(f"{before}{re.escape(text)}{behind}", name) is not None
