"""Lines that hold without any one of their robots: whoever falls silent, nothing behind them is lost."""

import pytest

from deploy.clear_checks import check_clear
from deploy.metrics.clear import ClearMetrics
from deploy.mistake import Mistake
from deploy.scenario_file import SHIPPED, ScenarioError, load_scenario
from swarm_agent.behaviour import settled_parameters
from swarm_agent.behaviours.sweep_line import SweepLine
from swarm_agent.sweep.radio import SIDES
from tests.clear_builders import sweeping
from tests.sweep_play import MET_TICK, Play, column, in_line, lined_up, play
from wire.fields import Point
from wire.scenario import PlannedFault, Scenario

CORRIDOR: tuple[Point, ...] = ((0, 0), (4, 0), (4, 2.4), (0, 2.4))
COUNT, LAST = 6, 120
KNOWN_TICK = 20  # by then all know that there is a line
TICK_S = 0.25
ROBUST = {"spacing": "robust"}


def in_corridor(node: str, tick: int) -> Scenario:
    """A line across a corridor and two robots behind it; one of them is killed."""
    kill = (PlannedFault(tick * TICK_S, "kill", (node,)),)
    line, reserve = column(0.5, 2.4, COUNT), [(0.15, 1.0), (0.15, 1.5)]
    return in_line((CORRIDOR,), line, reserve, faults=kill, parameters=ROBUST)


def losses(given: Scenario, last_tick: int) -> tuple[Play, dict[str, float]]:
    """The run, and what was lost by which cause after the line was set up."""
    fold = ClearMetrics(given)

    def watch(course: Play) -> None:
        lined_up(course, COUNT)
        if course.tick > KNOWN_TICK:
            fold.feed(course.facts[-1])

    return play(given, last_tick, watch), fold.summary()["recontaminated_m2"]


@pytest.mark.parametrize("number", range(2, 2 + COUNT))
@pytest.mark.parametrize("tick", [25, 60])
def test_whoever_of_a_robust_line_is_killed_the_barrier_holds(number: int, tick: int):
    """Source: specs of mission clear, 3.11: kill any robot, and the recontaminated area is 0."""
    course, lost_m2 = losses(in_corridor(f"r{number}", tick), LAST)
    assert lost_m2["breach"] < 1e-7 and lost_m2["release"] < 1e-7
    killed = next(one.clearing for one in course.facts if one.faults)
    assert killed.lost_m2 - killed.given_up_m2 < 1e-7, "more than what only the dead one had in view"
    assert course.told("restart") == [] and course.breaches() == []
    assert number not in course.line() and len(course.line()) >= COUNT - 1


def test_second_neighbours_are_linked_and_leaders_have_shadows():
    def watch(course: Play) -> bool:
        lined_up(course, COUNT)
        return course.tick > MET_TICK + 40

    course = play(in_corridor("r2", 10_000), LAST, watch)
    for place, number in enumerate(line := course.line()):
        robot = course.robots[number]
        near = {one: abs(line.index(one) - place) for one in robot.second if one in line}
        assert set(near.values()) <= {2} and near
        for one in near:
            assert robot.link_m(robot.peer(one), robot.second[one]) >= 0
    shadows = (course.robots[line[1]], course.robots[line[-2]])
    for robot, side in zip(shadows, SIDES, strict=True):
        assert robot.sees(robot.held[side])


def test_a_plain_line_says_nothing_new_and_a_robust_one_stands_closer():
    plain, said = (settled_parameters(SweepLine, given, 5) for given in ({}, {"spacing": "plain"}))
    robust = settled_parameters(SweepLine, ROBUST, 5)
    assert plain == said and plain.follow_m == 1.0
    assert robust.spacing == "robust" and robust.follow_m == 0.55


def test_words_and_distances_that_do_not_fit_are_refused():
    with pytest.raises(ScenarioError, match="spacing must be plain or robust, got 'tight'"):
        load_scenario(SHIPPED / "clear-rooms.toml", ['robots.parameters.spacing="tight"'])
    check_clear(sweeping(4, {"spacing": "robust", "follow_m": 0.64}))
    with pytest.raises(Mistake, match=r'follow_m must be <= .*0\.64.*"robust", got 0\.65'):
        check_clear(sweeping(4, {"spacing": "robust", "follow_m": 0.65}))
