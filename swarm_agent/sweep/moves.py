"""Which steps a robot may take without opening a barrier or coming too near to others and to walls."""

import cmath
import math
from collections.abc import Iterator

import numpy as np

from swarm_agent.sweep import robust
from swarm_agent.sweep.geometry import shortened
from swarm_agent.sweep.knots import is_crossed, turns_over
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import Side
from swarm_agent.sweep.robot import Robot

BODY_M, FALLEN_M = (
    0.03,
    0.08,
)  # room that robots leave between each other, and to the dead, who may have moved
WALL_M = 0.13  # and to walls
TURNS_DEG = (0, 30, -30, 60, -60, 85, -85)
LEAST_M = 0.004


def may(robot: Robot, way: complex, holds: bool = True, wall_m: float = WALL_M) -> bool:
    """May it go that way: no link opens (where it `holds` any), and nobody and no wall is in the way?"""
    there = robot.here + way
    if holds and not _holds_there(robot, there):
        return False
    if len(robot.hits):
        wall_there_m = float(np.abs(robot.hits - there).min())
        if wall_there_m < wall_m and wall_there_m < float(np.abs(robot.hits - robot.here).min()):
            return False
    for body, room_m in _bodies(robot):
        if abs(body - there) < min(robot.body_m + room_m, abs(body - robot.here)):
            return False
    return True


def best(robot: Robot, way: complex, holds: bool = True, wall_m: float = WALL_M) -> complex:
    """What it may do that is nearest to a wanted way; nothing where all is barred."""
    way = shortened(way, robot.step_m)
    for size in (1.0, 0.5):
        for turn_deg in TURNS_DEG:
            turn = math.radians(turn_deg)
            some = way * size * math.cos(turn) * cmath.exp(1j * turn)
            if abs(some) > LEAST_M and may(robot, some, holds, wall_m):
                return some
    return 0j


def toward(robot: Robot, place: complex) -> complex:
    """A step to a place, around what is in the way, of one who holds no link."""
    return best(robot, shortened(place - robot.here, robot.step_m), holds=False)


def _holds_there(robot: Robot, there: complex) -> bool:
    """Would all its links hold there?

    Whoever is linked may move at the same time, and may have moved since it was heard. Where a margin is too
    small for that, it may only grow.
    """
    for peer, side in _linked(robot):
        margin_m = robot.link_m(peer, side, there)
        if margin_m < robot.needed_m(peer) and margin_m < robot.link_m(peer, side) + 1e-6:
            return False
        if turns_over(robot, peer, there):
            return False
    if is_crossed(robot, there) and not is_crossed(robot, robot.here):
        return False
    return not robot.is_robust or robust.may(robot, there)


def _linked(robot: Robot) -> Iterator[tuple[Peer, Side]]:
    """Everybody whose link it must not open."""
    sides = {number: side for side, number in robot.beside.items() if number > 0} | robot.old
    for number, side in sides.items():
        peer = robot.peer(number)
        if peer is not None:
            yield peer, side


def _bodies(robot: Robot) -> Iterator[tuple[complex, float]]:
    """Where others are, and where the dead lie, and how much room to leave to them."""
    for peer in robot.peers.known.values():
        yield peer.here, BODY_M
    for place in robot.fallen:
        yield place, FALLEN_M
