"""DTAP: its auctions, what it says and hears. Source: Farinelli, Iocchi and Nardi 2017, their code."""

from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace as changed

from swarm_agent.behaviour import Heard
from swarm_agent.behaviours.dtag import Arrival
from swarm_agent.behaviours.dtap import Bid, Dtap, DtapParameters, Request
from swarm_agent.knowledge import Bulletin
from tests.builders import NO_NEWS, configuration, entries, from_tower, percept
from wire import codec
from wire.fields import Edge, Graph, Grid
from wire.messages import WAKE_ON_ARRIVAL, WAKE_ON_FRAME, GoTo

LINE = Grid(1, 11, 10.0)
"""Eleven cells in a line: site k is 10 k metres from site 0."""


def patroller(field: Grid = LINE, node: str = "r2", x_m: float = 5.0, tick: int = 0, **parameters: Any):
    """A robot that has just begun its first auction, at the first cell unless told otherwise."""
    told = configuration(node, "dtap", field=field)
    one = Dtap(DtapParameters(**parameters), told, np.random.Generator(np.random.Philox(1)))
    one.step(percept(tick, x_m, 5.0), [])
    return one


def says(sender: str, sent_tick: int, *words: Any) -> Heard:
    """A robot's frame as it is heard."""
    return Heard(sender, sent_tick, Bulletin(NO_NEWS, (), 0, words))


def there(tick: int):
    """A grant at the end of the way."""
    given = percept(tick)
    return changed(given, senses=changed(given.senses, arrived=True))


def words(move) -> tuple[Any, ...]:
    """What a robot says at a step, for other robots."""
    return tuple(word for bulletin in move.say for word in bulletin.message or ())


def told(arrival: Arrival) -> list[int]:
    """The table that a robot tells."""
    return np.frombuffer(arrival.zero_tick, "<i4").tolist()


def test_the_first_auction_is_for_the_best_site_from_the_nearest_while_the_robot_stands():
    """Source: all idle alike, hops decide; 1.0 + 0.1 * 0 seconds are too short for an answer to come."""
    one = Dtap(DtapParameters(), configuration("r2", "dtap", field=LINE), np.random.default_rng(1))
    move = one.step(percept(7, 5.0, 16.0), [])
    assert (one.current, words(move), move.motion) == (1, (Request(0, 10.0),), None)
    assert (move.wake_tick, move.wake_on) == (9, WAKE_ON_FRAME | WAKE_ON_ARRIVAL)


def test_on_a_graph_ways_lead_along_edges():
    """Source: path cost and hops of the cheapest path: 0-1-2 is 7 m, the edge 0-2 is 9 m."""
    nodes_m = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0))
    edges = (Edge(0, 1), Edge(1, 2), Edge(0, 2, 9.0))
    one = patroller(Graph(nodes_m=nodes_m, edges=edges), x_m=-5.0)
    assert (one.current, one.candidate, one.partition.bid_m[1]) == (0, 1, 4.0)
    move = one.step(percept(2), [says("r3", 1, Bid(1, 0.0))])
    assert words(move) == (Request(2, 7.0),) and one.ways.hops[0, 2] == 2


def test_an_auction_lasts_longer_the_more_tasks_and_no_longer_than_the_time_out():
    """Source: min(timeout, 1.0 + 0.1 * tasks), here in whole ticks of which there are at least two."""
    for tasks, timeout_s, ticks in ((0, 3.0, 2), (10, 3.0, 2), (11, 3.0, 3), (40, 3.0, 3), (40, 9.0, 5)):
        one = patroller(Grid(), timeout_s=timeout_s)
        one.partition.task_count = tasks
        one.request_best(100)
        assert one.auction_ends_tick == 100 + ticks


def test_who_has_lost_every_site_begins_again_with_all_but_where_it_is():
    """Source: selected = {current}: even the site where it goes is then asked for."""
    one, asked_for = patroller(Grid(1, 4, 10.0)), []
    for tick in range(1, 20):
        theirs = [says("r3", tick - 1, Bid(one.candidate, 0.0))] if one.next_site > 0 else []
        move = one.step(percept(tick), theirs)
        asked_for += [word.site for word in words(move) if isinstance(word, Request)]
    assert one.next_site == 1 and asked_for[:8] == [2, 3, 1, 2, 3, 1, 2, 3]


def test_a_robot_alone_wins_and_drives_on_and_auctions_what_comes_after():
    """Source: no answer within the time means that it is won."""
    one = patroller()
    assert one.step(percept(1), []).say == ()
    move = one.step(percept(2), [])
    assert move.motion == GoTo(5.0, 15.0, 3.0)
    arrival, request = words(move)
    assert arrival.next_site == 1 and request == Request(2, one.ways.costs_m[2, one.partition.centre] * 2)
    assert one.step(percept(4), []).wake_tick is None and one.site_after == 2


def is_greedy(site: int, excess_s: float, bid_m: float) -> bool:
    """Site 1 beside site 0, or site 2; idle so much longer than mean and two standard deviations."""
    one = patroller()
    others = np.array([0, 40, 20, 60, 30, 10, 50, 30, 20, 40, 0])
    most = next(
        idle
        for idle in range(1000)
        if idle > (idle_s := np.where(np.arange(11) == site, idle, others)).mean() + 2 * idle_s.std()
    )
    one.idleness.zero_tick[:] = 1000 - np.where(np.arange(11) == site, most + excess_s, others)
    one.partition.hear(site, bid_m, 3, 1)
    return one.is_greedy(site, 1000)


def test_a_very_idle_site_beside_is_taken_without_owning_it():
    """Source: at most one hop, above mean + 2 sd of the population, and nobody bids 0."""
    assert is_greedy(1, 0, bid_m=5.0)
    assert not is_greedy(1, -1, bid_m=5.0), "not idle enough"
    assert not is_greedy(1, 0, bid_m=0.0), "somebody is going there"
    assert not is_greedy(2, 0, bid_m=5.0), "too far"


def test_a_greedy_robot_goes_although_another_owns_the_site():
    one = patroller()
    one.idleness.zero_tick[1] = -5000
    one.step(percept(1), [says("r3", 0, Bid(1, 5.0))])
    assert one.step(percept(2), []).motion == GoTo(5.0, 15.0, 3.0)
    assert not one.partition.owns(1) and not one.partition.tasks[1]


# On the way and on arrival


def under_way(**parameters: Any) -> Dtap:
    """Set out at tick 2 from site 0 to site 1; site 2 was won at tick 4."""
    one = patroller(**parameters)
    for tick in range(1, 5):
        one.step(percept(tick), [])
    assert (one.current, one.next_site, one.site_after) == (0, 1, 2)
    return one


def test_on_arrival_the_table_is_told_with_the_next_site_as_if_visited():
    """Source: the site just reached is told with the time since it was set out for, here still never."""
    one = under_way()
    move = one.step(there(20), [])
    arrival = words(move)[0]
    assert (one.current, one.next_site, arrival.next_site) == (1, 2, 2)
    never = -2 * 11  # the idleness where a robot begins: twice the number of sites in seconds
    assert told(arrival)[:4] == [20, never, 20, never]
    assert one.idleness.zero_tick[1] == 20, "zero as the auction begins"
    assert one.step(percept(22), []).say == (), "site 3 is won; a grant without the tower in range"
    assert told(words(one.step(there(30), []))[0])[:5] == [20, 30, 20, 30, never]


def test_who_arrives_before_the_auction_ends_waits_at_the_site():
    """Source: the auction blocks the decision, not the driving; the visit counts when it is."""
    one = under_way()
    one.step(there(20), [])
    waits = one.step(there(21), [says("r3", 20, Bid(3, 0.0))])
    assert waits.motion is None and waits.wake_tick == 22
    tells = one.step(there(22), [from_tower(21)])
    assert tells.motion is None and isinstance(words(tells)[0], Request)
    assert entries(tells.say[0].news)[2] == 21
    goes = one.step(there(24), [])
    assert isinstance(goes.motion, GoTo) and one.current == 2


def test_a_request_is_answered_at_once_if_the_own_bid_is_best():
    """Source: the way from the centre; r2 at 5 m with its first task's centre."""
    one = under_way()
    move = one.step(percept(6), [says("r3", 5, Request(4, 500.0), Request(5, 1.0))])
    assert words(move) == (Bid(4, one.partition.bid_m[4]),) and one.partition.owner[5] == 3
    assert words(one.step(percept(7), [says("r3", 6, Request(1, 0.0))])) == (Bid(1, 0.0),)


def test_idleness_is_the_least_that_anybody_knows_and_has_no_end_at_3200_s():
    """Source: min of both; 16 bits of the original are not ours."""
    one, other = under_way(), patroller(node="r3")
    for tick in (4000, 9000):
        other.idleness.zero_tick[7] = tick - 3900
        one.step(percept(tick), [says("r3", tick - 1, Arrival(other.idleness.zero_tick.tobytes(), 7))])
        assert one.idle_s(tick)[7] == 3900
    assert one.idle_s(9000)[8] == 9000 + 22


@pytest.mark.parametrize(
    "word",
    [
        Request(11, 1.0),
        Bid(65535, 0.0),
        Arrival(np.zeros(12, "<i4").tobytes(), 3),
        Arrival(b"\0\0\0", 3),
        Arrival(b"", 3),
        Arrival(np.full(11, 2**31 - 1, "<i4").tobytes(), 3),
    ],
)
def test_words_about_sites_or_times_that_are_none_change_nothing(word):
    one, same = under_way(), under_way()
    move = one.step(percept(6), [says("r3", 5, word)])
    assert move == same.step(percept(6), [])
    assert one.idleness.zero_tick.tolist() == same.idleness.zero_tick.tolist()
    assert one.partition.owner.tolist() == same.partition.owner.tolist()


@pytest.mark.parametrize(
    "word", [("bid", 1, float("nan")), ("bid", -1, 1.0), ("request", 1), ("sale", 1, 1.0)]
)
def test_what_is_no_bid_is_not_understood(word):
    with pytest.raises(codec.Malformed):
        codec.decode(Dtap.Radio, codec.encode(Bulletin(NO_NEWS, (), 0, (word,))))
