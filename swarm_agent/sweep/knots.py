"""Links that would cross the way from a leader to its wall: beyond that way, front is back."""

from __future__ import annotations

from typing import TYPE_CHECKING

from swarm_agent.sweep.geometry import crosses
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import OTHER, SIDES, WALL

if TYPE_CHECKING:
    from swarm_agent.sweep.robot import Robot


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
