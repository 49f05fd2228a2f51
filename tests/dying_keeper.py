"""A tower that kills itself in the middle of a grant: a behaviour of a third party.

In a process of its own it dies by a real SIGKILL; in a rehearsal the mind raises, which is its death there.
"""

import os
import signal
import sys
from collections.abc import Callable
from functools import wraps
from typing import Literal, NamedTuple

from tower.ledger import Ledger
from tower.line_keeper import LineKeeper, LineKeeperParameters


class Death(NamedTuple):
    """`after` so many ticks of a life, with the next order that the tower gives: `write`, when the ledger
    has it and nobody has heard it, or `action`, when it is said, before the next grant is looked at. Or at
    once, at a `boundary` between ticks, which is for others to do.
    """

    after: int
    when: Literal["write", "action", "boundary"]


class DyingKeeperParameters(LineKeeperParameters, frozen=True):
    """`deaths`: of each incarnation in turn."""

    deaths: tuple[Death, ...] = ()


class DyingKeeper(LineKeeper):
    """The tower of the line patrol, with a date."""

    Parameters = DyingKeeperParameters

    def __init__(self, parameters, configuration, generator) -> None:
        super().__init__(parameters, configuration, generator)
        deaths = parameters.deaths[configuration.incarnation :]
        self._death = deaths[0] if deaths and deaths[0].when != "boundary" else None
        self._first_tick: int | None = None
        self._doomed = False
        _at_write.clear()

    def step(self, percept, heard):
        """As ever, unless it is to die."""
        if self._doomed:
            die()
        move = super().step(percept, heard)
        self._first_tick = percept.tick if self._first_tick is None else self._first_tick
        orders = any(entry.kind == "order" for entry in move.record)
        if self._death and orders and percept.tick - self._first_tick >= self._death.after:
            self._doomed = True
            if self._death.when == "write":
                _at_write.append(percept.grant)
        return move


_at_write: list[int] = []
"""The grant whose write is the last deed."""


def die() -> None:
    """As by `kill -9` where this is a process of its own."""
    if getattr(sys.modules["__main__"].__spec__, "name", "") == "tower.__main__":
        os.kill(os.getpid(), signal.SIGKILL)
    raise RuntimeError("the tower kills itself")


def _deadly(write: Callable) -> Callable:
    @wraps(write)
    def written(ledger, grant, tick, entries) -> None:
        write(ledger, grant, tick, entries)
        if grant in _at_write:
            die()

    return written


if not hasattr(Ledger.write, "__wrapped__"):
    Ledger.write = _deadly(Ledger.write)
