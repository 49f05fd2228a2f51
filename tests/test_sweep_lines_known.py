"""What a robot of a sweep team does with what it knows of lines: which have gone, and which comes next."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_agent.graph_copy import NOTHING, Delta, Edge, Version, Vertex
from swarm_agent.sweep import events
from swarm_agent.sweep.beginning import Beginning
from swarm_agent.sweep.robot import Robot
from tests.hostile_beacons import DELTAS
from tests.sweep_builders import a_robot


def knows(robots: dict[int, int], clear: set[int], lines: dict[tuple[int, int], int]) -> Robot:
    """A robot that was told of a graph: robots by vertex, and the lines that stand on edges, 0 for none."""
    robot = a_robot()
    vertices = tuple(
        Vertex(number, need, number in clear, number in clear) for number, need in robots.items()
    )
    edges = tuple(Edge(*ends, 2, "split", line) for ends, line in lines.items())
    assert robot.graph.take(Delta(NOTHING, Version(5, "r7"), max(lines.values()), None, vertices, edges))
    return robot


def test_two_lines_before_one_vertex_go_together():
    """Round an island two lines can stand before the same ground; when there is nothing, both have gone."""
    robot = knows({0: 2, 1: 2, 2: 2}, {0, 1}, {(0, 1): 0, (0, 2): 1, (1, 2): 2})
    robot.gone = {1, 2}
    events.strike_out(robot)
    assert robot.graph.lines() == {} and robot.graph.cleared() == {0, 1, 2}


def test_lines_that_have_gone_elsewhere_are_none_of_this_robots():
    robot = knows({0: 2, 1: 2, 2: 3}, {0}, {(0, 1): 1, (0, 2): 2})
    robot.gone = {1, 7}
    events.strike_out(robot)
    assert set(robot.graph.lines()) == {2} and robot.graph.cleared() == {0, 1}


@pytest.mark.parametrize(("needs", "first"), [((2, 5), 1), ((5, 2), 2)])
def test_the_cheaper_of_two_rooms_is_next_while_the_other_line_stands(needs, first):
    """Source: specs of mission clear, 2.4, line semantics: the step that needs fewer robots comes first."""
    robot = knows({0: 2, 1: needs[0], 2: needs[1]}, {0}, {(0, 1): 1, (0, 2): 2})
    events.choose_next(robot)
    assert robot.graph.main.line == first
    assert set(robot.graph.lines()) == {1, 2} - {first}


def test_a_line_that_has_dissolved_where_it_stood_is_never_next():
    robot = knows({0: 2, 1: 2, 2: 5}, {0}, {(0, 1): 1, (0, 2): 2})
    robot.gone = {1}
    events.choose_next(robot)
    assert robot.graph.main.line == 2 and robot.graph.cleared() == {0, 1}


def test_when_no_line_is_left_none_is_next():
    robot = knows({0: 2, 1: 2}, {0}, {(0, 1): 1})
    robot.gone = {1}
    events.choose_next(robot)
    assert robot.graph.main is None and robot.graph.cleared() == {0, 1}


@settings(max_examples=300)
@given(
    delta=DELTAS.filter(lambda one: one is not None),
    gone=st.sets(st.integers(0, 4)),
    deed=st.sampled_from(["choose", "again", "split", "park", "measure", "dissolve"]),
)
def test_no_graph_that_can_be_told_crashes_who_decides_by_it(delta, gone, deed):
    """Lines before nothing, a main line nowhere, vertices that take a million robots."""
    robot = a_robot()
    robot.graph.take(delta)
    robot.gone = set(gone)
    if robot.graph.main is None:
        events.choose_next(robot)
    if deed == "again":
        Beginning().again(robot, "r9 is silent", home=True)
        assert robot.graph.lines() == {} and robot.graph.main is None
    elif robot.graph.main is not None:
        graph = robot.graph
        {
            "choose": graph.dissolve,
            "split": lambda: graph.split(2, 3),
            "park": lambda: graph.park(4),
            "measure": lambda: graph.measure(3),
            "dissolve": graph.dissolve,
        }[deed]()
        if graph.main is None:
            events.choose_next(robot)
