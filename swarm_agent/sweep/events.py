"""What happens to a line: it stands, splits at an obstacle, loses a closed side, or dissolves.

Nothing is decided before the whole line has stood still for so long that all news is from then.
"""

import math

import networkx

from swarm_agent.graph_clear import next_vertex
from swarm_agent.sweep import robust_line
from swarm_agent.sweep.gait import touch
from swarm_agent.sweep.geometry import turn_rad
from swarm_agent.sweep.outlook import Outlook, is_closed_to, sides_open
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import GO_HOME, NOBODY, OTHER, SIDES, WALL, Side
from swarm_agent.sweep.robot import Robot

TURNED_RAD = 1.5 * math.pi
OWN_M = 0.1  # from where a leader holds its wall
TOLD_TICKS = 20  # for so long a new end of a line says why it is one


def decide(robot: Robot, outlook: Outlook) -> None:
    """Stand, split, or give up what is closed, as all that is known of the line calls for."""
    met, robot.meets = robot.meets, NOBODY
    if robot.tick - robot.since_role > TOLD_TICKS * robot.parameters.hop_ticks:
        robot.stage = ""
    if robot.role == "leader":
        if _meet(robot, outlook, met):
            return
        robot.close = robot.obstacle is not None
        if robot.wall_side() == "right":
            _end_of_line(robot)
    elif robot.role == "centre":
        _in_the_middle(robot, outlook)
    else:
        robot.halt = False


def _end_of_line(robot: Robot) -> None:
    """The right leader dissolves a line that has nothing ahead."""
    told = robot.told["left"]
    robot.halt = not robot.open and told is not None and not told.open and not _is_turned_over(robot)
    if robot.halt and robot.is_quiet:
        robot.events.append("dissolve")
        if robot.is_main:
            robot.graph.dissolve()
            choose_next(robot)
        else:
            robot.gone.add(robot.line)
        robot.become("reserve", "gone")


def _is_turned_over(robot: Robot) -> bool:
    """Is the back of a line of two where it takes its front to be? Then one angle is nearly all around."""
    told = robot.told["left"]
    return robot.count == 2 and robot.angle_rad + told.angle_rad > TURNED_RAD


def choose_next(robot: Robot) -> None:
    """A standing line becomes the main line, as the plan for what is known of the floor wants it."""
    strike_out(robot)
    lines, cleared = robot.graph.lines(), robot.graph.cleared()
    if not lines or not cleared:
        return
    around = networkx.node_connected_component(robot.graph.net, min(cleared))  # not from before a restart
    vertex = next_vertex(robot.graph.net.subgraph(around), cleared & around, robot.team)
    wanted = [line for line in lines if robot.graph.ahead_of(line) == vertex]
    robot.graph.activate(wanted[0] if wanted else max(lines))


def strike_out(robot: Robot) -> None:
    """Lines that have dissolved where they stood are no lines any more."""
    for line in sorted(robot.gone & set(robot.graph.lines())):
        if line in robot.graph.lines():  # else another one before the same vertex has gone, and this with it
            robot.graph.vanish(line)


def _meet(robot: Robot, outlook: Outlook, met: int) -> bool:
    """Two lines that meet from the front at one wall, with nothing between them, become one. Was it so?

    One of them is the main line, whose leader comes first; the island whose wall both held is behind them.
    """
    side = robot.wall_side()
    main = robot.graph.main
    if robot.any_told("meets"):
        robot.other_met_tick = robot.tick
    for peer in robot.peers.known.values():
        beacon = peer.beacon
        named = beacon.beside(OTHER[side]) == robot.number
        faces = beacon.role == "leader" and beacon.beside(OTHER[side]) == WALL and beacon.line != robot.line
        if main is None or main.line not in (robot.line, beacon.line) or not (named or faces):
            continue
        if robot.link_m(peer, side) < robot.step_m or not is_closed_to(robot, outlook, peer, side):
            continue
        if robot.is_robust and not robust_line.may_meet(robot, peer, side):
            continue
        if robot.is_main and not met and robot.tick <= robot.other_met_tick + 2 * _heard_ticks(robot):
            continue
        robot.meets, robot.old[peer.number] = peer.number, side
        if met != peer.number:
            robot.met_tick = robot.tick
        answered = named and met == peer.number and _has_heard(robot, peer)  # or it does not know yet
        if answered or (robot.is_main and beacon.meets == robot.number and _is_first(robot, side)):
            _become_one(robot, peer, side)
            return True
    return False


def _is_first(robot: Robot, side: Side) -> bool:
    """Does the other end of the line not meet anybody at the same time? The right end need not ask.

    If both did, a line could lose both its ends.
    """
    if side == "right":
        return True
    told = robot.told["right"]
    since = max(robot.met_tick, robot.other_met_tick) + _heard_ticks(robot)
    return told is not None and not told.meets and told.since >= since


def _has_heard(robot: Robot, peer: Peer) -> bool:
    """Had it heard that we would become one with it, and are an end of a line, when it spoke?"""
    return peer.heard_tick(robot.number) >= max(robot.met_tick, robot.since_role)


def _heard_ticks(robot: Robot) -> int:
    """By then the other end of the line has heard of something, and more."""
    return 2 * robot.count * robot.parameters.hop_ticks


def _become_one(robot: Robot, peer: Peer, side: Side) -> None:
    """Both leaders are robots in the middle now; the line has the number of the main line."""
    if robot.is_main:
        flows = (peer.beacon.from_left, peer.beacon.from_right)
        robots = robot.count + max((flow.count for flow in flows if flow), default=1)
        if peer.beacon.line in robot.graph.lines():
            robot.graph.meet(peer.beacon.line, robots)
        robot.since = robot.tick
        robot.events.append("merge")
    robot.old.pop(peer.number, None)
    robot.role, robot.stage, robot.since_role, robot.held_tick = "centre", "", robot.tick, robot.tick
    robot.beside[side], robot.meets, robot.close, robot.halt = peer.number, NOBODY, False, False


def _in_the_middle(robot: Robot, outlook: Outlook) -> None:
    was_ready = robot.ready
    robot.ready = False
    for side in SIDES:
        peer = robot.neighbour(side)
        if peer is None:
            continue
        if was_ready and _was_cut(robot, peer, side):
            _become_end(robot, side, robot.contact)
            robot.line, robot.since = peer.beacon.line + (1 if side == "left" else -1), peer.beacon.since
            return
        if _waits_for(robot, peer, side):
            robot.pinned = robot.halt = False
            if robot.sees(peer.wall):
                robot.ready, robot.contact = True, peer.wall
                if robot.is_robust:
                    touch(robot)
    if robot.ready or _beside_pivot(robot):
        return
    held = robot.pinned and robot.sees(robot.contact)
    place = robot.contact if held else robot.obstacle
    if place is None or robot.order == GO_HOME or _is_passed(robot, outlook, place):
        robot.pinned = robot.halt = False
        return
    was_pinned = robot.pinned
    if not was_pinned:
        robot.contact, robot.halt = robot.obstacle, True
    if robot.is_robust:
        touch(robot)  # its shadow is to see the place that it will hold as a leader
    if was_pinned and robot.is_main and _split(robot):
        return
    if robot.is_quiet:
        _judge(robot, outlook)


def _was_cut(robot: Robot, peer: Peer, side: Side) -> bool:
    beacon = peer.beacon
    return beacon.stage == "cut" and beacon.beside(OTHER[side]) == WALL and beacon.role == "leader"


def _waits_for(robot: Robot, peer: Peer, side: Side) -> bool:
    """Is that neighbour a pivot, and we the one to stand beside it? Of two pivots the right one gives way."""
    held = peer.beacon.beside(OTHER[side]) == robot.number
    if robot.is_robust and side == "right":
        return False  # the left neighbour of a pivot will be its shadow
    return held and peer.beacon.pinned and (side == "left" or not robot.pinned)


def _beside_pivot(robot: Robot) -> bool:
    left = robot.neighbour("left")
    return left is not None and left.beacon.pinned


def _is_passed(robot: Robot, outlook: Outlook, place: complex) -> bool:
    """Has a leader beside it gone past the obstacle, or come to it as its own wall, with more ahead?"""
    ahead_rad = turn_rad(outlook.ways["left"], outlook.ways["right"], "right")
    is_behind = turn_rad(outlook.ways["left"], place - robot.here, "right") > ahead_rad
    for side in SIDES:
        peer, told = robot.neighbour(side), robot.told[side]
        if peer is None or peer.beacon.role != "leader":
            continue
        if is_behind or (told is not None and told.open and abs(peer.wall - place) < OWN_M):
            return True
    return False


def _judge(robot: Robot, outlook: Outlook) -> None:
    """An obstacle ahead: is there anything on both sides of it?"""
    open_left, open_right = sides_open(outlook, robot.contact)
    open_left = open_left or robot.told["left"].open
    open_right = open_right or robot.told["right"].open
    if open_left and open_right:
        robot.pinned, robot.halt, robot.closing = True, False, False
    elif open_left or open_right:
        side: Side = "left" if open_right else "right"
        if robot.is_robust and not robust_line.may_end(robot, side):
            robot.pinned, robot.halt, robot.closing = True, False, True
            return
        robot.events.append("closed")
        _become_end(robot, side, robot.contact)
        robot.stage = "closed"


def _split(robot: Robot) -> bool:
    """A neighbour sees the wall too: each becomes the end of a line of its own. Was it so?

    Of several pivots of a line the leftmost comes first: only one robot writes into the graph at a time.
    """
    if robot.told["left"] is None or robot.told["left"].pivot or robot.closing:
        return False
    for side in ("right", "left"):
        peer = robot.neighbour(side)
        held = peer is not None and peer.beacon.ready and peer.beacon.beside(OTHER[side]) == robot.number
        if not held or robot.old or not robot.is_whole:
            continue
        if robot.is_robust and not robust_line.may_cut(robot, side):
            continue
        left = robot.told["left"].count + (side == "right")
        right = robot.told["right"].count + (side == "left")
        lines = robot.graph.split(left, right)
        more_left = (left >= right) == (robot.parameters.choose == "more")
        robot.graph.activate(lines[0] if more_left else lines[1])
        _become_end(robot, side, robot.contact)
        robot.line, robot.since, robot.stage = lines[0] if side == "right" else lines[1], robot.tick, "cut"
        robot.events.append("split")
        return True
    return False


def _become_end(robot: Robot, side: Side, wall: complex) -> None:
    """The link on that side is given up for a wall."""
    robot.role, robot.stage, robot.since_role = "leader", "", robot.tick
    robot.beside[side], robot.contact = WALL, wall
    robot.pinned = robot.halt = robot.close = robot.ready = robot.closing = False
