"""Lines that hold without any one of their robots (`spacing = "robust"`); that costs more robots.

Each robot is linked to its neighbours and to those beyond them, so when one falls silent the barrier is there
already, before anybody has noticed. Who stands beside a leader is its shadow: it holds a place of the leader's
wall, too. All this binds every step, with the age of what is known of others.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from swarm_agent.sweep.geometry import clearance_m, nearest, turn_rad, unit
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import BARRIER, OTHER, SIDES, WALL, Side

if TYPE_CHECKING:
    from swarm_agent.sweep.robot import Robot

EASE = 0.3  # of `slack_m`: how much nearer than `follow_m`, or farther apart, makes one leave, or come
LEAST = 3  # robots of a line
SHADOW_M = 0.3  # from the leader
ROOMY_M = 0.5  # a link in which there is room for a third robot
PAIR_M = 0.62  # two leaders who wait for a third robot go no farther apart
APART_M = 0.25  # from the right neighbour, where there are more robots than the line needs
WIDE_M = 0.08  # beyond `follow_m`: a gap that only a loss leaves
WALL_NEAR_M = 0.2  # a leader's next contact is no farther from the one before
AT_WALL_M = 0.08  # so near to a wall it bars no view of it
EDGE_M = 0.015
JOINED_M = 0.12  # hits of neighbouring rays that are no farther apart are one wall
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
    now = {one.number: side for side in SIDES if (one := beyond(robot, side)) and _counts(one)}
    kept = {
        number: side
        for number, side in robot.second.items()
        if number not in robot.beside.values() and not _is_agreed(robot, number, side)
    }
    robot.second = kept | now


def _counts(peer: Peer) -> bool:
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
    return last is not None and last.beacon.role in BARRIER and last.beacon.beside(OTHER[side]) == beside.number


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


def chain(robot: Robot) -> list[Peer | None]:
    """Second and first neighbour on the left, then on the right."""
    return [beyond(robot, "left"), robot.neighbour("left"), robot.neighbour("right"), beyond(robot, "right")]


def can_do_without(robot: Robot, slack_m: float) -> bool:
    """Would its line still hold without any one robot if it left, with that much slack?"""
    before, left, right, after = chain(robot)
    if left is None or right is None or robot.count <= LEAST:
        return False
    most_m = robot.parameters.follow_m - EASE * slack_m
    if abs(left.here - right.here) > most_m:
        return False
    for outer, inner, opposite, side in ((before, left, right, "left"), (after, right, left, "right")):
        if inner.beacon.beside(side) == WALL:
            if wall_m(robot, opposite.here, inner.contact, robot.walls(left, right)) < 2.5 * robot.step_m:
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
        return robot.beside["left"] == WALL and shadowed(robot, "right") is not None and gap_m > ROOMY_M
    if gap_m > follow_m + WIDE_M:
        return True
    if shadowed(robot, "right") is None:
        return False
    if shadowed(robot, "left") is not None:
        return robot.count == LEAST and not _holds_both(robot)
    return abs(left.here - robot.here) > follow_m + EASE * robot.parameters.slack_m or right.beacon.close


def _holds_both(robot: Robot) -> bool:
    leaders = [robot.neighbour(side) for side in SIDES]
    return all(wall_m(robot, robot.here, one.contact, robot.walls(one)) > 2 * robot.step_m for one in leaders if one)


def slot(robot: Robot, length_m: float, along_m: float) -> float:
    """How far along the way between its neighbours a robot stands: beside a leader as its shadow."""
    left, right = (shadowed(robot, side) is not None for side in SIDES)
    if left and right:
        return length_m / 2
    if left:
        return min(SHADOW_M, length_m / 2)
    return max(length_m - SHADOW_M, length_m / 2) if right else along_m


def aside(robot: Robot, length_m: float, way: complex) -> complex:
    """How far behind the way between its neighbours the right shadow stands where that is too short for it."""
    if shadowed(robot, "right") is None or length_m >= 2 * APART_M:
        return 0j
    return -1j * unit(way) * math.sqrt((APART_M + 0.02) ** 2 - length_m**2 / 4)


def may_cut(robot: Robot, side: Side) -> bool:
    """May a pivot cut the line on a side: have both new ends a shadow that sees their wall, and enough robots?"""
    ready, other, after = robot.neighbour(side), robot.neighbour(OTHER[side]), beyond(robot, side)
    counts = [flow.count for flow in robot.told.values() if flow]
    if ready is None or other is None or after is None:
        return False
    enough = robot.told[side].count >= LEAST and robot.told[OTHER[side]].count >= LEAST - 1
    sees = sees_wall(robot, other, robot.contact) and sees_wall(robot, after, ready.contact)
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
    return inner is not None and sees_wall(robot, inner, robot.contact) and robot.told[OTHER[side]].count >= 2


def wants_at(robot: Robot) -> bool:
    """Does a pivot need more robots to be cut at; of several pivots the leftmost comes first."""
    told = robot.told["left"]
    if not robot.is_main or not robot.is_whole or told is None or told.pivot:
        return False
    if robot.closing:
        return not any(may_end(robot, side) for side in SIDES)
    return not may_cut(robot, "right")


def wall_to_see(robot: Robot) -> complex | None:
    """The wall of a neighbour that it must come nearer to, to see it well."""
    for side in SIDES:
        peer = robot.neighbour(side)
        if peer is None or not (peer.beacon.pinned or peer.beacon.ready or shadowed(robot, side)):
            continue
        if wall_m(robot, robot.here, peer.contact, robot.walls(peer)) < 3 * robot.step_m:
            return peer.contact
    return None


def leaders_walls(robot: Robot) -> np.ndarray:
    """Which rays end at the wall of a leader beside it, without a jump: that is no obstacle."""
    own = np.zeros(robot.eye.rays, dtype=bool)
    seen = np.isfinite(robot.ranges_m)
    ends = np.where(seen, robot.here + np.where(seen, robot.ranges_m, 0.0) * robot.eye.units, np.nan)
    for side in SIDES:
        leader = shadowed(robot, side)
        if leader is None or not seen.any():
            continue
        near = int(np.where(seen, np.abs(ends - leader.contact), np.inf).argmin())
        if abs(ends[near] - leader.contact) > WALL_NEAR_M:
            continue
        own[near] = True
        for step in (1, -1):
            ray = near
            for _ in range(len(ends)):
                following = (ray + step) % len(ends)
                if not abs(ends[following] - ends[ray]) <= JOINED_M:
                    break
                own[following], ray = True, following
    return own


def are_ahead(robot: Robot, places: np.ndarray) -> np.ndarray:
    """Which places ahead are ahead of the neighbours nearer to them, too? Else the line is only folded there."""
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


def may_join(robot: Robot, left: Peer, right: Peer) -> bool:
    """Would the line hold without any one robot if it stood between two of it here?"""
    for inner, opposite, side in ((left, right, "left"), (right, left, "right")):
        number = inner.beacon.beside(side)
        if number == WALL:
            if wall_m(robot, robot.here, inner.contact, robot.walls(inner)) < robot.step_m:
                return False
            continue
        outer = robot.peer(number)
        if outer is None or robot.link_m(outer, side) < EDGE_M:
            return False
    return True


def followers(robot: Robot) -> Iterator[Peer]:
    """Who names this robot as a neighbour."""
    for peer in robot.peers.known.values():
        if _counts(peer) and robot.number in (peer.beacon.left, peer.beacon.right):
            yield peer
