"""Flooding along the line: everything new is heard once, travels its direction, and dies of age or hops."""

from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from swarm_agent.behaviour import Heard
from swarm_agent.line_radio import AGAIN_TICKS, Envelope, Order, Place, Relay, Report, Roll
from wire import codec

REPORT = Report("patrol", 3, 8.9)


def relay(node="r5", age_ticks=60, hops_most=5):
    return Relay(node, "r1", age_ticks, hops_most, contact_ticks=600)


def heard(message=REPORT, origin="r9", said=10, distance_m=20.0, again=True, hops=0, sender=None):
    envelope = Envelope(origin, said, 0, message, distance_m, again, hops)
    return Heard(sender or origin, said, envelope)


def at(distance_m, **fields):
    """A place on a straight line."""
    return Place(distance_m, distance_m, **fields)


def onward(node, distance_m=10.0):
    return node.outbox(11, (), at(distance_m), relay=False)


def test_a_message_is_new_once_however_often_it_comes():
    node = relay()
    copies = [heard(), heard(sender="r4", hops=1), heard(sender="r3", hops=2)]
    assert len(node.hear(11, copies, at(10.0))) == 1
    assert node.hear(12, copies, at(10.0)) == []
    assert len(onward(node)) == 1


def test_a_report_travels_on_only_towards_the_tower():
    node = relay()
    node.hear(11, [heard(distance_m=20.0)], at(10.0))
    (copy,) = onward(node)
    assert (copy.origin, copy.hops, copy.distance_m) == ("r9", 1, 10.0)
    other = relay()
    other.hear(11, [heard(distance_m=5.0)], at(10.0))
    assert onward(other) == ()


def test_an_order_travels_on_only_away_from_the_tower_and_not_beyond_whom_it_is_for():
    outer, inner, addressee = relay(), relay(), relay("r7")
    order = heard(Order(1, "r7", 2), origin="r1", distance_m=10.0)
    outer.hear(11, [order], at(15.0))
    inner.hear(11, [order], at(5.0))
    addressee.hear(11, [order], at(15.0))
    assert len(onward(outer)) == 1
    assert onward(inner) == () and onward(addressee) == ()


def test_what_is_not_to_be_relayed_stays():
    node = relay()
    assert len(node.hear(11, [heard(again=False)], at(10.0))) == 1
    assert onward(node) == ()


def test_too_many_hops_are_heard_and_not_said_again():
    node = relay(hops_most=5)
    assert len(node.hear(11, [heard(hops=5)], at(10.0))) == 1
    assert onward(node) == ()


def test_what_is_too_old_is_not_heard():
    node = relay(age_ticks=60)
    assert node.hear(71, [heard(said=10)], at(10.0)) == []
    assert len(node.hear(70, [heard(said=10)], at(10.0))) == 1


def test_ones_own_words_are_no_news():
    node = relay("r9")
    assert node.hear(11, [heard(origin="r9", sender="r4")], at(10.0)) == []


def test_the_tower_relays_nothing():
    tower = relay("r1")
    assert len(tower.hear(11, [heard()], at(0.0))) == 1
    assert onward(tower, 0.0) == ()


def test_contact_is_the_towers_own_voice_and_passes():
    node = relay()
    assert not node.in_contact(0, 10.0)
    node.hear(11, [heard(Roll(), origin="r1", sender="r4")], at(10.0))
    assert not node.in_contact(11, 10.0), "a relayed word is no contact"
    node.hear(20, [heard(Roll(), origin="r1", said=19)], at(10.0))
    assert node.in_contact(20, 10.0) and node.in_contact(619, 10.0) and not node.in_contact(620, 10.0)


def test_contact_does_not_reach_beyond_where_the_tower_was_heard():
    node = relay()
    node.hear(20, [heard(Roll(), origin="r1", said=19)], at(10.0))
    node.hear(30, [heard(Roll(), origin="r1", said=29)], at(4.0))
    assert node.in_contact(30, 4.0) and node.in_contact(30, 10.0) and not node.in_contact(30, 10.1)
    node.hear(700, [heard(Roll(), origin="r1", said=699)], at(4.0))
    assert node.in_contact(700, 4.0) and not node.in_contact(700, 10.0), "that was too long ago"


def test_a_report_that_the_tower_hears_is_said_again_no_further():
    node = relay()
    node.hear(10, [heard(Roll(), origin="r1", said=9)], at(10.0))
    node.hear(11, [heard(distance_m=20.0)], at(10.0))
    (copy,) = onward(node)
    assert not copy.relay, "whoever hears this, the tower hears it too"
    assert node.next_tick() is None


def test_a_report_that_nobody_carries_on_is_said_again_until_somebody_does():
    node = relay()
    own = node.outbox(10, (REPORT,), at(20.0), relay=True)
    node.hear(11, [heard(origin="r7", distance_m=25.0)], at(20.0))
    other = node.outbox(11, (), at(20.0), relay=False)
    assert node.next_tick() == 10 + AGAIN_TICKS
    assert node.outbox(14, (), at(18.0), relay=False) == ()
    (again,) = node.outbox(15, (), at(18.0), relay=False)
    assert (again.distance_m, again.hops, again.relay) == (18.0, 0, True)
    node.hear(16, [Heard("r3", 15, replace(other[0], distance_m=22.0))], at(18.0))
    (again,) = node.outbox(16, (), at(18.0), relay=False)
    assert again.origin == "r7", "a copy from further out carries nothing on"
    copies = [replace(one, distance_m=9.0, hops=3) for one in (*own, *other)]
    assert node.hear(17, [Heard("r3", 16, one) for one in copies], at(18.0)) == []
    assert node.next_tick() is None


def test_a_report_that_is_driven_the_wrong_way_is_taken_up_again():
    node = relay()
    (own,) = node.outbox(10, (REPORT,), at(20.0), relay=True)
    node.hear(12, [Heard("r3", 11, replace(own, distance_m=19.0, hops=1))], at(20.0))
    assert node.next_tick() is None
    for tick, distance_m in ((14, 20.5), (17, 21.0)):
        words = node.hear(
            tick, [Heard("r3", tick - 1, replace(own, distance_m=distance_m, hops=1))], at(20.0)
        )
        assert words == []
        said = node.outbox(tick, (), at(20.0), relay=False)
        assert [one.distance_m for one in said] == [20.0] * (tick == 17), "not when it was just carried on"
    assert node.next_tick() == 17 + AGAIN_TICKS


def test_a_report_is_kept_no_longer_than_it_is_heard_or_the_last_word_of_its_robot():
    node = relay(age_ticks=12)
    node.outbox(10, (REPORT,), at(20.0), relay=True)
    assert [len(node.outbox(tick, (), at(20.0), relay=True)) for tick in (15, 20, 25)] == [1, 1, 0]
    node.outbox(30, (REPORT,), at(20.0), relay=True)
    node.outbox(32, (REPORT,), at(20.0), relay=True)
    (again,) = node.outbox(37, (), at(20.0), relay=True)
    assert again.said_tick == 32
    node.hear(38, [heard(Roll(), origin="r1", said=37)], at(20.0))
    (again,) = node.outbox(42, (), at(20.0), relay=True)
    assert not again.relay and node.next_tick() is None, "now the tower hears it"


def test_orders_are_not_kept():
    node = relay()
    node.hear(11, [heard(Order(1, "r7", 2), origin="r1", distance_m=5.0)], at(10.0))
    assert len(onward(node)) == 1
    assert node.next_tick() is None


def test_what_was_carried_further_in_the_same_tick_is_not_said_again():
    report, order = relay(), relay()
    report.hear(11, [heard(distance_m=20.0), heard(distance_m=8.0, sender="r4", hops=1)], at(10.0))
    copies = [heard(Order(1, "r7", 2), "r1", distance_m=one, sender="r4") for one in (5.0, 12.0)]
    order.hear(11, copies, at(10.0))
    assert onward(report) == onward(order) == ()


def test_who_waits_in_the_queue_passes_nothing_on():
    node = relay()
    order = heard(Order(1, "r7", 2), origin="r1", distance_m=0.0)
    assert len(node.hear(11, [heard(), order], at(1.0, waits=True))) == 2
    assert onward(node) == ()


def test_several_messages_of_one_tick_have_different_names():
    node = relay()
    one, two = node.outbox(11, (REPORT, REPORT), at(10.0), relay=True)
    (three,) = node.outbox(11, (REPORT,), at(10.0), relay=True)
    assert len({(copy.origin, copy.said_tick, copy.number) for copy in (one, two, three)}) == 3
    assert one.relay


@given(
    st.integers(2, 25).flatmap(
        lambda count: st.tuples(
            st.lists(st.floats(0.5, 1.9), min_size=count, max_size=count), st.permutations(range(count))
        )
    )
)
def test_along_any_line_without_a_hole_every_report_arrives_and_every_copy_is_said_once(line):
    """Robots at most 1.9 m apart and a range of 2 m: the outermost robot's report reaches the tower."""
    gaps, order = line
    distances = {f"r{number + 2}": sum(gaps[: number + 1]) for number in range(len(gaps))}
    places = {"r1": 0.0} | distances
    nodes = {name: relay(name, hops_most=64) for name in places}
    outermost = f"r{len(gaps) + 1}"
    for name, place_m in distances.items():
        if place_m <= 2.0:
            nodes[name].hear(0, [heard(Roll(), origin="r1", said=-1)], at(place_m))
    unheard = not nodes[outermost].in_contact(0, places[outermost])
    air = {outermost: nodes[outermost].outbox(0, (REPORT,), at(places[outermost]), unheard)}
    said, arrived = 1, False
    for tick in range(1, 40):
        new_air = {}
        for index in (*order, -1):
            name = f"r{index + 2}"
            inbox = [
                Heard(sender, tick - 1, codec.decode(Envelope, codec.encode(one)))
                for sender, copies in air.items()
                for one in copies
                if sender != name and abs(places[sender] - places[name]) <= 2.0
            ]
            words = nodes[name].hear(tick, inbox, at(places[name]))
            arrived = arrived or (name == "r1" and bool(words))
            new_air[name] = nodes[name].outbox(tick, (), at(places[name]), relay=False)
        said += sum(map(len, new_air.values()))
        air = new_air
    assert arrived
    assert said <= len(gaps)
