"""How a team begins, and begins again: robots gather, and two of them form a first line on one wall.

The first line is two leaders at one place of a wall, so close that nothing is between them and the wall that
they do not see. After a loss that cannot be mended, or when no line can go on, one robot is the anchor: all
others that hear of it come to it, and two couriers go round the walls, each its way, to tell who is far.
"""

import numpy as np

from swarm_agent.sweep import fallen
from swarm_agent.sweep.corner import MOST_M, Walk, in_corner
from swarm_agent.sweep.geometry import nearest, unit
from swarm_agent.sweep.moves import best
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import MOST, OTHER, SIDES, WALL, Side
from swarm_agent.sweep.reserve import Reserve, is_clear
from swarm_agent.sweep.robot import Robot
from swarm_agent.sweep.trail import Trail

SETTLE_TICKS, SECOND_TICKS = 6, 40
BESIDE_M, BESIDE_MOST_M, WALL_MOST_M = 0.3, 0.55, 0.4
BESIDE_WALL_M = 0.02
AWAY_M = 4.0  # so far from where it began in vain it begins again
ON_M, STALLED_TICKS = 1.5, 100  # so far on goes an anchor that has not come to a wall for so long
BODY_ROOM_M = 0.75  # between the first leader and the body of a dead robot: the other one stands there
COURIERS = 2
LATE = 5  # of the patience is how much later than couriers somebody may come
FIRST_TICKS, MISSED_M = 100, 1.2
GATHER = 2  # times the patience, for the first to come has the longest way


class Beginning:
    """What a robot remembers of how its team began."""

    def __init__(self) -> None:
        self.beginnings = 0
        self._arrival_tick = self._chosen_tick = self._most_here = 0
        self._walk, self._has_walked = Walk(), False
        self._away_tick = 0
        """Since when the anchor is on its way to the wall."""
        self._trail = Trail()
        self._was_near = False
        self._sent: tuple[int, ...] = ()
        self._back_tick = 0
        """Couriers, and when they had not all come back yet."""
        self._asked: list[int] = []
        """Who did not come when it was asked to be the second leader."""

    def hear(self, robot: Robot, reserve: Reserve) -> None:
        """Take over who is dead, and that the team begins again."""
        if robot.stage != "homing":
            self._trail.note(robot.here)
        for peer in robot.peers.known.values():
            beacon = peer.beacon
            robot.dead.update(number for number in beacon.dead if number not in (0, robot.number))
            robot.gone.update(beacon.gone)
            newer = beacon.epoch > robot.epoch
            if newer or (beacon.epoch == robot.epoch and 0 < beacon.anchor < robot.anchor):
                robot.epoch, robot.anchor, robot.couriers = beacon.epoch, beacon.anchor, beacon.couriers
                robot.become("reserve", "gone")
                reserve.begin(robot, self._hand(robot, peer))
                robot.claim = ""
        fallen.see(robot)
        if robot.role == "reserve" and self._misses_anchor(robot):
            robot.dead.add(robot.anchor)
            self.again(robot, f"r{robot.anchor} is silent", home=False)

    def _misses_anchor(self, robot: Robot) -> bool:
        """Has the anchor fallen silent near by, and is it for this robot to be the next one?"""
        lost = robot.peers.lost.get(robot.anchor)
        if lost is None or robot.graph.main is not None or robot.graph.lines():
            return False
        silent_ticks = robot.tick - lost.tick - robot.parameters.dead_ticks
        if silent_ticks <= robot.parameters.hop_ticks:
            self._was_near = abs(lost.here - robot.here) <= MISSED_M  # else one of them went out of reach
        if not self._was_near or silent_ticks > 2 * SECOND_TICKS:
            return False
        known = robot.peers.known.values()
        return silent_ticks > SECOND_TICKS or all(
            one.number > robot.number for one in known if one.beacon.epoch == robot.epoch
        )

    @staticmethod
    def _hand(robot: Robot, teller: Peer) -> Side:
        """Couriers go away from the anchor, each its way; who is told comes back the way that they went."""
        if robot.number in robot.couriers:
            return SIDES[robot.couriers.index(robot.number) % 2]
        hand = teller.beacon.hand
        return OTHER[hand] if teller.number in robot.couriers else hand

    def again(self, robot: Robot, trouble: str, home: bool) -> None:
        """All that was clear is given up, here and now; this robot is the anchor.

        `home`: it goes back to where the team first began, which was good until somebody died.
        """
        robot.trouble = trouble
        graph = robot.graph
        if graph.main is not None:
            graph.release(None)
        while lines := graph.lines():
            graph.release(min(lines))
        near = sorted(
            robot.peers.known.values(), key=lambda one: (not is_clear(robot, one), abs(one.here - robot.here))
        )
        couriers = tuple(one.number for one in near[:COURIERS]) if len(near) + 1 < robot.team else ()
        robot.become("anchor", "gathering")
        robot.contact = robot.nearest_wall() or robot.here
        robot.epoch, robot.anchor, robot.couriers = robot.epoch + 1, robot.number, couriers
        self._sent = couriers
        robot.claim = ""
        graph.renew(robot.epoch)
        robot.events.append("restart")
        self.beginnings += 1
        if home and robot.epoch == 1:
            robot.stage = "homing"
            self._trail.begin(robot.tick)
        self._arrival_tick, self._most_here = robot.tick, 0
        self._away_tick, self._has_walked = robot.tick, False
        if self.beginnings > 1:
            self._walk_on(AWAY_M, MOST_M)

    def first(self, robot: Robot) -> complex:
        """A robot at the start: the one with most walls around it forms the first line with another."""
        second = self._second(robot)
        if second is not None:
            return second
        known = robot.peers.known.values()
        anchor = next((one.number for one in known if one.beacon.role == "anchor"), 0)
        if anchor or any(one.beacon.role == "leader" and one.beacon.stage != "forming" for one in known):
            robot.become("reserve")
            robot.anchor = anchor
            return 0j
        if robot.tick - robot.born < SETTLE_TICKS * robot.parameters.hop_ticks:
            return 0j
        if any(one.beacon.role == "leader" for one in known) or not self._is_first(robot):
            robot.stage = ""
            return 0j
        robot.stage = "forming"
        way = _to_wall(robot)
        if way is not None:
            return way
        if not in_corner(robot):
            robot.become("anchor", "gathering")
            robot.anchor, self._arrival_tick = robot.number, robot.tick
            self._walk_on(0.0, MOST_M)
            return 0j
        return self._form(robot)

    def _is_first(self, robot: Robot) -> bool:
        """Is it the one to form a line: of those who have begun to, else of all, who stands deepest?"""
        known = robot.peers.known.values()
        begun = [one for one in known if one.beacon.role == "free" and one.beacon.stage == "forming"]
        if begun or robot.stage == "forming":
            return robot.stage == "forming" and robot.number < min(
                (one.number for one in begun), default=MOST
            )
        told_m = robot.eye.unpacked(robot.eye.packed(robot.ranges_m))  # as the others have it
        own = (*_openness(robot, told_m), robot.number)
        return all((*_openness(robot, one.ranges_m), one.number) > own for one in known)

    def gather(self, robot: Robot) -> complex:
        """The anchor: it goes home, or away if that was in vain, on to a corner, waits, and forms."""
        if robot.stage == "homing":
            way = self._trail.way(robot)
            if way is not None:
                return way
            robot.stage, self._arrival_tick, self._away_tick = "gathering", robot.tick, robot.tick
        if not self._walk.is_over:
            self._away_tick = robot.tick
            return self._walk.way(robot)
        way = _to_wall(robot)
        if way is not None:
            if robot.tick - self._away_tick > STALLED_TICKS * robot.parameters.hop_ticks:
                self._walk_on(ON_M, MOST_M)
            return way
        if not self._has_walked and not in_corner(robot):
            self._walk_on(0.0, MOST_M)
            return 0j
        here = 1 + sum(
            peer.beacon.tail for peer in robot.peers.known.values() if peer.beacon.ahead == robot.number
        )
        known = robot.peers.known.values()
        here = max(here, 1 + sum(peer.beacon.epoch == robot.epoch for peer in known))
        if here > self._most_here:
            self._most_here, self._arrival_tick = here, robot.tick
        waited = robot.tick - self._arrival_tick
        if here < 2 or (here < robot.team and waited < self._patience(robot)):
            return 0j
        return self._form(robot)

    def _patience(self, robot: Robot) -> int:
        """How long to wait for one more: not for long when the couriers are back, and all have been told."""
        sent = [robot.peer(number) for number in self._sent if number not in robot.dead]
        back = bool(sent) and all(one and one.beacon.ahead and not one.beacon.couriers for one in sent)
        if not back:
            self._back_tick = robot.tick
        long = GATHER * robot.parameters.patience_ticks if robot.epoch else FIRST_TICKS
        return long if robot.tick - self._back_tick <= robot.parameters.patience_ticks / LATE else 0

    def await_second(self, robot: Robot) -> None:
        """The first leader waits for the other one, and asks somebody else after a while."""
        other = robot.neighbour("right")
        if other is not None and other.beacon.left == robot.number:
            robot.stage = ""
        elif other is None or robot.tick - self._chosen_tick > SECOND_TICKS:
            near = [one for one in _candidates(robot) if one.number not in self._asked]
            self._asked.append(robot.beside["right"])
            self._chosen_tick = robot.tick
            if near:
                robot.beside["right"] = _nearest_to_spot(robot, near).number
            else:  # there is no room beside it
                robot.become("anchor", "gathering")
                self._walk_on(ON_M, MOST_M)

    def second(self, robot: Robot) -> complex | None:
        """The step of one who is asked to be the other leader of a first line; None if nobody asks."""
        return self._second(robot)

    def _walk_on(self, least_m: float, most_m: float) -> None:
        self._walk.begin(least_m, most_m)
        self._has_walked = True

    def _form(self, robot: Robot) -> complex:
        """It stands at a wall: it is a leader there, and asks for another one."""
        wall = robot.contact
        near = _candidates(robot)
        if near:
            robot.become("leader", "forming")
            robot.since, robot.contact = robot.tick, wall
            robot.beside = {"left": WALL, "right": _nearest_to_spot(robot, near).number}
            self._chosen_tick, self._asked = robot.tick, []
        return 0j

    def _second(self, robot: Robot) -> complex | None:
        if robot.graph.main is not None:
            return None
        for peer in robot.peers.known.values():
            beacon = peer.beacon
            if beacon.stage == "forming" and beacon.right == robot.number and beacon.epoch == robot.epoch:
                return _stand_beside(robot, peer)
        return None


def _to_wall(robot: Robot) -> complex | None:
    """A step to the nearest wall where no dead body lies; None beside it."""
    free = robot.hits
    for body in robot.fallen:
        free = free[np.abs(free - body) > BODY_ROOM_M]
    wall = nearest(free, robot.here) or robot.nearest_wall()
    if wall is None:
        return best(robot, robot.step_m + 0j, holds=False)
    robot.contact = wall
    if len(robot.hits) and abs(wall - robot.here) <= robot.parameters.obstacle_m + BESIDE_WALL_M:
        return None
    return best(robot, wall - robot.here, holds=False, wall_m=0.1)


def _stand_beside(robot: Robot, first: Peer) -> complex:
    """Go to the place at the same wall on the right of the first leader, and be the second one there."""
    right = -1j * unit(first.here - first.wall)
    beside = robot.hits[np.abs(robot.hits - first.wall) < BESIDE_MOST_M]  # and not at a wall opposite
    wall = nearest(beside, robot.here)
    at_wall = wall is not None and abs(wall - robot.here) < WALL_MOST_M
    away = robot.here - first.here
    if at_wall and abs(away) < BESIDE_MOST_M and (away / right).real > 0.1:
        robot.become("leader")
        robot.beside = {"left": first.number, "right": WALL}
        robot.contact, robot.moved, robot.since = wall, robot.tick, first.beacon.since
        robot.graph.begin(2)
        return 0j
    return best(robot, first.here + right * BESIDE_M - robot.here, holds=False)


def _nearest_to_spot(robot: Robot, peers: list[Peer]) -> Peer:
    """Who is nearest to the place of the second leader."""
    spot = robot.here - 1j * unit(robot.here - robot.contact) * BESIDE_M
    return min(peers, key=lambda one: abs(one.here - spot))


def _candidates(robot: Robot) -> list[Peer]:
    """Who can be asked to be the second leader."""
    return [
        peer
        for number, peer in sorted(robot.peers.known.items())
        if peer.beacon.role in ("reserve", "free") and peer.beacon.epoch == robot.epoch
        if number != robot.beside["right"] and abs(peer.here - robot.here) < 4 * BESIDE_M
    ]


def _openness(robot: Robot, ranges_m: np.ndarray) -> tuple[bool, int]:
    """Is a wall out of reach, and how many rays meet none: least for who stands deepest in a corner.

    Nobody is in that one's way there.
    """
    far = float(ranges_m.min()) > robot.parameters.obstacle_m + robot.body_m / 2
    return far, int(np.isinf(ranges_m).sum())
