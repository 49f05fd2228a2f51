"""Orders that reached their robots and reports that reached the tower, and how many hops they took.

Source: none; in papers/line-patrol.txt all messages go directly.
"""

from collections.abc import Iterable
from typing import Any


class Hops:
    """Messages that arrived. A hop is somebody who said a message again: heard directly, it took none."""

    def __init__(self) -> None:
        self.count, self._sum, self._most = 0, 0, 0

    def add(self, hops: int) -> None:
        """Take in one message."""
        self.count += 1
        self._sum += hops
        self._most = max(self._most, hops)

    def summary(self) -> dict[str, Any]:
        """Mean and most; None of nothing."""
        if not self.count:
            return {"hops_mean": None, "hops_max": None}
        return {"hops_mean": self._sum / self.count, "hops_max": self._most}


class Words:
    """The fold of what tower and robots tell observers of each other's words."""

    def __init__(self) -> None:
        self._given = 0
        self._open: set[int] = set()
        self._orders, self._reports = Hops(), Hops()

    def tower_tells(self, orders: Iterable[int], hops: Iterable[int]) -> None:
        """The tower gave orders with these numbers, and heard reports after so many hops each."""
        for number in orders:
            self._given += 1
            self._open.add(number)
        for one in hops:
            self._reports.add(one)

    def robot_tells(self, order: int, hops: int) -> None:
        """The last order that a robot has heard, and the hops that it took."""
        if order in self._open:
            self._open.discard(order)
            self._orders.add(hops)

    def summary(self) -> dict[str, Any]:
        """Of orders and of reports."""
        orders = {"given": self._given, "delivered": self._orders.count} | self._orders.summary()
        return {"orders": orders, "reports": {"heard": self._reports.count} | self._reports.summary()}
