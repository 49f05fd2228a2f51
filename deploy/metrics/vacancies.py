"""Segments that nobody patrols, and how long it takes until they are covered again.

Source: papers/line-patrol.txt, section III-B: after a robot leaves, a segment is back at its visit frequency
when another has traversed it whole, T to 3 T later; T is the time for one segment, one way.

A vacancy begins when a segment's last patrolling robot leaves it, dies or goes flat. It is covered at the
first tick at which one robot has visited one end, the middle and the other end, in this order, all after the
vacancy began; its lap is complete when one robot has done so twice. While a vacancy is not covered no other
begins on its segment. Who merely passes on the way to somewhere else covers nothing: only visits of robots
that say they patrol the segment, or are on their way to it, are taken in.
"""

from typing import Literal

Cause = Literal["recall", "shift", "death", "flat"]
MID = 1
"""The place of a segment's middle among its three sites; the others are its ends."""


class Vacancy:
    """One time without a patrol on a segment; `filled_by` is the robot that first traversed it whole."""

    def __init__(self, segment: int, cause: Cause, began_tick: int) -> None:
        self.segment, self.cause, self.began_tick = segment, cause, began_tick
        self.covered_tick: int | None = None
        self.lap_tick: int | None = None
        self.filled_by: str | None = None
        self._courses: dict[str, _Course] = {}

    def visit(self, tick: int, robot: str, place: int) -> None:
        """Take in a visit of one of the segment's sites."""
        if tick <= self.began_tick or self.lap_tick is not None:
            return
        course = self._courses.setdefault(robot, _Course())
        if not course.visit(place):
            return
        if self.covered_tick is None:
            self.covered_tick, self.filled_by = tick, robot
        if course.traverses == 2:
            self.lap_tick = tick


class Vacancies:
    """All vacancies of a run, in the order in which they began."""

    def __init__(self) -> None:
        self.all: list[Vacancy] = []
        self._open: dict[int, list[Vacancy]] = {}

    def begin(self, segment: int, cause: Cause, tick: int) -> None:
        """Nobody patrols a segment any more."""
        still_open = self._open.setdefault(segment, [])
        if all(one.covered_tick is not None for one in still_open):
            vacancy = Vacancy(segment, cause, tick)
            self.all.append(vacancy)
            still_open.append(vacancy)

    def visit(self, tick: int, robot: str, site: int) -> None:
        """Take in a true visit."""
        segment = segment_of(site)
        if not self._open.get(segment):
            return
        for one in self._open[segment]:
            one.visit(tick, robot, site % 3)
        self._open[segment] = [one for one in self._open[segment] if one.lap_tick is None]

    def recovery_ticks(self) -> list[int]:
        """From the beginning of each vacancy that was covered to the end of the first complete traverse."""
        return [one.covered_tick - one.began_tick for one in self.all if one.covered_tick is not None]

    def recovery_full_lap_ticks(self) -> list[int]:
        """From the beginning of each vacancy to the end of the first complete lap, there and back."""
        return [one.lap_tick - one.began_tick for one in self.all if one.lap_tick is not None]


def segment_of(site: int) -> int:
    """The number of the segment that a site belongs to."""
    return site // 3 + 1


class _Course:
    """How far one robot has come in traversing a segment."""

    def __init__(self) -> None:
        self.traverses = 0
        self._from: int | None = None
        self._past_mid = False

    def visit(self, place: int) -> bool:
        """Does this visit complete a traverse?"""
        if place == MID:
            self._past_mid = self._from is not None
            return False
        whole = self._past_mid and place != self._from
        self._from, self._past_mid = place, False
        self.traverses += whole
        return whole
