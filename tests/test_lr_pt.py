"""LR-PT, line by line. Line numbers are those of Algorithms 1 and 2 in Kobayashi et al. 2025."""

import math

import numpy as np
import pytest

from swarm_agent.behaviour import Heard
from swarm_agent.behaviours.lr_pt import LrPt
from swarm_agent.knowledge import AssumedIdleness
from tests.builders import entries, from_robot, from_tower, percept, robot, table, visited
from wire import codec

# Algorithm 1


def test_assumed_idleness_of_every_site_grows_by_one_each_step():
    """Source: Algorithm 1, lines 1-4."""
    knowledge = AssumedIdleness(3)
    knowledge.note_visit(1, 4)
    assert knowledge.idle_ticks(10).tolist() == [10, 6, 10]
    assert knowledge.idle_ticks(11).tolist() == [11, 7, 11]


def test_arrival_within_rho_of_the_own_target_resets_only_that_site():
    """Source: Algorithm 1, lines 5-6; rho = 3 m, inclusive."""
    one = robot()
    one.step(percept(0), [])
    target = one.target
    x_m, y_m = one.centres_m[target]
    one.step(percept(20, x_m - 3.0, y_m), [])
    assert np.flatnonzero(one.knowledge.visited_tick).tolist() == [target]
    assert one.knowledge.visited_tick[target] == 20


def test_beyond_rho_nothing_is_visited_and_the_target_is_kept():
    """Source: Algorithm 1, line 5."""
    one = robot()
    one.step(percept(0), [])
    before = one.goal, one.target
    x_m, y_m = one.centres_m[one.target]
    one.step(percept(20, x_m - 3.01, y_m), [])
    assert (one.goal, one.target) == before
    assert not one.knowledge.visited_tick.any()


def test_a_centre_that_is_no_target_of_ours_is_passed_without_a_visit():
    """Source: section III-A: a patrol is completed for the robot's own target only."""
    one = robot()
    one.step(percept(0), [])
    other = next(site for site in range(400) if site != one.target)
    one.step(percept(20, *one.centres_m[other]), [])
    assert not one.knowledge.visited_tick.any()


def test_a_completed_patrol_chooses_the_next_target_in_the_same_step():
    """Source: Algorithm 1, line 7."""
    one = robot()
    one.step(percept(0), [])
    done = one.target
    move = one.step(percept(20, *one.centres_m[done]), [])
    assert one.target != done
    assert (move.motion.x_m, move.motion.y_m) == tuple(one.centres_m[one.target])


def test_the_s_entries_with_the_newest_visits_are_sent():
    """Source: Algorithm 1, lines 8-11."""
    knowledge = AssumedIdleness(6)
    knowledge.merge(table(s0=5, s2=9, s3=1, s5=7))
    assert entries(knowledge.newest(2)) == {2: 9, 5: 7}


def test_equally_new_entries_are_sent_in_order_of_site():
    """Source: Algorithm 1, lines 8-11; the tie is our choice."""
    knowledge = AssumedIdleness(400)
    knowledge.merge(table(s0=2, **{f"s{site}": 5 for site in range(1, 300)}))
    assert entries(knowledge.newest(100)) == dict.fromkeys(range(1, 101), 5)


@pytest.mark.parametrize("items", ["newest", "unsent"])
@pytest.mark.parametrize(("known", "carried"), [(3, 3), (8, 8), (30, 8)])
def test_a_frame_carries_exactly_s_entries_or_all_that_are_known(items, known, carried):
    """Source: Table I, s items per step."""
    one = robot(items_per_tick=8, items=items)
    visited(one, **{f"s{site}": site + 1 for site in range(known)})
    (said,) = one.step(percept(50), []).say
    assert len(entries(said.news)) == carried


def test_with_s_equal_to_the_number_of_cells_the_whole_table_is_sent():
    """Source: Table I, s = K."""
    one = robot()
    visited(one, s7=3)
    (said,) = one.step(percept(50), []).say
    assert len(entries(said.news)) == 400
    assert entries(said.news)[7] == 3


def test_a_received_entry_is_taken_over_only_when_it_is_strictly_newer():
    """Source: Algorithm 1, lines 13-18."""
    one = robot()
    visited(one, s1=10, s2=10, s3=10)
    one.step(percept(50), [from_robot("r3", 49, news=table(s1=9, s2=10, s3=11, s4=1))])
    assert one.knowledge.visited_tick[:6].tolist() == [0, 10, 10, 11, 1, 0]


def test_what_is_heard_is_merged_after_sending():
    """Source: Algorithm 1: lines 8-11 come before 13-18, so news travels one hop a step."""
    one = robot()
    (said,) = one.step(percept(50), [from_robot("r3", 49, news=table(s4=40))]).say
    assert entries(said.news)[4] == 0
    (said,) = one.step(percept(51), []).say
    assert entries(said.news)[4] == 40


def test_what_is_heard_is_merged_after_the_choice_of_a_target():
    """Source: Algorithm 1: line 7 comes before 13-18."""
    news = table(**{f"s{site}": 999 for site in range(400)})
    deaf, hearing = robot(seed=3), robot(seed=3)
    for one, heard in ((deaf, []), (hearing, [from_robot("r3", 999, news=news)])):
        one.update_priority = lambda tick, heard: None
        one.step(percept(1000), heard)
    assert (deaf.goal, deaf.target) == (hearing.goal, hearing.target)
    assert hearing.knowledge.visited_tick.min() == 999


def test_a_relayed_entry_keeps_the_time_of_the_visit():
    """Source: Algorithm 1, line 16; times are relayed, so no hop makes an entry look newer."""
    first, second = robot("r2"), robot("r3")
    visited(first, s9=30)
    (said,) = first.step(percept(40), []).say
    second.step(percept(41), [Heard("r2", 40, said)])
    (relayed,) = second.step(percept(42), []).say
    assert entries(relayed.news)[9] == 30


# Algorithm 2


def test_out_of_contact_with_the_tower_the_priority_grows_by_the_time_that_passes():
    """Source: Algorithm 2, lines 1-3."""
    one = robot()
    for tick in range(5):
        one.update_priority(tick, [])
    assert one.priority_s == 5.0


def test_the_priority_never_grows_past_its_largest_value():
    """Source: Algorithm 2, lines 1-3."""
    one = robot(report_priority_max_s=3.0)
    for tick in range(9):
        one.update_priority(tick, [])
    assert one.priority_s == 3.0


def test_without_neighbours_the_priority_is_kept():
    """Source: Algorithm 2, line 4: the reset belongs to those who have neighbours."""
    one = robot()
    one.priority_s = 70.0
    one.update_priority(9, [])
    assert one.priority_s == 71.0


def test_hearing_the_tower_sets_the_contact_time_and_clears_the_priority():
    """Source: Algorithm 2, lines 6-8 and 12-14."""
    one = robot()
    one.priority_s = 70.0
    one.update_priority(9, [from_tower(8)])
    assert (one.contact_tick, one.priority_s) == (9, 0.0)


def test_the_tower_is_taken_first_whatever_its_number():
    """Source: Algorithm 2, lines 6-11; r_1 is the first of A_n in the paper, here another name may be."""
    one = robot("r2", tower="base99")
    heard = [from_robot("r3", 8, priority_s=10.0, contact_tick=5), from_tower(8, tower="base99")]
    one.update_priority(9, heard)
    assert one.priority_s == 10.0  # r3 has been away for longer than we, who hear the tower now


def test_the_duty_of_a_neighbour_with_an_older_contact_is_taken_over_discounted():
    """Source: Algorithm 2, lines 9-11: max + eta * min, eta = 0.4 for ten nodes."""
    one = robot()
    one.contact_tick, one.priority_s = 100, 20.0
    one.update_priority(200, [from_robot("r3", 199, priority_s=50.0, contact_tick=99)])
    assert one.priority_s == pytest.approx(50.0 + 0.4 * 21.0)


def test_several_takeovers_are_made_one_after_another():
    """Source: Algorithm 2, lines 6-11: p changes inside the loop, in order of number."""
    one = robot()
    one.contact_tick, one.priority_s = 100, 19.0
    heard = [from_robot("r3", 199, 50.0, 10), from_robot("r4", 199, 100.0, 10)]
    one.update_priority(200, heard)
    first = 50.0 + 0.4 * 20.0
    assert one.priority_s == pytest.approx(100.0 + 0.4 * first)


def test_a_takeover_is_clipped_to_the_largest_priority():
    """Source: Algorithm 2, lines 9-11; the clip is our repair of its unbounded growth."""
    one = robot()
    one.contact_tick, one.priority_s = 100, 600.0
    one.update_priority(200, [from_robot("r3", 199, 600.0, 99)])
    assert one.priority_s == 703.0


@pytest.mark.parametrize("contact_tick", [100, 101, 199])
def test_with_neighbours_but_no_takeover_the_priority_is_cleared(contact_tick):
    """Source: Algorithm 2, lines 12-14; as printed an equal contact is no older one."""
    one = robot()
    one.contact_tick, one.priority_s = 100, 20.0
    one.update_priority(200, [from_robot("r3", 199, 50.0, contact_tick)])
    assert one.priority_s == 0.0


def test_a_takeover_keeps_the_priority_that_another_neighbour_would_not_have_raised():
    """Source: Algorithm 2, lines 12-13: one takeover is enough."""
    one = robot()
    one.contact_tick, one.priority_s = 100, 19.0
    one.update_priority(200, [from_robot("r3", 199, 0.0, 10), from_robot("r4", 199, 90.0, 150)])
    assert one.priority_s == 20.0


def test_the_worked_example_of_two_robots_that_meet():
    """Source: our specification: 190.4 and 0 in the first common step, then 191.4 and 0."""
    a, b = robot("r2"), robot("r3")
    a.contact_tick, a.priority_s = 100, 100.0
    b.contact_tick, b.priority_s = 50, 150.0
    from_a = Heard("r2", 199, a._bulletin(199, []))
    from_b = Heard("r3", 199, b._bulletin(199, []))
    for tick, expected in ((200, 190.4), (201, 191.4), (202, 192.4)):
        said_a = a.step(percept(tick), [from_b]).say[0]
        said_b = b.step(percept(tick), [from_a]).say[0]
        assert (said_a.message.priority_s, said_b.message.priority_s) == (pytest.approx(expected), 0.0)
        from_a, from_b = Heard("r2", tick, said_a), Heard("r3", tick, said_b)


def test_two_robots_at_the_tower_do_not_multiply_their_priorities_without_bound():
    """Source: Algorithm 2, lines 6-11, as printed: each sees the other's contact one tick older."""
    pair = {name: robot(name) for name in ("r2", "r3")}
    for one in pair.values():
        one.priority_s, one.contact_tick = 10.0, 1
    heard = {"r2": [], "r3": []}
    highest = 0.0
    for tick in range(2, 60):
        said = {name: one.step(percept(tick), heard[name]).say[0] for name, one in pair.items()}
        highest = max(highest, *(one.priority_s for one in pair.values()))
        heard = {
            name: [from_tower(tick), Heard(other, tick, said[other])]
            for name, other in (("r2", "r3"), ("r3", "r2"))
        }
    assert highest == 703.0  # ten seconds would have become 10 * 1.4^58 by now
    assert all(np.isfinite(one.utilities(60, percept(60).senses.pose)).any() for one in pair.values())


def test_compensated_two_robots_at_the_tower_leave_the_duty_to_the_lower_number():
    """Source: our option contact_reading; contacts of one tick are equal though heard a tick late."""
    low, high = robot("r2", contact_reading="compensated"), robot("r3", contact_reading="compensated")
    low.priority_s, high.priority_s = 10.0, 10.0
    low.update_priority(200, [from_tower(199), from_robot("r3", 199, 30.0, 199)])
    high.update_priority(200, [from_tower(199), from_robot("r2", 199, 30.0, 199)])
    assert low.priority_s == pytest.approx(30.0 + 0.4 * 10.0)
    assert high.priority_s == 0.0


@pytest.mark.parametrize(("name", "other", "taken"), [("r2", "r10", True), ("r10", "r2", False)])
def test_compensated_equal_old_contacts_give_the_duty_to_the_lower_number(name, other, taken):
    """Source: our option contact_reading; numbers are compared as numbers, r2 before r10."""
    one = robot(name, contact_reading="compensated")
    one.contact_tick, one.priority_s = 100, 19.0
    one.update_priority(200, [from_robot(other, 199, 5.0, 100)])
    assert (one.priority_s > 0) is taken


def test_compensated_an_older_contact_is_older_and_a_newer_one_is_not():
    """Source: our option contact_reading; Algorithm 2, line 9."""
    for contact_tick, priority_s in ((99, 52.0), (101, 0.0)):
        one = robot(contact_reading="compensated")
        one.contact_tick, one.priority_s = 100, 4.0
        one.update_priority(200, [from_robot("r3", 199, 50.0, contact_tick)])
        assert one.priority_s == priority_s


@pytest.mark.parametrize("priority_s", [math.nan, -1.0])
def test_a_priority_that_is_no_number_of_seconds_is_not_understood(priority_s):
    """Source: none; a NaN from one neighbour would make every utility of everybody a NaN."""
    said = from_robot("r3", 199, priority_s).message
    with pytest.raises(codec.Malformed):
        codec.decode(LrPt.Radio, codec.encode(said))
