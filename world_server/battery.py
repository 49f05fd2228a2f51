"""Charge: what robots lose by what the world sees them do, and what they gain at their place in the queue."""

from collections.abc import Sequence

from wire.channels import number_of
from wire.scenario import BatterySection
from world_server.chance import generator

SECONDS_PER_HOUR = 3600.0


PATROLLING, TRAVELLING, QUEUEING, NOTHING = range(4)
"""What a robot does: it is on the line, anywhere else, at rest at its place in the queue, or dead."""


class Batteries:
    """The batteries of all robots, in order of their numbers. `volts`: the charge of each."""

    def __init__(self, section: BatterySection, robots: Sequence[str], seed: int, tick_s: float) -> None:
        self._section = section
        hours = tick_s / SECONDS_PER_HOUR
        drains_v_h = (section.patrolling_v_h, section.travelling_v_h, section.queueing_v_h, 0.0)
        self._spent_v = [drain_v_h * hours for drain_v_h in drains_v_h]
        span_v = section.full_v - section.empty_v
        self._gained_v = span_v * tick_s / section.charge_s if section.charge_s else span_v
        draws = [float(generator(seed, "battery", number_of(robot)).standard_normal()) for robot in robots]
        self.volts = [section.full_v - section.start_sd_v * abs(draw) for draw in draws]
        self._charging = [False] * len(robots)

    def use(self, row: int, doing: int) -> None:
        """One tick of what a robot does; one that is charging gains charge until it is full or leaves."""
        if self._charging[row] and doing == QUEUEING:
            self.volts[row] = min(self._section.full_v, self.volts[row] + self._gained_v)
            self._charging[row] = self.volts[row] < self._section.full_v
        else:
            self.volts[row] = max(0.0, self.volts[row] - self._spent_v[doing])
            self._charging[row] = False

    def dock(self, row: int) -> None:
        """A robot at its place in the queue is given a full battery, or is charged while it stays."""
        if self._section.charge_s == 0:
            self.refill(row)
        else:
            self._charging[row] = self.volts[row] < self._section.full_v

    def undock(self, row: int) -> None:
        """The robot is told to do something else: charging ends."""
        self._charging[row] = False

    def refill(self, row: int) -> None:
        """A full battery at once."""
        self.volts[row], self._charging[row] = self._section.full_v, False

    def is_empty(self, row: int) -> bool:
        """Has this robot come to its end of charge?"""
        return self.volts[row] <= self._section.empty_v
