"""Graph-Clear: by hand, against all orders, and against the game itself, in which contamination spreads."""

from functools import cache
from itertools import chain, combinations, permutations

import networkx
import numpy as np
import pytest

from swarm_agent.cut_sets import CutSets, peak, sequential_label
from swarm_agent.graph_clear import (
    EXACT_VERTICES,
    exact,
    extra_sweepers,
    fallback,
    held,
    next_vertex,
    one_line,
    plan,
    step,
    steps,
)

CONVENTIONS = (extra_sweepers, one_line)


def graph(weights, edges) -> networkx.Graph:
    """Vertices 0, 1, ... of these weights, and edges as (vertex, vertex, weight)."""
    net = networkx.Graph()
    net.add_nodes_from((number, {"robots": weight}) for number, weight in enumerate(weights))
    net.add_edges_from((low, high, {"robots": weight}) for low, high, weight in edges)
    return net


PATH = graph([1, 1, 1], [(0, 1, 1), (1, 2, 1)])
STAR = graph([2, 1, 1, 1], [(0, 1, 1), (0, 2, 1), (0, 3, 1)])
RING = graph([1] * 4, [(0, 1, 1), (1, 2, 1), (2, 3, 1), (0, 3, 1)])
COMPLETE = graph([1] * 4, [(*pair, 1) for pair in combinations(range(4), 2)])
TREE = graph([2, 3, 1, 4, 2, 3], [(0, 1, 2), (1, 2, 1), (1, 3, 3), (3, 4, 1), (3, 5, 2)])
SPIDER = graph([1] * 7, [(0, 1, 1), (1, 2, 1), (0, 3, 1), (3, 4, 1), (0, 5, 1), (5, 6, 1)])
HEAVY_SPIDER = graph(
    [1, 1, 4, 1, 4, 1, 4], [(0, 1, 2), (1, 2, 1), (0, 3, 2), (3, 4, 1), (0, 5, 2), (5, 6, 1)]
)
HUB = graph([3, 1, 4, 4, 3], [(0, 1, 1), (1, 2, 1), (1, 3, 1), (1, 4, 1)])


def any_tree(chance: np.random.Generator, most: int, weight: int = 6) -> networkx.Graph:
    """Of 1 to `most` vertices: each is joined to a random one before it."""
    count = int(chance.integers(1, most + 1))
    edges = [(int(chance.integers(far)), far, int(chance.integers(1, 5))) for far in range(1, count)]
    return graph(chance.integers(1, weight + 1, count).tolist(), edges)


def any_graph(chance: np.random.Generator, fewest: int, most: int) -> networkx.Graph:
    """A random tree and some of the other edges."""
    net = any_tree(chance, most)
    while len(net) < fewest:
        net = any_tree(chance, most)
    for pair in combinations(net, 2):
        if not net.has_edge(*pair) and chance.random() < 0.4:
            net.add_edge(*pair, robots=int(chance.integers(1, 5)))
    return net


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


@pytest.mark.parametrize(
    ("net", "labels"),
    [
        (PATH, {(0, 1): 3, (1, 2): 2, (1, 0): 2, (2, 1): 3}),
        (STAR, {(0, leaf): 2 for leaf in (1, 2, 3)} | {(leaf, 0): 5 for leaf in (1, 2, 3)}),
        (
            TREE,
            {(0, 1): 10, (1, 0): 4, (1, 2): 2, (2, 1): 10, (1, 3): 10}
            | {(3, 1): 9, (3, 4): 3, (4, 3): 10, (3, 5): 5, (5, 3): 10},
        ),
    ],
)
def test_labels_are_those_computed_by_hand(net, labels):
    cut_sets = CutSets(net, extra_sweepers)
    for (source, target), robots in labels.items():
        assert cut_sets.label(source, target) == robots
        assert sequential_label(net, extra_sweepers, source, target) == robots


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


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_cut_sets_are_the_contiguous_optimum_on_a_thousand_trees(convention):
    chance = np.random.default_rng(2)
    for _ in range(1000):
        net = any_tree(chance, 9)
        cut_sets = CutSets(net, convention)
        best = min(peak(cut_sets.start(vertex)) for vertex in net)
        assert best == exact(net, convention, contiguous=True).robots


def test_segments_fall_rise_and_follow_each_other_as_promised():
    chance = np.random.default_rng(3)
    for _ in range(200):
        net = any_tree(chance, 12)
        cut_sets = CutSets(net, one_line)
        for source, target in net.to_directed().edges:
            segments = cut_sets.branch(source, target)
            assert segments[0].start == net.edges[source, target]["robots"]
            assert segments[-1].end == 0
            for before, after in zip(segments, segments[1:], strict=False):
                assert before.end == after.start
                assert before.rise < after.rise
            assert all(one.end < one.start <= one.peak for one in segments)
            assert cut_sets.label(source, target) <= sequential_label(net, one_line, source, target)


def test_interleaving_branches_can_save_a_robot():
    """Found by search: branch after branch this tree takes one more than with cut sets."""
    edges = [(0, 1, 3), (0, 5, 2), (1, 2, 1), (1, 3, 1), (2, 4, 2), (5, 6, 4)]
    net = graph([2, 2, 4, 1, 1, 3, 2], edges)
    assert sequential_label(net, extra_sweepers, 3, 1) == 10
    assert CutSets(net, extra_sweepers).label(3, 1) == 9


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


def test_the_fallback_keeps_the_end_of_the_path_that_needs_fewest():
    """0-1-2-3 are clear, 4 takes 5 robots: of 6, two may hold what is kept, so the line that leaves 2 goes back."""
    net = graph([2, 2, 2, 2, 5, 9], [(0, 1, 1), (1, 2, 2), (2, 3, 1), (0, 4, 1), (3, 5, 3)])
    kept = fallback(net, {0, 1, 2, 3}, vertex=4, robots=6)
    assert kept == ({0, 1, 2}, 2, (3,), 4)
    assert step(net, kept.cleared, 4, one_line) == 6
    assert fallback(net, {0, 1, 2, 3}, vertex=4, robots=8).given_up == ()
    assert fallback(net, {0, 1, 2, 3}, vertex=4, robots=5).cleared == frozenset()
    assert fallback(net, {0, 1, 2, 3}, vertex=4, robots=4) is None


def test_the_fallback_counts_area_where_it_is_known():
    """Either side may go: the smaller does."""
    net = graph([1, 2, 2, 3, 9, 9], [(0, 1, 1), (0, 2, 1), (0, 3, 1), (1, 4, 2), (2, 5, 2)])
    for larger, smaller in ((1, 2), (2, 1)):
        area_m2 = {0: 1.0, larger: 5.0, smaller: 1.0}
        kept = fallback(net, {0, 1, 2}, vertex=3, robots=6, area_m2=area_m2)
        assert kept == ({0, larger}, 4, (smaller,), 5)


def test_the_fallback_keeps_what_the_team_can_hold_and_get_to():
    """And hardly ever less than the most that any way of giving up leaves: so much is what was measured."""
    chance = np.random.default_rng(8)
    kept_most, cases = 0, 0
    for _ in range(300):
        net = any_tree(chance, 9)
        order = plan(net).order
        count = int(chance.integers(0, len(net)))
        cleared, robots = set(order[:count]), max(steps(net, order[: count + 1], one_line))
        vertex = order[count]
        net.nodes[vertex]["robots"] += 1
        most = largest_kept(net, cleared, vertex, robots)
        kept = fallback(net, cleared, vertex, robots)
        if not cleared or kept is None:
            assert most < 1
            continue
        assert kept.cleared | {*kept.given_up} == cleared
        assert kept.held == held(net, kept.cleared)
        assert step(net, kept.cleared, vertex, one_line) <= robots
        assert not kept.cleared or kept.retreat <= robots
        assert len(kept.cleared) <= most
        if most < 1:
            continue
        cases += 1
        kept_most += len(kept.cleared) == most
    print(f"the largest area in {kept_most} of {cases}")
    assert kept_most > 0.9 * cases > 0


def largest_kept(net, cleared, vertex, robots) -> int:
    """The most vertices that stay clear, over all ways to give up one after the other, or all at once."""
    reached = {frozenset(cleared), frozenset()}
    fresh = [frozenset(cleared)]
    while fresh:
        now = fresh.pop()
        for one in now:
            less = now - {one}
            if less not in reached and step(net, less, one, one_line) <= robots:
                reached.add(less)
                fresh.append(less)
    return max((len(one) for one in reached if step(net, one, vertex, one_line) <= robots), default=-1)
