"""How a robust line is filled: who is to come in goes to where the line wants one more robot."""

from swarm_agent.sweep import robust_line
from swarm_agent.sweep.geometry import clearance_m
from swarm_agent.sweep.knots import is_knotted
from swarm_agent.sweep.links import BARELY_M, ask_in
from swarm_agent.sweep.moves import toward
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import OTHER, SIDES, WALL, Side
from swarm_agent.sweep.robot import Link, Robot

DETOUR_M = 0.2
ROOM_M = 0.12  # free space on both sides of the way to a link
HOPS = 2


def fill(robot: Robot, beside: Peer, barred: bool) -> complex | None:
    """The way to where the line wants one more robot, along the line from who stands beside it; or ask in.

    `barred`: it has waited long; then it may stand farther aside from the link.
    """
    line = beside.beacon.line
    ours = [link for link in robot.links() if link[0].beacon.line == line and _is_open(*link)]
    links = _near_wanting(robot, ours)
    for left, right in links:
        detour_m = abs(left.here - robot.here) + abs(right.here - robot.here) - abs(left.here - right.here)
        holds = min(robot.link_m(left, "left"), robot.link_m(right, "right")) >= BARELY_M
        near = detour_m <= DETOUR_M or barred
        if near and holds and not is_knotted(robot, left, right) and robust_line.may_join(robot, left, right):
            ask_in(robot, left, right)
            return 0j
    middles = [(left.here + right.here) / 2 for left, right in links]
    clear = [place for place in middles if clearance_m(robot.hits, robot.here, place) >= ROOM_M]
    if clear:
        return toward(robot, min(clear, key=lambda place: abs(place - robot.here))) or None
    onward = _onward(robot, beside)
    return toward(robot, onward.here) or None if onward else None


def _is_open(left: Peer, right: Peer) -> bool:
    """May somebody come in there: will both stay, and is it not where a pivot is to be cut?"""
    stays = all(one.beacon.role in ("leader", "centre") for one in (left, right))
    return stays and not left.beacon.pinned and not right.beacon.ready


def _near_wanting(robot: Robot, links: list[Link]) -> list[Link]:
    """Of some links those that are near to who wants one more, the widest first."""
    wanting = {peer.number for peer in robot.peers.known.values() if _wants_first(robot, peer)}
    for _ in range(HOPS - 1):
        wanting |= {
            one.number for link in links for one in link if any(other.number in wanting for other in link)
        }
    near = [link for link in links if any(one.number in wanting for one in link)]
    return sorted(near, key=lambda link: -abs(link[0].here - link[1].here))


def _wants_first(robot: Robot, peer: Peer) -> bool:
    """Is it the one nearest to an end of the line that wants one more?"""
    return any(_tells_want(peer, side) and not _is_told_want(robot, peer, side) for side in SIDES)


def _tells_want(peer: Peer, side: Side) -> bool:
    flow = peer.beacon.from_left if side == "left" else peer.beacon.from_right
    return flow is not None and flow.want


def _is_told_want(robot: Robot, peer: Peer, side: Side) -> bool:
    before = robot.peer(peer.beacon.beside(side))
    return peer.beacon.beside(side) != WALL and (before is None or _tells_want(before, side))


def _onward(robot: Robot, beside: Peer) -> Peer | None:
    """The neighbour of a robot on the line in whose direction somebody wants one more."""
    for side in SIDES:
        if _tells_want(beside, side) and not _tells_want(beside, OTHER[side]):
            return robot.peer(beside.beacon.beside(side))
    return None
