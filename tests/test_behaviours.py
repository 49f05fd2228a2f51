"""The contract of every behaviour, found by itself: a new file is tested from the day it is there."""

import importlib
import pkgutil
from typing import get_args

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import swarm_agent.behaviours
import tower
from swarm_agent.behaviour import Behaviour, find_behaviour
from swarm_agent.knowledge import Bulletin
from swarm_agent.line_radio import Envelope
from swarm_agent.node import Mind, percepts_of
from tests.builders import percept
from tests.lives import (
    IN_A_PLAN,
    ON_A_LINE,
    a_life,
    a_mind,
    answers,
    damaged,
    first,
    hearing,
    sound_frames,
    strange,
)
from wire import codec
from wire.messages import Action, Frame, Motion, Percept, Senses

TOWERS = dict.fromkeys(ON_A_LINE, ("line_keeper", Envelope)) | dict.fromkeys(
    IN_A_PLAN, ("base_station", None)
)
"""The tower that listens to a behaviour, and as what it takes its words; all others are a base station's."""


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


DISCOVERED = _discover()
every_behaviour = pytest.mark.parametrize(("package", "name"), DISCOVERED, ids=lambda one: one)


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
    """Of a mission whose tower is a mast, that has no ear: no word is mistaken for another mission's."""
    station, kind = TOWERS.get(name, ("base_station", Bulletin))
    understands = find_behaviour(station, "tower").Radio
    for answer in answers(package, a_life(package, name)):
        for payload in codec.decode(Action, answer).outbox:
            if kind is None:
                with pytest.raises(codec.Malformed):
                    codec.decode(understands, payload)
            else:
                assert isinstance(codec.decode(understands, payload), kind)


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
        heard = Mind._decode(_mind_of(one), given_percept.inbox, given_percept.senses.bearings)
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
        frames = st.one_of(st.binary(max_size=60), damaged(), strange())
        payloads = data.draw(st.lists(frames, max_size=4))
        assert mind.answer(codec.encode(hearing(name, tick, payloads)))


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
