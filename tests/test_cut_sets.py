"""Labels and cut sets: by hand, against the contiguous optimum, and as states to fall back to."""

import numpy as np
import pytest

from swarm_agent.cut_sets import CutSets, peak, sequential_label
from swarm_agent.graph_clear import exact, extra_sweepers, fallback, held, one_line, plan, step, steps
from tests.clear_graphs import CONVENTIONS, PATH, STAR, TREE, any_tree, graph


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


def test_the_fallback_keeps_the_end_of_the_path_that_needs_fewest():
    """0-1-2-3 are clear; 4 takes 5 robots of 6: the line at the far end gives up 3 and holds less."""
    net = graph([2, 2, 2, 2, 5, 9], [(0, 1, 1), (1, 2, 2), (2, 3, 1), (0, 4, 1), (3, 5, 3)])
    kept = fallback(net, {0, 1, 2, 3}, vertex=4, robots=6)
    assert kept == ({0, 1, 2}, 2, (3,), 4)
    assert step(net, kept.cleared, 4, one_line) == 6
    assert fallback(net, {0, 1, 2, 3}, vertex=4, robots=8).given_up == ()
    assert fallback(net, {0, 1, 2, 3}, vertex=4, robots=5).cleared == frozenset()
    assert fallback(net, {0, 1, 2, 3}, vertex=4, robots=4) is None
    assert fallback(net, (), vertex=4, robots=5) == (frozenset(), 0, (), 0)


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
