"""How robots come to stand beside each other, and cease to, without the barrier opening.

Every change is made in two phases: who comes in is in place before the old link is given up, and nobody gives
up a link until the other end has shown that it holds the new one. Until then both count for its motion. All
that is said is a state, said again in every tick, so that lost frames cost time and nothing else.
"""

from swarm_agent.sweep import robust, robust_line
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import BARRIER, NOBODY, OTHER, SIDES, WALL, Side
from swarm_agent.sweep.robot import NEVER, Robot

PATIENCE_TICKS, FORGOTTEN = 12, 3
BARELY_M = 0.02  # the margin that is enough for a link that nobody opens before it is taken over


def tend(robot: Robot) -> str:
    """Take over, or give up, links as neighbours ask for. Returns why the barrier is open, or nothing."""
    robot.refused = {
        one for one in robot.refused if (peer := robot.peer(one)) and peer.beacon.role == "joining"
    }
    for side in SIDES:
        if not _holds_without(robot, side):
            robot.needed_tick[side] = robot.tick
    beside = robot.beside.values()
    for number in [number for number in robot.old if number in beside or _is_over(robot, number)]:
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


def _is_over(robot: Robot, number: int) -> bool:
    """Is the old link to a robot given up by both ends, and is who came between them on the line?

    It may have given up while they took it over; then they still have each other.
    """
    peer, between = robot.peer(number), robot.neighbour(robot.old[number])
    if peer is None:
        return True
    stands = between is None or (between.beacon.role in BARRIER and not _is_free_of(robot, between.number))
    return stands and _is_free_of(robot, number) and _answers(robot, peer)


def _answers(robot: Robot, peer: Peer) -> bool:
    """Had it heard of our latest link when it spoke? Before, what it says of its own is no refusal."""
    return peer.heard_tick(robot.number) >= robot.linked_tick


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
    """Do both neighbours hold each other, or another robot in its place? Or has it had no news for a while?

    Of two robots that have the same neighbours only the one with the higher number gives way: news is late,
    and each might see that both hold the other.
    """
    left, right = (robot.neighbour(side) for side in SIDES)
    if left is None or right is None:
        return False
    if any(robot.told.values()):
        robot.held_tick = robot.tick
    if robot.tick - robot.held_tick > FORGOTTEN * _patience(robot):
        return True
    if left.beacon.right == right.number and right.beacon.left == left.number:
        return True
    instead = robot.peer(left.beacon.right)
    return (
        instead is not None
        and instead.number < robot.number
        and instead.beacon.role in BARRIER
        and right.beacon.left == instead.number
        and (instead.beacon.left, instead.beacon.right) == (left.number, right.number)
        and robot.margin_m(instead.here, right.here, robot.walls(instead, right)) >= robot.step_m
    )


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
        if near and agreed and robot.link_m(beyond, side) >= robot.needed_m(beyond):
            _relink(robot, side, onward)
        return
    if robot.role == "leaving" or (robot.ready and not (robot.is_robust and side == "right")):
        return
    for one in robot.peers.known.values() if beacon.role in BARRIER else ():  # one comes in after the other
        asks = one.beacon.role == "joining" and one.beacon.beside(side) == peer.number
        if not asks or one.beacon.beside(OTHER[side]) != robot.number or one.number in robot.refused:
            continue
        agreed = side == "right" or beacon.right == one.number
        if agreed and robot.link_m(one, side) >= BARELY_M:
            _relink(robot, side, one.number)
            return
    instead = _instead(robot, peer) if side == "left" else None
    if instead is not None:
        _relink(robot, side, instead.number)
    elif back != robot.number and beacon.role != "joining":
        if _answers(robot, peer):
            _turn_back(robot, side)
    elif beacon.role == "joining" and side == "right" and robot.tick - robot.linked_tick > _patience(robot):
        _turn_back(robot, side)


def _instead(robot: Robot, peer: Peer) -> Peer | None:
    """Who claims the place of a left neighbour, if the robot on the left of both holds that one."""
    left = robot.peer(peer.beacon.left)
    one = robot.peer(left.beacon.right) if left is not None else None
    if one is None or one is peer or one.beacon.role not in BARRIER:
        return None
    fits = (one.beacon.left, one.beacon.right) == (left.number, robot.number)
    return one if fits and robot.link_m(one, "left") >= BARELY_M else None


def _turn_back(robot: Robot, side: Side) -> None:
    """Who we link to does not link to us: it gave up, or the other end decided otherwise. Who does?"""
    for one in robot.peers.known.values():
        holds = one.beacon.beside(OTHER[side]) == robot.number and one.beacon.role in ("centre", "leader")
        if holds and one.number != robot.beside[side]:
            robot.refused.add(robot.beside[side])
            _relink(robot, side, one.number)
            return
    if robot.neighbour(side).beacon.role not in (*BARRIER, "joining"):
        for number in [number for number, of in robot.old.items() if of == side and robot.peer(number)]:
            robot.refused.add(robot.beside[side])
            _relink(robot, side, number)


def _relink(robot: Robot, side: Side, number: int) -> None:
    if robot.beside[side] > 0:
        robot.old[robot.beside[side]] = side
    robot.old.pop(number, None)
    robot.beside[side], robot.linked_tick = number, robot.tick
    robot.needed_tick[side] = NEVER if _holds_without(robot, side) else robot.tick


def _adopt_line(robot: Robot, peer: Peer, side: Side) -> None:
    """Lines get their numbers where they are cut, and tell them on."""
    beacon = peer.beacon
    held = beacon.beside(OTHER[side]) == robot.number
    if held and beacon.role in ("centre", "leader") and beacon.since > robot.since:
        robot.line, robot.since = beacon.line, beacon.since


def _give_up(robot: Robot, side: Side) -> str:
    """A neighbour fell silent that did not hold it yet, or any more. Who does?"""
    before = next((one for one, of in robot.old.items() if of == side and not _is_free_of(robot, one)), None)
    if before is not None:
        _relink(robot, side, before)
        return ""
    other = robot.neighbour(OTHER[side])
    if robot.beside[OTHER[side]] == WALL or (other is not None and not _is_free_of(robot, other.number)):
        silent, robot.beside[side] = robot.beside[side], NOBODY
        return f"r{silent} is silent"
    robot.dead.discard(robot.beside[side])  # it is out of reach, and not dead
    robot.become("reserve")
    return ""


def _holds_without(robot: Robot, side: Side) -> bool:
    """Would the line hold if its neighbour on that side were gone?"""
    peer = robot.neighbour(side)
    if peer is None:
        return True  # it has fallen silent just now
    onward = peer.beacon.beside(side)
    if onward == WALL:
        return robot.role == "centre" and robot.sees(peer.wall)
    beyond = robot.peer(onward)
    near = beyond is not None and abs(beyond.here - robot.here) <= 2 * robot.reach_m
    return near and robot.link_m(beyond, side) >= 0


def _lose(robot: Robot, side: Side) -> str:
    """A neighbour is silent for good: the link may hold without it. Returns what is wrong, or nothing.

    It must have held without it at all times since it was last heard: a gap of one tick lets everything in.
    """
    number = robot.beside[side]
    robot.dead.add(number)
    robot.old.pop(number, None)
    lost = robot.peers.lost.get(number)
    if robot.is_robust and robust_line.close_ranks(robot, side, lost):
        return ""
    if lost is not None and robot.number not in (lost.beacon.left, lost.beacon.right):
        return _give_up(robot, side)
    if lost is not None:
        held = robot.needed_tick[side] < lost.tick
        beyond = robot.peer(lost.beacon.beside(side))
        if held and beyond is not None and robot.link_m(beyond, side) >= 0:
            robot.beside[side] = beyond.number
            return ""
        if held and lost.beacon.beside(side) == WALL and robot.role == "centre" and robot.sees(lost.wall):
            robot.beside[side], robot.contact, robot.role = WALL, lost.wall, "leader"
            return ""
    robot.beside[side] = NOBODY
    return f"r{number} is silent"
