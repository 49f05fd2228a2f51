"""Charge: what robots lose by what the world sees them do, and what they gain at their place in the queue."""

from collections.abc import Sequence

import numpy as np

from wire.channels import number_of
from wire.scenario import BatterySection
from world_server.chance import generator

SECONDS_PER_HOUR = 3600.0


class Batteries:
    """The batteries of all robots, in order of their numbers. `volts`: float64 per robot."""

    def __init__(self, section: BatterySection, robots: Sequence[str], seed: int, tick_s: float) -> None:
        self._section = section
        hours = tick_s / SECONDS_PER_HOUR
        self._patrolling_v = section.patrolling_v_h * hours
        self._travelling_v = section.travelling_v_h * hours
        self._queueing_v = section.queueing_v_h * hours
        span_v = section.full_v - section.empty_v
        self._charge_v = span_v * tick_s / section.charge_s if section.charge_s else span_v
        draws = [generator(seed, "battery", number_of(robot)).standard_normal() for robot in robots]
        self.volts = section.full_v - section.start_sd_v * np.abs(np.array(draws))
        self._charging = np.zeros(len(robots), dtype=bool)
        self._empty = self.volts <= section.empty_v

    def use(self, queueing: np.ndarray, patrolling: np.ndarray, dead: np.ndarray) -> list[int]:
        """One tick of what each robot does: masks, the first that holds counts, else it travels.

        Returns the rows whose batteries have just become empty.
        """
        spent_v = np.where(patrolling, self._patrolling_v, self._travelling_v)
        spent_v = np.where(queueing, self._queueing_v, spent_v)
        if self._charging.any():
            self._charging &= queueing & ~dead
            spent_v[self._charging] = -self._charge_v
        spent_v[dead] = 0.0
        self.volts = np.clip(self.volts - spent_v, 0.0, self._section.full_v)
        self._charging &= self.volts < self._section.full_v
        empty = self.volts <= self._section.empty_v
        new = empty & ~self._empty
        self._empty = empty
        return np.flatnonzero(new).tolist() if new.any() else []

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
        self._empty[row] = False

    def is_empty(self, row: int) -> bool:
        """Has this robot come to its end of charge?"""
        return bool(self._empty[row])
