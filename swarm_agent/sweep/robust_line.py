"""When a robust line takes robots in and lets them go, where they stand, and when it may change its ends.

Nothing is given up before the line without it holds without any one more of its robots.
"""

import math

from swarm_agent.sweep import robust
from swarm_agent.sweep.geometry import unit
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import OTHER, SIDES, WALL, Side
from swarm_agent.sweep.robot import Robot

LEAST = 3  # robots of a line
EASE = 0.3  # of `slack_m`: how much nearer than `follow_m`, or farther apart, makes one leave, or come
SHADOW_M = 0.3  # from the leader
ROOMY_M = 0.5  # a link in which there is room for a third robot
APART_M = 0.25  # from the right neighbour, where there are more robots than the line needs
WIDE_M = 0.08  # beyond `follow_m`: a gap that only a loss leaves
BARELY_M = 0.015


def can_do_without(robot: Robot, slack_m: float) -> bool:
    """Would its line still hold without any one robot if it left, with that much slack?"""
    left, right = (robot.neighbour(side) for side in SIDES)
    before, after = (robust.beyond(robot, side) for side in SIDES)
    if left is None or right is None or robot.count <= LEAST:
        return False
    most_m = robot.parameters.follow_m - EASE * slack_m
    if abs(left.here - right.here) > most_m:
        return False
    for outer, inner, opposite, side in ((before, left, right, "left"), (after, right, left, "right")):
        if inner.beacon.beside(side) == WALL:
            if (
                robust.wall_m(robot, opposite.here, inner.contact, robot.walls(left, right))
                < 2.5 * robot.step_m
            ):
                return False
        elif outer is None or _between_m(robot, outer, opposite, side) < 2 * robot.step_m:
            return False
    return True


def _between_m(robot: Robot, one: Peer, other: Peer, side: Side) -> float:
    """The margin of a link between two others, the first of whom is on that side."""
    ends = (one.here, other.here) if side == "left" else (other.here, one.here)
    return robot.margin_m(*ends, robot.walls(one, other))


def wants(robot: Robot) -> bool:
    """Is there a gap on its left that needs one more robot, or one that a loss has left on its right?"""
    left, right = (robot.neighbour(side) for side in SIDES)
    if robot.old or robot.role == "leaving" or right is None or right.beacon.left != robot.number:
        return False
    gap_m, follow_m = abs(right.here - robot.here), robot.parameters.follow_m
    if left is None:
        return (
            robot.beside["left"] == WALL and robust.shadowed(robot, "right") is not None and gap_m > ROOMY_M
        )
    if gap_m > follow_m + WIDE_M:
        return True
    if robust.shadowed(robot, "right") is None:
        return False
    if robust.shadowed(robot, "left") is not None:
        return robot.count == LEAST and not _holds_both(robot)
    return abs(left.here - robot.here) > follow_m + EASE * robot.parameters.slack_m or right.beacon.close


def _holds_both(robot: Robot) -> bool:
    leaders = [robot.neighbour(side) for side in SIDES]
    return all(
        robust.wall_m(robot, robot.here, one.contact, robot.walls(one)) > 2 * robot.step_m
        for one in leaders
        if one
    )


def wants_at(robot: Robot) -> bool:
    """Does a pivot need more robots to be cut at; of several pivots the leftmost comes first."""
    told = robot.told["left"]
    if not robot.is_main or not robot.is_whole or told is None or told.pivot:
        return False
    if robot.closing:
        return not any(may_end(robot, side) for side in SIDES)
    return not may_cut(robot, "right")


def slot(robot: Robot, length_m: float, along_m: float) -> float:
    """How far along the way between its neighbours a robot stands: beside a leader as its shadow."""
    left, right = (robust.shadowed(robot, side) is not None for side in SIDES)
    if left and right:
        return length_m / 2
    if left:
        return min(SHADOW_M, length_m / 2)
    return max(length_m - SHADOW_M, length_m / 2) if right else along_m


def aside(robot: Robot, length_m: float, way: complex) -> complex:
    """How far behind the way between its neighbours the right shadow stands where that is too short."""
    if robust.shadowed(robot, "right") is None or length_m >= 2 * APART_M:
        return 0j
    return -1j * unit(way) * math.sqrt((APART_M + 0.02) ** 2 - length_m**2 / 4)


def wall_to_see(robot: Robot) -> complex | None:
    """The wall of a neighbour that it must come nearer to, to see it well."""
    for side in SIDES:
        peer = robot.neighbour(side)
        if peer is None or not (peer.beacon.pinned or peer.beacon.ready or robust.shadowed(robot, side)):
            continue
        if robust.wall_m(robot, robot.here, peer.contact, robot.walls(peer)) < 3 * robot.step_m:
            return peer.contact
    return None


def may_join(robot: Robot, left: Peer, right: Peer) -> bool:
    """Would the line hold without any one robot if it stood between two of it here?

    Two leaders alone hold nothing yet.
    """
    if left.beacon.left == WALL and right.beacon.right == WALL:
        return True
    for inner, opposite, side in ((left, right, "left"), (right, left, "right")):
        number = inner.beacon.beside(side)
        if number == WALL:
            if robust.wall_m(robot, robot.here, inner.contact, robot.walls(inner)) < robot.step_m:
                return False
            continue
        outer = robot.peer(number)
        if outer is None or robot.link_m(outer, side) < BARELY_M:
            return False
    return True


def may_cut(robot: Robot, side: Side) -> bool:
    """May a pivot cut the line there: has each new end a shadow that sees its wall, and enough robots?"""
    ready, other, after = robot.neighbour(side), robot.neighbour(OTHER[side]), robust.beyond(robot, side)
    counts = [flow.count for flow in robot.told.values() if flow]
    if ready is None or other is None or after is None:
        return False
    enough = robot.told[side].count >= LEAST and robot.told[OTHER[side]].count >= LEAST - 1
    sees = robust.sees_wall(robot, other, robot.contact) and robust.sees_wall(robot, after, ready.contact)
    return enough and sees and len(counts) == len(SIDES)


def may_meet(robot: Robot, peer: Peer, side: Side) -> bool:
    """May two leaders link their lines: would the links to second neighbours hold, too?"""
    inner, other = robot.neighbour(OTHER[side]), robot.peer(peer.beacon.beside(side))
    if inner is None or other is None:
        return False
    ends = _between_m(robot, inner, peer, OTHER[side]), robot.link_m(other, side)
    return min(ends) >= robot.step_m


def may_end(robot: Robot, side: Side) -> bool:
    """May a robot give up its link on a side for a wall: does the neighbour on the other side see it?"""
    inner = robot.neighbour(OTHER[side])
    return (
        inner is not None
        and robust.sees_wall(robot, inner, robot.contact)
        and robot.told[OTHER[side]].count >= 2
    )


def close_ranks(robot: Robot, side: Side, lost: Peer | None) -> bool:
    """Link to who stands where one has fallen silent, or take over the wall that it held. Could it?

    First comes who links to us already, then who did so before, then who stood beyond.
    """
    known = robot.peers.known.values()
    holds = [
        one.number for one in known if robust.counts(one) and one.beacon.beside(OTHER[side]) == robot.number
    ]
    before = [number for number, one in robot.old.items() if one == side]
    after = [lost.beacon.beside(side)] if lost is not None else []
    for number in (*holds, *before, *after):
        peer = robot.peer(number)
        if peer is not None and robot.link_m(peer, side) >= 0:
            robot.old.pop(number, None)
            robot.beside[side], robot.role = number, "centre" if robot.role == "leaving" else robot.role
            return True
    wall, was_end = robot.held.get(side), lost is not None and lost.beacon.beside(side) == WALL
    if not was_end or wall is None or robot.role not in ("centre", "leaving"):
        return False
    if robust.wall_m(robot, robot.here, wall, robot.hits) < 0:
        return False
    robot.beside[side], robot.contact, robot.role = WALL, wall, "leader"
    return True
