"""DTAG: its choice, its reservation and who gives way. Source: Farinelli et al. 2017, their released code."""

import math
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace as changed

from swarm_agent.behaviour import Heard
from swarm_agent.behaviours.dtag import Arrival, Dtag, DtagParameters
from swarm_agent.knowledge import Bulletin
from tests.builders import NO_NEWS, configuration, entries, from_tower, percept
from wire import codec
from wire.fields import Grid
from wire.messages import WAKE_ON_ARRIVAL, WAKE_ON_FRAME, GoTo

FIELD = Grid(1, 6, 10.0)
"""Six cells in a line: site k is at 5 + 10 k metres."""


def patroller(node: str = "r2", y_m: float = 5.0, tick: int = 0, field: Grid = FIELD, **parameters: Any):
    """A robot that has just begun, at site 0 unless told otherwise, and goes to the site beside."""
    told = configuration(node, "dtag", field=field)
    weights = {"start_weight": -0.5} | parameters
    one = Dtag(DtagParameters(**weights), told, np.random.Generator(np.random.Philox(1)))
    one.step(percept(tick, 5.0, y_m), [])
    return one


def there(tick: int):
    """A grant at the end of the way."""
    given = percept(tick)
    return changed(given, senses=changed(given.senses, arrived=True))


def says(sender: str, sent_tick: int, next_site: int, zero_tick: bytes | None = None) -> Heard:
    """A robot's arrival as it is heard; unless told otherwise it knows of nothing that is less idle."""
    table = np.full(6, -(2**20), "<i4").tobytes() if zero_tick is None else zero_tick
    return Heard(sender, sent_tick, Bulletin(NO_NEWS, (), 0, Arrival(table, next_site)))


def said(move) -> Arrival | None:
    """What a robot says to other robots at a step."""
    return move.say[0].message if move.say else None


def test_the_worth_of_a_site_is_its_idleness_less_the_way_and_the_distance_from_the_start():
    """Source: 1.0 * idl - 0.75 * way - 5.0 * distance from the first place, which is no cell's centre."""
    one = patroller(y_m=8.0, start_weight=-5.0)
    one.current = 3
    one.idleness.zero_tick[:] = 1000 - np.array([600, 500, 400, 300, 200, 100])
    expected = [600 - 22.5 - 15, 500 - 15 - 35, 400 - 7.5 - 85, 300 - 135, 200 - 7.5 - 185, 100 - 15 - 235]
    assert one.utility(1000) == pytest.approx(expected)
    assert (one.choose(1000), one.idleness.zero_tick[3]) == (0, 1000)


def test_it_never_chooses_where_it_is_and_of_equals_the_lowest():
    """Source: over all v != current, first maximum."""
    one = patroller(cost_weight=0.0, start_weight=0.0)
    one.current = 0
    assert one.choose(1000) == 1
    one.current = 1
    one.idleness.zero_tick[:] = 0
    assert one.choose(1000) == 0


def test_far_sites_are_candidates_and_driven_to_directly():
    one = patroller()
    one.idleness.zero_tick[5] = -5000
    move = one.step(there(10), [])
    assert move.motion == GoTo(5.0, 55.0, 3.0) and one.next_site == 5
    assert (move.wake_tick, move.wake_on) == (None, WAKE_ON_FRAME | WAKE_ON_ARRIVAL)


def test_where_it_begins_all_sites_are_idle_for_100_s_and_the_first_choice_is_said():
    told = configuration("r2", "dtag", field=FIELD)
    one = Dtag(DtagParameters(), told, np.random.default_rng(1))
    move = one.step(percept(500, 5.0, 12.0), [])
    assert np.frombuffer(said(move).zero_tick, "<i4").tolist() == [500, 500, 400, 400, 400, 400]
    assert (one.current, said(move).next_site) == (1, 0)
    assert not any(entries(move.say[0].news).values())


def test_on_arrival_the_next_site_is_told_as_if_visited_and_the_own_table_is_not_changed():
    """Source: w_v = 0 for the next site: that is the reservation."""
    one = patroller()
    move = one.step(there(10), [])
    assert (one.current, said(move).next_site) == (1, 2)
    assert np.frombuffer(said(move).zero_tick, "<i4").tolist() == [0, 10, 10, -100, -100, -100]
    assert one.idleness.zero_tick.tolist() == [0, 10, -100, -100, -100, -100]
    assert entries(move.say[0].news)[1] == 10
    assert one.step(percept(11), []).say == (), "once"


def test_of_two_times_the_less_idle_counts_and_it_ages():
    """Source: min(idl + elapsed, w)."""
    one = patroller()
    theirs = np.array([-100, -100, 7, -200, -100, -100], "<i4").tobytes()
    one.step(percept(8), [says("r3", 7, 4, theirs)])
    assert one.idleness.idle_ticks(8).tolist() == [8, 108, 1, 108, 108, 108]
    assert one.idleness.idle_ticks(60).tolist() == [60, 160, 53, 160, 160, 160]


def test_who_hears_that_another_goes_to_the_same_site_gives_it_up():
    """Source: it reckons as if it had been there, reports nothing, and drives to another."""
    one = patroller()
    assert one.next_site == 1
    move = one.step(percept(5), [says("r3", 4, 1), from_tower(4)])
    assert (one.current, one.next_site, one.idleness.zero_tick[1]) == (1, 2, 5)
    assert move.motion == GoTo(5.0, 25.0, 3.0)
    assert move.say == () and not one.knowledge.visited_tick.any()


def test_it_gives_way_to_each_in_turn():
    """Source: each message is handled as it comes."""
    one = patroller()
    one.step(percept(5), [says("r3", 4, 1), says("r4", 4, 2), says("r5", 4, 1)])
    assert one.next_site == 3


def test_another_goal_is_no_reason_to_give_way():
    one = patroller()
    assert one.step(percept(5), [says("r3", 4, 2)]).motion is None and one.next_site == 1


def test_of_two_that_choose_one_site_in_one_tick_the_lower_number_gives_way():
    """Our choice: the original's second message comes after the first has had its effect."""
    low, high = patroller("r9"), patroller("r10")
    low.step(percept(1), [says("r10", 0, 1)])
    high.step(percept(1), [says("r9", 0, 1)])
    assert (low.next_site, high.next_site) == (2, 1)


def test_who_has_arrived_gives_nothing_up_but_learns_first():
    one = patroller()
    theirs = np.array([-100, -100, 9, -100, -100, -100], "<i4").tobytes()
    move = one.step(there(10), [says("r3", 9, 1, theirs)])
    assert (one.current, said(move).next_site) == (1, 3)
    assert one.knowledge.visited_tick[1] == 10


def test_a_reservation_ages_like_a_visit_and_then_attracts():
    """Source: a robot that dies on its way holds nothing for long."""
    one = patroller(cost_weight=0.0, start_weight=0.0)
    reserved = np.array([0, 0, 0, 0, 0, 10], "<i4").tobytes()
    one.step(percept(11), [says("r3", 10, 5, reserved)])
    one.idleness.zero_tick[:5] = 5
    assert one.choose(200) != 5, "5 s less idle than others"
    one.idleness.zero_tick[:5] = 11
    assert one.choose(201) == 5


@pytest.mark.parametrize(
    "table", [b"", b"\0\0\0", np.zeros(7, "<i4").tobytes(), np.full(6, 99, "<i4").tobytes()]
)
def test_a_table_of_another_size_or_of_times_to_come_changes_nothing(table):
    one = patroller()
    before = one.idleness.zero_tick.tolist()
    one.step(percept(8), [says("r3", 7, 65535, table)])
    assert one.idleness.zero_tick.tolist() == before and one.next_site == 1


@pytest.mark.parametrize("parameter", [math.nan, math.inf])
def test_a_weight_is_a_number(parameter):
    with pytest.raises(codec.Malformed):
        codec.decode(DtagParameters, codec.encode({"cost_weight": parameter}))
