"""Shortest paths: they are paths, they cost what they say, and none is cheaper."""

from itertools import pairwise
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from deploy.graph_file import Arc, GraphNode, PatrolGraph, read_graph
from deploy.graph_paths import shortest_paths
from tests.graph_texts import SMALL, grid_text


def check_table(graph: PatrolGraph) -> None:
    """Against Floyd and Warshall, in whole pixels."""
    ids = range(len(graph.nodes))
    arcs = {(node.id, arc.neighbour): arc.cost_px for node in graph.nodes for arc in node.arcs}
    far = [[0 if a == b else arcs.get((a, b), inf) for b in ids] for a in ids]
    for via in ids:
        far = [[min(far[a][b], far[a][via] + far[via][b]) for b in ids] for a in ids]
    table = shortest_paths(graph)
    assert len(table.costs_m) == len(table.paths) == len(ids)
    for a in ids:
        assert table.costs_m[a] == tuple(cost_px * graph.metres_per_px for cost_px in far[a])
        for b in ids:
            path = table.paths[a][b]
            if far[a][b] == inf:
                assert path == ()
            else:
                assert (path[0], path[-1]) == (a, b)
                assert sum(arcs[step] for step in pairwise(path)) == far[a][b]


@pytest.mark.parametrize("text", [SMALL, grid_text(), "1 9 9 1 0 0  0 4 5 0"])
def test_paths_of_a_file_are_the_cheapest(text):
    check_table(read_graph(text, "mine.graph"))


def test_known_paths():
    small = shortest_paths(read_graph(SMALL, "small.graph"))
    assert small.paths[2][3] == (2, 1, 3)
    assert (small.costs_m[2][3], small.costs_m[3][2]) == (pytest.approx(3.75), pytest.approx(3.25))
    assert small.diameter_m == pytest.approx(4.5)
    grid = shortest_paths(read_graph(grid_text(), "grid.graph"))
    assert grid.diameter_m == grid.costs_m[0][24] == pytest.approx(45.6)


def test_a_dear_arc_is_gone_around():
    text = "3 9 9 1 0 0  0 0 0 2 1 E 9 2 N 3  1 9 0 2 0 W 1 2 W 1  2 0 9 2 0 S 3 1 E 4"
    table = shortest_paths(read_graph(text, "mine.graph"))
    assert (table.paths[0][1], table.costs_m[0][1]) == ((0, 2, 1), 7)
    assert (table.paths[1][0], table.costs_m[1][0]) == ((1, 0), 1)


def test_there_is_no_way_to_an_island_nor_back_on_a_one_way_arc():
    table = shortest_paths(read_graph("3 9 9 1 0 0  0 0 0 1 1 E 3  1 9 0 0  2 0 9 0", "mine.graph"))
    assert table.costs_m == ((0, 3, inf), (inf, 0, inf), (inf, inf, 0))
    assert table.paths == (((0,), (0, 1), ()), ((), (1,), ()), ((), (), (2,)))
    assert table.diameter_m == inf


@given(st.integers(1, 7), st.data())
def test_paths_of_any_graph_are_the_cheapest_and_the_same_again(count, data):
    pairs = [(a, b) for a in range(count) for b in range(count) if a != b]
    costs = data.draw(st.dictionaries(st.sampled_from(pairs), st.integers(1, 9))) if pairs else {}
    nodes = [
        GraphNode(
            a, 0.0, 0.0, tuple(Arc(b, "N", cost, cost / 4) for (one, b), cost in costs.items() if one == a)
        )
        for a in range(count)
    ]
    graph = PatrolGraph(9, 9, 0.25, (0.0, 0.0), tuple(nodes))
    check_table(graph)
    assert shortest_paths(graph) == shortest_paths(graph)
