"""How robots travel that follow nobody: to corners, round rings of walls, across rooms, and through lines."""

import numpy as np
import pytest

from swarm_agent.sweep.across import back_across
from swarm_agent.sweep.corner import LEAST_M, Walk, in_corner
from swarm_agent.sweep.radio import WALL
from swarm_agent.sweep.reserve import Reserve
from swarm_agent.sweep.robot import UNRANKED, Robot
from swarm_agent.sweep.travel import THROUGH_TICKS, Round
from tests.sweep_builders import a_robot, meets, sees_walls, wall

FINE_M = 0.004
STRAIGHT = wall(-1 - 0.25j, 1 - 0.25j, FINE_M)
ROOM = np.concatenate([wall(*ends) for ends in ((-1 - 1j, 1 - 1j), (1 - 1j, 1 + 1j), (1 + 1j, -1 + 1j))])
ROOM = np.concatenate((ROOM, wall(-1 + 1j, -1 - 1j)))
"""Two metres square around the origin."""
AROUND_TICKS = 122
"""So long it takes to go round in that room."""


def walks(robot: Robot, walls: np.ndarray, mover, ticks: int) -> list[complex]:
    """Let a robot go for so many ticks, and see these walls. All places where it was."""
    places = []
    for _ in range(ticks):
        robot.tick += 1
        sees_walls(robot, walls)
        robot.peers.here += mover(robot)
        places.append(robot.here)
    return places


def stands_at(place: complex) -> Robot:
    robot = a_robot()
    robot.peers.here = place
    return robot


def test_a_robot_in_a_corner_has_one_wall_around_more_than_half_of_it():
    robot = a_robot()
    sees_walls(robot, STRAIGHT, wall(0.25 - 0.25j, 0.25 + 1j, FINE_M))
    assert in_corner(robot)


def test_no_straight_wall_and_no_two_walls_are_a_corner():
    robot = a_robot()
    sees_walls(robot, STRAIGHT)
    assert not in_corner(robot)
    sees_walls(robot, STRAIGHT, wall(-1 + 0.25j, 1 + 0.25j, FINE_M))
    assert not in_corner(robot), "a corridor"
    assert not in_corner(a_robot()), "nothing at all"


def test_an_anchor_walks_along_the_wall_on_its_left_to_the_next_corner():
    robot, walk = stands_at(0.75j), Walk()
    robot.contact = 1j
    walk.begin()
    places = walks(robot, fine(ROOM), walk.way, 30)
    assert walk.is_over and in_corner(robot)
    assert places[-1].real > 0.3 and places[-1].imag == pytest.approx(0.75, abs=0.05)


def test_an_anchor_that_is_to_go_away_leaves_its_corner_behind():
    robot, walk = stands_at(0.75 + 0.75j), Walk()
    robot.contact = 1 + 0.75j
    walk.begin(least_m=0.8)
    places = walks(robot, fine(ROOM), walk.way, 40)
    assert walk.is_over
    assert places[-1].imag < 0 < places[-1].real, "in the next one"


def test_an_anchor_does_not_walk_for_ever():
    robot, walk = a_robot(), Walk()
    assert walk.is_over, "it has not begun"
    robot.contact = -0.25j
    walk.begin(0.0, 0.5)
    places = walks(robot, wall(-9 - 0.25j, 9 - 0.25j, FINE_M), walk.way, 11)
    assert walk.is_over and abs(places[-1]) == pytest.approx(0.55, abs=0.06)


def test_an_anchor_that_is_held_up_by_a_crowd_ends_its_walk():
    robot, walk = a_robot(), Walk()
    for number in range(12):
        meets(robot, 10 + number, 0.15 * np.exp(2j * np.pi / 12 * number))
    walk.begin(0.0, 20 * LEAST_M)
    places = walks(robot, STRAIGHT, walk.way, 20)
    assert walk.is_over and abs(places[-1]) < 0.02


def fine(walls: np.ndarray) -> np.ndarray:
    """The same walls with more places between."""
    return np.concatenate((walls, walls[:-1] + np.diff(walls) / 3, walls[:-1] + np.diff(walls) * 2 / 3))


def goes_round(ticks: int) -> tuple[Robot, Round, list[complex]]:
    """A robot alone in a room, that keeps its wall on the left."""
    robot, around = stands_at(0.75j), Round("left")
    robot.contact = 1j
    return robot, around, walks(robot, ROOM, around.way, ticks)


def test_who_sees_nobody_goes_along_the_walls_all_round():
    robot, around, places = goes_round(AROUND_TICKS - 6)
    for corner in (0.7 + 0.7j, 0.7 - 0.7j, -0.7 - 0.7j, -0.7 + 0.7j):
        assert min(abs(place - corner) for place in places) < 0.15
    assert min(max(abs(place.real), abs(place.imag)) for place in places) > 0.65
    assert not around.goes_through(robot)


def test_who_has_gone_all_round_goes_straight_across_and_along_the_wall_there():
    _, _, places = goes_round(AROUND_TICKS + 40)
    ring = [max(abs(place.real), abs(place.imag)) for place in places]
    inside = [row for row, away_m in enumerate(ring) if away_m < 0.6]
    assert inside and min(inside) > AROUND_TICKS - 12
    assert max(inside) - min(inside) == len(inside) - 1, "once"
    left, came = places[min(inside) - 1], places[max(inside) + 1]
    assert abs(came - left) > 1.1 and abs(came.real - left.real) < 0.1
    assert ring[-1] > 0.65


def test_who_goes_across_a_second_time_does_so_from_another_place():
    _, _, places = goes_round(3 * AROUND_TICKS + 60)
    ring = [max(abs(place.real), abs(place.imag)) for place in places]
    turns = [row for row in range(1, len(ring)) if (ring[row] < 0.6) != (ring[row - 1] < 0.6)]
    assert len(turns) >= 3
    came, left = places[turns[1]], places[turns[2]]
    assert abs(came - left) > 0.6, "else it would go to where it came from"


def test_who_has_gone_across_goes_through_lines_for_a_while():
    robot, around, _ = goes_round(AROUND_TICKS + 10)
    assert around.goes_through(robot)
    robot.tick += THROUGH_TICKS
    assert not around.goes_through(robot)


def test_on_its_way_across_it_passes_the_wall_that_it_left():
    """And what juts from it: a wall counts once it has come so far."""
    robot, around, places = goes_round(AROUND_TICKS)
    while abs(places[-1].imag) > 0.65:
        places += walks(robot, ROOM, around.way, 1)
    ahead, left = robot.here - 0.3j, robot.here
    places = walks(robot, np.append(ROOM, [ahead + 0.2, ahead + 0.22]), around.way, 14)
    assert places[-1].imag < ahead.imag - 0.3 and abs(places[-1].real - left.real) < 0.05


def a_link(
    robot: Robot, left: complex = -0.5 - 0.4j, right: complex = 0.5 - 0.4j, line: int = 0, **said
) -> None:
    """Let a robot know of two leaders that hold each other: behind them is below."""
    meets(robot, 3, left, "leader", left=WALL, right=4, line=line, **said)
    meets(robot, 4, right, "leader", left=3, right=WALL, line=line)


def test_who_is_ahead_of_a_line_goes_through_it_to_behind():
    robot = a_robot()
    a_link(robot)
    for _ in range(30):
        way = back_across(robot, only_main=False)
        if way is None:
            break
        robot.peers.here += way
    assert way is None and robot.here.imag < -0.4
    assert robot.here.real == pytest.approx(0, abs=0.05)


def test_who_is_behind_a_line_stays_there():
    robot = a_robot()
    a_link(robot, -0.5 + 0.1j, 0.5 + 0.1j)
    assert back_across(robot, only_main=False) is None


def test_who_is_not_before_the_middle_of_a_link_goes_there_first():
    robot = stands_at(0.4 + 0j)
    a_link(robot)
    way = back_across(robot, only_main=False)
    assert way.real < -0.02 and abs(way.imag) < 0.02


def too_narrow(robot: Robot) -> None:
    a_link(robot, -0.2 - 0.4j, 0.2 - 0.4j)


def too_far(robot: Robot) -> None:
    a_link(robot, -0.5 - 1.1j, 0.5 - 1.1j)


def walled_off(robot: Robot) -> None:
    a_link(robot)
    sees_walls(robot, wall(-0.3 - 0.2j, 0.3 - 0.2j))


def not_held_by_both(robot: Robot) -> None:
    a_link(robot)
    meets(robot, 4, 0.5 - 0.4j, "leader", left=5, right=WALL)


def not_on_a_line(robot: Robot) -> None:
    a_link(robot)
    meets(robot, 4, 0.5 - 0.4j, "joining", left=3, right=WALL)


def from_before_a_restart(robot: Robot) -> None:
    a_link(robot, epoch=1)


@pytest.mark.parametrize(
    "why", [too_narrow, too_far, walled_off, not_held_by_both, not_on_a_line, from_before_a_restart]
)
def test_nobody_goes_through_what_is_no_link_or_bars_its_way(why):
    robot = a_robot()
    why(robot)
    assert back_across(robot, only_main=False) is None


def test_who_has_just_gone_through_a_line_that_stands_goes_back_through_the_main_line_only():
    robot = a_robot()
    robot.graph.begin(2)
    a_link(robot, line=0)
    assert back_across(robot, only_main=True)
    a_link(robot, line=3)
    assert back_across(robot, only_main=False)
    assert back_across(robot, only_main=True) is None


def ring_of_three() -> list[tuple[Robot, Reserve]]:
    """Three robots that crowd, each of which takes the next one for the one ahead, and that one's rank."""
    ring = []
    for number, place, ahead, rank in ((2, 0j, 3, 5), (3, 0.15 + 0j, 4, 4), (4, 0.07 + 0.12j, 2, 3)):
        robot = a_robot(number)
        robot.become("reserve")
        robot.peers.here, robot.ahead, robot.rank = place, ahead, rank
        ring.append((robot, Reserve()))
    return ring


def test_robots_that_follow_each_other_in_a_ring_lose_their_ranks_also_while_they_make_room():
    """Nobody stays for ever behind a line that is not there."""
    ring, made_room = ring_of_three(), 0
    for _ in range(40):
        said = [(one.number, one.here, one.ahead, one.rank) for one, _ in ring]
        for robot, reserve in ring:
            robot.tick += 1
            for number, place, ahead, rank in said:
                if number != robot.number:
                    meets(robot, number, place, "reserve", ahead=ahead, rank=rank)
            made_room += bool(reserve.way(robot))
    assert made_room == 3 * 40
    assert [robot.rank for robot, _ in ring] == [UNRANKED] * 3
