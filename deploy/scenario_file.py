"""From a TOML file and `--set` options to a checked Scenario, with errors an operator can act on."""

import difflib
import math
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import tomli_w

from deploy.explain import explain
from deploy.field_file import whole
from deploy.mistake import Mistake
from deploy.scenario_checks import check
from swarm_agent.behaviour import Air, BehaviourError, find_behaviour, settled_parameters
from wire.scenario import Cluster, Scenario, Sensors

SHORT = {"behaviour": "robots.behaviour"}
"""Settings that are given so often that their place need not be named."""
SHIPPED = Path(__file__).parent / "scenarios"
SHIPPED_PLANS = {path.stem: path for path in sorted((SHIPPED / "plans").glob("*.*"))}


class ScenarioError(Exception):
    """An operator's mistake, in one line: the file, the field, the value and what would be right."""

    def __init__(self, text: str) -> None:
        super().__init__(" ".join(text.splitlines()))


def shipped_scenarios() -> dict[str, Path]:
    """Name and path of every scenario that comes with Picket."""
    return {path.stem: path for path in sorted(SHIPPED.glob("*.toml"))}


def find_scenario(name: str) -> Path:
    """The file of a scenario given by path or by the name of a shipped one. Raises ScenarioError."""
    if name in shipped_scenarios():
        return shipped_scenarios()[name]
    path = Path(name)
    if not name:
        raise ScenarioError("the name of the scenario is empty; `picket scenarios` lists the shipped ones")
    try:
        if path.is_dir():
            raise ScenarioError(f"{name}: is a directory; give a scenario file")
        found = path.exists()
    except OSError:  # a name that no file can have
        found = False
    if not found:
        near = difflib.get_close_matches(name, shipped_scenarios(), 1)
        hint = f"did you mean {near[0]}?" if near else "`picket scenarios` lists the shipped ones"
        raise ScenarioError(f"{name}: no such file and no such scenario; {hint}")
    return path


def load_scenario(path: Path, settings: list[str] = [], **overrides: Any) -> Scenario:
    """Read, change, check and complete a scenario. `overrides` replace top-level fields.

    Raises ScenarioError.
    """
    document = _read(path)
    _look_beside(document, path)
    for setting in settings:
        _apply(document, setting)
    document.update(overrides)
    source = path.name
    for place, number in _endless(document):
        raise ScenarioError(f"{source}: {place} must be finite, got {number}")
    try:
        scenario = msgspec.convert(document, Scenario)
    except msgspec.ValidationError as error:
        raise ScenarioError(f"{source}: {explain(str(error), document, Scenario)}") from None
    try:
        scenario = msgspec.structs.replace(scenario, field=whole(scenario))
        scenario = _understood(scenario, document)
        check(scenario)
    except Mistake as mistake:
        raise ScenarioError(f"{source}: {mistake}") from None
    return _complete(scenario, source)


def to_toml(scenario: Scenario) -> str:
    """The scenario as TOML that loads back to an equal one."""
    return tomli_w.dumps(_without_none(msgspec.to_builtins(scenario)))


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text("utf-8"))
    except UnicodeDecodeError as error:
        raise ScenarioError(f"{path.name}: not UTF-8 text (byte {error.start}); a scenario is TOML") from None
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{path.name}: not valid TOML: {error}") from None
    except RecursionError:
        raise ScenarioError(f"{path.name}: not valid TOML: nested too deeply") from None
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be read: {error.strerror}") from None


def _look_beside(document: dict[str, Any], path: Path) -> None:
    """The file of a graph or a plan that a scenario names lies beside the scenario, or ships with Picket."""
    field = document.get("field")
    for kind in ("graph", "plan") if isinstance(field, dict) else ():
        if isinstance(name := field.get(kind), str) and name:
            field[kind] = str(SHIPPED_PLANS.get(name, path.parent / name))


def _understood(scenario: Scenario, document: dict[str, Any]) -> Scenario:
    """With what goes without saying in mission clear: sensors, and a tower where robots are deployed."""
    if scenario.mission != "clear":
        return scenario
    start, told, tower = scenario.robots.start, document.get("tower", {}), scenario.tower
    if isinstance(start, Cluster) and not {"x_m", "y_m"} & told.keys():
        tower = msgspec.structs.replace(tower, x_m=start.x_m, y_m=start.y_m)
    return msgspec.structs.replace(scenario, tower=tower, sensors=scenario.sensors or Sensors())


def _apply(document: dict[str, Any], setting: str) -> None:
    """Carry out one `key.path=value`; the value is TOML, or else a plain string."""
    path, equals, text = setting.partition("=")
    path = SHORT.get(path, path)
    if not equals or not path:
        raise ScenarioError(f"--set {setting}: must be key.path=value")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError):
        value = text
    *parents, last = path.split(".")
    place: Any = document
    try:
        for step in parents:
            place = place[int(step)] if isinstance(place, list) else place.setdefault(step, {})
        if isinstance(place, list):
            place[int(last)] = value
        else:
            place[last] = value
    except (ValueError, IndexError, AttributeError, TypeError):
        raise ScenarioError(f"--set {setting}: there is no such place in the scenario") from None


def _endless(value: Any, place: str = "") -> Iterator[tuple[str, float]]:
    """Place and value of every number in a document that is infinite or none; TOML knows both."""
    if isinstance(value, float) and not math.isfinite(value):
        yield place, value
    elif isinstance(value, dict):
        for name, one in value.items():
            yield from _endless(one, f"{place}.{name}".lstrip("."))
    elif isinstance(value, list):
        for number, one in enumerate(value):
            yield from _endless(one, f"{place}[{number}]")


def _complete(scenario: Scenario, source: str) -> Scenario:
    """Find both behaviours and fill in their parameters, so that the resolved scenario says all."""
    team_size, radio = len(scenario.node_ids), scenario.radio
    slowest = max((fault.every for fault in scenario.faults), default=1)
    air = Air(scenario.tick_s, radio.latency_ticks, radio.loss, slowest)
    robots = _with_parameters(scenario.robots, "swarm_agent.behaviours", team_size, air, f"{source}: robots")
    tower = _with_parameters(scenario.tower, "tower", team_size, air, f"{source}: tower")
    return msgspec.structs.replace(scenario, robots=robots, tower=tower)


def _with_parameters(section: Any, package: str, team_size: int, air: Air, place: str) -> Any:
    try:
        behaviour = find_behaviour(section.behaviour, package)
        parameters = settled_parameters(behaviour, section.parameters, team_size, air)
    except BehaviourError as error:
        raise ScenarioError(f"{place}.behaviour: {error}") from None
    except msgspec.ValidationError as error:
        kind = behaviour.Parameters
        what = explain(str(error), section.parameters, kind)
        if "is not a field" in what and "did you mean" not in what:
            part = place.rpartition(" ")[2]
            what += f"; --set {part}.parameters={{}} drops those of the scenario"
        raise ScenarioError(f"{place}.parameters.{what}") from None
    except ValueError as error:
        raise ScenarioError(f"{place}.parameters: {error}") from None
    return msgspec.structs.replace(section, parameters=_without_none(msgspec.to_builtins(parameters)))


def _without_none(value: Any) -> Any:
    """TOML has no null: fields at None are left out, which reads back as None."""
    if isinstance(value, dict):
        return {name: _without_none(one) for name, one in value.items() if one is not None}
    if isinstance(value, (list, tuple)):
        return [_without_none(one) for one in value]
    return value
