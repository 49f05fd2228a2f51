"""Graph-Clear: by hand, against all orders, and against the game itself, in which contamination spreads."""

from functools import cache
from itertools import chain, combinations, permutations

import networkx
import numpy as np
import pytest

from swarm_agent.graph_clear import (
    EXACT_VERTICES,
    exact,
    extra_sweepers,
    held,
    next_vertex,
    one_line,
    plan,
    step,
    steps,
)
from tests.clear_graphs import (
    COMPLETE,
    CONVENTIONS,
    HEAVY_SPIDER,
    HUB,
    PATH,
    RING,
    SPIDER,
    STAR,
    TREE,
    any_graph,
    any_tree,
)


def by_definition(net, cleared, vertex, convention) -> int:
    """A step as the definitions have it, with sets of edges."""

    def leaving(some):
        return {frozenset(edge) for edge in net.edges if len(some & set(edge)) == 1}

    def weight(edges):
        return sum(net.edges[tuple(edge)]["robots"] for edge in edges)

    own, blocked = leaving({vertex}), leaving(set(cleared))
    if convention is extra_sweepers:
        return net.nodes[vertex]["robots"] + weight(own | blocked)
    return max(net.nodes[vertex]["robots"], weight(own & blocked), weight(own - blocked)) + weight(
        blocked - own
    )


def cheapest(net, convention, contiguous) -> int:
    """The cheapest of all orders, by trying each."""

    @cache
    def onward(cleared: frozenset) -> float:
        if len(cleared) == len(net):
            return 0
        candidates = [
            vertex
            for vertex in net
            if vertex not in cleared
            and (not contiguous or networkx.is_connected(net.subgraph({*cleared, vertex})))
        ]
        return min(
            max(by_definition(net, cleared, vertex, convention), onward(cleared | {vertex}))
            for vertex in candidates
        )

    return onward(frozenset())


def subsets(items):
    items = list(items)
    return chain.from_iterable(combinations(items, count) for count in range(len(items) + 1))


def game(net) -> int:
    """The fewest robots that win the game with recontamination and any number of sweeps at a time.

    A position is the set of clear vertices: an edge that nobody blocks is as its ends are.
    """
    actions = [
        (sum(net.edges[edge]["robots"] for edge in blocked), blocked, swept)
        for blocked in subsets(net.edges)
        for swept in subsets(
            [one for one in net if all(edge in blocked or edge[::-1] in blocked for edge in net.edges(one))]
        )
    ]
    after = {}
    for block, blocked, swept in actions:
        left = net.copy()
        left.remove_edges_from(blocked)
        parts = [frozenset(part) for part in networkx.connected_components(left)]
        after[block + sum(net.nodes[one]["robots"] for one in swept), blocked, swept] = parts
    for robots in sorted({cost for cost, _, _ in after}):
        reached, fresh = {frozenset()}, [frozenset()]
        while fresh:
            clear = fresh.pop()
            for (cost, _, swept), parts in after.items():
                if cost <= robots:
                    still = (part for part in parts if part <= clear)
                    following = frozenset(swept).union(*still)
                    if following not in reached:
                        reached.add(following)
                        fresh.append(following)
        if frozenset(net) in reached:
            return robots
    raise AssertionError("all robots together always win")


@pytest.mark.parametrize(
    ("net", "free", "contiguous", "free_lines", "contiguous_lines"),
    [
        (PATH, 3, 3, 1, 1),
        (STAR, 5, 5, 2, 2),
        (RING, 4, 4, 2, 2),
        (COMPLETE, 6, 6, 4, 4),
        (TREE, 10, 10, None, None),
        (SPIDER, 4, 4, 2, 2),
        (HEAVY_SPIDER, 7, 7, None, None),
        (HUB, 5, 6, 4, 5),
    ],
)
def test_small_graphs_take_what_was_computed_by_hand(net, free, contiguous, free_lines, contiguous_lines):
    """Contiguity costs a robot on HUB, with either convention."""
    assert exact(net, extra_sweepers, contiguous=False).robots == free
    assert exact(net, extra_sweepers, contiguous=True).robots == contiguous
    assert plan(net, (), extra_sweepers).robots == contiguous
    if free_lines is not None:
        assert exact(net, one_line, contiguous=False).robots == free_lines
        assert exact(net, one_line, contiguous=True).robots == contiguous_lines
        assert plan(net).robots == contiguous_lines


def test_orders_known_by_hand_take_what_they_should():
    assert max(steps(HUB, (2, 0, 1, 4, 3), extra_sweepers)) == 5
    assert max(steps(HUB, (2, 1, 0, 3, 4), extra_sweepers)) == 6
    assert max(steps(SPIDER, (1, 2, 0, 3, 4, 5, 6), extra_sweepers)) == 4
    assert step(SPIDER, {1, 2}, 0, one_line) == 2
    assert held(SPIDER, {0, 1, 2}) == 2
    assert list(steps(PATH, (1, 2), one_line, cleared={0})) == [1, 1]


@pytest.mark.parametrize("contiguous", [True, False])
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_exact_solver_finds_the_cheapest_of_all_orders(convention, contiguous):
    chance = np.random.default_rng(1)
    for _ in range(40):
        net = any_graph(chance, 1, 5)
        found = exact(net, convention, contiguous)
        assert sorted(found.order) == sorted(net)
        assert found.robots == max(steps(net, found.order, convention))
        assert found.robots == cheapest(net, convention, contiguous)
        orders = permutations(net)
        costs = [
            max(by_definition(net, order[:k], order[k], convention) for k in range(len(net)))
            for order in orders
        ]
        assert contiguous or found.robots == min(costs)


def test_contamination_that_spreads_again_helps_nobody():
    chance = np.random.default_rng(5)
    for _ in range(36):
        net = any_graph(chance, 2, 4)
        assert game(net) == exact(net, extra_sweepers, contiguous=False).robots


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_a_plan_goes_on_from_what_is_cleared_at_least_cost(convention):
    """Also over cycles, as long as the graph is small."""
    chance = np.random.default_rng(6)
    for turn in range(150):
        net = any_tree(chance, 8) if turn % 2 else any_graph(chance, 1, 7)
        count = int(chance.integers(0, len(net)))
        cleared = set(plan(net, (), convention).order[:count])
        found = plan(net, cleared, convention)
        assert found.robots == exact(net, convention, contiguous=True, cleared=cleared).robots
        assert {*found.order} | cleared == set(net)
        assert not cleared & {*found.order}
        order = [*plan(net, (), convention).order[:count], *found.order]
        assert all(networkx.is_connected(net.subgraph(order[: k + 1])) for k in range(len(net)))
    assert plan(net, set(net)) == (0, ())


def test_what_is_reached_from_two_cleared_vertices_is_planned_with_both_edges():
    """2 takes no more than already block it, so it comes before 3; by one edge alone it would come after."""
    net = networkx.Graph([(0, 1, {"robots": 1}), (0, 2, {"robots": 3}), (1, 2, {"robots": 3})])
    net.add_edge(0, 3, robots=1)
    networkx.set_node_attributes(net, {0: 1, 1: 1, 2: 6, 3: 2}, "robots")
    assert plan(net, {0, 1}) == (7, (2, 3))


def test_a_large_graph_with_cycles_is_planned_along_a_spanning_tree():
    chance = np.random.default_rng(7)
    for _ in range(20):
        net = any_graph(chance, EXACT_VERTICES + 1, EXACT_VERTICES + 4)
        tree = networkx.maximum_spanning_tree(net, weight="robots")
        closing = sum(robots for *edge, robots in net.edges(data="robots") if not tree.has_edge(*edge))
        found = plan(net)
        assert sorted(found.order) == sorted(net)
        assert found.robots == max(steps(net, found.order, one_line))
        assert found.robots <= plan(tree).robots + closing


def test_the_next_vertex_lies_beside_cleared_ones_and_can_be_swept_now():
    assert next_vertex(SPIDER, {1, 2}, robots=2) == 0
    assert next_vertex(HEAVY_SPIDER, {0, 1}, robots=4) is None
    assert next_vertex(HEAVY_SPIDER, {0, 1}, robots=5) == 3
    assert next_vertex(PATH, {0, 1, 2}, robots=9) is None
