"""Islands: a line that goes round one meets the line that it left there, and they become one."""

from functools import cache

import pytest

from swarm_agent.sweep import gait
from swarm_agent.sweep.events import decide
from swarm_agent.sweep.outlook import look
from swarm_agent.sweep.radio import NOBODY, OTHER, WALL, Flow, Measured, Side
from swarm_agent.sweep.robot import Robot
from tests.sweep_builders import a_robot, flow, meets, sees_walls, stands, wall
from tests.sweep_play import Play, in_line, play
from wire.fields import Point

OUTER: tuple[Point, ...] = ((0, 0), (4.2, 0), (4.2, 4.2), (0, 4.2))
ISLAND: tuple[Point, ...] = ((1.3, 1.3), (2.9, 1.3), (2.9, 2.9), (1.3, 2.9))
PLACES: list[Point] = [(0.3, 0.3), (0.6, 0.3), (0.3, 0.6), (0.6, 0.6), (0.9, 0.3), (0.3, 0.9), (0.9, 0.6)]
LAST_TICK = 2000
NOW = 1000


@cache
def around() -> Play:
    """Seven robots begin in a corner of a corridor that leads round an island."""
    given = in_line((OUTER, ISLAND), [], PLACES)
    return play(given, LAST_TICK, lambda course: all(one.claim for one in course.robots.values()))


def test_two_lines_go_round_an_island_become_one_and_all_is_clear():
    course = around()
    assert [one.claim for one in course.robots.values()] == ["done"] * len(PLACES)
    assert course.facts[-1].clearing.contaminated_m2 < 1e-7
    assert course.breaches() == []


def test_a_merge_is_told_once_and_draws_a_cycle():
    course = around()
    assert len(course.told("split")) == len(course.told("merge")) == 1
    kinds = [edge.kind for edge in course.robots[2].graph.edges()]
    assert kinds.count("cycle") == 1


def a_leader(side: Side, other: Flow, line: int = 0, **met: int) -> Robot:
    """An end of a line at a wall below it, and near it an end of another line that faces it.

    `line`: the number of its own line; the main line has 0. `met`: what the other one says of whom it meets.
    """
    robot, ahead = a_robot(), -1 if side == "left" else 1
    neighbours = (WALL, 3) if side == "left" else (3, WALL)
    robot.tick = NOW
    stands(robot, "leader", *neighbours)
    robot.graph.split(2, 2)
    robot.graph.activate(1)
    robot.line = line
    sees_walls(robot, wall(-1 - 0.25j, 1 - 0.25j, 0.004))
    robot.contact = -0.25j
    robot.told[OTHER[side]] = other
    meets(
        robot,
        3,
        0.85j + 0.3 * ahead,
        left=2 if side == "right" else WALL,
        right=2 if side == "left" else WALL,
        line=line,
    )
    facing = {side: 8, OTHER[side]: WALL}
    meets(robot, 7, 0.5 * ahead, "leader", line=3 - line, wall_y_m=-0.25, **facing, **met)
    robot.met_tick = robot.other_met_tick = NOW - 100
    robot.meets = 7
    return robot


@pytest.mark.parametrize(
    ("side", "told", "merges"),
    [
        ("right", flow(since=NOW - 2), True),
        ("left", flow(since=NOW - 2), True),
        ("left", flow(since=NOW - 2, meets=True), False),
        ("left", flow(since=NOW - 99), False),
        ("right", flow(since=NOW - 2, meets=True), True),
    ],
)
def test_the_left_end_of_the_main_line_merges_only_if_it_knows_that_the_right_end_does_not(
    side, told, merges
):
    """Else a line could lose both its ends. The right one comes first."""
    robot = a_leader(side, told, line=1, meets=2)
    decide(robot, look(robot))
    assert robot.role == ("centre" if merges else "leader")
    assert robot.beside[side] == (7 if merges else WALL)
    assert robot.events == (["merge"] if merges else [])


def test_the_right_end_does_not_begin_while_the_left_one_wants_to_merge():
    robot = a_leader("right", flow(since=NOW - 2, meets=True), line=1, meets=2)
    robot.meets = NOBODY
    decide(robot, look(robot))
    assert robot.role == "leader" and robot.meets == NOBODY


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_other_line_holds_its_wall_until_the_main_line_holds_it(side):
    robot = a_leader(side, flow(since=NOW - 2), line=2, meets=2)
    decide(robot, look(robot))
    assert robot.role == "leader" and robot.meets == 7 and 7 in robot.old
    held = {side: 8, OTHER[side]: 2}
    meets(robot, 7, robot.peers.known[7].here, "centre", line=1, **held)
    decide(robot, look(robot))
    assert robot.role == "leader", "it has not heard yet what we would do: it may still think so from before"
    heard = (Measured(2, robot.tick, 0.0),)
    meets(robot, 7, robot.peers.known[7].here, "centre", line=1, measured=heard, **held)
    decide(robot, look(robot))
    assert robot.role == "centre" and robot.beside[side] == 7


def test_who_waits_for_an_answer_stands_for_a_while_and_then_comes_nearer():
    robot = a_leader("right", flow(since=NOW - 2, angle_rad=1.5), line=1)
    decide(robot, look(robot))
    assert robot.meets == 7
    robot.met_tick = NOW
    assert gait.lead(robot, look(robot), gait.Strides()) == 0
    robot.met_tick = NOW - 100
    robot.angle_rad = 0.0
    assert gait.lead(robot, look(robot), gait.Strides()) != 0


def test_nothing_merges_over_ground_that_neither_line_sees():
    robot = a_leader("right", flow(since=NOW - 2), line=1, meets=2)
    blind = bytes(len(robot.peers.known[7].beacon.ranges))
    meets(robot, 7, 0.5 + 0j, "leader", line=2, ranges=blind, right=8, left=WALL, meets=2)
    decide(robot, look(robot))
    assert robot.role == "leader" and robot.meets == NOBODY


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_neighbour_that_has_not_heard_yet_that_it_was_given_up_is_no_line_to_meet(side):
    """It names this robot as a neighbour, but not in answer to anything."""
    robot = a_leader(side, flow(since=NOW - 2), line=2)
    robot.meets = NOBODY
    meets(robot, 7, robot.peers.known[7].here, "centre", line=1, **{side: 8, OTHER[side]: 2})
    decide(robot, look(robot))
    assert robot.role == "leader" and robot.beside[side] == WALL
