"""How robots come into a line and leave it, in small worlds: the barrier never opens.

All lines begin at the dead end of a corridor, with nothing behind them that they do not see.
"""

from swarm_agent.sweep.links import PATIENCE_TICKS, ask_in
from tests.sweep_play import MET_TICK, Play, apart_m, in_line, lined_up, play
from wire.fields import Point
from wire.scenario import PlannedFault

WIDENS: tuple[Point, ...] = (
    (0, 0),
    (1.2, 0),
    (2.2, -0.5),
    (4, -0.5),
    (4, 1.9),
    (2.2, 1.9),
    (1.2, 1.4),
    (0, 1.4),
)
NARROWS: tuple[Point, ...] = ((0, 0), (1, 0), (2.2, 0.5), (4, 0.5), (4, 1.7), (2.2, 1.7), (1, 2.2), (0, 2.2))
LONG: tuple[Point, ...] = ((0, 0), (6, 0), (6, 1.4), (0, 1.4))
BROAD: tuple[Point, ...] = ((0, 0), (6, 0), (6, 1.9), (0, 1.9))
PAIR: tuple[Point, ...] = ((0.35, 1.15), (0.35, 0.25))


def test_a_robot_of_the_reserve_comes_in_where_the_gap_is_too_wide():
    """Source: specs of mission clear, 3.5: RESERVE(first), mean gap > r_follow, to CENTRE beside leader 2."""
    given = in_line((WIDENS,), PAIR, [(0.1, 0.7)])

    def watch(course: Play) -> bool:
        lined_up(course, 2)
        course.note("joining", course.robots[4].role == "joining")
        return course.note("in", course.line() == [2, 4, 3] and not course.robots[2].old)

    course = play(given, 200, watch)
    assert "joining" in course.seen and "in" in course.seen
    assert course.robots[2].beside["right"] == course.robots[3].beside["left"] == 4
    assert apart_m(course.places, [2, 3]).max() > 0.98, "sooner it was not wanted"
    assert course.breaches() == []


def test_a_robot_in_the_middle_leaves_when_its_neighbours_can_do_without_it():
    """Source: specs of mission clear, 3.5: CENTRE, (p - 1) r_follow >= L + hysteresis, to RESERVE."""
    given = in_line((NARROWS,), [(0.35, 1.95), (0.35, 1.1), (0.35, 0.25)])

    def watch(course: Play) -> bool:
        lined_up(course, 3)
        leaves = course.tick > MET_TICK and course.robots[3].role != "centre"
        if course.note("leaves", leaves) and course.seen["leaves"] == course.tick:
            assert apart_m(course.places, [2, 4])[0] <= 0.95
        return leaves and course.line() == [2, 4] and not course.robots[2].old and not course.robots[4].old

    course = play(given, 300, watch)
    assert course.line() == [2, 4] and course.robots[3].role == "reserve"
    assert course.robots[3].beside == {"left": 0, "right": 0}
    assert course.breaches() == []


def test_two_that_ask_into_one_link_at_once_never_open_it():
    given = in_line((LONG,), PAIR, [(0.12, 0.9), (0.12, 0.5)])

    def watch(course: Play) -> None:
        lined_up(course, 2)
        if course.tick == MET_TICK + 8:
            left, right = course.robots[2], course.robots[3]
            for number in (4, 5):
                asks = course.robots[number]
                ask_in(asks, asks.peer(left.number), asks.peer(right.number))
        roles = [course.robots[number].role for number in (4, 5)]
        course.note("both ask", roles == ["joining", "joining"])
        course.note("one is in", "centre" in roles)

    course = play(given, 90, watch)
    assert {"both ask", "one is in"} <= set(course.seen)
    assert {course.robots[number].role for number in (4, 5)} <= {"reserve", "centre"}
    assert not any(robot.old for robot in course.robots.values())
    line = course.line()
    assert line[0] == 2 and line[-1] == 3
    assert course.breaches() == []


def test_one_that_asks_between_two_that_are_no_neighbours_gives_up():
    """Nobody takes it, so it is of the reserve again; the line has not noticed."""
    given = in_line((BROAD,), [(0.35, 1.65), (0.35, 0.95), (0.35, 0.25)], [(0.12, 1.2)])

    def watch(course: Play) -> bool:
        lined_up(course, 3)
        if course.tick == MET_TICK + 8:
            asks = course.robots[5]
            ask_in(asks, asks.peer(2), asks.peer(4))
        if course.tick > MET_TICK + 1:
            assert 5 not in [number for robot in course.robots.values() for number in robot.beside.values()]
        return course.tick > MET_TICK + 9 and course.robots[5].role == "reserve"

    course = play(given, 80, watch)
    assert course.robots[5].role == "reserve"
    assert PATIENCE_TICKS < course.tick - MET_TICK - 8 <= PATIENCE_TICKS + 4
    assert course.breaches() == []


def first_link_tick() -> int:
    """The tick in which the left leader first links to who comes in."""

    def watch(course: Play) -> bool:
        lined_up(course, 2)
        return course.tick > MET_TICK and course.robots[2].beside["right"] == 4

    return play(in_line((WIDENS,), PAIR, [(0.1, 0.7)]), 200, watch).tick


def test_one_that_dies_while_it_comes_in_leaves_the_link_as_it_was():
    """The left end has taken it over already: the right end is still held, by both, until both agree."""
    dies = PlannedFault((first_link_tick() + 1) * 0.25, "kill", ("r4",))
    given = in_line((WIDENS,), PAIR, [(0.1, 0.7)], faults=(dies,))

    def watch(course: Play) -> bool:
        lined_up(course, 2)
        taken = course.tick > MET_TICK and course.robots[2].beside["right"] == 4
        return not course.note("taken", taken) and "taken" in course.seen

    course = play(given, 200, watch)
    assert "taken" in course.seen and 4 not in course.robots
    assert course.line() == [2, 3]
    assert course.robots[3].beside["left"] == 2
    assert 4 in course.robots[2].dead
    assert course.breaches() == [] and course.told("restart") == []
