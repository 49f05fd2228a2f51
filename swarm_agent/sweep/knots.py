"""Links that would cross the way from a leader to its wall: beyond that way, front is back."""

import cmath
import math

from swarm_agent.sweep.geometry import crosses
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import OTHER, SIDES, WALL
from swarm_agent.sweep.robot import Robot

TURNED_M, TURNED_RAD = 0.6, math.radians(35)


def turns_over(robot: Robot, peer: Peer, there: complex) -> bool:
    """Would the link to a robot near by come too near to the way from a leader to its wall?"""
    if abs(peer.here - there) >= TURNED_M:
        return False
    ends = [(robot.here, there, robot.contact, peer.here)] if robot.role == "leader" else []
    if peer.beacon.role == "leader":
        ends.append((peer.here, peer.here, peer.wall, there))
    for before, after, wall, other in ends:
        now, then = abs(wall - before), abs(wall - after)
        was = other if before != after else robot.here
        if not (now and then):
            continue
        angle = abs(cmath.phase((other - after) / (wall - after)))
        angle_before = abs(cmath.phase((was - before) / (wall - before)))
        if angle < TURNED_RAD and angle < angle_before:
            return True
    return False


def is_crossed(robot: Robot, there: complex) -> bool:
    """Would the second link of a line cross the way from its leader to its wall?"""
    for side in SIDES:
        end, other = robot.neighbour(OTHER[side]), robot.neighbour(side)
        if other is None:
            continue
        if robot.beside[OTHER[side]] == WALL:
            beyond = robot.peer(other.beacon.beside(side))
            crossed = beyond and crosses(other.here, beyond.here, there, robot.contact)
        else:
            is_end = end is not None and end.beacon.beside(OTHER[side]) == WALL
            crossed = is_end and crosses(there, other.here, end.here, end.wall)
        if crossed:
            return True
    return False


def is_knotted(robot: Robot, left: Peer, right: Peer) -> bool:
    """Would a link across the way from a leader to its wall come about?"""
    ends = ((left, "left", right), (right, "right", left))
    return any(
        end.beacon.beside(side) == WALL and crosses(robot.here, other.here, end.here, end.wall)
        for end, side, other in ends
    )
