"""What a robot on a line takes for its frontier: not what lies beyond other parts of its own line."""

import numpy as np
import pytest

from swarm_agent.sweep.outlook import look
from swarm_agent.sweep.radio import WALL
from swarm_agent.sweep.robot import Robot
from tests.sweep_builders import DETECT_M, RAYS, a_robot, meets, sees_walls, stands, wall

BLIND = bytes(RAYS)
"""A scan that sees nothing at all, so that only what a line crosses counts."""


def in_the_middle() -> Robot:
    """A robot between two others that see nothing, with no wall in sight: ahead is above."""
    robot = a_robot()
    stands(robot, "centre", 1, 3)
    meets(robot, 1, -1 + 0j, right=2, left=4, ranges=BLIND)
    meets(robot, 3, 1 + 0j, left=2, right=9, ranges=BLIND)
    return robot


def frontier_at(robot: Robot, place: complex) -> bool:
    """Is the ray to there frontier?"""
    outlook = look(robot)
    return bool(outlook.frontier[np.abs(outlook.ends - place).argmin()])


def test_what_nobody_sees_is_frontier():
    robot = in_the_middle()
    assert look(robot).frontier[1:-1].all()


def test_what_lies_beyond_a_link_of_its_own_line_is_no_frontier():
    """The line has come round; there is its back."""
    robot = in_the_middle()
    meets(robot, 5, -0.6 + 0.4j, right=6, left=7, ranges=BLIND)
    meets(robot, 6, 0.2 + 0.4j, left=5, right=8, ranges=BLIND)
    assert not frontier_at(robot, DETECT_M * 1j)
    assert frontier_at(robot, DETECT_M * (0.8 + 0.6j)), "beside it"


def another_line(robot: Robot) -> None:
    for number, place in ((5, -0.6 + 0.4j), (6, 0.6 + 0.4j)):
        meets(robot, number, place, left=5, right=6, line=1, ranges=BLIND)


def no_link(robot: Robot) -> None:
    meets(robot, 5, -0.6 + 0.4j, right=6, ranges=BLIND)
    meets(robot, 6, 0.6 + 0.4j, left=7, ranges=BLIND)


def too_far(robot: Robot) -> None:
    meets(robot, 5, -0.6 + 0.8j, right=6, ranges=BLIND)
    meets(robot, 6, 0.6 + 0.8j, left=5, ranges=BLIND)


def on_no_line(robot: Robot) -> None:
    meets(robot, 5, -0.6 + 0.4j, "joining", right=6, ranges=BLIND)
    meets(robot, 6, 0.6 + 0.4j, left=5, ranges=BLIND)


@pytest.mark.parametrize("what", [another_line, no_link, too_far, on_no_line])
def test_what_is_no_link_of_its_line_or_out_of_reach_covers_nothing(what):
    robot = in_the_middle()
    what(robot)
    assert frontier_at(robot, DETECT_M * 1j)


@pytest.mark.parametrize(("role", "frontier"), [("leader", False), ("centre", True)])
def test_what_lies_beyond_the_way_from_a_leader_to_its_wall_is_no_frontier(role, frontier):
    robot = in_the_middle()
    meets(robot, 5, -0.3 + 0.4j, role, right=WALL, ranges=BLIND, wall_x_m=0.6)
    assert frontier_at(robot, DETECT_M * 1j) == frontier


@pytest.mark.parametrize(("right", "frontier"), [(6, False), (9, True)])
def test_a_jump_between_walls_beyond_a_link_of_its_own_line_is_no_frontier(right, frontier):
    """The same holds for what a corner hides."""
    robot = in_the_middle()
    sees_walls(robot, wall(-0.6 + 0.5j, 0.0 + 0.5j, 0.004), wall(0.02 + 0.67j, 0.2 + 0.67j, 0.004))
    meets(robot, 5, -0.6 + 0.4j, right=right, ranges=BLIND)
    meets(robot, 6, 0.6 + 0.4j, left=5, ranges=BLIND)
    assert frontier_at(robot, 0.5j) == frontier
