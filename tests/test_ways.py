"""The cheapest ways: by hand on small fields, and against each other."""

import math

import numpy as np
import pytest

from swarm_agent.ways import _along_edges, ways_of
from wire.fields import Edge, Graph, Grid


def graph(count: int, *edges: Edge) -> Graph:
    """Nodes 10 m apart in a line, and these edges."""
    return Graph(nodes_m=tuple((10.0 * site, 0.0) for site in range(count)), edges=edges)


def test_on_cells_cost_is_straight_and_hops_are_the_steps_of_a_king():
    """Source: our reading of the grid: Euclidean metres of centres, Chebyshev distance in cells."""
    ways = ways_of(Grid(20, 20, 30.0))
    assert ways.costs_m.shape == ways.hops.shape == ways.next_site.shape == (400, 400)
    here, there = 3 * 20 + 4, 9 * 20 + 12  # six columns and eight rows apart
    assert ways.costs_m[here, there] == pytest.approx(300.0)
    assert ways.hops[here, there] == 8
    assert (ways.hops[0, 399], ways.costs_m[0, 399]) == (19, pytest.approx(570 * math.sqrt(2)))


@pytest.mark.parametrize("field", [Grid(), Grid(3, 7), Grid(1, 5), Grid(1, 1)])
def test_on_cells_every_step_leads_to_a_cell_beside_and_one_hop_nearer(field):
    ways = ways_of(field)
    for here in range(len(ways.hops)):
        beside = {site for site, _ in field.neighbours(here)}
        goals = np.flatnonzero(np.arange(len(ways.hops)) != here)
        steps = ways.next_site[here, goals]
        assert set(steps.tolist()) <= beside
        assert (ways.hops[steps, goals] == ways.hops[here, goals] - 1).all()
        assert ways.next_site[here, here] == here


def test_along_edges_the_way_is_the_cheapest_even_with_more_hops():
    """Source: hops on the cheapest path, not the fewest: 0-1-2 costs 3, 0-2 costs 4."""
    ways = ways_of(graph(3, Edge(0, 1, 1.0), Edge(1, 2, 2.0), Edge(0, 2, 4.0)))
    assert ways.costs_m.tolist() == [[0, 1, 3], [1, 0, 2], [3, 2, 0]]
    assert ways.hops.tolist() == [[0, 1, 2], [1, 0, 1], [2, 1, 0]]
    assert ways.next_site.tolist() == [[0, 1, 1], [0, 1, 2], [1, 1, 2]]


def test_an_edge_may_cost_more_one_way_than_the_other():
    ways = ways_of(graph(3, Edge(0, 1, 9.0), Edge(1, 0, 1.0), Edge(1, 2, 4.0), Edge(0, 2, 3.0)))
    assert ways.costs_m.tolist() == [[0, 7, 3], [1, 0, 4], [3, 4, 0]]
    assert (ways.hops[0, 1], ways.next_site[0, 1]) == (2, 2)


def test_where_there_is_no_way_it_costs_infinitely_much_and_has_more_hops_than_any():
    ways = ways_of(graph(3, Edge(0, 1, 5.0)))
    assert ways.costs_m.tolist() == [[0, 5, math.inf], [5, 0, math.inf], [math.inf, math.inf, 0]]
    assert ways.hops.tolist() == [[0, 1, 3], [1, 0, 3], [3, 3, 0]]
    assert ways.next_site.tolist() == [[0, 1, -1], [0, 1, -1], [-1, -1, 2]]


def test_of_equal_ways_it_is_always_the_same():
    square = graph(4, Edge(0, 1, 1.0), Edge(0, 2, 1.0), Edge(1, 3, 1.0), Edge(2, 3, 1.0))
    first = ways_of(square)
    ways_of.cache_clear()
    again = ways_of(square)
    assert all((one == other).all() for one, other in zip(first, again, strict=True))
    assert first.hops[0, 3] == 2 and first.next_site[0, 3] in (1, 2)


def test_a_hole_is_gone_around():
    """Cells 0, 1, 2 are the left column, 3 is above the hole, 4, 5, 6 are the right column."""
    ways = ways_of(Grid(3, 3, 10.0, holes=((1, 0), (1, 1))))
    assert ways.costs_m[0, 4] == pytest.approx(10 + 2 * 10 * math.sqrt(2) + 10)
    assert (ways.hops[0, 4], ways.next_site[0, 4]) == (4, 1)


def test_cells_as_edges_have_as_many_hops_and_are_no_shorter():
    """The two readings of a grid agree on hops, and driving straight never costs more."""
    field = Grid(5, 4, 10.0)
    straight, stepwise = ways_of(field), _along_edges(field)
    assert (straight.hops == stepwise.hops).all()
    assert (straight.costs_m <= stepwise.costs_m + 1e-9).all()


def test_nobody_changes_what_all_share():
    with pytest.raises(ValueError, match="read-only"):
        ways_of(Grid(2, 2)).costs_m[0, 1] = 1.0
