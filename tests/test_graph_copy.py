"""Copies of the surveillance graph: what they tell each other, and that they agree."""

import msgspec
import numpy as np
import pytest

from swarm_agent.graph_copy import NOTHING, Delta, Edge, Moving, Version, Vertex
from swarm_agent.surveillance_graph import SurveillanceGraph
from tests.sweep_team import Team, begun


def same(one: SurveillanceGraph, other: SurveillanceGraph) -> bool:
    return one.delta_since(NOTHING) == other.delta_since(NOTHING)


def tell(speaker: SurveillanceGraph, listener: SurveillanceGraph) -> Delta:
    """What the listener lacks goes over the wire to it."""
    delta = speaker.delta_since(listener.version)
    listener.take(msgspec.msgpack.decode(msgspec.msgpack.encode(delta), type=Delta))
    return delta


def test_a_delta_carries_what_has_changed_and_nothing_else():
    graph, copy = begun(5, 4), SurveillanceGraph("r2")
    assert tell(graph, copy).since == NOTHING
    since = graph.version
    left, _ = graph.split(3, 2)
    graph.activate(left)
    middle = graph.version
    graph.measure(4)
    delta = tell(graph, copy)
    assert (delta.since, delta.version, delta.main) == (since, graph.version, Moving(2, 4, left))
    assert [one.number for one in delta.vertices] == [1, 2, 3]
    assert [(one.low, one.high) for one in delta.edges] == [(1, 2), (1, 3)]
    assert same(graph, copy)
    assert [one.number for one in graph.delta_since(middle).vertices] == [2]


def test_what_does_not_fit_is_not_taken():
    graph = begun(5, 4)
    older = graph.version
    graph.split(3, 2)
    assert not SurveillanceGraph("r2").take(graph.delta_since(older))
    assert not graph.take(graph.delta_since(NOTHING))
    wild = Delta(NOTHING, Version(99, "r9"), 1, None, (Vertex(0, 1),), (Edge(0, 7, 1, "move"),))
    assert not graph.take(wild)
    assert graph.version == Version(3, "r1")
    with pytest.raises(msgspec.ValidationError, match="not the lower one"):
        msgspec.msgpack.decode(msgspec.msgpack.encode((3, 3, 1, "move", 0)), type=Edge)


def test_copies_converge_by_version_whatever_is_lost_or_late():
    """The main line's robot writes; anybody tells anybody; old deltas come again, and some never come."""
    chance = np.random.default_rng(3)
    for _ in range(20):
        team = Team(chance)
        copies = [team.graph, *(SurveillanceGraph(f"r{number}") for number in range(2, 7))]
        late: list[Delta] = []
        for _ in range(80):
            team.act()
            speaker, listener = (copies[team.some(0, 5)] for _ in range(2))
            late.append(speaker.delta_since(listener.version))
            before = listener.version
            listener.take(late[team.some(0, len(late) - 1)])
            assert listener.version >= before
        for speaker, listener in zip(copies, copies[1:], strict=False):  # once along the chain
            tell(speaker, listener)
        assert all(same(team.graph, copy) for copy in copies)


def test_a_copy_whose_writer_is_lost_is_written_on_and_the_newest_holds():
    """Two go on from the same copy: what one wrote, new vertices too, is gone from all in the end."""
    first = begun(4)
    left, right = first.split(3, 2)
    second, third, fourth = (SurveillanceGraph(name) for name in ("r2", "r3", "r4"))
    tell(first, second)
    tell(first, third)
    second.activate(left)
    second.split(2, 2)
    tell(second, fourth)
    assert len(fourth.net) == 5
    third.activate(right)
    third.measure(3)
    third.measure(4)
    assert third.version > second.version
    assert tell(third, second).since == NOTHING
    assert tell(second, fourth).since == NOTHING
    assert tell(fourth, first).version == third.version
    assert all(same(copy, third) for copy in (first, second, fourth))
    assert (first.main, len(first.net)) == (Moving(2, 4, 2), 3)


def test_of_equally_many_events_the_later_name_holds():
    first, second = begun(4), SurveillanceGraph("r2")
    tell(first, second)
    first.measure(5)
    second.measure(6)
    assert not second.take(first.delta_since(NOTHING))
    assert first.take(second.delta_since(NOTHING))
    assert first.main == second.main == Moving(0, 6)
