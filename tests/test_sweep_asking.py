"""When robots of the reserve ask into a line that wants one more."""

import pytest

from swarm_agent.sweep.radio import WALL
from swarm_agent.sweep.reserve import REFUSED_TICKS, Reserve
from swarm_agent.sweep.robot import Robot
from tests.sweep_builders import a_robot, flow, meets


def asks_after(robot: Robot, reserve: Reserve, ticks: int = 300, want: bool = True, y_m: float = 0.05) -> int:
    """After how many ticks a robot asks into a link before it that wants one more; 0 if it never does."""
    told = {"from_left": flow(want=want), "from_right": flow(want=want)}
    for after in range(1, ticks):
        robot.tick += 1
        meets(robot, 3, -0.5 + y_m * 1j, "leader", left=WALL, right=4, **told)
        meets(robot, 4, 0.5 + y_m * 1j, "leader", left=3, right=WALL, **told)
        reserve.way(robot)
        if robot.role == "joining":
            return after
    return 0


def refused(robot: Robot, reserve: Reserve) -> None:
    robot.become("reserve")
    reserve.refused(robot)


def a_spare(**parameters) -> tuple[Robot, Reserve]:
    robot = a_robot(**parameters)
    robot.graph.begin(2)
    robot.become("reserve")
    return robot, Reserve()


def test_who_was_refused_by_a_line_waits_longer_each_time_before_it_asks_again():
    robot, reserve = a_spare()
    first = asks_after(robot, reserve)
    assert 0 < first < 10
    waits = []
    for _ in range(3):
        refused(robot, reserve)
        waits.append(asks_after(robot, reserve))
    assert waits == [REFUSED_TICKS, 2 * REFUSED_TICKS, 3 * REFUSED_TICKS]


def test_who_was_refused_is_patient_anew_when_the_line_has_wanted_nobody_meanwhile():
    robot, reserve = a_spare()
    for _ in range(3):
        refused(robot, reserve)
    assert asks_after(robot, reserve, 3 * REFUSED_TICKS, want=False) == 0
    assert 0 < asks_after(robot, reserve) < 10
    refused(robot, reserve)
    assert asks_after(robot, reserve) == REFUSED_TICKS


@pytest.mark.parametrize(("spacing", "asks"), [("plain", False), ("robust", True)])
def test_who_is_ahead_of_a_line_goes_behind_it_before_it_asks_but_not_of_a_robust_one(spacing, asks):
    """A robust line of two wants a third at once, and in its corner there is no room behind it yet."""
    robot, reserve = a_spare(spacing=spacing)
    assert bool(asks_after(robot, reserve, 30, y_m=-0.05)) == asks
