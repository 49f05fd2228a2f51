"""The contract of every behaviour, found by itself: a new file is tested from the day it is there."""

import importlib
import pkgutil
from functools import cache
from typing import get_args

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import swarm_agent.behaviours
import tower
from swarm_agent.behaviour import Behaviour, find_behaviour, settled_parameters
from swarm_agent.behaviours.dtag import Arrival
from swarm_agent.behaviours.dtap import Request
from swarm_agent.behaviours.expected_reactive import Decision
from swarm_agent.knowledge import Bulletin
from swarm_agent.line_radio import Envelope
from swarm_agent.node import Mind, percepts_of
from tests.builders import configuration, from_robot, from_tower, percept, table
from tests.line_builders import report, straight
from wire import codec
from wire.fields import Grid
from wire.messages import Action, Frame, Motion, Percept, Senses, Sighting


def _discover() -> list[tuple[str, str]]:
    """(package, file) of every behaviour of ours."""
    found = []
    for package in (swarm_agent.behaviours, tower):
        for module in pkgutil.iter_modules(package.__path__):
            if module.name != "__main__":
                loaded = importlib.import_module(f"{package.__name__}.{module.name}")
                own = [
                    one
                    for one in vars(loaded).values()
                    if isinstance(one, type) and issubclass(one, Behaviour)
                ]
                if any(one.__module__ == loaded.__name__ for one in own):
                    found.append((package.__name__, module.name))
    return found


ON_A_LINE = ("line_patrol", "overlap_patrol", "line_keeper")
DISCOVERED = _discover()
every_behaviour = pytest.mark.parametrize(("package", "name"), DISCOVERED, ids=lambda one: one)


def first(package: str, name: str, generator_key: tuple[int, ...] = (1, 2)) -> Percept:
    """The first percept of a node with this behaviour, on a small field, in the paper's team of ten."""
    parameters = settled_parameters(find_behaviour(name, package), {}, 10)
    node = "r1" if package == "tower" else "r2"
    place = {"field": straight(), "tower_m": (30.0, 0.0)} if name in ON_A_LINE else {"field": Grid(6, 6)}
    told = configuration(node, name, msgspec.to_builtins(parameters), generator_key=generator_key, **place)
    return percept(0, 2.0, 3.0, why="start", configuration=told)


@cache
def sound_frames() -> list[bytes]:
    """Frames that our behaviours really say: without own words, with a duty, a decision, a request."""
    news = table(s1=4, s30=2)
    return [
        codec.encode(from_tower(3, news).message),
        codec.encode(from_robot("r3", 3, 5.0, 1, 2, 3, news).message),
        *(codec.encode(report("r3", tick, "patrol", 1 + tick % 6).message) for tick in (3, 7)),
        codec.encode(Bulletin(news, (), 3, Decision(1, 8, 20.0))),
        codec.encode(Bulletin(news, (), 3, (Request(8, 500.0), Arrival(bytes(4 * 36), 8)))),
    ]


def a_life(package: str, name: str, ticks: int = 25, seed: int = 0) -> list[Percept]:
    """Percepts of a node that drives about, sees others, hears sense and garbage."""
    draw = np.random.Generator(np.random.Philox(seed))
    life = [first(package, name)]
    for tick in range(1, ticks):
        x_m, y_m = (draw.random(2) * 180).tolist()
        heard = [
            Frame(f"r{number}", tick - 1, payload)
            for number, payload in zip(
                (1, 3, 4, 5, 6, 7, 8), [*sound_frames(), draw.bytes(int(draw.integers(40)))], strict=True
            )
            if draw.random() < 0.7
        ]
        seen = [Sighting("r3", x_m + 1, y_m)] if draw.random() < 0.5 else []
        life.append(percept(tick, x_m, y_m, inbox=heard, in_sight=seen))
    return life


class Notebook:
    """A ledger in memory."""

    def __init__(self) -> None:
        self.grants = {}

    def read(self, before_grant):
        """All entries of the grants before."""
        self.grants = {grant: kept for grant, kept in self.grants.items() if grant < before_grant}
        return [one for kept in self.grants.values() for one in kept]

    def write(self, grant, tick, entries) -> None:
        """Keep the entries of one grant."""
        self.grants[grant] = [msgspec.structs.replace(one, tick=tick) for one in entries]


def a_mind(package: str) -> Mind:
    """A mind with a ledger, which a tower may need."""
    return Mind(package, Notebook())


def answers(package: str, life: list[Percept]) -> list[bytes]:
    mind = a_mind(package)
    return [mind.answer(codec.encode(one)) for one in life]


def test_every_behaviour_is_discovered():
    assert ("swarm_agent.behaviours", "lr_pt") in DISCOVERED
    assert ("swarm_agent.behaviours", "stand_still") in DISCOVERED
    assert ("tower", "base_station") in DISCOVERED
    assert ("tower", "line_keeper") in DISCOVERED


def test_every_file_among_the_behaviours_is_one():
    files = {module.name for module in pkgutil.iter_modules(swarm_agent.behaviours.__path__)}
    assert files == {name for package, name in DISCOVERED if package == "swarm_agent.behaviours"}


@every_behaviour
def test_equal_percepts_give_equal_bytes(package, name):
    life = a_life(package, name)
    np.random.seed(1)
    once = answers(package, life)
    np.random.seed(2)
    assert answers(package, life) == once


@every_behaviour
def test_two_minds_in_one_process_share_nothing(package, name):
    here, there = a_life(package, name, seed=1), a_life(package, name, seed=2)
    apart = answers(package, here), answers(package, there)
    one, other = a_mind(package), a_mind(package)
    mixed = [
        (one.answer(codec.encode(a)), other.answer(codec.encode(b))) for a, b in zip(here, there, strict=True)
    ]
    assert tuple(map(list, zip(*mixed, strict=True))) == apart


@every_behaviour
def test_answers_are_actions_that_carry_the_grants_number_and_tick(package, name):
    life = a_life(package, name)
    for given_percept, answer in zip(life, answers(package, life), strict=True):
        action = codec.decode(Action, answer)
        assert (action.tick, action.grant) == (given_percept.tick, given_percept.grant)
        assert action.wake_tick is None or action.wake_tick > action.tick
        assert isinstance(action.motion, (*get_args(Motion), type(None)))


@every_behaviour
def test_what_a_behaviour_says_it_understands(package, name):
    radio = find_behaviour(name, package).Radio
    for answer in answers(package, a_life(package, name)):
        for payload in codec.decode(Action, answer).outbox:
            assert codec.encode(codec.decode(radio, payload)) == payload


@every_behaviour
def test_the_tower_understands_the_news_of_every_behaviour_that_speaks(package, name):
    on_a_line = name in ON_A_LINE
    station = find_behaviour("line_keeper" if on_a_line else "base_station", "tower")
    for answer in answers(package, a_life(package, name)):
        for payload in codec.decode(Action, answer).outbox:
            assert isinstance(codec.decode(station.Radio, payload), Envelope if on_a_line else Bulletin)


@every_behaviour
def test_a_repeated_grant_gets_the_same_answer_and_changes_nothing(package, name):
    life = a_life(package, name)
    once = answers(package, life)
    mind = a_mind(package)
    for given_percept, expected in zip(life, once, strict=True):
        data = codec.encode(given_percept)
        assert [mind.answer(data) for _ in range(3)] == [expected] * 3


@every_behaviour
def test_a_percept_is_never_changed(package, name):
    behaviour = find_behaviour(name, package)
    told = first(package, name).configuration
    parameters = codec.decode(behaviour.Parameters, told.parameters)
    one = behaviour(parameters, told, np.random.Generator(np.random.Philox(1)))
    for given_percept in a_life(package, name):
        heard = Mind._decode(_mind_of(one), given_percept.inbox)
        before = codec.encode(given_percept), codec.encode([item.message for item in heard]), list(heard)
        one.step(given_percept, heard)
        assert (
            codec.encode(given_percept),
            codec.encode([item.message for item in heard]),
            list(heard),
        ) == before


def _mind_of(behaviour: Behaviour) -> Mind:
    mind = Mind("")
    mind._behaviour = behaviour
    return mind


@every_behaviour
@settings(max_examples=25)
@given(data=st.data())
def test_garbage_in_the_inbox_crashes_nobody(package, name, data):
    mind = a_mind(package)
    mind.answer(codec.encode(first(package, name)))
    for tick in range(1, 4):
        frames = st.one_of(st.binary(max_size=60), _damaged(), _strange())
        payloads = data.draw(st.lists(frames, max_size=4))
        inbox = [Frame(f"r{number}", tick - 1, payload) for number, payload in enumerate(payloads, start=1)]
        assert mind.answer(codec.encode(percept(tick, 45.0, 45.0, inbox=inbox)))


@st.composite
def _damaged(draw) -> bytes:
    payload = bytearray(draw(st.sampled_from(sound_frames())))
    payload[draw(st.integers(0, len(payload) - 1))] = draw(st.integers(0, 255))
    return bytes(payload)


@st.composite
def _strange(draw) -> bytes:
    """A frame that has the form of a bulletin and says impossible things."""
    whole = st.integers(-(2**63), 2**63 - 1)
    number = st.floats() | whole
    acknowledged = st.lists(st.tuples(st.text(max_size=3), whole), max_size=2)
    columns = st.tuples(st.binary(max_size=12), st.binary(max_size=6))
    own = st.none() | st.tuples(number, whole, whole, whole)
    return codec.encode(draw(st.tuples(columns, acknowledged, whole, own)))


@every_behaviour
def test_a_mind_rebuilt_from_its_percepts_goes_on_as_if_nothing_had_happened(package, name):
    life = a_life(package, name)
    once = answers(package, life)
    mind = a_mind(package)
    told = msgspec.msgpack.encode([codec.encode(one) for one in life[:15]])
    for data in percepts_of(told):
        mind.answer(data)
    assert [mind.answer(codec.encode(one)) for one in life[15:]] == once[15:]


def test_undecodable_frames_are_counted_and_the_rest_is_heard():
    mind = Mind("tower")
    mind.answer(codec.encode(first("tower", "base_station")))
    sound = sound_frames()[1]
    inbox = [
        Frame("r2", 0, b""),
        Frame("r3", 0, b"\1garbage"),
        Frame("r4", 0, sound),
        Frame("r5", 0, b"\2" + sound[1:]),
    ]
    report = codec.decode(Action, mind.answer(codec.encode(percept(1, inbox=inbox)))).report
    assert mind.undecodable_frames == 3
    assert report


def test_a_mute_behaviour_counts_nothing_as_undecodable():
    mind = Mind("swarm_agent.behaviours")
    mind.answer(codec.encode(first("swarm_agent.behaviours", "stand_still")))
    mind.answer(codec.encode(percept(1, inbox=[Frame("r3", 0, b"garbage")])))
    assert mind.undecodable_frames == 0


def test_the_end_of_the_run_has_no_answer():
    mind = Mind("tower")
    mind.answer(codec.encode(first("tower", "base_station")))
    assert mind.answer(codec.encode(Percept(9, 2**53, "end", Senses()))) is None


def test_a_new_configuration_begins_a_new_mind():
    mind = Mind("tower")
    mind.answer(codec.encode(first("tower", "base_station")))
    mind.answer(codec.encode(percept(1, inbox=[Frame("r3", 0, sound_frames()[1])])))
    again = msgspec.structs.replace(first("tower", "base_station"), tick=9, grant=9)
    fresh = msgspec.structs.replace(first("tower", "base_station"), tick=9, grant=9)
    assert mind.answer(codec.encode(again)) == Mind("tower").answer(codec.encode(fresh))


def test_memory_of_a_former_life_may_be_empty():
    assert percepts_of(b"") == []
