"""What the tower of a line patrol writes down, and what it shows to observers."""

from typing import Literal

import msgspec

Kind = Literal["born", "heard", "order", "recall", "vacant", "covered", "lost", "returned"]


class Entry(msgspec.Struct, frozen=True):
    """One line of the tower's ledger. `tick` is filled in by the ledger.

    born: the tower process began. heard: a robot's own word; `number` is the last order it has heard, `text`
    its state, with "low" behind it when it goes home for its battery's sake. order: `number`, to `node`, for
    `segment` (0: home). recall: Algorithm 3 chose `node`. vacant, covered: `segment`. lost, returned: `node`.
    """

    kind: Kind
    node: str = ""
    segment: int = 0
    battery_v: float = 0.0
    number: int = 0
    text: str = ""
    tick: int = 0


class Desk(msgspec.Struct, frozen=True, array_like=True):
    """What observers are told: who waits in the queue in which order, which segments nobody covers, who is
    recalled and not yet back, who counts as lost; how many hops each report took that was just heard, and
    the numbers of the orders that were just given.
    """

    queue: tuple[str, ...]
    vacant: tuple[int, ...]
    recalled: tuple[str, ...]
    lost: tuple[str, ...]
    hops: tuple[int, ...] = ()
    orders: tuple[int, ...] = ()
