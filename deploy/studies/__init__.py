"""Studies: what a paper ran, run again, with its tables beside ours."""

from typing import Any, NamedTuple


class Table(NamedTuple):
    """A table of results: a title with the paper's place, headings, rows of text, and what is to be said."""

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    remark: str = ""


class Bars(NamedTuple):
    """A figure of grouped bars: values (None: nothing measured) and errors by group, one per label."""

    name: str
    title: str
    unit: str
    labels: tuple[str, ...]
    groups: dict[str, tuple[float | None, ...]]
    errors: dict[str, tuple[float | None, ...]]


Summaries = dict[str, dict[str, Any]]


def number(value: float | None, digits: int = 1, unit: str = "") -> str:
    """A value as it stands in a table; a dash for what was not measured."""
    return "-" if value is None else f"{value:.{digits}f}{unit}"


def mean(values: list[float | None]) -> float | None:
    """The mean of what was measured."""
    known = [one for one in values if one is not None]
    return sum(known) / len(known) if known else None


def spread(values: list[float | None]) -> float | None:
    """The standard deviation over runs, of what was measured."""
    known = [one for one in values if one is not None]
    middle = mean(values)
    return None if middle is None else (sum((one - middle) ** 2 for one in known) / len(known)) ** 0.5
