"""Chain: where posts are, which ways lead there, how layers count. By hand, or against brute force."""

import itertools
import math
from types import SimpleNamespace

import networkx
import numpy as np
import pytest

from swarm_agent.behaviour import Heard
from swarm_agent.company import CUT_OFF, Company, Word
from swarm_agent.knowledge import Bulletin
from swarm_agent.relay_posts import OUT_OF_REACH, RelayPosts, Roads
from tests.builders import NO_NEWS
from wire.fields import Grid

TOWER_M = (0.0, 0.0)


def posts(field, reach_m: float) -> RelayPosts:
    return RelayPosts(np.array(field.sites_m()), Roads(field), TOWER_M, reach_m)


def graph(places_m, *edges):
    """A field of another shape than a grid: places, and the pairs between which a way leads."""
    ways = {site: [] for site in range(len(places_m))}
    for start, end in edges:
        length_m = math.dist(places_m[start], places_m[end])
        ways[start].append((end, length_m))
        ways[end].append((start, length_m))
    return SimpleNamespace(
        sites_m=lambda: places_m, neighbours=lambda site: sorted(ways[site]), visit_within_m=0.001
    )


# Posts


@pytest.mark.parametrize("reach_m", [120.0, 170.0])
def test_the_links_to_a_cell_are_the_fewest_that_reach_it(reach_m):
    """Against a breadth-first search over the whole graph of cells within reach of each other."""
    cells = Grid().sites_m()
    net = networkx.Graph()
    for one, other in itertools.combinations([TOWER_M, *cells], 2):
        if math.dist(one, other) <= reach_m + 1e-6:
            net.add_edge(one, other)
    fewest = networkx.single_source_shortest_path_length(net, TOWER_M)
    assert posts(Grid(), reach_m).links.tolist() == [fewest[cell] for cell in cells]


def test_the_far_corner_needs_five_robots_and_four_leave_48_cells_out():
    """170 m are four diagonals of a cell, 169.7 m: from cell (3, 3) in fours to (19, 19)."""
    plan = posts(Grid(), 170.0)
    assert [divmod(one, 20) for one in plan.chain(399)] == [(3, 3), (7, 7), (11, 11), (15, 15), (19, 19)]
    assert np.bincount(plan.links)[1:].tolist() == [24, 70, 114, 144, 48]


def test_every_chain_consists_of_links_within_reach():
    cells, plan = Grid().sites_m(), posts(Grid(), 170.0)
    for site in range(400):
        chain = plan.chain(site)
        places = [TOWER_M, *(cells[one] for one in chain)]
        assert chain[-1] == site and len(chain) == plan.links[site]
        assert max(map(math.dist, places, places[1:])) <= 170.0 + 1e-6


def test_a_relay_may_be_wherever_it_reaches_the_posts_before_and_behind():
    """Two links to cell (8, 0) at 255 m: the relay is within 170 m of the tower and of that cell."""
    plan, cells = posts(Grid(), 170.0), Grid().sites_m()
    chain = plan.chain(160)
    there = np.flatnonzero(plan.around(chain, 0)).tolist()
    near = [math.dist(one, TOWER_M) <= 170 and math.dist(one, cells[160]) <= 170 for one in cells]
    assert len(chain) == 2 and there == np.flatnonzero(near).tolist() and chain[0] in there
    assert np.flatnonzero(plan.around(chain, 1)).tolist() == [160]


def test_a_site_that_is_near_but_whose_way_leads_out_of_reach_is_no_post():
    """A hairpin: 3 lies 60 m beside 0, but the only way goes 300 m out; with longer links, from post 1."""
    field = graph([(0.0, 0.0), (100.0, 0.0), (300.0, 30.0), (0.0, 60.0)], (0, 1), (1, 2), (2, 3))
    plan = posts(field, 150.0)
    assert plan.links.tolist() == [1, 1, OUT_OF_REACH, OUT_OF_REACH]
    far = posts(field, 250.0)
    assert far.links.tolist() == [1, 1, 2, 2] and far.chain(3) == [1, 3]


# Ways


def test_ways_are_the_shortest_through_free_sites():
    """Against networkx, on a grid of which a third of the cells is closed."""
    field, chance = Grid(9, 9), np.random.Generator(np.random.Philox(3))
    free = chance.random(81) > 1 / 3
    free[40] = True
    net = networkx.Graph()
    net.add_node(40)
    for site, (other, cost_m) in ((one, way) for one in range(81) for way in field.neighbours(one)):
        if free[site] and free[other]:
            net.add_edge(site, other, weight=cost_m)
    expected = networkx.single_source_dijkstra_path_length(net, 40)
    ways = Roads(field).ways(40, free)
    assert ways.far_m.tolist() == pytest.approx([expected.get(site, math.inf) for site in range(81)])
    for site in expected:
        step = ways.first_step(site)
        cost_m = dict(field.neighbours(40)).get(step, 0.0)
        rest_m = networkx.dijkstra_path_length(net, step, site)
        assert cost_m + rest_m == pytest.approx(expected[site])
    assert ways.first_step(int(np.flatnonzero(~free)[0])) == 40


# Layers


def company(node: str) -> Company:
    return Company(node, "r1", 400, 3, 30)


def word(layer: int, beacon_tick: int, parent: str | None = None, roll=(), site: int = 0) -> Word:
    return Word(0.0, 0.0, site, site, layer, beacon_tick, parent, tuple(roll))


def heard(sender: str, sent_tick: int, said: Word | None) -> Heard:
    return Heard(sender, sent_tick, Bulletin(NO_NEWS, (), 0, said))


def test_a_layer_is_one_more_than_the_smallest_in_hearing():
    """The tower is 0. Of its same frame the shorter way counts, in whatever order words are heard."""
    words = [heard("r3", 9, word(2, 7)), heard("r4", 9, word(1, 7)), heard("r5", 9, word(4, 7))]
    for order in itertools.permutations(words):
        one = company("r9")
        one.listen(10, order)
        assert (one.layer, one.beacon_tick) == (2, 7)
    one.listen(11, [heard("r1", 10, None), *words])
    assert (one.layer, one.beacon_tick) == (1, 10)


def test_a_layer_is_lost_after_three_seconds_of_silence():
    one = company("r9")
    one.listen(10, [heard("r1", 9, None)])
    one.listen(13, [])
    assert one.layer == 1
    one.listen(14, [])
    assert one.layer == CUT_OFF and not one.hears_tower()


def test_the_same_old_frame_of_the_tower_told_again_keeps_nobody_connected():
    one = company("r9")
    for tick in range(10, 20):
        one.listen(tick, [heard("r3", tick - 1, word(1, 5)), heard("r4", tick - 1, word(6, 5))])
    assert one.layer == CUT_OFF


def talk(robots, links, tick: int, tower_hears: tuple[str, ...]) -> None:
    """One tick of companies that hear each other along these links, and some of them the tower."""
    said = {name: word(one.layer, one.beacon_tick, roll=one.roll(tick - 1)) for name, one in robots.items()}
    for name, one in robots.items():
        near = [other for pair in links if name in pair for other in pair if other != name]
        inbox = [heard(other, tick - 1, said[other]) for other in near]
        one.listen(tick, inbox + [heard("r1", tick - 1, None)] * (name in tower_hears))


@pytest.mark.parametrize("shape", ["line", "ring", "all"])
def test_robots_cut_off_from_the_tower_do_not_count_to_infinity(shape):
    """Six robots that go on hearing each other: within six hops and three seconds all know it."""
    names = [f"r{number}" for number in range(2, 8)]
    links = {
        "line": list(itertools.pairwise(names)),
        "ring": [*itertools.pairwise(names), (names[-1], names[0])],
        "all": list(itertools.combinations(names, 2)),
    }[shape]
    robots = {name: company(name) for name in names}
    for tick in range(1, 30):
        talk(robots, links, tick, ("r2",))
    hops = networkx.single_source_shortest_path_length(networkx.Graph(links), "r2")
    assert {name: one.layer for name, one in robots.items()} == {name: hops[name] + 1 for name in names}
    most = 0
    for tick in range(30, 30 + 6 + 3 + 1):
        talk(robots, links, tick, ())
        most = max(most, *(one.layer for one in robots.values()))
    assert {one.layer for one in robots.values()} == {CUT_OFF} and most <= 6
    for tick in range(40, 60):
        talk(robots, links, tick, ())
        assert {one.layer for one in robots.values()} == {CUT_OFF}
    for tick in range(60, 80):
        talk(robots, links, tick, ("r7",))
    assert robots["r7"].layer == 1 and CUT_OFF not in {one.layer for one in robots.values()}


def test_who_is_there_goes_round_and_who_falls_silent_is_counted_no_more():
    names = ["r2", "r10", "r3"]
    robots = {name: company(name) for name in names}
    for tick in range(1, 10):
        talk(robots, [("r2", "r10"), ("r10", "r3")], tick, ("r2",))
    assert [name for name, _ in robots["r3"].roll(9)] == ["r2", "r3", "r10"]
    for tick in range(10, 50):
        talk(robots, [("r10", "r3")], tick, ())
    assert [name for name, _ in robots["r3"].roll(49)] == ["r3", "r10"]


def test_a_child_is_heeded_for_three_seconds_after_it_has_left():
    """It may not have heard yet what the new parent does, and come back."""
    one = company("r2")
    one.listen(10, [heard("r3", 9, word(2, 8, "r2"))])
    for tick in range(11, 15):
        one.listen(tick, [heard("r3", tick - 1, word(2, tick - 2, "r1"))])
        assert len(list(one.children(tick))) == (tick <= 12)


def test_words_of_another_field_and_frames_found_after_a_freeze_are_not_heeded():
    one = company("r9")
    one.listen(100, [heard("r3", 99, word(1, 98, site=400)), heard("r1", 50, None)])
    assert one.layer == CUT_OFF and not list(one.others())
