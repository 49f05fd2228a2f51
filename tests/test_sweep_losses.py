"""Robots of a line that fall silent: the link closes over them, or the team begins again."""

import pytest

from swarm_agent.sweep import links
from swarm_agent.sweep.radio import NOBODY, WALL, Role
from swarm_agent.sweep.robot import Robot
from tests.sweep_builders import a_robot, meets, stands
from tests.sweep_play import MET_TICK, Play, column, in_line, lined_up, play
from wire.fields import Point
from wire.scenario import PlannedFault

NARROW: tuple[Point, ...] = ((0, 0), (3, 0), (3, 1.8), (0, 1.8))
"""Where two leaders are near enough to each other without the robot between them."""
BROAD: tuple[Point, ...] = ((0, 0), (3, 0), (3, 2.4), (0, 2.4))
KILL_TICK, DEAD_TICKS, TICK_S = 20, 6, 0.25


def killed(node: str) -> tuple[PlannedFault, ...]:
    return (PlannedFault(KILL_TICK * TICK_S, "kill", (node,)),)


def until_done(course: Play) -> bool:
    lined_up(course, 3)
    return course.tick > MET_TICK and all(robot.claim for robot in course.robots.values())


def test_a_link_closes_over_one_that_has_fallen_silent():
    """Source: specs of mission clear, 3.11: T_dead, close ranks, the reserve inserts."""
    given = in_line((NARROW,), column(0.35, 1.8, 3), [(0.12, 0.9)], faults=killed("r3"))

    def watch(course: Play) -> bool:
        course.note("closed", course.tick > KILL_TICK and course.line() == [2, 4])
        course.note("filled", "closed" in course.seen and course.line() == [2, 5, 4])
        return until_done(course)

    course = play(given, 400, watch)
    assert KILL_TICK + DEAD_TICKS - 1 <= course.seen["closed"] <= KILL_TICK + DEAD_TICKS + 3
    assert "filled" in course.seen
    assert course.told("restart") == [] and course.breaches() == []
    assert {robot.claim for robot in course.robots.values()} == {"done"}
    assert course.facts[-1].clearing.contaminated_m2 < 1e-7
    assert all(3 in robot.dead for robot in course.robots.values())


def test_the_neighbour_of_a_leader_that_has_fallen_silent_takes_its_wall_if_it_sees_it():
    """Source: specs of mission clear, 3.11; slots are packed to the left, so the last is near it."""
    given = in_line((NARROW,), column(0.35, 1.8, 3), [(0.12, 0.9)], faults=killed("r4"))

    def watch(course: Play) -> bool:
        course.note("taken", course.tick > KILL_TICK and course.robots[3].beside["right"] == WALL)
        return until_done(course)

    course = play(given, 400, watch)
    assert KILL_TICK + DEAD_TICKS - 1 <= course.seen["taken"] <= KILL_TICK + DEAD_TICKS + 3
    assert course.told("restart") == [] and course.breaches() == []
    assert course.facts[-1].clearing.contaminated_m2 < 1e-7


def test_where_no_link_closes_the_team_begins_again():
    """Source: specs of mission clear, 3.11: the region behind is contaminated; a restart."""
    given = in_line((BROAD,), column(0.35, 2.4, 3), [(0.12, 0.9), (0.12, 1.5)], faults=killed("r3"))

    def watch(course: Play) -> bool:
        lined_up(course, 3)
        begun = course.told("restart")
        assert any(robot.epoch for robot in course.robots.values()) == bool(begun)
        if not course.note("all know", begun and all(robot.epoch for robot in course.robots.values())):
            return False
        return course.note("first line", len(course.line()) >= 2)

    course = play(given, 400, watch)
    first = course.told("restart")[0]
    assert KILL_TICK + DEAD_TICKS - 1 <= first <= KILL_TICK + DEAD_TICKS + 3
    assert first < course.seen["all know"] < first + 10
    assert "first line" in course.seen
    assert {robot.team for robot in course.robots.values()} == {4}
    graphs = [robot.graph for robot in course.robots.values() if robot.is_main]
    assert all(graph.cleared() == frozenset() and len(graph.vertices()) == 2 for graph in graphs)


def test_of_the_reserve_one_that_dies_is_not_missed():
    given = in_line((NARROW,), column(0.35, 1.8, 3), [(0.12, 0.9)], faults=killed("r5"))
    course = play(given, 400, until_done)
    assert course.told("restart") == [] and course.breaches() == []
    assert {robot.claim for robot in course.robots.values()} == {"done"}


@pytest.mark.parametrize(("needed_tick", "beside", "trouble"), [(23, 4, ""), (24, NOBODY, "r3 is silent")])
def test_a_gap_that_may_have_been_open_for_one_tick_is_not_closed_over(needed_tick, beside, trouble):
    """Whoever is fast has come through by then, even if both ends of the gap see each other now."""
    robot = a_robot(2)
    stands(robot, "leader", WALL, 3)
    robot.tick = 25
    robot.peers.lost[3] = meets(robot, 3, -0.4j, left=2, right=4)
    del robot.peers.known[3]
    meets(robot, 4, -0.8j, left=3, right=WALL)
    robot.needed_tick["right"] = needed_tick
    assert links.tend(robot) == trouble
    assert robot.beside["right"] == beside


def whose_new_neighbour_falls_silent(role: Role, left: int) -> Robot:
    """A robot with somebody new on its right that had not linked to it yet, and has been silent since."""
    robot = a_robot(2)
    stands(robot, role, left, 3)
    robot.peers.lost[3] = meets(robot, 3, -0.4j, left=5, right=4)
    del robot.peers.known[3]
    if left != WALL:
        meets(robot, left, 0.4j, left=9, right=2)
    return robot


@pytest.mark.parametrize(("role", "left"), [("leader", WALL), ("centre", 1)])
def test_who_is_left_by_a_new_neighbour_goes_back_to_the_one_before_that_still_holds_it(role, left):
    robot = whose_new_neighbour_falls_silent(role, left)
    robot.old[5] = "right"
    meets(robot, 5, -0.5j, left=2, right=WALL)
    assert links.tend(robot) == ""
    assert robot.beside == {"left": left, "right": 5} and robot.role == role
    assert 5 not in robot.old


@pytest.mark.parametrize(("role", "left"), [("leader", WALL), ("centre", 1)])
@pytest.mark.parametrize(("of", "holds"), [("left", 2), ("right", 6), ("", 6)])
def test_who_is_left_by_a_new_neighbour_and_has_none_to_go_back_to_leaves_the_line_open(
    role, left, of, holds
):
    """The other side counts on it. The one before holds others now, or was on the left."""
    robot = whose_new_neighbour_falls_silent(role, left)
    if of:
        robot.old[5] = of
    meets(robot, 5, -0.5j, left=holds, right=WALL)
    assert links.tend(robot) == "r3 is silent"
    assert robot.beside == {"left": left, "right": NOBODY} and robot.role == role
    assert 3 in robot.dead


def test_who_is_held_on_no_side_when_a_new_neighbour_falls_silent_is_of_the_reserve():
    """Who fell silent is only out of reach: the line has gone on without this one."""
    robot = whose_new_neighbour_falls_silent("centre", 1)
    meets(robot, 1, 0.4j, left=9, right=5)
    assert links.tend(robot) == ""
    assert robot.role == "reserve" and 3 not in robot.dead
