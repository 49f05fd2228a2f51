"""Where a first line is best formed: in a corner. On a straight wall it lies along all of it at once."""

import math

import numpy as np

from swarm_agent.sweep.geometry import one_wall, ray_ends
from swarm_agent.sweep.robot import Robot
from swarm_agent.sweep.travel import travel

SPAN_RAD = math.radians(185)  # of a wall all around; a straight one is seen over 140 degrees from beside it
MOST_M = 12.0
LEAST_M = 0.005


def in_corner(robot: Robot) -> bool:
    """Does one wall, without a jump, lie around more than half of a robot that stands beside it?"""
    if not len(robot.hits):
        return False
    ends = ray_ends(robot.here, robot.ranges_m, robot.eye.units)
    near = int(np.nanargmin(np.abs(ends - robot.here)))
    return len(one_wall(ends, near)) * math.tau / robot.eye.rays >= SPAN_RAD


class Walk:
    """The way of an anchor along the wall, that is on its left, to a corner."""

    def __init__(self) -> None:
        self._least_m = self._left_m = 0.0

    def begin(self, least_m: float = 0.0, most_m: float = MOST_M) -> None:
        """Begin to walk, at least so far, and at most."""
        self._least_m, self._left_m = least_m, most_m

    @property
    def is_over(self) -> bool:
        """Has it come far enough?"""
        return self._left_m <= 0

    def way(self, robot: Robot) -> complex:
        """The next step; who stands in a crowd does not walk for ever."""
        if self._least_m <= 0 and in_corner(robot):
            self._left_m = 0.0
            return 0j
        way = travel(robot, "left")
        walked_m = max(abs(way), LEAST_M)
        self._least_m -= walked_m
        self._left_m -= walked_m
        return way
