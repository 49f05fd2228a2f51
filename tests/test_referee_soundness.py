"""No intruder, however fast, is ever where the referee says that none can be.

Intruders go along the edges of a random graph of points, as far as they like at every quarter of a tick, but
only where the robots do not see them just then. What robots see is worked out by tests/plan_oracle.py.
"""

import itertools
import math
from typing import NamedTuple

import networkx as nx
import numpy as np
import pytest
import shapely

from tests.plan_oracle import seen
from world_server import chance
from world_server.random_plans import random_plan
from world_server.referee import Referee, living

DETECT_M, STEP_M, NEIGHBOUR_M = 1.5, 0.3, 1.2  # sees across a corridor and most rooms
POINTS, INTRUDERS, ROBOTS, TICKS = 80, 100, 2, 20
PLANS = [(1, (2, 1), 0), (2, (1, 3), 0), (3, (2, 2), 0), (4, (2, 2), 1), (5, (2, 1), 0)]
PLANS += [(6, (2, 2), 1), (7, (3, 1), 0), (8, (2, 2), 1), (9, (1, 2), 0), (10, (2, 1), 0)]


class Robot(NamedTuple):
    """Where one is and where it heads; a dead one stays."""

    place_m: tuple[float, float]
    heading: float
    alive: bool = True


class Hunt:
    """Robots that walk, sometimes jump and sometimes die, and the intruders that are left."""

    def __init__(self, seed: int, rooms: tuple[int, int], islands: int) -> None:
        self.chance = chance.generator(seed, "hunt")
        self.plan = random_plan(seed, rooms, islands)
        self.within = self.plan.buffer(-0.2)
        self.points = self.places(POINTS)
        pairs = [
            (one, other)
            for one, other in itertools.combinations(range(POINTS), 2)
            if math.dist(self.points[one], self.points[other]) < NEIGHBOUR_M
        ]
        lines = shapely.linestrings([[self.points[one], self.points[other]] for one, other in pairs])
        free = shapely.covers(self.plan, lines)
        self.lines, self.pairs = (
            lines[free],
            [pair for pair, is_free in zip(pairs, free, strict=True) if is_free],
        )
        self.at = self.chance.integers(POINTS, size=INTRUDERS)
        start = max(self.places(8), key=self.pieces_left)
        self.robots = [Robot(start, 2 * math.pi * number / ROBOTS) for number in range(ROBOTS)]

    def pieces_left(self, place: tuple[float, float]) -> int:
        """Into how many pieces a robot at a place cuts the plan."""
        return len(shapely.get_parts(self.plan.difference(seen(self.plan, place, DETECT_M))))

    def begin_in(self, contaminated: shapely.Geometry) -> None:
        """All intruders begin there, so that the robots have something to lose."""
        self.at = self.at[shapely.intersects(contaminated, shapely.points(self.points)[self.at])]
        self.at = self.chance.choice(self.at, INTRUDERS)

    def places(self, number: int) -> list[tuple[float, float]]:
        """Random places where robots can be."""
        west, south, east, north = self.plan.bounds
        found = []
        while len(found) < number:
            place = (self.chance.uniform(west, east), self.chance.uniform(south, north))
            found += [place] if shapely.contains_xy(self.within, *place) else []
        return found

    def moved(self, robot: Robot) -> Robot:
        """One tick later: a jump, a death, a new life, or a step."""
        what = self.chance.random()
        if what < 0.02:
            return robot._replace(place_m=self.places(1)[0])
        if what < 0.04 or not robot.alive:
            return robot._replace(alive=not robot.alive)
        heading = robot.heading + self.chance.normal(0, 0.2)
        x_m, y_m = robot.place_m
        ahead = (x_m + STEP_M * math.cos(heading), y_m + STEP_M * math.sin(heading))
        if shapely.contains_xy(self.within, *ahead):
            return Robot(ahead, heading)
        return Robot(robot.place_m, self.chance.uniform(0, 2 * math.pi))

    def flee(self, robots: list[Robot], later: list[Robot]) -> None:
        """Intruders that are seen are out; the others go anywhere, unseen, at each quarter of the tick."""
        for share in (0.0, 0.25, 0.5, 0.75, 1.0):
            sights = [
                seen(self.plan, place_m, DETECT_M)
                for before, after in zip(robots, later, strict=True)
                if (place_m := between(before, after, share)) is not None
            ]
            lit = shapely.union_all(sights)
            shapely.prepare(lit)
            graph = nx.Graph()
            graph.add_nodes_from(range(POINTS))
            dark = ~shapely.intersects(lit, self.lines)
            graph.add_edges_from(itertools.compress(self.pairs, dark))
            unseen = ~shapely.intersects(lit, shapely.points(self.points))
            self.at = self.at[unseen[self.at]]
            pieces = {one: sorted(piece) for piece in nx.connected_components(graph) for one in piece}
            self.at = np.array([self.chance.choice(pieces[one]) for one in self.at], dtype=int)


def between(before: Robot, after: Robot, share: float) -> tuple[float, float] | None:
    """Where a robot watches in the course of a tick. Who jumps, dies or awakes watches at its ends only."""
    whole = before.alive and after.alive and math.dist(before.place_m, after.place_m) <= STEP_M + 1e-9
    if share == 0:
        return before.place_m if before.alive else None
    if share == 1:
        return after.place_m if after.alive else None
    if not whole:
        return None
    (x_m, y_m), (later_x_m, later_y_m) = before.place_m, after.place_m
    return (x_m + share * (later_x_m - x_m), y_m + share * (later_y_m - y_m))


def hunted(referee_type, seed: int, rooms: tuple[int, int], islands: int) -> tuple[float, float, int]:
    """The most that was clear out of sight, how far an intruder was off contamination, how many are left."""
    hunt = Hunt(seed, rooms, islands)
    robots = hunt.robots
    referee = referee_type(hunt.plan, DETECT_M, [one.place_m for one in robots], [True] * ROBOTS)
    referee.contaminated = max(shapely.get_parts(referee.contaminated), key=shapely.area)
    hunt.begin_in(referee.contaminated)
    held_m2, astray_m = 0.0, 0.0
    for _ in range(TICKS):
        later = [hunt.moved(robot) for robot in robots]
        hunt.flee(robots, later)
        places, lives = zip(*[(one.place_m, one.alive) for one in robots], strict=True)
        later_places, later_lives = zip(*[(one.place_m, one.alive) for one in later], strict=True)
        referee.step(places, later_places, lives, later_lives)
        robots = later
        left = shapely.points(hunt.points)[hunt.at]
        astray_m = max(astray_m, shapely.distance(referee.contaminated, left).max(initial=0.0))
        lit = [seen(hunt.plan, one.place_m, DETECT_M) for one in robots if one.alive]
        held_m2 = max(held_m2, hunt.plan.difference(shapely.union_all([referee.contaminated, *lit])).area)
    return held_m2, astray_m, len(hunt.at)


class Forgetful(Referee):
    """A wrong referee: what was once seen is clear for ever."""

    def step(self, before_m, after_m, alive_before, alive_after):
        lit = self._seen_from(living(after_m, alive_after))
        self.contaminated = self.contaminated.difference(lit)


@pytest.mark.parametrize(("seed", "rooms", "islands"), PLANS)
def test_no_intruder_is_where_the_exact_referee_says_that_none_can_be(seed, rooms, islands):
    _, astray_m, _ = hunted(Referee, seed, rooms, islands)
    assert astray_m < 1e-5


@pytest.mark.parametrize(("seed", "rooms", "islands"), PLANS[:4])
def test_nothing_that_is_contaminated_stops_being_so_unseen(seed, rooms, islands):
    hunt = Hunt(seed, rooms, islands)
    robots = hunt.robots
    referee = Referee(hunt.plan, DETECT_M, [one.place_m for one in robots], [True] * ROBOTS)
    for _ in range(TICKS):
        later, before = [hunt.moved(robot) for robot in robots], referee.contaminated
        places, lives = zip(*[(one.place_m, one.alive) for one in robots], strict=True)
        referee.step(places, [one.place_m for one in later], lives, [one.alive for one in later])
        lit = shapely.union_all([seen(hunt.plan, one.place_m, DETECT_M) for one in later if one.alive])
        vanished = before.difference(shapely.union_all([referee.contaminated, lit]))
        assert vanished.area < 1e-5, "sight reaches a millionth of a metre into walls"
        robots = later


def test_the_hunt_holds_ground_and_finds_a_wrong_referee():
    held_m2, astray_m, left = hunted(Forgetful, *PLANS[2])
    assert held_m2 > 1.0 and left > INTRUDERS / 2
    assert astray_m > 1.0
