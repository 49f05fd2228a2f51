"""Behaviours for tests of mission clear: they go about by what they sense and say what they know."""

from collections.abc import Sequence

import msgspec
import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from wire.clearing import Standing
from wire.messages import Percept, Shift


class Hello(msgspec.Struct, frozen=True, array_like=True):
    """What they say to each other."""

    odometry_m: tuple[float, float]


class WandererParameters(Parameters, frozen=True):
    """`claim_tick`: when the first robot claims that it is done. `roles`: of robots, by their ids."""

    follow_m: float = 1.0
    obstacle_m: float = 0.25
    step_m: float = 0.05
    claim_tick: int = -1
    releasing: bool = False
    roles: dict[str, str] = {}
    events: dict[str, tuple[str, ...]] = {}


class Wandering(Behaviour):
    """Drives straight until something is near, then anywhere; never stands still for long."""

    Parameters = WandererParameters
    Radio = Hello

    def __init__(self, parameters, configuration, generator) -> None:
        super().__init__(parameters, configuration, generator)
        self.angle_rad = 0.0

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Turn where it does not go on; say how far it came."""
        senses, wish = percept.senses, self.parameters
        scan_m = np.frombuffer(senses.scan, "<f4")
        near = bool(len(scan_m)) and scan_m.min() < wish.obstacle_m
        if near or any(one.range_m < 0.4 for one in heard) or percept.tick % 40 == 0:
            self.angle_rad = float(np.round(self.generator.random() * 2 * np.pi, 6))
        way = Shift(float(wish.step_m * np.cos(self.angle_rad)), float(wish.step_m * np.sin(self.angle_rad)))
        node = self.configuration.node
        claim = "done" if percept.tick == wish.claim_tick else ""
        events = wish.events.get(f"{node}@{percept.tick}", ())
        standing = Standing(
            wish.roles.get(node, ""), 1, True, claim=claim, releasing=wish.releasing, events=events
        )
        return Move(way, (Hello(senses.odometry_m),), percept.tick + 1, report=standing)
