"""Small worlds in which sweep robots really run: rehearsed, looked at after every tick, and judged."""

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from deploy.rehearsal import rehearse
from deploy.scenario_file import to_toml
from swarm_agent.behaviours.sweep_line import SweepLine
from swarm_agent.sweep.geometry import nearest
from swarm_agent.sweep.radio import WALL
from swarm_agent.sweep.robot import Robot
from tests.clear_builders import places_m, sweeping
from wire.channels import number_of
from wire.fields import Point
from wire.messages import Facts, Senses
from wire.scenario import Poses, Scenario

MET_TICK = 4
"""By then all have heard each other twice and know how their frames are turned; nobody has begun yet."""
BREACH_M2 = 1e-6
Robots = dict[int, Robot]


class Play:
    """A run, as far as it has come. `robots`: those that live, by number; `said`: (tick, number, event)."""

    def __init__(self) -> None:
        self.tick = -1
        self.facts: list[Facts] = []
        self.minds: dict[int, SweepLine] = {}
        self.senses: dict[int, Senses] = {}
        self.said: list[tuple[int, int, str]] = []
        self.seen: dict[str, int] = {}
        """When something was first the case."""
        self.when: dict[tuple, int] = {}
        """The same, of whatever a test likes to know."""

    @property
    def robots(self) -> Robots:
        return {number: mind.robot for number, mind in self.minds.items()}

    @property
    def places(self) -> dict[int, complex]:
        """Where robots are, by number: r2 stands in the second row."""
        return {row + 1: complex(*place) for row, place in enumerate(places_m(self.facts[-1]).tolist())}

    def note(self, what: str, holds: Any) -> bool:
        """Remember the first tick in which something holds."""
        if holds:
            self.seen.setdefault(what, self.tick)
        return bool(holds)

    def told(self, event: str) -> list[int]:
        """The ticks in which that event was told."""
        return [tick for tick, _, one in self.said if one == event]

    def breaches(self) -> list[tuple[int, float]]:
        """Ticks, kills apart, in which held ground became contaminated that nobody had in sight before."""
        lost = []
        for one in self.facts:
            said = one.clearing
            lost.append((one.tick, said.lost_m2 - said.given_up_m2 - said.ahead_m2, one.faults))
        return [(tick, lost_m2) for tick, lost_m2, faults in lost if lost_m2 > BREACH_M2 and not faults]

    def line(self) -> list[int]:
        """The robots of the main line from left to right, as each believes who is on its right."""
        on_main = {number: robot for number, robot in self.robots.items() if robot.is_main}
        ends = [number for number, robot in on_main.items() if robot.beside["left"] == WALL]
        found = ends[:1]
        while found and (right := on_main[found[-1]].beside["right"]) in on_main and right not in found:
            found.append(right)
        return found


def play(given: Scenario, last_tick: int, watch: Callable[[Play], bool | None]) -> Play:
    """Rehearse; `watch` sees the play after every tick and ends it with True."""
    course = Play()

    def look(commit, swarm) -> None:
        course.tick = commit.tick
        course.facts.append(commit.facts)
        course.minds = {
            number_of(node): mind._behaviour
            for node, mind in swarm._minds.items()
            if isinstance(mind._behaviour, SweepLine)
        }
        course.senses = {number_of(grant.node): grant.senses for grant in commit.grants}
        for number, robot in course.robots.items():
            course.said += [(commit.tick, number, event) for event in robot.events]
        swarm.finishing = bool(watch(course))

    with tempfile.TemporaryDirectory() as folder:
        rehearse(given, to_toml(given), Path(folder), last_tick, look, journalled=False)
    return course


def in_line(
    rings_m: tuple[tuple[Point, ...], ...], line_m: Sequence[Point], others_m: Sequence[Point] = (), **fields
) -> Scenario:
    """A scenario in which robots r2, r3, ... stand at these places, the first of them on a line."""
    places = [(x_m, y_m, 0.0) for x_m, y_m in (*line_m, *others_m)]
    return sweeping(len(places), rings_m=rings_m, start=Poses(tuple(places)), **fields)


def column(x_m: float, width_m: float, count: int, wall_m: float = 0.25) -> list[Point]:
    """Places of a line across a corridor, from its left end to its right one, equally far apart."""
    return [(x_m, y_m) for y_m in np.linspace(width_m - wall_m, wall_m, count).tolist()]


def lined_up(course: Play, count: int, at_tick: int = MET_TICK) -> None:
    """The first robots become a line, from left to right, the others its reserve, when all have met."""
    if course.tick != at_tick:
        for robot in course.robots.values() if course.tick < at_tick else ():
            robot.born = robot.tick
        return
    for number, mind in course.minds.items():
        robot, last = mind.robot, count + 1
        if number > last:
            robot.become("reserve")
            mind.reserve.begin(robot)
            continue
        robot.become("centre" if 2 < number < last else "leader")
        robot.beside = {
            "left": number - 1 if number > 2 else WALL,
            "right": number + 1 if number < last else WALL,
        }
        robot.since = robot.moved = robot.tick
        if robot.role == "leader":
            robot.contact = nearest(robot.hits, robot.here)
    course.robots[count + 1].graph.begin(count)


def apart_m(places: dict[int, complex], line: Sequence[int]) -> np.ndarray:
    """How far neighbours of a line are apart."""
    return np.abs(np.diff([places[number] for number in line]))
