"""Fields: who is beside whom, and that every behaviour patrols every field."""

import math

import numpy as np
import pytest

from deploy.field_file import whole_graph
from deploy.scene import Scene
from deploy.scenes.mission import INFERNO, hot
from tests.builders import course, scenario
from tests.graph_builders import GRAPHS, made_up
from wire.fields import Edge, Graph, Grid
from wire.scenario import Robots

HOLED = Grid(4, 4, 30.0, holes=((1, 1), (2, 1), (0, 3)))
RING = Grid(3, 3, 30.0, holes=((1, 1),))
BEHAVIOURS = """
    random conscientious_reactive heuristic_conscientious_reactive gbs sebs expected_reactive lr_pt dtag dtap
    chain_connected
""".split()


def test_cells_of_a_grid_with_holes_are_numbered_without_them():
    assert HOLED.cells == [
        *((0, row) for row in (0, 1, 2)),
        *((1, row) for row in (0, 2, 3)),
        *((2, row) for row in (0, 2, 3)),
        *((3, row) for row in (0, 1, 2, 3)),
    ]
    assert HOLED.sites_m()[4] == (45.0, 75.0)
    assert len(HOLED.sites_m()) == 13


def test_holes_are_nobodys_neighbours_and_diagonals_around_them_remain():
    assert dict(RING.neighbours(0)) == {1: 30.0, 3: 30.0}
    assert dict(RING.neighbours(1)) == pytest.approx({0: 30, 2: 30, 3: 30 * 2**0.5, 4: 30 * 2**0.5})
    for site in range(8):
        for beside, cost_m in RING.neighbours(site):
            assert (site, cost_m) in RING.neighbours(beside)
            assert math.dist(RING.sites_m()[site], RING.sites_m()[beside]) == pytest.approx(cost_m)


def test_a_grid_without_holes_has_the_neighbours_that_arithmetic_says():
    grid = Grid(5, 4, 2.0)
    for site in range(20):
        column, row = divmod(site, 4)
        beside = [other for other in range(20) if max(abs(other // 4 - column), abs(other % 4 - row)) == 1]
        assert [other for other, _ in grid.neighbours(site)] == beside


def test_an_edge_leads_both_ways_unless_the_way_back_is_given():
    graph = Graph(nodes_m=((0, 0), (3, 4), (0, 9)), edges=(Edge(2, 0, 1.5), Edge(0, 1), Edge(1, 0, 7.0)))
    assert graph.neighbours(0) == [(1, 5.0), (2, 1.5)]
    assert graph.neighbours(1) == [(0, 7.0)]
    assert graph.neighbours(2) == [(0, 1.5)]


def test_the_shipped_grid_is_that_of_patrolling_sim():
    """Source: patrolling_sim, maps/grid: id 5 c + r at pixel (19 + 76 c, 325 - 76 r) of 0.075 m, costs 76."""
    graph = whole_graph(Graph(graph=str(GRAPHS / "grid.toml")))
    for node, (x_m, y_m) in enumerate(graph.nodes_m):
        column, row = divmod(node, 5)
        assert (x_m, y_m) == pytest.approx(((19 + 76 * column) * 0.075, (325 - 76 * row) * 0.075))
        beside = {node + step for step in (-5, 5) if 0 <= node + step < 25}
        beside |= {node + step for step in (-1, 1) if 0 <= row + step < 5}
        assert dict(graph.neighbours(node)) == dict.fromkeys(sorted(beside), pytest.approx(76 * 0.075))


@pytest.mark.parametrize("name", BEHAVIOURS)
@pytest.mark.parametrize("field", [HOLED, made_up(1)], ids=["holes", "graph"])
def test_every_behaviour_visits_on_every_field_and_comes_out_the_same_twice(field, name, tmp_path):
    start = (0, 1, 2) if name == "chain_connected" else (0, 3, 9)
    robots = Robots(name, start=start, max_speed_m_s=2.0)
    given = scenario(robots, field=field, duration_s=300.0)
    run = course(given, tmp_path / "one")
    visited = {site for _, _, site in run.visits()}
    assert len(visited) > 3 and visited <= set(range(len(field.sites_m())))
    assert {fact.modes for fact in run.facts} == {b"\0" * 4}, "nobody died"
    assert course(given, tmp_path / "two").run_hash == run.run_hash


def test_holes_are_0_on_the_heat_map_and_nodes_are_discs(tmp_path):
    robots = Robots("random", start=(0, 3), max_speed_m_s=2.0)
    outer = Grid(3, 3, 30.0, holes=((0, 0), (0, 1), (0, 2)))
    for field in (outer, made_up(1)):
        given = scenario(robots, field=field, duration_s=100.0)
        scene = Scene(given)
        for fact in course(given, tmp_path).facts:
            scene.take(fact)
        shown = scene.snapshot()
        if isinstance(field, Grid):
            assert scene.mission.bounds_m == (0.0, 0.0, 90.0, 90.0), "the empty column is seen too"
            assert shown.heat_s.shape == (3, 3) and not shown.heat_s[:, 0].any() and shown.heat_s[:, 1:].any()
            assert shown.glow == ()
        else:
            assert shown.heat_s is None
            assert len(shown.glow) == len(scene.mission.sites) == 12
            assert len(scene.mission.ways) == len(field.edges)


def test_colours_run_from_cold_to_hot():
    assert (hot(-1), hot(0), hot(1), hot(9)) == (INFERNO[0], INFERNO[0], INFERNO[-1], INFERNO[-1])
    assert hot(0.5) == INFERNO[4]
    assert np.all(np.diff([sum(hot(share)) for share in np.linspace(0, 1, 50)]) >= 0)
