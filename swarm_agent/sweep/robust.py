"""Lines that hold without any one of their robots (`spacing = "robust"`); that costs more robots.

Each robot is linked to its neighbours and to those beyond them, so when one falls silent the barrier is
there already, before anybody has noticed. Who stands beside a leader is its shadow: it holds a place of the
leader's wall, too. All this binds every step, with the age of what is known of others.
"""

import math

import numpy as np

from swarm_agent.sweep.geometry import clearance_m, nearest, one_wall, ray_ends, turn_rad
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import BARRIER, OTHER, SIDES, WALL, Side
from swarm_agent.sweep.robot import Robot

PAIR_M = 0.62  # two leaders who wait for a third robot go no farther apart
WALL_NEAR_M = 0.2  # a leader's next contact is no farther from the one before
AT_WALL_M, EDGE_M = 0.08, 0.015  # so near to its end a wall bars no view of it, else so near to the view
NONE_M = -9.0  # the margin of what is not seen at all


def beyond(robot: Robot, side: Side) -> Peer | None:
    """Who stands beyond the neighbour on a side."""
    beside = robot.neighbour(side)
    number = beside.beacon.beside(side) if beside else 0
    return robot.peer(number) if number > 0 and number != robot.number else None


def shadowed(robot: Robot, side: Side) -> Peer | None:
    """The leader beside it on a side, whose wall it is to hold, too."""
    beside = robot.neighbour(side)
    if beside is None or beside.beacon.role != "leader" or beside.beacon.beside(side) != WALL:
        return None
    return beside


def watch(robot: Robot) -> None:
    """Take over whom and which walls it holds beyond its neighbours; the old until the new are agreed on."""
    for side in SIDES:
        leader = shadowed(robot, side)
        if leader is None:
            if robot.neighbour(side) is not None or robot.beside[side] == WALL:
                robot.held.pop(side, None)
        elif robot.sees(leader.contact):
            robot.held[side] = leader.contact
    now = {one.number: side for side in SIDES if (one := beyond(robot, side)) and counts(one)}
    kept = {
        number: side
        for number, side in robot.second.items()
        if number not in robot.beside.values() and not _is_agreed(robot, number, side)
    }
    robot.second = kept | now


def counts(peer: Peer) -> bool:
    """Is it on a line, or coming in?"""
    return peer.beacon.role in BARRIER or peer.beacon.role == "joining"


def _is_agreed(robot: Robot, number: int, side: Side) -> bool:
    """Do all see the chain on that side as it is without that robot?"""
    peer, beside = robot.peer(number), robot.neighbour(side)
    if peer is None or peer.beacon.role not in BARRIER or robot.beside[side] == WALL:
        return True
    if beside is None or beside.beacon.beside(OTHER[side]) != robot.number:
        return False
    if beside.beacon.beside(side) == WALL:
        return True
    last = robot.peer(beside.beacon.beside(side))
    return (
        last is not None and last.beacon.role in BARRIER and last.beacon.beside(OTHER[side]) == beside.number
    )


def may(robot: Robot, there: complex) -> bool:
    """May it stand there: do links to second neighbours hold, and do two see each leader's wall?

    What does not hold yet may only become better: so a line that would not hold without one goes nowhere.
    """
    for number, side in robot.second.items():
        peer = robot.peer(number)
        if peer is None:
            continue
        needed_m = robot.step_m * (robot.tick - peer.tick)
        margin_m = robot.link_m(peer, side, there)
        if margin_m < needed_m and margin_m < robot.link_m(peer, side) + 1e-6:
            return False
    if robot.role == "leader":
        other = shadowed(robot, OTHER[robot.wall_side()])
        if other is not None:
            return abs(other.here - there) <= max(PAIR_M, abs(other.here - robot.here) - 1e-6)
        if not _may_lead(robot, there):
            return False
    return all(_keeps_wall(robot, side, there) for side in SIDES)


def _may_lead(robot: Robot, there: complex) -> bool:
    """Would its shadow see the wall that it holds there, as well as it sees this one?"""
    shadow = robot.neighbour(OTHER[robot.wall_side()])
    if shadow is None:
        return True
    walls = robot.walls(shadow)
    contact = next_contact(robot, there)
    margin_m = wall_m(robot, shadow.here, contact, walls)
    needed_m = robot.step_m * (robot.tick - shadow.tick)
    return margin_m >= needed_m or margin_m >= wall_m(robot, shadow.here, robot.contact, walls) + 1e-6


def next_contact(robot: Robot, there: complex) -> complex:
    """The place of its wall that a leader would touch there."""
    near = robot.hits[np.abs(robot.hits - robot.contact) <= WALL_NEAR_M]
    return nearest(near, there) or robot.contact


def _keeps_wall(robot: Robot, side: Side, there: complex) -> bool:
    """Would it, beside a leader, still see the leader's wall, or the place of it that it holds?"""
    leader, held = shadowed(robot, side), robot.held.get(side)
    walls = robot.hits if leader is None else robot.walls(leader)
    if leader is not None:
        needed_m = robot.step_m * (robot.tick - leader.tick)
        margin_m, now_m = (wall_m(robot, place, leader.contact, walls) for place in (there, robot.here))
        if margin_m >= needed_m:
            return True
        if now_m > NONE_M and margin_m < now_m + 1e-6:
            return False
    if held is None:
        return True
    margin_m = wall_m(robot, there, held, walls) - robot.step_m
    return margin_m >= 0 or margin_m >= wall_m(robot, robot.here, held, walls) - robot.step_m


def wall_m(robot: Robot, here: complex, wall: complex, walls: np.ndarray) -> float:
    """How far one at a place may go, and still sees a place of a wall."""
    away = wall - here
    far_m = abs(away)
    if far_m > AT_WALL_M:
        end = here + away * (1 - AT_WALL_M / far_m)
        if clearance_m(walls, here, end) < EDGE_M:
            return NONE_M
    return robot.reach_m - far_m


def sees_wall(robot: Robot, peer: Peer, wall: complex) -> bool:
    """Does another robot see a wall, with a step to spare?"""
    return wall_m(robot, peer.here, wall, robot.walls(peer)) >= robot.step_m


def leaders_walls(robot: Robot) -> np.ndarray:
    """Which rays end at the wall of a leader beside it, without a jump: that is no obstacle."""
    own = np.zeros(robot.eye.rays, dtype=bool)
    ends = ray_ends(robot.here, robot.ranges_m, robot.eye.units)
    for side in SIDES:
        leader = shadowed(robot, side)
        if leader is not None and len(robot.hits):
            near = int(np.nanargmin(np.abs(ends - leader.contact)))
            if abs(ends[near] - leader.contact) <= WALL_NEAR_M:
                own[one_wall(ends, near)] = True
    return own


def are_ahead(robot: Robot, places: np.ndarray) -> np.ndarray:
    """Which places ahead are ahead of neighbours nearer to them, too? Else the line is only folded there."""
    ahead = np.ones(len(places), dtype=bool)
    for side in SIDES:
        beside, after = robot.neighbour(side), beyond(robot, side)
        if beside is None:
            continue
        end = beside.contact if shadowed(robot, side) else after.here if after else None
        if end is None:
            continue
        ways = [end - beside.here, robot.here - beside.here]
        left, right = ways if side == "left" else ways[::-1]
        away = places - beside.here
        turned = np.angle(left / away) % math.tau
        within = turned <= turn_rad(left, right, "right")
        ahead &= within | (np.abs(away) >= np.abs(places - robot.here))
    return ahead
