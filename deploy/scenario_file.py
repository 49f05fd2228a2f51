"""From a TOML file and `--set` options to a checked Scenario, with errors an operator can act on."""

import difflib
import math
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import msgspec
import tomli_w

from deploy.mistake import Mistake
from deploy.scenario_checks import check
from swarm_agent.behaviour import BehaviourError, find_behaviour, settled_parameters
from wire.scenario import Scenario

WORDS = {"float": "a number", "int": "a whole number", "str": "text", "array": "a list", "object": "a table"}
SHIPPED = Path(__file__).parent / "scenarios"


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
    for setting in settings:
        _apply(document, setting)
    document.update(overrides)
    source = path.name
    for place, number in _endless(document):
        raise ScenarioError(f"{source}: {place} must be finite, got {number}")
    try:
        scenario = msgspec.convert(document, Scenario)
    except msgspec.ValidationError as error:
        raise ScenarioError(f"{source}: {_explain(str(error), document)}") from None
    try:
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


def _apply(document: dict[str, Any], setting: str) -> None:
    """Carry out one `key.path=value`; the value is TOML, or else a plain string."""
    path, equals, text = setting.partition("=")
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


def _explain(error: str, document: Any, kind: Any = Scenario) -> str:
    """msgspec's complaint as: field, what would be right, value."""
    what, _, place = error.partition(" - at `$")
    steps = re.findall(r"\.([^.\[\]`]+)|\[(\d+)\]", place)
    names = [name or int(index) for name, index in steps]
    field = "".join(f"[{one}]" if isinstance(one, int) else f".{one}" for one in names).lstrip(".")
    unknown = re.search(r"unknown field `(.+)`", what, re.DOTALL)
    if unknown:
        return _unknown(unknown.group(1), field, kind, names)
    missing = re.search(r"missing required field `(.+)`", what)
    if missing:
        return f"{'.'.join(filter(None, (field, missing.group(1))))} is missing"
    value = document
    for one in names:
        value = value[one]
    choices = _choices_at(kind, names)
    if what.startswith("Invalid") and choices:
        what = f"must be {' or '.join(choices)}"
    words = re.sub("`([a-z |]+)`", _in_words, re.sub(", got `.*`$", "", what)).replace("Expected", "must be")
    return f"{field} {words}, got {value!r}".replace("`", "").lstrip()


def _in_words(types: re.Match) -> str:
    """msgspec's names of types as an operator calls them."""
    return " or ".join(WORDS.get(one, one) for one in types.group(1).split(" | ") if one != "null")


def _unknown(name: str, field: str, kind: Any, names: list[str | int]) -> str:
    known = _fields_at(kind, names)
    near = difflib.get_close_matches(name, known, 1)
    hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}" if known else ""
    return f"{'.'.join(filter(None, (field, name)))} is not a field; {hint}".rstrip("; ")


def _fields_at(kind: Any, names: list[str | int]) -> list[str]:
    """Names of the fields that may stand at a place of the schema; all variants of a union together."""
    return [field for one in _kinds_at(kind, names) if _is_struct(one) for field in one.__struct_fields__]


def _choices_at(kind: Any, names: list[str | int]) -> list[str]:
    """The words that may stand at a place of the schema, where only some may."""
    tagged = [one.__struct_config__ for one in _kinds_at(kind, names[:-1]) if _is_struct(one)]
    tags = [one.tag for one in tagged if names and one.tag_field == names[-1]]
    return tags or [one for one in _kinds_at(kind, names) if isinstance(one, str)]


def _kinds_at(kind: Any, names: list[str | int]) -> list[Any]:
    """The types, or the words, that may stand at a place of the schema."""
    kinds = [kind]
    for name in names:
        found = [_inside(one, name) for one in _variants(kinds)]
        kinds = [one for one in found if one is not None]
    return _variants(kinds)


def _is_struct(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, msgspec.Struct)


def _variants(kinds: list[Any]) -> list[Any]:
    flat = []
    for kind in kinds:
        inner = [one for one in get_args(kind) if one is not Ellipsis]
        flat += [kind] if _is_struct(kind) or not inner else _variants(inner)
    return flat


def _inside(kind: Any, name: str | int) -> Any:
    if isinstance(name, int) or not _is_struct(kind):
        return kind
    hints = {field.name: field.type for field in msgspec.structs.fields(kind)}
    return hints.get(name)


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
    team_size = len(scenario.node_ids)
    robots = _with_parameters(scenario.robots, "swarm_agent.behaviours", team_size, f"{source}: robots")
    tower = _with_parameters(scenario.tower, "tower", team_size, f"{source}: tower")
    return msgspec.structs.replace(scenario, robots=robots, tower=tower)


def _with_parameters(section: Any, package: str, team_size: int, place: str) -> Any:
    try:
        behaviour = find_behaviour(section.behaviour, package)
        parameters = settled_parameters(behaviour, section.parameters, team_size)
    except BehaviourError as error:
        raise ScenarioError(f"{place}.behaviour: {error}") from None
    except msgspec.ValidationError as error:
        kind = behaviour.Parameters
        raise ScenarioError(f"{place}.parameters.{_explain(str(error), section.parameters, kind)}") from None
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
