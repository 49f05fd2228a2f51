"""The codec: what is said is what is heard, and whatever else arrives is Malformed and nothing worse."""

import inspect
from typing import get_args

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.builders import percept
from wire import codec, messages
from wire.clearing import Standing
from wire.fields import Edge, Graph, Grid, Polyline, Unseen
from wire.messages import Action, GoTo, Message, Motion, Notice, Percept, Request, Stay

KINDS = [
    kind
    for _, kind in inspect.getmembers(messages, inspect.isclass)
    if issubclass(kind, Message) and kind is not Message
] + [Standing]

ids = st.from_regex(r"[a-z][a-z_]{0,5}[0-9]{1,4}", fullmatch=True)
counts = st.integers(0, 2**53)
finite = st.floats(allow_nan=False, allow_infinity=False)
any_data = st.dictionaries(
    st.text(max_size=4), st.one_of(st.none(), st.booleans(), finite, st.text(max_size=4))
)
grids = st.builds(
    Grid,
    st.integers(1, 30),
    st.integers(1, 30),
    st.floats(0.1, 100),
    st.none() | st.floats(0, 100),
    st.floats(0.1, 9),
    st.lists(st.tuples(st.integers(0, 29), st.integers(0, 29)), max_size=3).map(tuple),
)
places = st.tuples(finite, finite)
polylines = st.builds(
    Polyline,
    st.lists(places, max_size=3).map(tuple),
    st.integers(1, 9) | st.lists(places, max_size=3).map(tuple),
    st.floats(0, 9),
    st.floats(0, 9),
    st.floats(0.1, 9),
    st.floats(0.1, 9),
)
numbers = st.integers(0, 9)
graphs = st.builds(
    Graph,
    st.text(max_size=4),
    st.lists(places, max_size=3).map(tuple),
    st.lists(st.builds(Edge, numbers, numbers, st.none() | st.floats(0.1, 9)), max_size=3).map(tuple),
    st.sampled_from(["cost", "straight"]),
    st.floats(0.1, 9),
)


def strategy_of(kind):
    """A strategy for a message type, from the types of its fields."""
    hints = inspect.get_annotations(kind, eval_str=True)
    return st.builds(kind, **{name: field_of(kind, name, hint) for name, hint in hints.items()})


def field_of(kind, name, hint):
    if name == "value":
        return st.floats(0, allow_nan=False, allow_infinity=False)
    if hint is messages.NodeId:
        return ids
    if hint is messages.Count:
        return counts
    if hint is Grid:
        return grids
    if hint is Graph:
        return graphs
    if hint is Polyline:
        return polylines
    if hint is Unseen:
        return st.builds(Unseen, st.floats(0.1, 9), numbers, st.floats(0.1, 9))
    if hint is float:
        return finite
    if name == "path_m":
        return st.lists(places, min_size=1, max_size=3).map(tuple)
    if name == "every":
        return st.integers(1, 9)
    if name == "wake_on":
        return st.integers(0, 15)
    if name == "wake_tick":
        return st.none()
    if name == "data":
        return any_data
    return from_hint(kind, name, hint)


def from_hint(kind, name, hint):
    inner = get_args(hint)
    if getattr(hint, "__origin__", None) is tuple:
        if inner[-1] is Ellipsis:
            return st.lists(field_of(kind, "", inner[0]), max_size=3).map(tuple)
        return st.tuples(*(field_of(kind, "", one) for one in inner))
    if hint is int:
        return st.integers(-(2**63), 2**64 - 1)
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        return strategy_of(hint)
    if type(None) in inner or (inner and all(isinstance(one, type) for one in inner)):
        return st.one_of([st.none() if one is type(None) else field_of(kind, "", one) for one in inner])
    return st.from_type(hint)


def any_message(kinds=KINDS):
    return st.sampled_from(kinds).flatmap(lambda kind: st.tuples(st.just(kind), strategy_of(kind)))


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_message_comes_back_as_it_was_said(kind):
    @given(strategy_of(kind))
    def comes_back(message):
        data = codec.encode(message)
        assert codec.decode(kind, data) == message
        assert codec.encode(codec.decode(kind, data)) == data

    comes_back()


@given(strategy_of(Action), st.integers(1, 10))
def test_an_action_with_a_time_to_wake_comes_back(action, later):
    action = msgspec.structs.replace(
        action, wake_tick=min(action.tick, 2**52) + later, tick=min(action.tick, 2**52)
    )
    assert codec.decode(Action, codec.encode(action)) == action


@given(any_message([kind for kind in KINDS if kind in get_args(Motion) + get_args(Notice)]))
def test_a_member_of_a_union_is_told_apart_by_its_tag(drawn):
    kind, message = drawn
    union = Motion if kind in get_args(Motion) else Notice
    assert codec.decode(union, codec.encode(message)) == message


def decodes_or_is_malformed(kind, data: bytes) -> None:
    try:
        assert isinstance(codec.decode(kind, data), kind)
    except codec.Malformed as error:
        assert str(error)


@given(st.sampled_from(KINDS), st.binary(max_size=80))
def test_any_bytes_decode_or_are_malformed(kind, data):
    decodes_or_is_malformed(kind, data)
    decodes_or_is_malformed(kind, codec.encode(0)[:1] + data)


@given(
    st.sampled_from(KINDS),
    st.recursive(
        st.one_of(
            st.none(), st.booleans(), st.integers(-(2**63), 2**64 - 1), st.floats(), st.text(), st.binary()
        ),
        lambda inner: st.lists(inner, max_size=12) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    ),
)
def test_any_messagepack_decodes_or_is_malformed(kind, value):
    decodes_or_is_malformed(kind, codec.encode(value))


@given(any_message(), st.data())
def test_a_damaged_message_decodes_or_is_malformed(drawn, data):
    kind, message = drawn
    sound = codec.encode(message)
    damaged = bytearray(sound)
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    decodes_or_is_malformed(kind, bytes(damaged[: data.draw(st.integers(0, len(damaged)))]))
    decodes_or_is_malformed(kind, bytes(damaged))


@given(any_message())
def test_a_cut_message_is_malformed(drawn):
    kind, message = drawn
    data = codec.encode(message)
    for end in range(len(data)):
        with pytest.raises(codec.Malformed):
            codec.decode(kind, data[:end])


@given(any_message(), st.binary(min_size=1, max_size=9))
def test_bytes_behind_a_message_are_malformed(drawn, more):
    kind, message = drawn
    with pytest.raises(codec.Malformed):
        codec.decode(kind, codec.encode(message) + more)


@given(any_message(), st.integers(0, 255).filter(lambda version: version != codec.SCHEMA_VERSION))
def test_another_schema_version_is_named(drawn, version):
    kind, message = drawn
    with pytest.raises(codec.Malformed, match=f"schema version {version}, this program speaks 1"):
        codec.decode(kind, bytes([version]) + codec.encode(message)[1:])


@pytest.mark.parametrize("number", [float("nan"), float("inf"), float("-inf")])
@pytest.mark.parametrize("place", [0, 1, 2])
def test_a_goal_that_is_nowhere_is_refused(number, place):
    values = [1.0, 2.0, 3.0]
    values[place] = number
    with pytest.raises(codec.Malformed, match="finite"):
        codec.decode(Action, codec.encode([1, 1, ["go_to", *values], [], None, 0, b""]))
    with pytest.raises(ValueError, match="finite"):
        GoTo(*values)


@pytest.mark.parametrize("wake_tick", [0, 6, 7])
def test_a_time_to_wake_that_is_not_after_the_tick_is_refused(wake_tick):
    with pytest.raises(codec.Malformed, match=f"wake_tick {wake_tick} is not after tick 7"):
        codec.decode(Action, codec.encode([7, 1, None, [], wake_tick, 0, b""]))


@pytest.mark.parametrize("wake_on", [-1, 16])
def test_unknown_reasons_to_wake_are_refused(wake_on):
    with pytest.raises(codec.Malformed):
        codec.decode(Action, codec.encode([7, 1, None, [], None, wake_on, b""]))


@given(any_message())
def test_a_field_too_many_is_refused(drawn):
    kind, message = drawn
    longer = [*msgspec.msgpack.decode(codec.encode(message)[1:]), None]
    with pytest.raises(codec.Malformed):
        codec.decode(kind, codec.encode(longer))


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
@pytest.mark.parametrize("verb", ["step", "speed"])
def test_a_request_for_no_number_is_refused(verb, value):
    with pytest.raises(codec.Malformed, match="finite"):
        codec.decode(Request, codec.encode([verb, "", "lost", value]))


@pytest.mark.parametrize("name", ["", "R2", "2", "r", "r12345", "r2 ", "r2\n", "r2/../r3", "*", "r*2", "é2"])
def test_a_name_that_is_no_node_id_is_refused(name):
    with pytest.raises(codec.Malformed):
        codec.decode(messages.Sighting, codec.encode([name, 0.0, 0.0]))


def test_a_message_that_is_too_long_is_refused_unread():
    with pytest.raises(codec.Malformed, match="at most"):
        codec.decode(Percept, codec.encode(bytes(codec.MAX_BYTES)))


def test_nested_beyond_reason_is_malformed():
    with pytest.raises(codec.Malformed):
        codec.decode(messages.Event, b"\x01\x95\x01\xa1k\xa1n\xa1t\x81\xa1d" + b"\x91" * 100_000)


def test_equal_messages_give_equal_bytes():
    assert codec.encode(percept(3, 1.0, 2.0)) == codec.encode(percept(3, 1.0, 2.0))
    assert codec.encode(Stay()) == codec.encode(Stay())
