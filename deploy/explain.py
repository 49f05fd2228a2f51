"""What msgspec says of a document that does not fit its schema, in words an operator can act on."""

import difflib
import re
from typing import Any, get_args

import msgspec

WORDS = {"float": "a number", "int": "a whole number", "str": "text", "array": "a list", "object": "a table"}


def explain(error: str, document: Any, kind: Any) -> str:
    """msgspec's complaint about a document that was to be a `kind` as: field, what would be right, value."""
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
