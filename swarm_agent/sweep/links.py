"""How robots come to stand beside each other, and cease to, without the barrier opening.

Every change is made in two phases: who comes in is in place before the old link is given up, and nobody gives
up a link until the other end has shown that it holds the new one. Until then both count for its motion. All
that is said is a state, said again in every tick, so that lost frames cost time and nothing else.
"""

from swarm_agent.sweep import robust, robust_line
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import NOBODY, OTHER, SIDES, WALL, Side
from swarm_agent.sweep.robot import Robot

PATIENCE_TICKS = 12
BARELY_M = 0.02  # the margin that is enough for a link that nobody opens before it is taken over


def tend(robot: Robot) -> str:
    """Take over, or give up, links as neighbours ask for. Returns why the barrier is open, or nothing."""
    robot.refused = {
        one for one in robot.refused if (peer := robot.peer(one)) and peer.beacon.role == "joining"
    }
    for number in [number for number in robot.old if _is_free_of(robot, number)]:
        del robot.old[number]
    if robot.is_robust:
        robust.watch(robot)
    if robot.role == "joining":
        _come_in(robot)
        return ""
    if robot.role == "leaving" and robot.tick - robot.since_role > _patience(robot):
        robot.role = "centre"
    for side in SIDES:
        if robot.beside[side] > 0:
            peer = robot.neighbour(side)
            if peer is None:
                trouble = _lose(robot, side)
                if trouble or not robot.on_line:
                    return trouble
                continue
            if _is_dissolved(robot, peer, side):
                robot.become("reserve", "gone")
                return ""
            _follow(robot, peer, side)
            _adopt_line(robot, peer, side)
    if robot.role in ("centre", "leaving") and _is_passed_over(robot):
        robot.become("reserve")
    return ""


def ask_in(robot: Robot, left: Peer, right: Peer) -> None:
    """Ask to stand between two robots."""
    robot.become("joining")
    robot.beside = {"left": left.number, "right": right.number}
    robot.moved = robot.tick


def is_spare(robot: Robot) -> bool:
    """Could its neighbours do without it, with some slack?"""
    left, right = (robot.neighbour(side) for side in SIDES)
    if left is None or right is None or robot.old:
        return False
    if not (_holds(left, "right", robot) and _holds(right, "left", robot)):
        return False
    needed = any(
        one.beacon.pinned or one.beacon.close or one.beacon.role == "leaving" for one in (left, right)
    )
    if robot.is_robust:
        return (
            not needed
            and not robot.any_told("want")
            and robust_line.can_do_without(robot, robot.parameters.slack_m)
        )
    near = abs(left.here - right.here) <= robot.parameters.follow_m - robot.parameters.slack_m
    return (
        not needed
        and near
        and robot.margin_m(left.here, right.here, robot.walls(left, right)) >= robot.step_m
    )


def _holds(peer: Peer, side: Side, robot: Robot) -> bool:
    return peer.beacon.beside(side) == robot.number


def _is_free_of(robot: Robot, number: int) -> bool:
    """Has the robot at the old end of a link let it go, or fallen silent?"""
    peer = robot.peer(number)
    return peer is None or robot.number not in (peer.beacon.left, peer.beacon.right)


def _come_in(robot: Robot) -> None:
    """Both hold it: it is on the line. Neither does, for a while: it is not. Until then it stays there."""
    left, right = (robot.neighbour(side) for side in SIDES)
    if (
        left is not None
        and right is not None
        and _holds(left, "right", robot)
        and _holds(right, "left", robot)
    ):
        robot.role, robot.since_role, robot.held_tick = "centre", robot.tick, robot.tick
        robot.line, robot.since = left.beacon.line, left.beacon.since
        return
    named = any(one is not None and not _is_free_of(robot, one.number) for one in (left, right))
    if not named and robot.tick - robot.since_role > _patience(robot):
        robot.become("reserve")


def _patience(robot: Robot) -> int:
    return PATIENCE_TICKS * robot.parameters.hop_ticks


def _is_dissolved(robot: Robot, peer: Peer, side: Side) -> bool:
    """Has the line beyond that neighbour gone, because nothing is left ahead of it?"""
    beacon = peer.beacon
    cut_off = beacon.beside(OTHER[side]) == WALL and beacon.stage == "closed"
    return cut_off or (beacon.follows_nobody and beacon.stage == "gone")


def _is_passed_over(robot: Robot) -> bool:
    """Do both neighbours hold each other, or for a while others than this robot?"""
    left, right = (robot.neighbour(side) for side in SIDES)
    if left is None or right is None:
        return False
    if _holds(left, "right", robot) or _holds(right, "left", robot):
        robot.held_tick = robot.tick
    forgotten = robot.tick - robot.held_tick > _patience(robot)
    return forgotten or (left.beacon.right == right.number and right.beacon.left == left.number)


def _follow(robot: Robot, peer: Peer, side: Side) -> None:
    """Link to who comes in on a side, or to who stands beyond one that leaves.

    Of the two ends of a link the left one decides, and the right one follows: so they never decide otherwise.
    """
    beacon = peer.beacon
    onward, back = beacon.beside(side), beacon.beside(OTHER[side])
    beyond = robot.peer(onward)
    if beacon.role == "leaving" and robot.role != "leaving" and beyond is not None and back == robot.number:
        near = abs(beyond.here - robot.here) <= robot.parameters.follow_m
        agreed = side == "right" or beyond.beacon.right == robot.number
        if near and agreed and robot.link_m(beyond, side) >= robot.step_m:
            _relink(robot, side, onward)
        return
    if robot.role == "leaving" or (robot.ready and not (robot.is_robust and side == "right")):
        return
    for one in robot.peers.known.values():
        asks = one.beacon.role == "joining" and one.beacon.beside(side) == peer.number
        if not asks or one.beacon.beside(OTHER[side]) != robot.number or one.number in robot.refused:
            continue
        agreed = side == "right" or beacon.right == one.number
        if agreed and robot.link_m(one, side) >= BARELY_M:
            _relink(robot, side, one.number)
            robot.linked_tick = robot.tick
            return
    if back != robot.number and beacon.role != "joining":
        _turn_back(robot, side)
    elif beacon.role == "joining" and side == "right" and robot.tick - robot.linked_tick > _patience(robot):
        _turn_back(robot, side)


def _turn_back(robot: Robot, side: Side) -> None:
    """Who we link to does not link to us: it gave up, or the other end decided otherwise. Who does?"""
    for one in robot.peers.known.values():
        holds = one.beacon.beside(OTHER[side]) == robot.number and one.beacon.role in ("centre", "leader")
        if holds and one.number != robot.beside[side]:
            robot.refused.add(robot.beside[side])
            _relink(robot, side, one.number)
            return


def _relink(robot: Robot, side: Side, number: int) -> None:
    if robot.beside[side] > 0:
        robot.old[robot.beside[side]] = side
    robot.old.pop(number, None)
    robot.beside[side] = number


def _adopt_line(robot: Robot, peer: Peer, side: Side) -> None:
    """Lines get their numbers where they are cut, and tell them on."""
    beacon = peer.beacon
    held = beacon.beside(OTHER[side]) == robot.number
    if held and beacon.role in ("centre", "leader") and beacon.since > robot.since:
        robot.line, robot.since = beacon.line, beacon.since


def _lose(robot: Robot, side: Side) -> str:
    """A neighbour is silent for good: the link may hold without it. Returns what is wrong, or nothing."""
    number = robot.beside[side]
    robot.dead.add(number)
    robot.old.pop(number, None)
    lost = robot.peers.lost.get(number)
    if robot.is_robust and robust_line.close_ranks(robot, side, lost):
        return ""
    if lost is not None and robot.number not in (lost.beacon.left, lost.beacon.right):
        robot.become("reserve")  # it did not hold us when it was last heard: it is out of reach, and not dead
        robot.dead.discard(number)
        return ""
    if lost is not None:
        beyond = robot.peer(lost.beacon.beside(side))
        if beyond is not None and robot.link_m(beyond, side) >= 0:
            robot.beside[side] = beyond.number
            return ""
        if lost.beacon.beside(side) == WALL and robot.role == "centre" and robot.sees(lost.wall):
            robot.beside[side], robot.contact, robot.role = WALL, lost.wall, "leader"
            return ""
    robot.beside[side] = NOBODY
    return f"r{number} is silent"
