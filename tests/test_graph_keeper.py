"""The tower of a clearing: it hears, keeps and tells the robots' graph, and is nobody to them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_agent.behaviour import Heard
from swarm_agent.behaviours.sweep_line import Parameters, SweepLine
from swarm_agent.graph_copy import NOTHING, Delta, Version
from swarm_agent.node import Mind
from swarm_agent.surveillance_graph import SurveillanceGraph
from swarm_agent.sweep.radio import Beacon, Lacking
from tests.builders import STILL, configuration, percept
from tests.clear_builders import sweeping
from tests.hostile_beacons import absurd
from tests.sweep_builders import DETECT_M, RAYS, SAID, beacon, meets
from tests.sweep_play import Play, play
from tests.sweep_team import begun
from tower.graph_keeper import GraphKeeper
from wire import codec
from wire.clearing import Overheard
from wire.fields import Unseen
from wire.messages import WAKE_ON_FRAME, Action, Configuration, Frame, Percept, Senses, Stay
from wire.scenario import TowerSection

OVERHEARD, SPOKEN = codec.decoder(Overheard), codec.decoder(GraphKeeper.Radio)
BESIDE, FAR = (5.0, 1.0), (2.8, 1.0)


def told(node: str, behaviour: str = "") -> Configuration:
    """What a node of a clearing is told."""
    field = Unseen(DETECT_M, RAYS, 2.0)
    return configuration(node, behaviour, field=field, tick_s=0.25, max_speed_m_s=0.2, body_m=0.2)


def keeper() -> GraphKeeper:
    return GraphKeeper(GraphKeeper.Parameters(), told("r1"), np.random.default_rng(1))


def says(graph: SurveillanceGraph, tick: int, since: Version | None = None, node: str = "r2") -> Heard:
    """A robot's beacon, with what has changed in its graph since a version, if any is given."""
    delta = None if since is None else graph.delta_since(since)
    return Heard(node, tick, SPOKEN(codec.encode(beacon(version=graph.version, delta=delta))))


def graph_of(report: Overheard) -> Delta:
    return codec.decode(Delta, report.graph)


def test_it_hears_keeps_and_tells_what_robots_tell_each_other():
    tower, graph = keeper(), begun(4)
    move = tower.step(percept(6), [says(graph, 5, NOTHING)])
    assert (move.motion, move.say, move.wake_tick, move.wake_on) == (Stay(), (), None, WAKE_ON_FRAME)
    assert move.report.heard_tick == 5
    assert graph_of(move.report) == graph.delta_since(NOTHING)
    before = graph.version
    graph.split(2, 2)
    report = tower.step(percept(9), [says(graph, 8, before)]).report
    assert (report.heard_tick, graph_of(report)) == (8, graph.delta_since(NOTHING))


def test_a_graph_is_as_old_as_the_last_word_that_it_is_the_newest():
    tower, old, graph = keeper(), begun(4), begun(4)
    graph.split(2, 2)
    tower.step(percept(6), [says(graph, 5, NOTHING)])
    assert tower.step(percept(8), [says(graph, 7)]).report == Overheard(7)
    assert tower.step(percept(9), [says(graph, 6)]).report is None, "late words make nothing younger"
    assert tower.step(percept(10), [says(old, 9)]).report is None
    assert tower.step(percept(11), []).report is None


def test_of_a_graph_that_nobody_has_nothing_is_told():
    move = keeper().step(percept(1), [Heard("r2", 0, SAID)])
    assert (move.report, move.say) == (None, ())


def test_it_asks_for_what_it_cannot_take_and_only_then():
    tower, graph = keeper(), begun(4)
    missed = graph.version
    graph.split(2, 2)
    assert tower.step(percept(6), [says(graph, 5, missed)]).say == (Lacking(NOTHING),)
    assert tower.step(percept(7), []).say == ()
    move = tower.step(percept(8), [says(graph, 7), says(graph, 7, NOTHING, "r3")])
    assert (move.say, move.report.heard_tick) == ((), 7)


class Alone:
    """A robot that has begun a graph, sees nothing, and hears what it is told to."""

    def __init__(self) -> None:
        parameters = Parameters(team=4, dead_ticks=6, hop_ticks=1)
        self.mind = SweepLine(parameters, told("r2"), np.random.default_rng(1))
        self.mind.robot.become("reserve")
        self.mind.robot.graph.begin(3)
        self.scan = np.full(RAYS, np.inf, "<f4").tobytes()

    def hears(self, *heard: Heard) -> Beacon:
        tick = self.mind.robot.tick + 1
        (said,) = self.mind.step(Percept(tick, tick, "wake", Senses(scan=self.scan)), heard).say
        return said


def lacks(version: Version) -> Heard:
    """What a robot hears of a tower beside it."""
    return Heard("r1", 0, SPOKEN(codec.encode(Lacking(version))), 1.0, 0.5)


def test_a_robot_tells_the_tower_what_it_lacks():
    robot = Alone()
    graph = robot.mind.robot.graph
    before = graph.version
    graph.measure(4)
    assert robot.hears().delta is None
    assert robot.hears(lacks(NOTHING)).delta == graph.delta_since(NOTHING)
    assert robot.hears(lacks(before)).delta == graph.delta_since(before)
    assert robot.hears(lacks(Version(1, "r9"))).delta == graph.delta_since(NOTHING)
    assert robot.hears(lacks(graph.version)).delta is None
    assert robot.hears(lacks(Version(7, "r9"))).delta is None


def test_robots_are_told_first():
    robot = Alone()
    graph = robot.mind.robot.graph
    before = graph.version
    graph.measure(4)
    meets(robot.mind.robot, 3, 1 + 0j, "reserve", version=before)
    assert robot.hears(lacks(NOTHING)).delta == graph.delta_since(before)


def test_to_a_robot_the_tower_is_nobody():
    robot = Alone()
    said = robot.hears(lacks(NOTHING))
    assert said.measured == ()
    assert robot.mind.robot.peers.known == {}
    assert robot.hears(lacks(NOTHING)) == said


@pytest.mark.parametrize("place", [BESIDE, FAR])
def test_robots_do_what_they_would_do_without_it(place):
    """They move and report alike; a tower that they come to late asks, and has all."""

    def run(behaviour: str) -> Play:
        tower = TowerSection(behaviour=behaviour, x_m=place[0], y_m=place[1])
        return play(sweeping(tower=tower), 260, lambda course: None)

    with_it, without = run("graph_keeper"), run(STILL)
    robots = [[one for one in facts.reports if one[0] != "r1"] for facts in with_it.facts]
    assert robots == [list(facts.reports) for facts in without.facts]
    assert [one.poses for one in with_it.facts] == [one.poses for one in without.facts]
    words = [OVERHEARD(data) for facts in with_it.facts for node, data in facts.reports if node == "r1"]
    newest = max(robot.graph.version for robot in with_it.robots.values())
    assert [graph_of(one).version for one in words if one.graph][-1] == newest
    asked = sum(facts.radio[0] for facts in with_it.facts) - sum(facts.radio[0] for facts in without.facts)
    assert (asked > 0) == (place == FAR)


def answered(mind: Mind, tick: int, *payloads: bytes, **fields: Configuration) -> Action:
    inbox = tuple(Frame(f"r{row}", tick - 1, payload) for row, payload in enumerate(payloads, start=2))
    said = Percept(tick, tick, "frame", Senses(), inbox, **fields)
    return codec.decode(Action, mind.answer(codec.encode(said)))


def settled() -> tuple[Mind, SurveillanceGraph]:
    """A tower's mind with a graph."""
    mind, graph = Mind("tower"), begun(4)
    sound = beacon(version=graph.version, delta=graph.delta_since(NOTHING))
    answered(mind, 1, codec.encode(sound), configuration=told("r1", "graph_keeper"))
    return mind, graph


def test_bytes_that_are_no_graph_do_not_end_it():
    mind, graph = settled()
    sound = codec.encode(beacon(version=graph.version, delta=graph.delta_since(NOTHING)))
    torn = [sound[:-cut] for cut in range(1, 40)]
    for tick, payload in enumerate((b"", b"\x01", b"\xff" * 99, b"\x01\x80", *torn), start=2):
        assert answered(mind, tick, payload).report == b""
    graph.split(2, 2)
    report = OVERHEARD(answered(mind, 99, says_bytes(graph)).report)
    assert graph_of(report) == graph.delta_since(NOTHING)


def says_bytes(graph: SurveillanceGraph) -> bytes:
    return codec.encode(beacon(version=graph.version, delta=graph.delta_since(NOTHING)))


@settings(max_examples=150)
@given(data=st.data())
def test_no_beacon_ends_it_or_lets_it_tell_what_is_no_graph(data):
    mind, graph = settled()
    for tick in (2, 3, 4):
        sound = beacon(version=graph.version, delta=graph.delta_since(NOTHING))
        action = answered(mind, tick, *(codec.encode(data.draw(absurd(sound))) for _ in range(2)))
        if action.report:
            report = OVERHEARD(action.report)
            copy = SurveillanceGraph("r9")
            assert not report.graph or copy.take(graph_of(report))
        for frame in action.outbox:
            assert isinstance(SPOKEN(frame), Lacking)
