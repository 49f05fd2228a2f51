"""The radio: who hears what, judged rule by rule."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wire.scenario import Latency, Loss, Partition, RadioSection, Range
from world_server.radio import Radio, distances_m

places = st.lists(st.tuples(st.floats(-300, 300), st.floats(-300, 300)), min_size=1, max_size=6)
rules = st.lists(
    st.one_of(
        st.builds(Range, st.floats(1, 400)),
        st.builds(Loss, st.floats(0, 1)),
        st.builds(Latency, st.integers(1, 9)),
        st.just(Partition((("r1", "r2"), ("r4",)), 2.0, 8.0)),
    ),
    max_size=4,
)


def radio(*given, nodes: int = 6, seed: int = 1, tick_s: float = 1.0, **limits) -> Radio:
    return Radio(RadioSection(tuple(given), **limits), [f"r{n + 1}" for n in range(nodes)], seed, tick_s)


def apart(*positions) -> np.ndarray:
    return distances_m(np.array(positions, dtype=float).reshape(-1, 2))


CLOSE = apart(*[(0, 0)] * 6)


def heard(one: Radio, tick: int, outboxes, apart_m=CLOSE, deaf=()) -> dict[tuple[int, int, int], int]:
    """(sender, frame, receiver) -> tick at which it is heard."""
    deliveries, _, _ = one.transmit(tick, outboxes, apart_m, deaf)
    columns = [column.tolist() for column in deliveries]
    return {key: when for *key, when in zip(*columns, strict=True) for key in [tuple(key)]}


@given(places, st.floats(1, 400), st.data())
def test_a_frame_is_heard_exactly_by_those_in_range_one_tick_later(positions, range_m, data):
    sender = data.draw(st.integers(0, len(positions) - 1))
    apart_m = apart(*positions)
    expected = {
        (sender, 0, other): 8
        for other in range(len(positions))
        if other != sender
        and np.hypot(*np.subtract(positions[sender], positions[other])) <= range_m * (1 - 1e-12)
    }
    border = {
        (sender, 0, other): 8
        for other in range(len(positions))
        if other != sender
        and np.hypot(*np.subtract(positions[sender], positions[other])) <= range_m * (1 + 1e-12)
    }
    found = heard(radio(Range(range_m), nodes=len(positions)), 7, {sender: [b"x"]}, apart_m)
    assert expected.items() <= found.items() <= border.items()


@pytest.mark.parametrize(("away", "gets_through"), [(180.0, True), (np.nextafter(180.0, 181), False)])
def test_the_range_itself_is_within_range(away, gets_through):
    found = heard(radio(Range(180.0), nodes=2), 0, {0: [b"x"]}, apart((0, 0), (away, 0)))
    assert bool(found) is gets_through


@given(places)
def test_range_is_symmetric(positions):
    everyone = {row: [b"x"] for row in range(len(positions))}
    found = heard(radio(Range(180.0), nodes=len(positions)), 0, everyone, apart(*positions))
    assert {(receiver, 0, sender) for sender, _, receiver in found} == set(found)


@given(places, rules, st.lists(st.integers(0, 5)))
def test_nobody_hears_itself_and_the_deaf_hear_nothing(positions, given_rules, deaf):
    deaf = [row for row in deaf if row < len(positions)]
    everyone = {row: [b"x", b"y"] for row in range(len(positions))}
    found = heard(radio(*given_rules, nodes=len(positions)), 3, everyone, apart(*positions), deaf)
    assert all(sender != receiver and receiver not in deaf for sender, _, receiver in found)


def test_without_rules_everybody_hears_everything_in_the_next_tick():
    assert set(heard(radio(), 4, {0: [b"x"]}, apart(*[(1e6 * n, 0) for n in range(6)])).values()) == {5}


@pytest.mark.parametrize("ticks", [1, 2, 50])
def test_latency_is_exact(ticks):
    assert set(heard(radio(Latency(ticks)), 4, {0: [b"x"]}).values()) == {4 + ticks}


def test_the_first_rule_that_does_not_pass_decides():
    far = apart(*[(200.0 * n, 0) for n in range(6)])
    assert heard(radio(Range(180.0), Latency(3)), 0, {0: [b"x"]}, far) == {}
    assert len(heard(radio(Latency(3), Range(180.0)), 0, {0: [b"x"]}, far)) == 5
    assert set(heard(radio(Latency(3), Latency(9)), 0, {0: [b"x"]}).values()) == {3}
    assert len(heard(radio(Latency(3), Loss(1.0)), 0, {0: [b"x"]})) == 5
    assert heard(radio(Loss(1.0), Latency(3)), 0, {0: [b"x"]}) == {}


@pytest.mark.parametrize(("tick", "lasting"), [(1, False), (2, True), (7, True), (8, False)])
def test_a_partition_lasts_from_its_first_tick_until_before_its_last(tick, lasting):
    split = Partition((("r2",),), from_s=2.0, until_s=8.0)
    assert bool(heard(radio(split, nodes=2), tick, {0: [b"x"]}, apart((0, 0), (0, 0)))) is not lasting


def test_the_times_of_a_partition_are_seconds():
    split = Partition((("r2",),), from_s=2.0, until_s=4.0)
    one = radio(split, nodes=2, tick_s=0.5)
    close = apart((0, 0), (0, 0))
    assert [bool(heard(one, tick, {0: [b"x"]}, close)) for tick in (3, 4, 7, 8)] == [True, False, False, True]


def test_a_partition_without_an_end_lasts():
    assert heard(radio(Partition((("r2",),)), nodes=2), 10**6, {0: [b"x"]}, apart((0, 0), (0, 0))) == {}


def test_a_partition_separates_groups_and_those_in_no_group_are_one():
    split = Partition((("r1", "r2"), ("r3",)))
    found = heard(radio(split), 0, {row: [b"x"] for row in range(6)})
    together = [{0, 1}, {2}, {3, 4, 5}]
    assert set(found) == {(a, 0, b) for group in together for a in group for b in group if a != b}


@given(st.integers(0, 2**63 - 1), st.integers(0, 10**6), st.data())
def test_who_else_speaks_changes_nobodys_luck(seed, tick, data):
    one = radio(Loss(0.5), seed=seed)
    everyone = {row: [b"x", b"yy", b"z"] for row in range(6)}
    all_heard = heard(one, tick, everyone)
    some = data.draw(st.sets(st.integers(0, 5)))
    frames = data.draw(st.integers(1, 3))
    few_heard = heard(one, tick, {row: everyone[row][:frames] for row in sorted(some)})
    assert set(few_heard) == {key for key in all_heard if key[0] in some and key[1] < frames}


@given(st.integers(0, 10**6), st.lists(st.integers(0, 5)))
def test_who_else_listens_changes_nobodys_luck(tick, deaf):
    one = radio(Loss(0.5))
    all_heard = heard(one, tick, {0: [b"x"]})
    assert set(heard(one, tick, {0: [b"x"]}, deaf=deaf)) == {key for key in all_heard if key[2] not in deaf}


@given(st.integers(0, 10**9), st.integers(0, 5))
def test_loss_with_probability_zero_loses_nothing_and_one_loses_all(tick, row):
    assert len(heard(radio(Loss(0.0)), tick, {row: [b"x"]})) == 5
    assert heard(radio(Loss(1.0)), tick, {row: [b"x"]}) == {}


def test_the_share_of_lost_frames_is_the_probability():
    one = radio(Loss(0.3))
    through = sum(len(heard(one, tick, {row: [b"x", b"y"] for row in range(6)})) for tick in range(200))
    assert through / (200 * 60) == pytest.approx(0.7, abs=0.0126)  # three standard deviations


def test_frames_are_lost_to_each_receiver_independently():
    one = radio(Loss(0.5), nodes=2)
    pair = apart((0, 0), (0, 0))
    draws = [heard(one, tick, {0: [b"x"], 1: [b"x"]}, pair) for tick in range(2000)]
    both = sum(len(found) == 2 for found in draws)
    assert both / 2000 == pytest.approx(0.25, abs=0.03)


def test_two_loss_rules_draw_twice():
    one = radio(Loss(0.5), Loss(0.5))
    through = sum(len(heard(one, tick, {0: [b"x"]})) for tick in range(800))
    assert through / 4000 == pytest.approx(0.25, abs=0.03)


def test_another_seed_loses_other_frames():
    lucks = {
        tuple(len(heard(radio(Loss(0.5), seed=seed), tick, {0: [b"x"]})) for tick in range(40))
        for seed in range(5)
    }
    assert len(lucks) == 5


@given(st.lists(st.integers(0, 60), max_size=6))
def test_frames_beyond_the_bytes_of_a_tick_are_refused_in_order_and_counted(sizes):
    deliveries, refused, tally = radio(nodes=2, bytes_per_tick=100).transmit(
        0, {0: [bytes(size) for size in sizes]}, apart((0, 0), (0, 0))
    )
    fitting = max(n for n in range(len(sizes) + 1) if sum(sizes[:n]) <= 100)
    assert deliveries.frames.tolist() == list(range(fitting))
    assert refused == ({0: len(sizes) - fitting} if fitting < len(sizes) else {})
    assert (tally.sent, tally.oversize, tally.bytes) == (fitting, len(sizes) - fitting, sum(sizes[:fitting]))


def test_the_limit_is_each_senders_own():
    _, refused, tally = radio(bytes_per_tick=10).transmit(
        0, {0: [bytes(10)], 1: [bytes(11)], 2: [bytes(9)]}, CLOSE
    )
    assert refused == {1: 1}
    assert tally.bytes == 19


@given(
    places,
    rules,
    st.lists(st.integers(0, 5)),
    st.dictionaries(st.integers(0, 5), st.lists(st.binary(max_size=9))),
)
def test_the_tally_adds_up(positions, given_rules, deaf, outboxes):
    nodes = len(positions)
    outboxes = {row: frames for row, frames in sorted(outboxes.items()) if row < nodes}
    deaf = {row for row in deaf if row < nodes}
    one = radio(*given_rules, nodes=nodes, bytes_per_tick=20)
    deliveries, refused, tally = one.transmit(5, outboxes, apart(*positions), list(deaf))
    said = {row: len(frames) - refused.get(row, 0) for row, frames in outboxes.items()}
    pairs = sum(count * len(set(range(nodes)) - deaf - {row}) for row, count in said.items())
    assert pairs == tally.delivered + tally.out_of_range + tally.lost
    assert tally.delivered == len(deliveries.senders)
    assert tally.sent == sum(said.values())
    assert min(tally) >= 0


def test_out_of_range_and_lost_are_counted_apart():
    far = apart((0, 0), (0, 0), (500, 0))
    one = radio(Range(180.0), Loss(1.0), nodes=3)
    _, _, tally = one.transmit(0, {0: [b"xyz"]}, far)
    assert tally == (1, 0, 1, 1, 0, 3)


@given(places, rules)
def test_deliveries_stand_in_order_of_sender_frame_and_receiver(positions, given_rules):
    everyone = {row: [b"x", b"y"] for row in reversed(range(len(positions)))}
    found = heard(radio(*given_rules, nodes=len(positions)), 3, everyone, apart(*positions))
    assert list(found) == sorted(found)


@given(places)
def test_distances_are_euclidean(positions):
    found = apart(*positions)
    for a, here in enumerate(positions):
        for b, there in enumerate(positions):
            assert found[a, b] == pytest.approx(np.hypot(here[0] - there[0], here[1] - there[1]))
