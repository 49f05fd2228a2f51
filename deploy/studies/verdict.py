"""A paper's claims beside what was measured: how they are judged, and how that is told."""

from collections.abc import Iterable
from typing import Literal, NamedTuple

from rich.console import Console
from rich.table import Table

from deploy.markdown import table

Word = Literal["reproduced", "direction only", "not reproduced", "not testable"]


class Verdict(NamedTuple):
    """A claim, what was measured, what follows, and the rule by which it does."""

    claim: str
    measured: str
    word: Word
    rule: str


def told(judged: Iterable[Verdict]) -> str:
    """Claim, verdict, what was measured, rule, as Markdown."""
    rows = [(one.claim, f"**{one.word}**", one.measured, one.rule) for one in judged]
    return table(("the paper says", "verdict", "measured", "rule"), rows)


def show(judged: Iterable[Verdict], quick: bool) -> None:
    """Print the claims and what became of them."""
    title = "QUICK RUN: says nothing about the paper" if quick else "The paper's claims"
    printed = Table(title=title, title_justify="left", show_lines=True)
    for heading in ("the paper says", "verdict", "measured"):
        printed.add_column(heading)
    for one in judged:
        printed.add_row(one.claim, one.word, one.measured)
    Console().print(printed)
