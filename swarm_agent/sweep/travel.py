"""How a robot travels that sees nobody to follow: along walls, and the backs of lines as if they were walls.

So it meets every line there is on that ring of walls. Whoever has gone all round, on an island or in a pocket
behind a line, and met nobody, goes straight across to another wall.
"""

import numpy as np

from swarm_agent.sweep.geometry import NOTHING, nearest, roll, unit
from swarm_agent.sweep.moves import may, toward
from swarm_agent.sweep.radio import BARRIER, OTHER, Side
from swarm_agent.sweep.robot import Robot

WALL_M, KEEP_M, KEEP_MOST_M = 0.2, 0.25, 0.45
STALLED_M, STALLED_TICKS, COURIERS_STALL = 0.3, 60, 4
RING_M, CLOSED_M = 3.0, 0.25
FARTHER_M = 1.3  # each time it leaves the ring so much farther on, or it would go to the same place
ACROSS_M, ACROSS_MOST_M, BEFORE_M = 0.8, 8.0, 0.35
THROUGH_TICKS = 400


class Round:
    """The way of one robot. `hand`: on which side it keeps walls."""

    def __init__(self, hand: Side = "left") -> None:
        self.hand = hand
        self._place, self._place_tick = 0j, 0
        self._start: complex | None = None
        self._walked_m, self._times = 0.0, 0
        self._left_m: float | None = None
        """How much farther to go on a ring that it has gone all round."""
        self._heading, self._crossed_m, self._through_tick = 0j, 0.0, 0

    def goes_through(self, robot: Robot) -> bool:
        """Has it gone across of late, and through lines that stood in its way?"""
        return 0 < robot.tick - self._through_tick < THROUGH_TICKS and self._times > 0

    def way(self, robot: Robot) -> complex:
        """The next step; who meets another and comes no farther turns round, couriers last."""
        if self._heading:
            return self._across(robot)
        if abs(robot.here - self._place) > STALLED_M:
            self._place, self._place_tick = robot.here, robot.tick
        patience = STALLED_TICKS * (COURIERS_STALL if robot.number in robot.couriers else 1)
        if robot.tick - self._place_tick > patience:
            self.hand, self._place_tick, self._start = OTHER[self.hand], robot.tick, None
        if self._is_round(robot):
            self._heading = unit(robot.here - robot.contact)
            self._crossed_m, self._start, self._through_tick = 0.0, None, robot.tick
            self._times += 1
        way = travel(robot, self.hand)
        self._walked_m += abs(way)
        return way

    def _is_round(self, robot: Robot) -> bool:
        """Is it again where it began to go round, or a little farther?"""
        if self._start is None:
            self._start, self._walked_m, self._left_m = robot.here, 0.0, None
        elif self._left_m is not None:
            self._left_m -= robot.step_m
        elif self._walked_m >= RING_M and abs(robot.here - self._start) < CLOSED_M:
            self._left_m = self._times * FARTHER_M
        return self._left_m is not None and self._left_m <= 0

    def _across(self, robot: Robot) -> complex:
        """Straight on, until a wall is before it that is not the one it left."""
        wall = nearest(robot.hits[((robot.hits - robot.here) / self._heading).real > 0], robot.here)
        at_wall = wall is not None and abs(wall - robot.here) <= BEFORE_M and self._crossed_m >= ACROSS_M
        way = toward(robot, robot.here + self._heading * robot.step_m)
        self._crossed_m += max(abs(way), robot.step_m / 2)
        if at_wall or self._crossed_m >= ACROSS_MOST_M:
            self._heading, self._place_tick = 0j, robot.tick
            robot.contact = robot.here if wall is None else wall
        return way


def travel(robot: Robot, hand: Side) -> complex:
    """A step along walls and the backs of lines, which stay on one hand."""
    bodies = np.array(robot.fallen, dtype=complex)
    walls = np.concatenate((robot.hits, _lines(robot), bodies))
    if not len(walls):
        return toward(robot, robot.contact)
    near = walls[np.abs(walls - robot.contact) <= WALL_M]
    robot.contact = nearest(near if len(near) else walls, robot.here)
    keep_m = max(KEEP_M, min(abs(robot.contact - robot.here) - 0.3 * robot.step_m, KEEP_MOST_M))
    way, contact = roll(robot.here, walls, robot.contact, hand, keep_m, robot.step_m)
    for size in (1.0, 0.5):
        if may(robot, way * size, holds=False, wall_m=0.1):
            if size == 1.0:
                robot.contact = contact
            return way * size
    return toward(robot, robot.here + way)


def _lines(robot: Robot) -> np.ndarray:
    """Places along the links of lines, and between leaders and their walls."""
    places = []
    for peer in robot.peers.known.values():
        if peer.beacon.role not in BARRIER:
            continue
        right = robot.peer(peer.beacon.right)
        if right is not None:
            places.append(peer.here + np.linspace(0, 1, 12) * (right.here - peer.here))
        if peer.beacon.role == "leader":
            places.append(peer.here + np.linspace(0, 1, 5) * (peer.wall - peer.here))
    return np.concatenate(places) if places else NOTHING
