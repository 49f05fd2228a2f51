"""Are two runs the same, and if not, where do they first part?"""

from itertools import zip_longest
from pathlib import Path

from world_server.journal import JournalError, commits, read
from world_server.records import Commit, Header


def compare(first: Path, second: Path) -> tuple[bool, str]:
    """Whether two runs are equal, and a sentence that names the first tick and node that differ.

    Raises JournalError.
    """
    headers = [_header(folder / "journal") for folder in (first, second)]
    if headers[0].nodes != headers[1].nodes:
        return False, f"different teams: {', '.join(headers[0].nodes)} against {', '.join(headers[1].nodes)}"
    if headers[0].seed != headers[1].seed:
        return False, f"different seeds: {headers[0].seed} against {headers[1].seed}"
    ticks = 0
    for one, other in zip_longest(commits(first / "journal"), commits(second / "journal")):
        if one is None or other is None:
            shorter = first if one is None else second
            return False, f"equal up to the end of {shorter.name}, which is shorter: {ticks} ticks"
        if one != other:
            return False, f"they part at tick {min(one.tick, other.tick)}: {_difference(one, other)}"
        ticks += 1
    return True, f"equal: {ticks} commits, and every grant, action, delivery and fault in them"


def _header(journal: Path) -> Header:
    """How a journal begins. Raises JournalError."""
    beginning = next(read(journal), None)
    if not isinstance(beginning, Header):
        raise JournalError(f"{journal}: has no beginning: it is empty or no journal")
    return beginning


def _difference(one: Commit, other: Commit) -> str:
    """The first thing that differs within a tick, in the order in which a tick happens."""
    if one.tick != other.tick:
        return f"one has a commit at tick {one.tick}, the other at {other.tick}"
    if one.facts.faults != other.facts.faults:
        return f"faults: {_faults(one)} against {_faults(other)}"
    for (grant, action), (other_grant, other_action) in zip_longest(
        zip(one.grants, one.actions, strict=True),
        zip(other.grants, other.actions, strict=True),
        fillvalue=(None, None),
    ):
        if grant is None or other_grant is None or grant.node != other_grant.node:
            named = sorted({one.node for one in (grant, other_grant) if one is not None})
            return f"{' or '.join(named)} was granted in one run only"
        for what, mine, theirs in (("was told", grant, other_grant), ("answered", action, other_action)):
            if mine != theirs:
                return f"{grant.node} {what} something else: {_field(mine, theirs)}"
    return "the same answers led to other deliveries or other facts"


def _field(mine: object, theirs: object) -> str:
    """The first differing field of two Structs of one type."""
    for name in mine.__struct_fields__:
        left, right = getattr(mine, name), getattr(theirs, name)
        if left != right:
            return f"{name} {_short(left)} against {_short(right)}"
    return "nothing that shows"


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 100 else f"{text[:97]}..."


def _faults(commit: Commit) -> str:
    return ", ".join(f"{fault.verb} {fault.node}" for fault in commit.facts.faults) or "none"
