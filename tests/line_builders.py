"""Builders for tests of the line patrol's tower: a line, its tower, reports as they are heard."""

from typing import Any

import numpy as np

from swarm_agent.behaviour import Heard, Move
from swarm_agent.line_radio import Envelope, Order, Report, Roll, State
from tests.builders import configuration, percept
from tower.line_keeper import LineKeeper, LineKeeperParameters
from tower.roster import Robot
from wire.fields import Polyline
from wire.line import Line
from wire.messages import Configuration

LISTENED = 30
"""The tick at which a tower that was born at tick 0 sends its first robot."""


def straight(segments: int = 6) -> Polyline:
    """A straight line with segments of ten metres."""
    return Polyline(((0.0, 0.0), (10.0 * segments, 0.0)), segments)


def line(segments: int = 6) -> Line:
    """Its geometry, with the tower at its middle."""
    return Line(straight(segments), (5.0 * segments, 0.0))


def line_configuration(segments: int = 6, **fields: Any) -> Configuration:
    """What the tower of this line is told; ticks of a second."""
    tower_m = (5.0 * segments, 0.0)
    return configuration("r1", "line_keeper", field=straight(segments), tower_m=tower_m, **fields)


def robot(node: str, state: State = "patrol", segment: int = 0, **fields: Any) -> Robot:
    """A robot as the roster knows it."""
    known = {"battery_v": 9.0, "low": False, "acknowledged": 0, "heard_tick": 0, "said_tick": 0}
    return Robot(node, state, segment, **(known | {"since_tick": 0} | fields))


def report(
    node: str,
    tick: int,
    state: State = "queue",
    segment: int = 0,
    hops: int = 0,
    relay: bool = False,
    **fields: Any,
) -> Heard:
    """A robot's word of itself as the tower hears it."""
    word = Report(state, segment, **({"battery_v": 9.0} | fields))
    return Heard(node, tick, Envelope(node, tick, 0, word, 5.0, relay, hops))


class Watch:
    """A tower with its ledger in memory, which is stepped by hand. `orders`: the last one for each robot."""

    def __init__(self, segments: int = 6, remembered: Any = None, **parameters: Any) -> None:
        self.keeper = LineKeeper(
            LineKeeperParameters(**parameters),
            line_configuration(segments),
            np.random.Generator(np.random.Philox(1)),
        )
        self.entries: list[Any] = list(remembered or [])
        self.orders: dict[str, Order] = {}
        self.move = Move()
        if remembered is not None:
            self.keeper.remember(self.entries)

    def step(self, tick: int, *heard: Heard) -> Move:
        """One grant, after all for which the tower asked to be woken before it."""
        self.until(tick - 1)
        return self.grant(tick, *heard)

    def grant(self, tick: int, *heard: Heard) -> Move:
        """One grant and no other, whose entries are kept as a ledger keeps them."""
        self.move = self.keeper.step(percept(tick), heard)
        for one in self.move.record:
            assert one.tick == 0, "the ledger fills in the tick"
            self.entries.append(
                type(one)(one.kind, one.node, one.segment, one.battery_v, one.number, one.text, tick)
            )
        self.orders |= {one.to: one for one in self.said(Order)}
        return self.move

    def until(self, tick: int) -> None:
        """Step whenever the tower asked to be woken, up to and with `tick`."""
        while self.move.wake_tick is not None and self.move.wake_tick <= tick:
            self.grant(self.move.wake_tick)

    def said(self, kind: type = Order) -> list[Any]:
        """Messages of a kind in the last move."""
        return [one.message for one in self.move.say if isinstance(one.message, kind)]

    def sent(self) -> list[tuple[str, int]]:
        """Robot and segment of each order in the last move."""
        return [(one.to, one.segment) for one in self.said(Order)]

    def rolls(self) -> list[tuple[bool, bool]]:
        """For each roll in the last move: is it to be answered, is it to be passed on?"""
        return [(one.message.answer, one.relay) for one in self.move.say if isinstance(one.message, Roll)]

    def kinds(self, *wanted: str) -> list[tuple[str, str, int]]:
        """Kind, node and segment of all entries of these kinds."""
        return [(one.kind, one.node, one.segment) for one in self.entries if one.kind in wanted]

    def obey(self, node: str, tick: int, state: State | None = None, **fields: Any) -> Heard:
        """The report of a robot that has carried out its last order."""
        order = self.orders[node]
        state = state or ("patrol" if order.segment else "home")
        return report(node, tick, state, order.segment, order=order.number, **fields)


def deployed(segments: int = 6, robots: int = 8, **parameters: Any) -> Watch:
    """A tower whose segments are all patrolled, the rest of its robots in the queue, at tick 100."""
    watch = Watch(segments, **parameters)
    watch.step(0)
    watch.step(1, *[report(f"r{number}", 0) for number in range(2, robots + 2)])
    for tick in range(2, 100):
        watch.step(tick, *[watch.obey(one.to, tick - 1) for one in watch.said(Order)])
    everybody = [
        watch.obey(node, 99) if node in watch.orders else report(node, 99)
        for node in (f"r{number}" for number in range(2, robots + 2))
    ]
    watch.step(100, *everybody)
    return watch
