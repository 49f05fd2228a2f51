"""What tests of the chain share: who is connected, and a world small enough for fields of any shape."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from swarm_agent.behaviour import Heard
from swarm_agent.behaviours.chain_connected import ChainConnected, ChainConnectedParameters
from swarm_agent.knowledge import AssumedIdleness, Bulletin
from tests.builders import configuration, percept
from wire.messages import Facts

Point = tuple[float, float]


def connected(places_m: Iterable[Point], range_m: float) -> set[int]:
    """The rows that the first one reaches over any number of hops."""
    places = list(places_m)
    reached, ahead = {0}, [0]
    while ahead:
        here = ahead.pop()
        near = {row for row, place in enumerate(places) if math.dist(place, places[here]) <= range_m}
        ahead += near - reached
        reached |= near
    return reached


def cut_off(facts: Facts, range_m: float = 180.0) -> set[int]:
    """The rows of living robots that have no connection to the tower in row 0 at the end of a tick."""
    poses = np.frombuffer(facts.poses).reshape(-1, 3)
    alive = [row for row, mode in enumerate(facts.modes) if mode == 0]
    reached = connected([tuple(poses[row, :2]) for row in alive], range_m)
    return {row for place, row in enumerate(alive) if place not in reached}


def newborn(node: str = "r3", field: Any = None, **parameters: Any) -> ChainConnected:
    """A robot that knows nothing yet."""
    told = configuration(node, "chain_connected", **({} if field is None else {"field": field}))
    generator = np.random.Generator(np.random.Philox(1))
    return ChainConnected(ChainConnectedParameters(**parameters), told, generator)


class Course:
    """Robots r2, r3, ... that go straight from site to site, and a tower at the origin."""

    def __init__(self, field: Any, robots: int, range_m: float, **parameters: Any) -> None:
        self.range_m, self.tick = range_m, 0
        names = [f"r{number}" for number in range(2, robots + 2)]
        self.robots = {name: newborn(name, field, range_m=range_m, **parameters) for name in names}
        self.places_m: dict[str, Point] = {"r1": (0.0, 0.0)} | dict.fromkeys(names, (0.0, 0.0))
        self.known = AssumedIdleness(len(field.sites_m()))
        self.said: dict[str, Bulletin] = {}

    def advance(self, ticks: int) -> int:
        """Let time pass. Returns in how many ticks somebody had no connection to the tower."""
        broken = 0
        for _ in range(ticks):
            heard = {name: self._inbox(name) for name in self.places_m}
            self.known.merge(*[one.message.news for one in heard["r1"]])
            self.said = {"r1": Bulletin(self.known.newest(len(self.known.visited_tick)))} | {
                name: self._step(one, heard[name]) for name, one in self.robots.items()
            }
            self.tick += 1
            broken += len(connected(self.places_m.values(), self.range_m)) < len(self.places_m)
        return broken

    def _inbox(self, name: str) -> list[Heard]:
        here_m = self.places_m[name]
        return [
            Heard(other, self.tick - 1, bulletin)
            for other, bulletin in self.said.items()
            if other != name and math.dist(self.places_m[other], here_m) <= self.range_m
        ]

    def _step(self, robot: ChainConnected, heard: list[Heard]) -> Bulletin:
        name = robot.configuration.node
        here_m = self.places_m[name]
        move = robot.step(percept(self.tick, *here_m), heard)
        there_m = robot.points_m[robot.next]
        far_m, step_m = math.dist(here_m, there_m), robot.configuration.max_speed_m_s
        share = min(1.0, step_m / far_m) if far_m else 0.0
        self.places_m[name] = tuple(a + share * (b - a) for a, b in zip(here_m, there_m, strict=True))
        return move.say[0]


def ring(parents: Mapping[str, str | None]) -> bool:
    """Does somebody hang on itself, over however many others?"""
    for name in parents:
        seen, above = {name}, parents[name]
        while above in parents:
            if above in seen:
                return True
            seen.add(above)
            above = parents[above]
    return False
