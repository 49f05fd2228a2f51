"""The surveillance graph: event by event by hand, and under random events with a team beside it."""

import networkx
import numpy as np
import pytest

from swarm_agent.graph_clear import held, plan
from swarm_agent.graph_copy import NOTHING, Edge, Moving, Vertex
from swarm_agent.surveillance_graph import SurveillanceGraph
from tests.sweep_team import Team, begun


def test_the_first_vertex_weighs_the_most_robots_of_the_first_line():
    graph = begun(2, 3, 5)
    assert graph.vertices() == (Vertex(0, 5),)
    assert graph.edges() == ()
    assert graph.main == Moving(0, 5)


def test_a_narrowing_makes_a_vertex_of_the_widest_and_an_edge_of_the_narrowest_between():
    graph = begun(5, 4, 3, 2, 3, 4, 6, 5)
    assert graph.vertices() == (
        Vertex(0, 5, explored=True, clear=True),
        Vertex(1, 6, explored=True, clear=True),
        Vertex(2, 5),
    )
    assert graph.edges() == (Edge(0, 1, 2, "move"), Edge(1, 2, 5, "move"))
    assert graph.main == Moving(2, 5)


def test_a_split_makes_the_vertex_ahead_its_own_and_one_for_each_line():
    graph = begun(5, 4)
    left, right = graph.split(3, 2)
    assert graph.vertices() == (
        Vertex(0, 5, True, True),
        Vertex(1, 5, True, True),
        Vertex(2, 3),
        Vertex(3, 2),
    )
    assert graph.edges() == (
        Edge(0, 1, 4, "move"),
        Edge(1, 2, 3, "split", left),
        Edge(1, 3, 2, "split", right),
    )
    assert (graph.ahead_of(left), graph.ahead_of(right), graph.main) == (2, 3, None)


def test_a_line_that_dissolves_leaves_its_vertex_explored_and_nothing_new():
    graph = begun(5, 4)
    left, right = graph.split(3, 2)
    graph.activate(left)
    graph.measure(4)
    graph.dissolve()
    assert graph.vertex(2) == Vertex(2, 4, explored=True, clear=True)
    assert (len(graph.net), list(graph.lines())) == (4, [right])
    graph.activate(right)
    graph.dissolve()
    assert graph.cleared() == {0, 1, 2, 3}
    assert graph.lines() == {}


def test_a_line_that_could_not_go_on_waits_at_its_narrowest_and_its_vertex_takes_more():
    graph = begun(4, 3, 2, 3, 5)
    (line,) = graph.park(available=5)
    assert graph.lines() == {line: Edge(0, 1, 2, "move", line)}
    assert graph.vertex(1) == Vertex(1, 6)
    graph.activate(line)
    assert graph.main == Moving(1, 2, line)
    graph.measure(7)
    graph.measure(6)
    assert (graph.vertex(1).robots, graph.edge(0, 1).robots, graph.edge(1, 2).robots) == (7, 2, 6)


def test_a_first_line_that_could_not_go_on_holds_nothing():
    graph = begun(2, 3)
    assert graph.park(available=3) == ()
    assert graph.vertices() == (Vertex(0, 4),)


def test_a_stationary_line_tightens_and_never_gives_ground_back():
    graph = begun(4)
    left, _ = graph.split(3, 3)
    graph.tighten(left, 2)
    assert graph.lines()[left] == Edge(0, 1, 2, "split", left)
    with pytest.raises(ValueError, match="never gives ground back"):
        graph.tighten(left, 3)


def test_a_line_round_an_island_meets_its_sibling_and_closes_a_cycle():
    graph = begun(4)
    left, right = graph.split(3, 2)
    graph.activate(left)
    graph.meet(right, robots=5)
    assert graph.edge(1, 2) == Edge(1, 2, 2, "cycle")
    assert graph.vertex(2) == Vertex(2, 2, explored=True, clear=True)
    assert graph.lines() == {}
    graph.measure(4)
    assert graph.edges()[-1] == Edge(1, 3, 4, "move")
    graph.dissolve()
    assert graph.cleared() == {0, 1, 2, 3}


def test_two_lines_that_meet_and_dissolve_leave_nothing_behind():
    graph = begun(4)
    left, right = graph.split(3, 2)
    graph.activate(right)
    graph.meet(left, robots=5)
    assert graph.dissolve() == ()
    assert graph.cleared() == {0, 1, 2}


def test_what_a_lost_line_kept_clear_is_contaminated_as_far_as_nobody_blocks():
    graph = begun(4)
    left, right = graph.split(3, 2)
    graph.activate(left)
    graph.release(right)
    assert graph.cleared() == frozenset()
    assert (graph.main, graph.lines()) == (None, {})
    assert graph.vertex(0).explored


def test_with_the_main_line_goes_what_no_other_line_keeps_clear():
    graph = begun(4)
    left, _ = graph.split(3, 2)
    graph.activate(left)
    graph.release(None)
    assert (graph.cleared(), graph.lines(), graph.main) == (frozenset(), {}, None)


def test_a_line_holds_what_is_behind_it_when_others_are_lost():
    """0 and 2 are clear, 1 between them is not: when the line at 0 is lost, the other still holds 2."""
    graph = begun(4, 3)
    graph.measure(4)
    graph.measure(2)
    graph.dissolve()
    (before_one,) = graph.retreat({0})
    graph.begin(2, vertex=2)
    (behind_one,) = graph.dissolve()
    assert graph.ahead_of(before_one) == graph.ahead_of(behind_one) == 1
    graph.release(before_one)
    assert graph.cleared() == {2}
    assert graph.lines() == {behind_one: Edge(1, 2, 2, "move", behind_one)}


def test_between_two_clear_vertices_there_is_no_line():
    graph = begun(4, 3)
    (line,) = graph.park(available=9)
    assert graph.retreat({0}) == (line + 1,)
    graph.begin(2, vertex=1)
    assert graph.dissolve() == ()
    assert (graph.cleared(), graph.lines()) == ({0, 1}, {})


def test_known_ground_that_is_swept_again_makes_no_new_vertices():
    graph = begun(4)
    left, right = graph.split(3, 2)
    graph.activate(left)
    graph.dissolve()
    graph.activate(right)
    graph.park(available=5)
    before = [(one.number, one.explored) for one in graph.vertices()]
    assert len(graph.retreat(())) == 0
    graph.begin(1, vertex=1)
    (line,) = graph.dissolve()
    assert graph.lines() == {line: Edge(0, 1, 3, "split", line)}
    graph.activate(line)
    graph.measure(5)
    graph.measure(3)
    (onward,) = graph.dissolve()
    assert (graph.ahead_of(onward), graph.vertex(0).robots) == (2, 5)
    assert [(one.number, one.explored) for one in graph.vertices()] == before


def test_a_plan_is_made_from_what_is_known():
    graph = begun(4)
    graph.split(3, 2)
    assert plan(graph.net, graph.cleared()) == (5, (1, 2))
    graph.activate(1)
    assert plan(graph.net).robots == plan(graph.net, {0}).robots == 5


@pytest.mark.parametrize(
    ("event", "complaint"),
    [
        (lambda graph: graph.begin(2), "a main line already"),
        (lambda graph: graph.activate(1), "a main line already"),
        (lambda graph: graph.retreat(()), "must have stopped"),
    ],
)
def test_events_that_cannot_be_change_nothing(event, complaint):
    graph = begun(3)
    with pytest.raises(ValueError, match=complaint):
        event(graph)
    assert (graph.version.events, len(graph.net)) == (1, 1)


def test_there_is_no_event_of_a_main_line_where_there_is_none():
    graph = SurveillanceGraph("r1")
    for event in (
        lambda: graph.measure(2),
        graph.dissolve,
        lambda: graph.split(2, 2),
        lambda: graph.release(None),
    ):
        with pytest.raises(ValueError, match="no main line"):
            event()
    assert graph.version == NOTHING


def check(team: Team) -> None:
    """What holds of a graph as long as no line is lost and nothing given up."""
    graph, net = team.graph, team.graph.net
    unexplored = [vertex.number for vertex in graph.vertices() if not vertex.explored]
    assert all(vertex.clear == vertex.explored for vertex in graph.vertices())
    stands_before = [graph.ahead_of(line) for line in graph.lines()]
    swept = [graph.main.vertex] if graph.main else []
    assert sorted(stands_before + swept) == unexplored
    entries = sum(
        graph.edge(one, beside).robots for one in swept for beside in net[one] if graph.vertex(beside).clear
    )
    assert {line: edge.robots for line, edge in graph.lines().items()} == team.stationary
    assert sum(team.stationary.values()) == held(net, graph.cleared()) - entries
    if swept and not team.merged():
        assert entries == team.blocking
    tree = networkx.Graph([(edge.low, edge.high) for edge in graph.edges() if edge.kind != "cycle"])
    tree.add_nodes_from(net)
    assert networkx.is_tree(tree)
    assert all(net.nodes[one.number]["robots"] == one.robots for one in graph.vertices())
    assert all(net.edges[one.low, one.high]["robots"] == one.robots for one in graph.edges())


def test_random_events_keep_every_line_before_one_unexplored_vertex_and_all_edges_blocked():
    chance = np.random.default_rng(1)
    seen: dict[str, int] = {}
    for _ in range(40):
        team = Team(chance)
        for _ in range(60):
            if not (event := team.act()):
                break
            seen[event] = seen.get(event, 0) + 1
            check(team)
    assert (
        min(seen.get(name, 0) for name in "activate tighten narrowing split dissolve park meet".split()) > 30
    )


def test_after_any_loss_contamination_stops_only_at_lines():
    chance = np.random.default_rng(2)
    lost = 0
    for _ in range(150):
        team = Team(chance)
        for _ in range(team.some(5, 40)):
            team.act()
        graph = team.graph
        lines = [*sorted(graph.lines()), *([None] if graph.main else [])]
        if not lines:
            continue
        before = graph.cleared()
        line = lines[team.some(0, len(lines) - 1)]
        graph.release(line)
        lost += len(before) > len(graph.cleared())
        assert line not in graph.lines()
        swept = graph.main.vertex if graph.main else None
        for edge in graph.edges():
            ends = {graph.vertex(edge.low).clear, graph.vertex(edge.high).clear}
            assert (len(ends) == 2) == bool(edge.line or (len(ends) == 2 and swept in (edge.low, edge.high)))
    assert lost > 50


def test_what_is_written_of_before_a_new_beginning_is_older_however_much_it_is():
    """A line that has not heard of it goes on, dissolves, and writes so: nobody who has heard takes that."""
    far, graph = begun(2, 3), begun(2, 3)
    graph.renew(1)
    for robots in (4, 5, 6, 7):
        far.measure(robots)
    assert graph.version > far.version
    assert not graph.take(far.delta_since(NOTHING))
    assert far.take(graph.delta_since(NOTHING)) and far.version == graph.version
