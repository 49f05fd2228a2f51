"""Bodies on graphs: they take edges, exactly as long as these are, and never leave them."""

import math

import pytest

from tests.builders import AWAKE, STILL, course, scenario
from tests.graph_builders import made_up
from wire.fields import Edge, Graph
from wire.messages import Follow, GoTo, Pose, Stay
from wire.scenario import PlannedFault, Robots, TowerSection
from world_server.edges import EdgeBody, Routes

LINE = Graph(
    nodes_m=((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)),
    edges=(Edge(0, 1, 6.0), Edge(1, 0, 2.0), Edge(1, 2, 3.0), Edge(2, 3, 4.0), Edge(0, 3, 20.0)),
)
"""A rectangle whose edge 3-0 is a detour; from 0 to 1 takes 6 m, back 2 m."""


def body(node=0, graph=LINE, speed_m_s=1.0):
    return EdgeBody(Pose(*graph.nodes_m[node], 0.5), speed_m_s, Routes(graph))


def send(one, node, graph=LINE):
    return one.command(GoTo(*graph.nodes_m[node], graph.visit_within_m))


def drive(one, ticks, tick_s=1.0):
    for _ in range(ticks):
        one.advance(tick_s)
    return one.x_m, one.y_m


def test_it_is_on_the_straight_line_in_proportion_to_the_length_it_has_gone():
    one = body()
    send(one, 1)
    assert drive(one, 3) == pytest.approx((2.0, 0.0))
    assert one.heading_rad == 0.0 and not one.arrived
    assert drive(one, 3) == (4.0, 0.0) and one.arrived and one.at_rest
    send(one, 0)
    assert drive(one, 1) == pytest.approx((2.0, 0.0)), "the way back is 2 m long"
    assert one.heading_rad == math.pi


def test_to_a_node_that_is_far_it_takes_the_cheapest_way_and_loses_no_time_at_nodes():
    one = body()
    send(one, 2)
    assert drive(one, 4, 1.6) == pytest.approx((4.0, 0.4)), "6 m and 0.4 m"
    assert one.heading_rad == pytest.approx(math.pi / 2)
    assert drive(one, 2, 1.6) == (4.0, 3.0) and one.arrived


def test_to_a_neighbour_it_takes_the_edge_even_where_another_way_is_cheaper():
    one = body(3)
    send(one, 0)
    assert drive(one, 9) == pytest.approx((0.0, 3 - 3 * 9 / 20)), "not by 2 and 1, which takes 9 m"
    send(one, 0)
    assert drive(one, 10) == pytest.approx((0.0, 3 / 20)), "told again it goes on"
    assert drive(one, 1) == (0.0, 0.0)


@pytest.mark.parametrize("tick_s", [0.075, 0.1, 0.3, 1 / 3, 0.7])
def test_a_length_of_whole_ticks_takes_exactly_so_many(tick_s):
    for ticks in (1, 3, 7, 999, 20_000):
        graph = Graph(nodes_m=((0.1, 0.2), (7.3, 9.1)), edges=(Edge(0, 1, ticks * tick_s * 1.1),))
        one = body(0, graph, 1.1)
        send(one, 1, graph)
        drive(one, ticks - 1, tick_s)
        assert not one.arrived
        assert drive(one, 1, tick_s) == graph.nodes_m[1]


def test_rounding_does_not_add_up_over_many_edges():
    count = 400
    nodes = tuple((0.3 * node, 0.0) for node in range(count))
    graph = Graph(nodes_m=nodes, edges=tuple(Edge(node, node + 1, 0.3) for node in range(count - 1)))
    one = body(0, graph)
    send(one, count - 1, graph)
    drive(one, 3 * (count - 1) - 1, 0.1)
    assert not one.arrived
    assert drive(one, 1, 0.1) == nodes[-1]


def test_a_fast_body_passes_many_nodes_in_a_tick():
    one = body(0, speed_m_s=100.0)
    send(one, 2)
    assert drive(one, 1) == (4.0, 3.0)


def test_sent_elsewhere_in_the_middle_of_an_edge_it_goes_on_or_turns_back():
    """Half of the edge 0-1: on to 1 takes 3 m, back to 0 one of the 2 m of the way back."""
    one = body()
    send(one, 1)
    drive(one, 3)
    send(one, 0)
    assert drive(one, 1) == (0.0, 0.0)
    send(one, 1)
    drive(one, 3)
    send(one, 2)
    assert drive(one, 3) == (4.0, 0.0)
    assert drive(one, 3) == (4.0, 3.0)


def test_staying_is_where_it_is_and_a_point_is_the_nearest_node():
    one = body()
    one.command(GoTo(4.4, 2.9))
    assert (one.goal.x_m, one.goal.y_m) == (4.0, 3.0)
    drive(one, 3)
    one.command(Stay())
    assert drive(one, 5) == pytest.approx((2.0, 0.0)) and one.at_rest
    one.command(Follow(((9.0, 9.0), (4.2, 0.1))))
    assert drive(one, 3) == (4.0, 0.0)
    assert send(one, 1) is True, "it is there already"


def test_it_begins_at_the_nearest_node():
    assert drive(EdgeBody(Pose(1.0, 2.0, 0.0), 1.0, Routes(LINE)), 3) == (0.0, 3.0)


def test_a_killed_body_stays_on_its_edge_and_goes_on_from_there(tmp_path):
    """From 3 s to 10 s it lies in the middle of the edge 0-1, on its way to 2."""
    script = AWAKE | {"go": {"0": [4.0, 3.0, 0.001]}}
    robots = Robots("tests.scripted:Scripted", start=(0,), max_speed_m_s=1.0)
    given = scenario(
        robots,
        parameters={"scripts": {"r2": script}},
        field=LINE,
        duration_s=30.0,
        tower=TowerSection(behaviour=STILL),
        faults=(PlannedFault(3.0, "kill", ("r2",)), PlannedFault(10.0, "restart", ("r2",), memory="kept")),
    )
    run = course(given, tmp_path)
    at = {one.tick: place for one, place in zip(run.facts, run.positions(1), strict=True)}
    assert at[3] == pytest.approx((2.0, 0.0))
    assert run.visits() == [(16, "r2", 2)], "3 m and 3 m from tick 10 on; node 1 on the way is not visited"


def test_bodies_never_leave_the_edges(tmp_path):
    graph = made_up(1)
    robots = Robots("sebs", start=(0, 3, 7), max_speed_m_s=1.7)
    run = course(scenario(robots, field=graph, duration_s=150.0), tmp_path)
    segments = [(graph.nodes_m[start], graph.nodes_m[end]) for start, end, _ in graph.edges]
    for row in (1, 2, 3):
        for place in run.positions(row):
            assert any(
                math.dist(one, place) + math.dist(place, other) == pytest.approx(math.dist(one, other))
                for one, other in segments
            )
    assert len(run.visits()) > 50
