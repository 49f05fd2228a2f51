"""How robots on a line move: leaders along their walls, the others so that the chain stays taut.

Source: the rules for leaders and slots are those of Kolling and Carpin, "Multi-robot pursuit-evasion without
maps", 2010, section III; its errors are mended as docs/clear.md says.
"""

import cmath
import math

import numpy as np

from swarm_agent.sweep import robust, robust_line
from swarm_agent.sweep.geometry import nearest, one_wall, ray_ends, roll, turn_rad, unit
from swarm_agent.sweep.links import is_spare
from swarm_agent.sweep.moves import may
from swarm_agent.sweep.outlook import Outlook
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import GO_BACK, GO_HOME, GO_ON, OTHER, SIDES, WALL, Flow, Side
from swarm_agent.sweep.resting import Slot, Strides
from swarm_agent.sweep.robot import Robot

STRAIGHT_RAD = 1.8 * math.pi  # larger angles are noise around zero
ALIKE_RAD = 0.01
LOST_M = 0.2  # a leader that finds no wall so near to where it was before does not know its wall any more
BODIES_M = 0.36
HOLD_M, HOLD_MOST_M = 0.5, 0.64  # a leader goes no farther from its wall; around a dead body a little
FARTHEST_M = 0.6  # from its wall, for who comes near to it again while it goes
ASIDE_DEG = (0, 20, 40, 60, 80, 100, -20, -40, -60)
FALLEN = 0.04 * np.exp(2j * math.pi / 8 * np.arange(8))  # a dead robot is passed at a little more than a wall
AT_BODY_M, INSIDE_M, ROOM_M, LEAST_M = 0.34, 0.38, 0.28, 0.1  # is there room behind a dead one?
APART_M, TOGETHER_M, BACK_M = 0.34, 0.25, 0.5
TAUT_TICKS = 12
ANSWER_TICKS = 40
SETTLED_TICKS = 20  # who has just come in does not know yet whether the line wants it


def lead(robot: Robot, outlook: Outlook, strides: Strides) -> complex:
    """A leader's way: along its wall, if that shortens the line, or lengthens it less than the other's.

    Who would go, and cannot, is barred: then the other leader may go on instead.
    """
    wanted = _lead(robot, outlook)
    way = strides.taken(robot, wanted or 0j)
    if way or wanted == 0:
        robot.free_tick = robot.tick
    return way


def _lead(robot: Robot, outlook: Outlook) -> complex | None:
    """The way; 0 where it is to stand, None where all ways are barred."""
    side = robot.wall_side()
    touch(robot)
    way = along_wall(robot, side)
    robot.angle_rad = turn_rad(outlook.ways[OTHER[side]], way, side)
    if robot.angle_rad > STRAIGHT_RAD:
        robot.angle_rad = 0.0
    other = robot.told[OTHER[side]]
    if other is None or robot.halt or robot.any_told("halt") or _awaits(robot):
        return 0j
    if robot.order in (GO_BACK, GO_HOME):
        return _go_back(robot, side, other.angle_rad)
    if robot.order > 0 or robot.close:
        return 0j
    shortens = robot.angle_rad < math.pi / 2 - 2 * ALIKE_RAD
    if not shortens and not may_grow(robot, other):
        return 0j
    return _go(robot, way, side) or None


def _awaits(robot: Robot) -> bool:
    """Does it stand until another line has answered? Only for a while: from nearer both may see more."""
    return robot.meets > 0 and robot.tick - robot.met_tick <= ANSWER_TICKS * robot.parameters.hop_ticks


def _go(robot: Robot, way: complex, hand: Side) -> complex:
    """That way along the wall, or one near to it, rather away from the wall, that links and others allow."""
    inward = -1 if hand == "left" else 1
    for aside_deg in ASIDE_DEG:
        some = way * cmath.exp(1j * inward * math.radians(aside_deg))
        for size in (1.0, 0.5, 0.2):
            if _stays_at_wall(robot, some * size) and may(robot, some * size, wall_m=0.1):
                return some * size
    return 0j


def may_grow(robot: Robot, other: Flow) -> bool:
    """May it lengthen the line: the main line, without a pivot, by the smaller angle of the two?"""
    held = robot.close or robot.any_told("pinned")
    turn = other.barred or robot.angle_rad <= other.angle_rad + ALIKE_RAD
    return robot.is_main and not held and turn


def touch(robot: Robot) -> None:
    """Find the place of its wall again that is nearest now.

    What counts is the same wall, without a jump between rays: another one, however near, would leave a gap
    between the two that nobody sees.
    """
    ends, near = _around(robot)
    if near is None:
        return
    robot.contact = nearest(ends[one_wall(ends, near)], robot.here)


def _around(robot: Robot) -> tuple[np.ndarray, int | None]:
    """Where all rays end, NaN where at no wall, and which of them ends at what was its wall before."""
    ends = ray_ends(robot.here, robot.ranges_m, robot.eye.units)
    gaps = np.where(np.isnan(ends), np.inf, np.abs(ends - robot.contact))
    near = int(gaps.argmin())
    return ends, near if gaps[near] <= LOST_M else None


def along_wall(robot: Robot, hand: Side) -> complex:
    """A step along the wall on one hand, around robots that stand there, and around or behind the dead."""
    others = [
        peer.here
        for peer in robot.peers.known.values()
        if peer.beacon.follows_nobody and abs(peer.here - robot.here) < BODIES_M
    ]
    keep_m, contact = _keep_m(robot), robot.contact
    forward = unit(contact - robot.here) * (-1j if hand == "left" else 1j)
    for body in robot.fallen:
        if abs(body - robot.here) < HOLD_M and len(robot.hits):
            gap_m = float(np.abs(robot.hits - body).min())
            if gap_m >= INSIDE_M:
                keep_m = min(keep_m, max(LEAST_M, gap_m - ROOM_M))
            else:
                keep_m = robot.parameters.obstacle_m
                others += (body + FALLEN).tolist()
                if ((body - robot.here) / forward).real > -LEAST_M / 2 and abs(body - robot.here) < AT_BODY_M:
                    contact = body
    walls = np.concatenate((robot.hits, np.array(others, dtype=complex)))
    return roll(robot.here, walls, contact, hand, keep_m, robot.step_m)[0]


def _stays_at_wall(robot: Robot, way: complex) -> bool:
    """Is it still beside its wall after that way, or at least no farther from it?"""
    there = robot.here + way
    wall = robust.next_contact(robot, there) if robot.is_robust else robot.contact
    hold_m = HOLD_MOST_M if _is_barred(robot) else HOLD_M
    return abs(there - wall) <= max(hold_m, abs(robot.here - robot.contact))


def _is_barred(robot: Robot) -> bool:
    """Does a dead body lie near by?"""
    return any(abs(body - robot.here) < HOLD_M for body in robot.fallen)


def _keep_m(robot: Robot) -> float:
    """How far to stay from the wall: from wherever it is, a little nearer with every step."""
    nearer_m = min(abs(robot.contact - robot.here) - 0.3 * robot.step_m, FARTHEST_M)
    return max(robot.parameters.obstacle_m, nearer_m)


def _go_back(robot: Robot, side: Side, other_rad: float) -> complex:
    """Back along the wall, if that shortens the line, and not much less than the other end's way would.

    Two leaders at one place of a wall stay there: who went on would turn the line over, front to back.
    """
    for peer in robot.peers.known.values():
        ends_ours = peer.beacon.line == robot.line and peer.beacon.beside(OTHER[side]) == WALL
        is_other = peer.number == robot.beside[OTHER[side]] or ends_ours  # robots may stand between the two
        if peer.beacon.role == "leader" and is_other and abs(peer.wall - robot.contact) < BACK_M:
            return 0j
    if robot.angle_rad <= math.pi / 2 or robot.angle_rad < other_rad - 0.3:
        return 0j
    return _go(robot, along_wall(robot, OTHER[side]), OTHER[side])


def keep(robot: Robot, slot: Slot) -> complex:
    """The way of a robot in the middle: to its slot, forward when it searches, or to the wall of a pivot."""
    left, right = (robot.neighbour(side) for side in SIDES)
    stands = robot.pinned or robot.ready or robot.halt or robot.any_told("halt")
    if left is None or right is None or stands:
        return 0j
    if robot.order > 0 and robot.order == robot.place and robot.role == "centre":
        return _push(robot, left, right)
    if (
        robot.order in (GO_ON, GO_HOME)
        and robot.role == "centre"
        and robot.tick - robot.since_role > SETTLED_TICKS * robot.parameters.hop_ticks
        and not robot.any_told("want")
        and is_spare(robot)
    ):
        robot.role, robot.since_role = "leaving", robot.tick
    if robot.is_robust:
        wall = robust_line.wall_to_see(robot)
        walls = [] if wall is None else [wall]
    else:
        pivots = [one for one in (left, right) if one.beacon.pinned]
        walls = [one.wall for one in pivots if abs(one.wall - robot.here) > APART_M]
    aims = walls[:1] if robot.is_robust and walls else [*walls, _slot(robot, left, right)]
    return slot.way(robot, aims, (left.here, right.here))


def _slot(robot: Robot, left: Peer, right: Peer) -> complex:
    """On the taut chain between its neighbours, `follow_m` from the left one, not too near the right one."""
    over_left = robot.over(left.here, robot.here, robot.walls(left))
    over_right = robot.over(robot.here, right.here, robot.walls(right))
    first = left.here if over_left is None else over_left
    last = right.here if over_right is None else over_right
    length_m = abs(last - first)
    if length_m < 1e-9:
        return robot.here
    near = left.beacon.pinned or left.beacon.close or (robot.is_robust and left.beacon.ready)
    along_m = (TOGETHER_M if near else robot.parameters.follow_m) - abs(first - left.here)
    apart_m = robust_line.APART_M if robot.is_robust else APART_M
    most_m = length_m - (apart_m if over_right is None else 0.0)
    if right.beacon.close and right.beacon.role == "leader":
        along_m = max(along_m, min(most_m - 0.05, robot.parameters.follow_m + 0.1))
    along_m = min(max(along_m, 0.0), max(most_m, 0.0))
    if over_left is None:
        along_m = max(along_m, min(TOGETHER_M, length_m / 2))
    if robot.is_robust:
        along_m = robust_line.slot(robot, length_m, along_m)
    back = robust_line.aside(robot, length_m, last - first) if robot.is_robust else 0j
    return first + (last - first) * (along_m / length_m) + back


def _push(robot: Robot, left: Peer, right: Peer) -> complex:
    """Forward as far as both links reach, in search of an obstacle.

    Where it ends, the left part of the chain is as long as its robots reach, and the right part too: the
    places of the paper's obstacle search.
    """
    forward = 1j * unit(right.here - left.here) * robot.step_m
    longest_m = robot.parameters.follow_m + robot.step_m
    for turn_deg in (0, 25, -25, 50, -50):
        way = forward * cmath.exp(1j * math.radians(turn_deg))
        taut = max(abs(one.here - robot.here - way) for one in (left, right)) > longest_m
        if not taut and may(robot, way):
            robot.taut, robot.pushed = 0, robot.tick
            return way
    if robot.tick - robot.pushed > TAUT_TICKS * robot.parameters.hop_ticks:
        robot.taut = robot.place
    return 0j
