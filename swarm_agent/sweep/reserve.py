"""Robots that are on no line: they follow the main line in file, come in where it needs one more, or travel.

Who sees nobody of the main line goes along walls, and along the backs of other lines as if they were walls,
all on the same hand; so it meets every line there is on that ring of walls.
"""

import numpy as np

from swarm_agent.sweep.across import back_across
from swarm_agent.sweep.filling import fill
from swarm_agent.sweep.geometry import clearance_m, unit
from swarm_agent.sweep.knots import is_knotted
from swarm_agent.sweep.links import BARELY_M, ask_in
from swarm_agent.sweep.moves import toward
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import NOBODY, OTHER, Side
from swarm_agent.sweep.robot import UNRANKED, Robot
from swarm_agent.sweep.travel import Round

ROOM_M = {"leader": 0.4, "reserve": 0.26, "free": 0.26}
ROOM_ELSE_M = 0.28
TRAVEL_ROOM_M = 0.24
FILE_M, LEADER_FILE_M = 0.36, 0.5
NEAR_M, HEARD_M, FAR_M = 0.6, 1.2, 1.9
BODY_WIDTH_M = 0.13
CRUMB_M = 0.04
BARRED_TICKS = 40
DETOUR_M = 0.2  # who stood far behind would bend the line around walls that it has passed
KEPT_M = 0.2
MOST_TAIL = 50
STALLED_TICKS = 60
WAIT_TICKS = 3
DEPART_M = 0.5
REFUSED_TICKS = 25


class Reserve:
    """What a robot remembers while it is on no line."""

    def __init__(self) -> None:
        self.round = Round()
        self.underway = self.gone_round = False
        self._depart_tick = 0
        self._asked: tuple[bool, int, int] = (False, 0, 0)
        self._asked_tick = self._refusals = self._again_tick = 0

    def begin(self, robot: Robot, hand: Side = "left") -> None:
        """It has just left a line, or heard that the team begins again."""
        self.round = Round(hand)
        self.underway, self.gone_round, self._depart_tick = False, False, 0
        robot.contact = robot.nearest_wall() or robot.here

    def refused(self, robot: Robot) -> None:
        """The line did not take it in: it waits, longer each time, so that somebody else can ask."""
        self._refusals += 1
        self._again_tick = robot.tick + self._refusals * REFUSED_TICKS * robot.parameters.hop_ticks

    def way(self, robot: Robot) -> complex:
        """Where to go now. It may ask to come into the line instead."""
        carries = robot.number in robot.couriers and not _is_homing(robot)
        leader = None if carries else _choose(robot)
        robot.ahead = leader.number if leader else NOBODY
        robot.rank = _rank(robot, leader)
        robot.tail = min(MOST_TAIL, 1 + _followers(robot))
        ours = leader is not None and is_ours(robot, leader)
        room = _make_room(robot, robot.is_robust and ours and _is_wanted(leader))
        if room:
            return room
        way = self._come_in(robot, leader) if ours and robot.is_robust else None  # behind may be no room yet
        if way is None:
            way = back_across(robot, self.round.goes_through(robot))
        if way is None and ours and not robot.is_robust:
            way = self._come_in(robot, leader)
        if way is not None:
            return way
        if leader is None:
            return self._carry_word(robot) if carries else self._travel(robot)
        return _follow(robot, leader)

    def _carry_word(self, robot: Robot) -> complex:
        """A courier goes round the walls from the anchor, until it meets the other one, or the anchor."""
        if not self.underway:
            return self._depart(robot)
        met = [peer for number in (robot.anchor, *robot.couriers) if (peer := robot.peer(number))]
        if not met:
            self.gone_round = True
        elif self.gone_round and any(_is_in_sight(robot, peer) for peer in met):
            robot.couriers = ()
        return self.round.way(robot)

    def _depart(self, robot: Robot) -> complex:
        """Couriers begin at the wall of the anchor, on each side of it, else they might go the same way."""
        anchor = robot.peer(robot.anchor)
        self._depart_tick = self._depart_tick or robot.tick
        stalled = robot.tick - self._depart_tick > STALLED_TICKS * robot.parameters.hop_ticks
        if anchor is None or stalled:
            self.underway, robot.contact = True, robot.nearest_wall() or robot.contact
            return 0j
        ahead = unit(anchor.wall - anchor.here) * (-1j if self.round.hand == "left" else 1j)
        place = anchor.here + DEPART_M * ahead
        if anchor.wall != anchor.here and abs(place - robot.here) < DEPART_M / 2:
            self.underway, robot.contact = True, anchor.wall
        return toward(robot, place)

    def _travel(self, robot: Robot) -> complex:
        if robot.graph.main is None and not robot.graph.lines() and not robot.anchor:
            return 0j
        return self.round.way(robot)

    def _come_in(self, robot: Robot, beside: Peer) -> complex | None:
        """Ask into a link beside that robot, if the line wants one more; or go to where that can be done."""
        beacon = beside.beacon
        flows = [flow for flow in (beacon.from_left, beacon.from_right) if flow]
        wanted, count = _is_wanted(beside), sum(flow.count for flow in flows)
        asked = (wanted, count, beside.number)
        if asked != self._asked:
            if not wanted:
                self._refusals = 0
            self._asked, self._asked_tick = asked, robot.tick
        wait = (WAIT_TICKS + (2 * count if _is_second(robot) else 0)) * robot.parameters.hop_ticks
        too_early = robot.tick - self._asked_tick <= wait or robot.tick < self._again_tick
        if not wanted or len(flows) < 2 or too_early:
            return None
        if robot.is_robust:
            return fill(robot, beside, robot.tick - self._asked_tick > wait + BARRED_TICKS)
        middles = []
        for side in ("right", "left"):
            other = robot.peer(beacon.beside(side))
            if other is None or not _is_link(beside, other, side):
                continue
            left, right = (beside, other) if side == "right" else (other, beside)
            detour_m = (
                abs(left.here - robot.here) + abs(right.here - robot.here) - abs(left.here - right.here)
            )
            holds = min(robot.link_m(left, "left"), robot.link_m(right, "right")) >= BARELY_M
            holds = holds and not is_knotted(robot, left, right)
            barred = robot.tick - self._asked_tick > wait + BARRED_TICKS * robot.parameters.hop_ticks
            if holds and (detour_m <= DETOUR_M or barred):
                ask_in(robot, left, right)
                return 0j
            middles.append((left.here + right.here) / 2)
        if not middles:
            return None
        return toward(robot, min(middles, key=lambda place: abs(place - robot.here))) or None


def _is_wanted(beside: Peer) -> bool:
    """Does its line want one more robot?"""
    return any(flow and flow.want for flow in (beside.beacon.from_left, beside.beacon.from_right))


def _is_homing(robot: Robot) -> bool:
    """Is the anchor on its way home? Couriers go with it."""
    anchor = robot.peer(robot.anchor)
    return anchor is not None and anchor.beacon.stage == "homing"


def _rank(robot: Robot, leader: Peer | None) -> int:
    """Its place behind the line; whoever follows nobody, or only others like itself, has none."""
    if leader is None:
        return UNRANKED
    rank = 1 if is_ours(robot, leader) else leader.beacon.rank + 1
    return rank if rank <= robot.parameters.team else UNRANKED


def is_ours(robot: Robot, peer: Peer) -> bool:
    """Does that robot stand on the main line, or is it the one to gather around?"""
    beacon, main = peer.beacon, robot.graph.main
    if beacon.epoch != robot.epoch:
        return False
    if beacon.role == "anchor" or beacon.stage == "forming":
        return True
    return beacon.role in ("leader", "centre") and main is not None and beacon.line == main.line


def _make_room(robot: Robot, near: bool) -> complex:
    """Away from who is too near; lines have the right of way."""
    push = 0j
    for peer in robot.peers.known.values():
        away, room_m = robot.here - peer.here, ROOM_M.get(peer.beacon.role, ROOM_ELSE_M)
        if robot.ahead == NOBODY or near:
            room_m = min(room_m, TRAVEL_ROOM_M)
        if abs(away) < room_m:
            push += unit(away) * (room_m + 0.02 - abs(away))
    return toward(robot, robot.here + unit(push) * robot.step_m) if push else 0j


def _followers(robot: Robot) -> int:
    return sum(peer.beacon.tail for peer in _file(robot) if peer.beacon.ahead == robot.number)


def _file(robot: Robot) -> list[Peer]:
    return [peer for peer in robot.peers.known.values() if peer.beacon.role == "reserve"]


def _choose(robot: Robot) -> Peer | None:
    """Whom to follow: somebody of the main line, else the last of a file behind it; if it can, the same."""
    taken = {peer.beacon.ahead: peer.number for peer in _file(robot) if peer.beacon.ahead}
    reach: list[tuple[int, float, Peer]] = []
    for peer in robot.peers.known.values():
        far_m = abs(peer.here - robot.here)
        if is_ours(robot, peer):
            clear = far_m < NEAR_M or is_clear(robot, peer)
            reach += [(0, far_m, peer)] if clear else []
        elif peer.beacon.role == "reserve" and peer.beacon.rank < UNRANKED:
            follower = taken.get(peer.number)
            given = follower is None or (follower > robot.number and robot.ahead == peer.number)
            if given and peer.beacon.ahead != robot.number and far_m < HEARD_M:
                reach.append((peer.beacon.rank, far_m, peer))
    now = robot.peer(robot.ahead)
    kept = next((one for one in reach if one[2] is now), None)
    if kept is not None and (kept[0] == 0 or kept[0] < robot.rank):
        near = min((far_m for rank, far_m, _ in reach if rank == 0), default=np.inf)
        limit_m = kept[1] - KEPT_M if kept[0] == 0 else NEAR_M
        if near >= limit_m:
            return now
    elif now is not None and is_ours(robot, now) and abs(now.here - robot.here) <= FAR_M:
        return now
    better = [one for one in reach if one[0] < robot.rank or robot.rank >= UNRANKED]
    robot.crumbs = []
    return min(better, key=lambda one: (one[0] > 0, one[1]))[2] if better else None


def _is_in_sight(robot: Robot, peer: Peer) -> bool:
    """Is it not heard through a wall only?"""
    return abs(peer.here - robot.here) < HEARD_M and is_clear(robot, peer)


def is_clear(robot: Robot, peer: Peer) -> bool:
    """Is there room for a body on the straight way to another robot?"""
    return clearance_m(robot.walls(peer), robot.here, peer.here) >= BODY_WIDTH_M


def _is_second(robot: Robot) -> bool:
    """Does somebody else ask already, or has it the right to ask first?"""
    for peer in robot.peers.known.values():
        if peer.beacon.role == "joining":
            return True
        first = peer.beacon.role == "reserve" and peer.beacon.rank == 1 and peer.number < robot.number
        if first:
            return True
    return False


def _is_link(beside: Peer, other: Peer, side: Side) -> bool:
    """Do the two hold each other, and will both stay?"""
    held = other.beacon.beside(OTHER[side]) == beside.number
    stays = all(one.beacon.role in ("leader", "centre") and not one.beacon.ready for one in (beside, other))
    left = beside if side == "right" else other
    return held and stays and not left.beacon.pinned


def _follow(robot: Robot, leader: Peer) -> complex:
    """Along the way that the one ahead has come, up to a distance."""
    if not robot.crumbs or abs(robot.crumbs[-1] - leader.here) > CRUMB_M:
        robot.crumbs.append(leader.here)
    far_m = abs(leader.here - robot.here)
    if far_m <= (LEADER_FILE_M if leader.beacon.role == "leader" else FILE_M):
        del robot.crumbs[:-1]
        return 0j
    for crumb in range(len(robot.crumbs) - 1, -1, -1):
        place = robot.crumbs[crumb]
        if abs(place - robot.here) <= NEAR_M and clearance_m(robot.hits, robot.here, place) >= BODY_WIDTH_M:
            del robot.crumbs[:crumb]
            break
    goal = robot.crumbs[0]
    if abs(goal - robot.here) < robot.step_m and len(robot.crumbs) > 1:
        del robot.crumbs[0]
    return toward(robot, goal)
