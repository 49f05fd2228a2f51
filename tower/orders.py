"""The tower's orders until they are carried out: numbered for ever, repeated until acknowledged."""

from collections.abc import Iterator

import msgspec

from swarm_agent.line_radio import Order
from tower.roster import Robot

PER_TICK = 1000


class Pending(msgspec.Struct):
    """An order that is not carried out as far as the tower knows."""

    order: Order
    given_tick: int
    said_tick: int | None = None
    acknowledged_tick: int | None = None


class Orders:
    """At most one order for each robot: a new one takes the place of the old."""

    def __init__(self, retry_ticks: int) -> None:
        self._retry_ticks = retry_ticks
        self._pending: dict[str, Pending] = {}
        self._last_number = 0

    def __contains__(self, node: str) -> bool:
        return node in self._pending

    def __iter__(self) -> Iterator[str]:
        """Names of the robots with an order."""
        return iter(self._pending)

    def segment(self, node: str) -> int | None:
        """The segment that a robot is ordered to, 0 for home, None without an order."""
        return self._pending[node].order.segment if node in self._pending else None

    def give(self, tick: int, node: str, segment: int) -> Order:
        """A new order. Its number is above all earlier ones, those before a restart included."""
        order = Order(max(tick * PER_TICK, self._last_number + 1), node, segment)
        self.keep(tick, order, said_tick=None)
        return order

    def keep(self, tick: int, order: Order, said_tick: int | None) -> None:
        """Take over an order that was given at `tick`, maybe in a former life."""
        self._last_number = max(self._last_number, order.number)
        self._pending[order.to] = Pending(order, tick, said_tick)

    def drop(self, node: str) -> None:
        """Forget a robot's order."""
        self._pending.pop(node, None)

    def hear(self, tick: int, robot: Robot) -> None:
        """A robot has reported: is its order acknowledged, carried out, or void?"""
        pending = self._pending.get(robot.node)
        if pending is None or robot.said_tick < pending.given_tick:
            return
        if robot.acknowledged < pending.order.number:
            pending.acknowledged_tick = None  # reborn, it may have forgotten what it acknowledged
        elif pending.acknowledged_tick is None:
            pending.acknowledged_tick = tick
        if self._is_done(pending, robot):
            del self._pending[robot.node]

    def due(self, tick: int) -> list[tuple[Order, bool]]:
        """Orders to be said now, in order of number, and whether each was said before; they count as said."""
        due = []
        for pending in self._pending.values():
            if pending.acknowledged_tick is None and self._due_tick(pending) <= tick:
                due.append((pending.order, pending.said_tick is not None))
                pending.said_tick = tick
        return sorted(due, key=lambda one: one[0].number)

    def next_tick(self) -> int | None:
        """When an order is to be repeated next."""
        open_ones = [one for one in self._pending.values() if one.acknowledged_tick is None]
        return min(map(self._due_tick, open_ones), default=None)

    def _due_tick(self, pending: Pending) -> int:
        return pending.given_tick if pending.said_tick is None else pending.said_tick + self._retry_ticks

    def _is_done(self, pending: Pending, robot: Robot) -> bool:
        """Carried out; or void, as the robot goes home for its battery or waits in the queue all the same."""
        heard = pending.acknowledged_tick
        if pending.order.segment == 0:
            return robot.said_tick > pending.given_tick and robot.state in ("home", "queue")
        if robot.state == "home":
            return robot.said_tick > pending.given_tick
        if robot.state == "queue":  # who has heard it and waits there much later has been out and is back
            return heard is not None and robot.said_tick > pending.given_tick + self._retry_ticks
        return heard is not None and robot.segment == pending.order.segment
