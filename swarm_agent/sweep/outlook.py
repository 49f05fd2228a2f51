"""What a robot on a line has ahead of it: its frontier, its own wall, and obstacles.

Ahead is the contaminated side: clockwise from the way to its left neighbour, or wall, to its right one. A
frontier is where what it sees ends without a wall and nobody of its line sees on. A line without frontier has
nothing ahead that an intruder could be in.

Source: frontiers are those of Durham, Franchi and Bullo, 2012; the paper's robots have none.
"""

import math
from collections.abc import Container, Iterator
from typing import NamedTuple

import numpy as np

from swarm_agent.sweep import robust
from swarm_agent.sweep.geometry import JOINED_M, crossed, shortened, turn_rad, unit
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import BARRIER, SIDES, WALL, Side
from swarm_agent.sweep.robot import Robot

BETWEEN = np.array([0.2, 0.4, 0.6, 0.8])
CONTACT_M = 0.02
PROBED_M = 0.5  # a robot that searches takes a wall for an obstacle from so far away
ASKEW = 0.2
CORNER_M = 0.03  # a corner of 46 degrees just out of reach has rays on both sides that end so far before it


class Outlook(NamedTuple):
    """The rays ahead, clockwise: where they end, whether at a wall, which wall is the leader's own, and which
    of them are frontier. `ways`: to what is on the left and on the right.
    """

    ends: np.ndarray
    walls: np.ndarray
    own: np.ndarray
    frontier: np.ndarray
    ways: dict[Side, complex]


def look(robot: Robot) -> Outlook:
    """What it has ahead now."""
    ways = {side: _way(robot, side) for side in SIDES}
    rays, eye = robot.eye.rays, robot.eye
    count = round(turn_rad(ways["left"], ways["right"], "right") / math.tau * rays)
    ahead = (eye.ray(ways["left"]) - np.arange(count + 1)) % rays
    ranges_m = robot.ranges_m[ahead]
    walls = np.isfinite(ranges_m)
    ends = robot.here + np.where(walls, ranges_m, eye.detect_m) * eye.units[ahead]
    own = _own_wall(robot, ends, walls, eye.units[ahead], ways)
    if robot.is_robust:
        own |= robust.leaders_walls(robot)[ahead]
    return Outlook(ends, walls, own, _frontier(robot, ends, walls, {robot.line}), ways)


def is_closed_to(robot: Robot, outlook: Outlook, peer: Peer, side: Side) -> bool:
    """Is nothing between the wall of a leader and a robot of another line that neither line sees?"""
    turned = turn_rad(outlook.ways["left"], peer.here - robot.here, "right") / math.tau
    ray = round(turned * robot.eye.rays)
    if ray >= len(outlook.ends):
        return False
    frontier = _frontier(robot, outlook.ends, outlook.walls, {robot.line, peer.beacon.line})
    return not (frontier[:ray] if side == "left" else frontier[ray:]).any()


def _frontier(robot: Robot, ends: np.ndarray, walls: np.ndarray, lines: Container[int]) -> np.ndarray:
    """Which rays end where nobody of some lines sees on, or so far away that a corner may be behind."""
    near = walls & (np.abs(ends - robot.here) <= robot.eye.detect_m - CORNER_M)
    frontier = ~near & ~_covered(robot, ends, lines)
    jumps = np.abs(np.diff(ends)) > JOINED_M
    for ray in np.flatnonzero(jumps & (walls[1:] | walls[:-1])):
        if not _covered(robot, ends[ray] + BETWEEN * (ends[ray + 1] - ends[ray]), lines).all():
            frontier[ray] = True
    return frontier


def obstacle(robot: Robot, outlook: Outlook) -> complex | None:
    """The nearest place of a wall ahead, not the leader's own, too near to it or to its half of a link."""
    found = np.flatnonzero(outlook.walls & ~outlook.own)
    if not len(found):
        return None
    places = outlook.ends[found]
    if robot.is_robust:
        places = places[robust.are_ahead(robot, places)]
        if not len(places):
            return None
    gaps = np.abs(places - robot.here)
    for side in SIDES:
        peer = robot.neighbour(side)
        if peer is not None:
            half = shortened(outlook.ways[side], abs(peer.here - robot.here) / 2)
            share = np.clip(
                ((places - robot.here) * half.conjugate()).real / max(abs(half) ** 2, 1e-12), 0, 1
            )
            gaps = np.minimum(gaps, np.abs(places - robot.here - share * half))
    nearest = int(gaps.argmin())
    searches = robot.order > 0 and robot.order == robot.place
    within_m = PROBED_M if searches else robot.parameters.obstacle_m + CONTACT_M
    return complex(places[nearest]) if gaps[nearest] <= within_m else None


def sides_open(outlook: Outlook, wall: complex) -> tuple[bool, bool]:
    """Is there any frontier to the left, and to the right, of a place of a wall ahead?"""
    away = np.where(outlook.walls, np.abs(outlook.ends - wall), np.inf)
    ray = int(away.argmin())
    return bool(outlook.frontier[:ray].any()), bool(outlook.frontier[ray:].any())


def _way(robot: Robot, side: Side) -> complex:
    if robot.beside[side] == WALL:
        return robot.contact - robot.here
    peer = robot.neighbour(side)
    return robot.toward(peer, side) if peer is not None else 1 + 0j


def _covered(robot: Robot, places: np.ndarray, lines: Container[int]) -> np.ndarray:
    """Which places are seen by somebody else on one of some lines, or are behind such a line."""
    covered = np.zeros(len(places), dtype=bool)
    for peer in robot.peers.known.values():
        if (
            peer.beacon.role in BARRIER
            and peer.beacon.line in lines
            and abs(peer.here - robot.here) < 2 * robot.eye.detect_m
        ):
            covered |= peer.sees(places)
            if covered.all():
                return covered
            for start, end in _barriers(robot, peer):
                covered |= crossed(robot.here, places, start, end)
    return covered


def _barriers(robot: Robot, peer: Peer) -> Iterator[tuple[complex, complex]]:
    """The parts of a line between a robot and who is on its right, and between a leader and its wall."""
    right = robot.peer(peer.beacon.right)
    if right is not None and right.beacon.left == peer.number:
        yield peer.here, right.here
    if peer.beacon.role == "leader":
        yield peer.here, peer.wall


def _own_wall(
    robot: Robot, ends: np.ndarray, walls: np.ndarray, units: np.ndarray, ways: dict[Side, complex]
) -> np.ndarray:
    """Which rays end at the wall that a leader follows: all from its contact on, without a jump."""
    own = np.zeros(len(ends), dtype=bool)
    if robot.role != "leader":
        return own
    side = robot.wall_side()
    last = -1
    for ray in range(len(ends)) if side == "left" else range(len(ends) - 1, -1, -1):
        if not walls[ray]:
            if last < 0 and abs(units[ray] - unit(ways[side])) < ASKEW:
                continue
            break
        if last >= 0 and abs(ends[ray] - ends[last]) > JOINED_M:
            break
        own[ray], last = True, ray
    return own
