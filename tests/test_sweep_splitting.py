"""Lines that split at obstacles, give up closed sides, dissolve, stand, and are activated: in small worlds.

All lines begin at the dead end of a room, with nothing behind them that they do not see.
"""

from functools import cache

import pytest

from swarm_agent.sweep.radio import WALL
from tests.sweep_play import MET_TICK, Play, column, in_line, lined_up, play
from wire.fields import Point

NOSE: tuple[Point, ...] = ((0, 0), (3, 0), (3, 1.6), (1.5, 1.6), (1.5, 2), (3, 2), (3, 3.6), (0, 3.6))
"""A wall juts from the far side: a line of five is split into two and three robots."""
HALL: tuple[Point, ...] = (
    *((0, 0), (2.6, 0), (2.6, 1.6), (1.5, 1.6), (1.5, 2), (2.6, 2)),
    *((3, 1.4), (5, 1.4), (5, 4.4), (3, 4.4), (2.6, 3.6), (0, 3.6)),
)
"""The same, and on the left of it a hall for which two robots are too few."""
STEP_RIGHT: tuple[Point, ...] = ((0, 0), (1.6, 0), (1.6, 1.5), (4, 1.5), (4, 3), (0, 3))
"""The far wall of the right half is nearer than that of the left one."""
STEP_LEFT: tuple[Point, ...] = ((0, 0), (4, 0), (4, 1.5), (1.6, 1.5), (1.6, 3), (0, 3))
DOOR: tuple[Point, ...] = (
    (0, 0),
    (1.6, 0),
    (1.6, -0.2),
    (1.0, -0.2),
    (1.0, -1.0),
    (3.2, -1.0),
    (3.2, 2.2),
    (1.0, 2.2),
    (1.0, 1.4),
    (1.6, 1.4),
    (1.6, 1.2),
    (0, 1.2),
)
"""A corridor that opens into a room on both sides."""
BOX: tuple[Point, ...] = ((0, 0), (2, 0), (2, 1.2), (0, 1.2))


def over(course: Play) -> bool:
    return course.tick > MET_TICK and all(robot.claim for robot in course.robots.values())


@cache
def split() -> Play:
    """Five robots come to the nose, split, and clear both sides of it, three first."""
    given = in_line((NOSE,), column(0.35, 3.6, 5), [(0.12, 1.0), (0.12, 2.6)])

    def watch(course: Play) -> bool:
        lined_up(course, 5)
        for number, robot in course.robots.items():
            state = (number, robot.role, robot.stage, robot.pinned, robot.ready, robot.line)
            course.when.setdefault(state, course.tick)
        course.note(
            "activated", course.told("split") and course.robots[3].is_main and course.robots[3].line == 1
        )
        course.note("first dissolved", course.told("dissolve"))
        course.note("claimed", any(robot.claim == "done" for robot in course.robots.values()))
        return over(course)

    return play(given, 400, watch)


def test_an_obstacle_ahead_makes_a_pivot_of_the_robot_before_it():
    """Source: specs of mission clear, 3.5: CENTRE, obstacle on the contaminated side within r_obstacle."""
    course = split()
    pinned = sorted((tick, number) for (number, *state), tick in course.when.items() if state[2])
    assert pinned[0][1] == 4, "the one in the middle"
    assert pinned[0][0] < course.told("split")[0]


def test_a_pivot_splits_the_line_when_its_neighbour_sees_the_wall_too():
    """Source: specs of mission clear, 3.5: PIVOT, split committed: two leaders, and only then moves.

    3.9: the left line has robots 1 to p, the right one the others; the main line is the one with more robots.
    """
    course = split()
    ready = min(tick for (number, *state), tick in course.when.items() if state[3])
    (cut,) = course.told("split")
    assert ready < cut
    left, right = (
        {number for (number, role, *_, of) in course.when if role == "leader" and of == line}
        for line in (1, 2)
    )
    assert (left, right) in (({2, 3}, {4, 6}), ({2, 4}, {5, 6}))
    assert course.breaches() == []


def test_a_standing_line_is_activated_when_the_main_line_has_dissolved():
    """Source: specs of mission clear, 3.5: STATIONARY leader, ACTIVATE, to LEADER: the line becomes main."""
    course = split()
    first, second = course.told("dissolve")
    assert first < course.seen["activated"] < second
    assert course.robots[2].graph.cleared() == {0, 1, 2}


def test_nobody_claims_that_all_is_done_while_a_line_stands():
    """Source: specs of mission clear, 3.10: DONE when no line is left and the last one dissolved."""
    course = split()
    first, second = course.told("dissolve")
    assert course.seen["claimed"] >= second > first
    assert all(one.clearing.contaminated_m2 < 1e-7 for one in course.facts[course.seen["claimed"] :])
    assert {robot.claim for robot in course.robots.values()} <= {"", "done"}


def test_robots_of_a_line_that_has_dissolved_travel_to_another_one_and_come_into_it():
    """Source: specs of mission clear, 3.5: TRAVEL, beacon of the stationary line, to RESERVE of that line."""
    given = in_line((HALL,), column(0.35, 3.6, 5))

    def watch(course: Play) -> bool:
        lined_up(course, 5)
        for number, robot in course.robots.items():
            course.note(f"{number} on the right", robot.on_line and robot.line == 2)
            course.note(f"{number} on the left", robot.on_line and robot.line == 1)
        course.note("both", len(course.line()) > 2 and course.line()[-1] == 3)
        return over(course)

    course = play(given, 700, watch)
    came = [number for number in (4, 5) if f"{number} on the left" in course.seen]
    assert came, "that line wanted one more"
    for number in came:
        assert (
            course.seen[f"{number} on the right"]
            < course.told("dissolve")[0]
            < course.seen[f"{number} on the left"]
        )
    assert course.breaches() == [] and course.told("restart") == []
    assert course.facts[-1].clearing.contaminated_m2 < 1e-7


@pytest.mark.parametrize(
    ("plan", "left"), [(STEP_RIGHT, {2, 3}), (STEP_LEFT, {3, 4, 5})], ids=["right", "left"]
)
def test_a_side_of_an_obstacle_that_is_closed_is_given_up(plan, left):
    """Source: specs of mission clear, 3.9, 3.8: a child that sees a closed pocket is dissolved at once."""
    given = in_line((plan,), column(0.35, 3.0, 4), [(0.12, 1.0)])

    def watch(course: Play) -> bool:
        lined_up(course, 4)
        closed = course.told("closed")
        if closed and course.tick == closed[0] + 6:
            course.note("ends", [course.robots[number].beside for number in sorted(left)])
            assert set(course.line()) == left
            assert course.robots[min(left)].beside["left"] == course.robots[max(left)].beside["right"] == WALL
            assert {robot.role for number, robot in course.robots.items() if number not in left} == {
                "reserve"
            }
        return over(course)

    course = play(given, 400, watch)
    assert "ends" in course.seen and course.told("split") == []
    assert course.breaches() == []
    assert course.facts[-1].clearing.contaminated_m2 < 1e-7


def test_an_obstacle_on_the_cleared_side_only_bends_the_link():
    """Source: specs of mission clear, 3.5: obstacle on the cleared side, the chain bends, no event; 3.6."""
    given = in_line((DOOR,), column(0.35, 1.2, 2), [(0.12, 0.3), (0.12, 0.7), (0.12, 0.95), (0.35, 0.6)])

    def watch(course: Play) -> bool:
        lined_up(course, 2)
        for robot in course.robots.values():
            assert not robot.pinned
            peer = robot.neighbour("right")
            if robot.on_line and peer is not None:
                ends = robot.here, peer.here, robot.walls(peer)
                if course.note("bent", robot.over(*ends) is not None):
                    assert robot.margin_m(*ends) >= 0
        return over(course)

    course = play(given, 400, watch)
    assert "bent" in course.seen, "else this tests nothing"
    assert {event for _, _, event in course.said} == {"dissolve"}
    assert course.breaches() == []
    assert course.facts[-1].clearing.contaminated_m2 < 1e-7


def test_a_line_with_nothing_ahead_dissolves_and_not_before():
    """Source: specs of mission clear, 3.8: never on length alone, but when nothing can hide ahead."""
    given = in_line((BOX,), column(0.35, 1.2, 2))

    def watch(course: Play) -> bool:
        lined_up(course, 2)
        if not course.told("dissolve"):
            course.note("still contaminated", course.facts[-1].clearing.contaminated_m2 > 1e-7)
        return over(course)

    course = play(given, 200, watch)
    (dissolved,) = course.told("dissolve")
    assert "still contaminated" in course.seen
    assert course.facts[dissolved].clearing.contaminated_m2 < 1e-7
    assert all(one.clearing.contaminated_m2 < 1e-7 for one in course.facts[dissolved:])
    assert {robot.claim for robot in course.robots.values()} == {"done"}
