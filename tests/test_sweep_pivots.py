"""When a robot in the middle is held by an obstacle, and when it is not any more."""

import pytest

from swarm_agent.sweep.events import decide
from swarm_agent.sweep.outlook import look, obstacle
from swarm_agent.sweep.radio import WALL
from swarm_agent.sweep.robot import Robot
from tests.sweep_builders import a_robot, flow, meets, sees_walls, stands, wall

WALL_Y_M = 0.25
FAR, OWN, BEYOND = (-0.9 + 0j, 0.25j), (-0.3 + 0.05j, 0.3 + 0.2j), (0.15 + 0.1j, 0.05 + 0.15j)
"""Where the left leader stands, and from there its wall: far from the obstacle, beside it, and past it."""


def decided(leader: complex, its_wall: complex, is_open: bool = True) -> Robot:
    """A robot that an obstacle held, after it has decided anew. `is_open`: has that leader anything ahead?"""
    robot = a_robot(number=2)
    stands(robot, "centre", 1, 3)
    sees_walls(robot, wall(-0.1 + WALL_Y_M * 1j, 0.1 + WALL_Y_M * 1j))
    robot.tick, robot.pinned, robot.contact = 50, True, WALL_Y_M * 1j
    holds = {"wall_x_m": its_wall.real, "wall_y_m": its_wall.imag}
    meets(robot, 1, leader, "leader", left=WALL, right=2, **holds)
    meets(robot, 3, 0.9 + 0j, "leader", left=2, right=WALL)
    robot.told = {"left": flow(since=48, open=is_open), "right": flow(since=48)}
    outlook = look(robot)
    robot.obstacle = obstacle(robot, outlook)
    decide(robot, outlook)
    return robot


@pytest.mark.parametrize(("leader", "is_held"), [(FAR, True), (OWN, False), (BEYOND, False)])
def test_an_obstacle_holds_no_robot_once_a_leader_beside_it_has_come_to_it_or_past_it(leader, is_held):
    """Else a line was split there, and its left part stood with its front to where all was clear."""
    assert decided(*leader).pinned == is_held


def test_a_leader_that_has_nothing_ahead_is_given_up_for_an_obstacle_at_its_wall():
    robot = decided(*OWN, is_open=False)
    assert robot.events == ["closed"] and robot.beside["left"] == WALL
