"""LR-PT, line by line. Line numbers are those of Algorithms 1 and 2 in Kobayashi et al. 2025."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_agent.behaviour import Heard
from swarm_agent.behaviours.lr_pt import PUBLISHED, LrPt, LrPtParameters
from swarm_agent.knowledge import AssumedIdleness
from tests.builders import entries, from_robot, from_tower, percept, robot, table
from wire import codec
from wire.fields import Grid
from wire.messages import Sighting

CENTRE_0 = (15.0, 15.0)


def visited(one, **sites: int) -> None:
    one.knowledge.merge(table(**sites))


def chosen(one, tick=1000, at=CENTRE_0, heard=(), completed=0, in_sight=()) -> tuple[int, int]:
    one.choose_target(percept(tick, *at, in_sight=in_sight), list(heard), completed)
    return one.goal, one.target


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
    knowledge = AssumedIdleness(6)
    knowledge.merge(table(s1=5, s3=5, s4=5, s0=2))
    assert entries(knowledge.newest(2)) == {1: 5, 3: 5}


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
    """Source: Algorithm 2, lines 6-11; r_1 is the first of A_n in the paper, here it may be called otherwise."""
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
    """Source: the numbers of our specification: 190.4 and 0 in the first common step, 191.4 and 0 in the next."""
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
    """Source: Algorithm 2, lines 6-11, as printed: each sees the other's contact as one tick older than its own."""
    pair = {name: robot(name) for name in ("r2", "r3")}
    for one in pair.values():
        one.priority_s, one.contact_tick = 10.0, 1
    heard = {"r2": [], "r3": []}
    highest = 0.0
    for tick in range(2, 60):
        said = {name: one.step(percept(tick), heard[name]).say[0] for name, one in pair.items()}
        highest = max(highest, *(one.priority_s for one in pair.values()))
        heard = {name: [from_tower(tick), Heard(other, tick, said[other])] for name, other in (("r2", "r3"), ("r3", "r2"))}
    assert highest == 703.0  # ten seconds would have become 10 * 1.4^58 by now
    assert all(np.isfinite(one.utilities(60, percept(60).senses.pose)).any() for one in pair.values())


def test_compensated_two_robots_at_the_tower_leave_the_duty_to_the_lower_number():
    """Source: our option contact_reading; contacts of the same tick are equal though one is heard a tick late."""
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


# Equations 10 and 11


def test_utility_is_alpha_times_idleness_and_travel_over_travel():
    """Source: equations 11a and 11b, by hand for one cell."""
    one = robot(team_size=10)  # p_M = 703, sigma = 304
    one.priority_s = 103.0
    visited(one, s21=940)  # cell 21 is column 1, row 1: its centre is (45, 45)
    pose = percept(1000, 45.0, 15.0).senses.pose
    travel_s = 30.0 / 1.5
    alpha = math.exp(-((45.0 - 600.0) ** 2) / (2 * 304.0**2))
    assert one.utilities(1000, pose)[21] == pytest.approx(alpha * (60 + travel_s) / travel_s)


def test_alpha_prefers_cells_at_the_chebyshev_distance_of_the_remaining_priority():
    """Source: equation 11b and its figure: p_M = 600 s, sigma = 200 m."""
    one = robot(report_priority_max_s=600.0, spread_m=200.0, search_radius_m=2000.0)
    pose = percept(0, -1e9, 0.0).senses.pose  # so far away that travel outweighs idleness: utility is alpha
    one.parameters = LrPtParameters(report_priority_max_s=600.0, spread_m=200.0, search_radius_m=1e12)
    at = dict(zip(map(tuple, one.centres_m.tolist()), one.utilities(0, pose), strict=True))
    assert at[585.0, 15.0] == pytest.approx(math.exp(-(15.0**2) / 80000), abs=1e-6)
    assert at[15.0, 15.0] == pytest.approx(math.exp(-(585.0**2) / 80000), abs=1e-6)
    assert at[405.0, 15.0] == at[15.0, 405.0] == at[405.0, 405.0]
    one.priority_s = 600.0  # the full duty to report: near the tower
    near = dict(zip(map(tuple, one.centres_m.tolist()), one.utilities(0, pose), strict=True))
    assert max(near.values()) == near[15.0, 15.0] == pytest.approx(math.exp(-(15.0**2) / 80000), abs=1e-6)


def test_the_goal_is_the_cell_of_largest_utility():
    """Source: equation 10."""
    one = robot(search_radius_m=2000.0, report_priority_max_s=600.0, spread_m=1e6)
    visited(one, **{f"s{site}": 999 for site in range(400) if site != 250})
    assert chosen(one)[0] == 250


def test_cells_beyond_the_search_radius_are_no_goals_and_the_radius_itself_is_inside():
    """Source: equation 10, delta = 180 m."""
    one = robot(spread_m=1e6)
    utility = one.utilities(1000, percept(1000, *CENTRE_0).senses.pose)
    away = np.hypot(*(one.centres_m - CENTRE_0).T)
    assert (np.isfinite(utility) == (away <= 180.0)).all()
    assert np.isfinite(utility[6])  # six cells of 30 m


def test_the_cell_just_completed_is_no_candidate():
    """Source: our specification of equation 10."""
    one = robot(spread_m=1e6)
    visited(one, **{f"s{site}": 1000 for site in range(400)})
    assert chosen(one, completed=0)[0] != 0


def test_equal_utilities_are_decided_by_the_generator_of_the_node():
    """Source: equation 10; the tie is our choice: at random among the best."""
    goals = {chosen(robot(seed=seed), tick=0, completed=None)[0] for seed in range(30)}
    assert len(goals) > 1
    assert chosen(robot(seed=7), tick=0) == chosen(robot(seed=7), tick=0)


def test_with_no_cell_in_reach_the_nearest_other_cell_is_the_goal():
    """Source: none; a search radius smaller than a cell must not stop a robot."""
    assert chosen(robot(search_radius_m=5.0), completed=0)[0] in (1, 20)


def test_the_target_is_the_next_cell_in_the_direction_of_the_goal():
    """Source: section IV-C, temporary target; rounding to 45 degrees is our choice."""
    one = robot()
    centre = 10 * 20 + 10
    assert one.on_the_way(centre, 19 * 20 + 10) == 11 * 20 + 10
    assert one.on_the_way(centre, 10 * 20) == 10 * 20 + 9
    assert one.on_the_way(centre, 15 * 20 + 15) == 11 * 20 + 11
    assert one.on_the_way(centre, 15 * 20 + 12) == 11 * 20 + 10  # 21.8 degrees
    assert one.on_the_way(centre, 14 * 20 + 12) == 11 * 20 + 11  # 26.6 degrees
    assert one.on_the_way(centre, 11 * 20 + 9) == 11 * 20 + 9


@given(st.data())
def test_a_step_on_the_way_stays_in_the_grid_and_comes_strictly_nearer(data):
    """Source: section IV-C."""
    field = Grid(data.draw(st.integers(1, 30)), data.draw(st.integers(1, 30)))
    cells = st.tuples(st.integers(0, field.columns - 1), st.integers(0, field.rows - 1))
    (here_x, here_y), (goal_x, goal_y) = data.draw(cells), data.draw(cells)
    step = robot(field=field).on_the_way(here_x * field.rows + here_y, goal_x * field.rows + goal_y)
    x, y = divmod(step, field.rows)
    assert 0 <= x < field.columns
    assert max(abs(x - here_x), abs(y - here_y)) <= 1
    before = max(abs(goal_x - here_x), abs(goal_y - here_y))
    assert max(abs(goal_x - x), abs(goal_y - y)) == max(0, before - 1)


def test_the_first_target_starts_from_the_cell_in_which_the_robot_stands():
    """Source: our choice; at the start no cell has been completed."""
    one = robot()
    one.step(percept(0, 100.0, 100.0), [])  # cell (3, 3)
    column, row = divmod(one.target, 20)
    assert max(abs(column - 3), abs(row - 3)) <= 1


# Lock breakers


def lonely(name: str = "r2", breaker: str = "none", **parameters):
    """A robot at cell (10, 10) to which (12, 10) looks best, then (10, 12), then nothing much."""
    one = robot(name, lock_breaker=breaker, spread_m=1e6, **parameters)
    visited(one, **{f"s{site}": 1000 for site in range(400)})
    one.knowledge.visited_tick[12 * 20 + 10] = 0
    one.knowledge.visited_tick[10 * 20 + 12] = 100
    return one


HERE = 10 * 20 + 10
AT = (315.0, 315.0)
EAST, NORTH = (12 * 20 + 10, 11 * 20 + 10), (10 * 20 + 12, 10 * 20 + 11)


def test_without_a_lock_breaker_announced_goals_are_ignored():
    """Source: equation 10 as printed."""
    heard = [from_robot("r3", 999, goal=EAST[0], target=EAST[1])]
    assert chosen(lonely(), at=AT, heard=heard, completed=HERE) == EAST


def test_excl_skips_the_goals_that_neighbours_announced():
    """Source: our option lock_breaker."""
    heard = [from_robot("r3", 999, goal=EAST[0], target=EAST[1])]
    assert chosen(lonely(breaker="excl"), at=AT, completed=HERE) == EAST
    assert chosen(lonely(breaker="excl"), at=AT, heard=heard, completed=HERE) == NORTH


def test_excl_falls_back_to_the_best_goal_when_all_are_announced():
    """Source: our option lock_breaker."""
    heard = [from_robot("r3", 999, goal=site) for site in range(400)]
    assert chosen(lonely(breaker="excl"), at=AT, heard=heard, completed=HERE) == EAST


def test_excl_ignores_goals_that_are_no_cells():
    """Source: none; a neighbour may say anything."""
    heard = [from_robot("r3", 999, goal=goal) for goal in (-1, 400, 10**9)]
    assert chosen(lonely(breaker="excl"), at=AT, heard=heard, completed=HERE) == EAST


def test_exclnext_takes_the_best_goal_whose_next_cell_is_no_neighbours_target():
    """Source: our option lock_breaker."""
    same_goal = [from_robot("r3", 999, goal=EAST[0], target=0)]
    same_step = [from_robot("r3", 999, goal=0, target=EAST[1])]
    assert chosen(lonely(breaker="exclnext"), at=AT, heard=same_goal, completed=HERE) == EAST
    assert chosen(lonely(breaker="exclnext"), at=AT, heard=same_step, completed=HERE) == NORTH


def test_exclnext_falls_back_to_the_best_goal_when_all_steps_are_taken():
    """Source: our option lock_breaker."""
    around = [HERE + dx * 20 + dy for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
    heard = [from_robot("r3", 999, target=site) for site in around]
    assert chosen(lonely(breaker="exclnext"), at=AT, heard=heard, completed=HERE) == EAST


@pytest.mark.parametrize(
    ("seen", "expected"),
    [
        ((), EAST),
        ((Sighting("r3", 315.0, 345.0),), NORTH),
        ((Sighting("r3", 315.0, 345.1),), EAST),
        ((Sighting("r9", 315.0, 315.0),), EAST),
        ((Sighting("r1", 315.0, 315.0),), EAST),
    ],
    ids=["alone", "lower at 30 m", "lower beyond", "higher", "tower"],
)
def test_rank_gives_way_to_lower_numbered_robots_within_30_m(seen, expected):
    """Source: our option lock_breaker: with q of them, the (q + 1)-th best distinct step."""
    one = lonely("r4", "rank")
    assert chosen(one, at=AT, completed=HERE, in_sight=seen) == expected


def test_announcements_are_made_of_the_choice_of_this_tick():
    """Source: our option lock_breaker; Algorithm 2, line 18: (p, omega) goes with it."""
    one = robot()
    (said,) = one.step(percept(3), [from_tower(2)]).say
    assert said.message.goal == one.goal
    assert said.message.target == one.target
    assert (said.message.priority_s, said.message.contact_tick) == (0.0, 3)


# Scarce items


def exchange(speaker, listener, ticks, gets_through=lambda tick: True, start=100):
    """Two robots far from everything talk, one tick of delay each way."""
    to_listener, to_speaker = [], []
    for tick in range(start, start + ticks):
        said = speaker.step(percept(tick, 300.0, 300.0), to_speaker).say[0]
        reply = listener.step(percept(tick, 300.0, 310.0), to_listener).say[0]
        to_listener = [Heard("r2", tick, said)] if gets_through(tick) else []
        to_speaker = [Heard("r3", tick, reply)] if gets_through(-tick) else []


def knowing(name: str, items: str, count: int = 40):
    one = robot(name, items=items, items_per_tick=8, seed=5)
    visited(one, **{f"s{site}": site + 1 for site in range(count)})
    return one


def test_the_newest_entries_alone_never_carry_what_dropped_out_of_the_newest_eight():
    """Source: Algorithm 1, lines 8-11 with s = 8, as printed."""
    speaker, listener = knowing("r2", "newest"), robot("r3", items="newest", items_per_tick=8)
    exchange(speaker, listener, 60)
    assert np.flatnonzero(listener.knowledge.visited_tick[:40]).tolist() == list(range(32, 40))


def test_unsent_entries_carry_everything_in_as_few_steps_as_the_answer_allows():
    """Source: our option items."""
    speaker, listener = knowing("r2", "unsent"), robot("r3", items_per_tick=8)
    exchange(speaker, listener, 20)
    assert listener.knowledge.visited_tick[:40].tolist() == list(range(1, 41))


@given(st.integers(0, 2**32 - 1))
def test_unsent_entries_carry_everything_through_heavy_loss(seed):
    """Source: our option items; what was lost is not acknowledged, so it is said again."""
    lucky = np.random.Generator(np.random.Philox(seed))
    luck = {tick: lucky.random() > 0.5 for tick in range(-400, 400)}
    speaker, listener = knowing("r2", "unsent"), robot("r3", items_per_tick=8)
    exchange(speaker, listener, 150, luck.get)
    assert listener.knowledge.visited_tick[:40].tolist() == list(range(1, 41))


def test_unsent_entries_are_said_again_to_a_neighbour_that_lost_its_memory():
    """Source: our option items; a younger mind behind a known name knows nothing."""
    speaker = knowing("r2", "unsent")
    exchange(speaker, robot("r3", items_per_tick=8), 30)
    reborn = robot("r3", items_per_tick=8)
    exchange(speaker, reborn, 30, start=200)
    assert reborn.knowledge.visited_tick[:40].tolist() == list(range(1, 41))


def test_unsent_says_nothing_old_once_every_neighbour_has_everything():
    """Source: our option items: scarce items are not spent on what is known."""
    speaker, listener = knowing("r2", "unsent"), robot("r3", items_per_tick=8)
    exchange(speaker, listener, 30)
    reply = Heard("r3", 129, listener._bulletin(129, []))
    speaker.memory.listen([reply])
    assert not speaker.memory.unknown_to(["r3"], speaker.knowledge.visited_tick).any()


def test_unsent_is_newest_when_there_is_room_for_all():
    """Source: our option items: equal for s >= K."""
    one, other = robot(items="newest"), robot(items="unsent")
    for each in (one, other):
        visited(each, s3=7)
    assert one.step(percept(9), []).say[0].news == other.step(percept(9), []).say[0].news


# Parameters


@pytest.mark.parametrize("team_size", [5, 10, 15])
def test_the_published_parameters_belong_to_the_size_of_the_team(team_size):
    """Source: Table I."""
    settled = LrPtParameters().settled(team_size)
    found = settled.takeover_discount, settled.report_priority_max_s, settled.spread_m
    assert found == PUBLISHED[team_size]
    table_1 = {5: (0.55, 1088, 356), 10: (0.40, 703, 304), 15: (0.50, 425, 525)}
    assert found == table_1[team_size]


def test_for_another_team_the_error_names_what_must_be_given():
    """Source: Table I has no other sizes, and says nothing of how to scale."""
    with pytest.raises(ValueError, match="takeover_discount, spread_m must be given.*5, 10, 15.*has 7"):
        LrPtParameters(report_priority_max_s=500.0).settled(7)


def test_what_is_given_replaces_the_published_value():
    """Source: none."""
    settled = LrPtParameters(spread_m=100.0).settled(10)
    assert (settled.takeover_discount, settled.spread_m) == (0.4, 100.0)
    assert LrPtParameters(takeover_discount=0.0, report_priority_max_s=1.0, spread_m=1.0).settled(7)


@pytest.mark.parametrize(("offset", "first", "last"), [(None, 15.0, 585.0), (0.0, 0.0, 570.0), (7.5, 7.5, 577.5)])
def test_the_centre_offset_moves_all_centres(offset, first, last):
    """Source: the paper leaves the first centre open; k = 20 * column + row."""
    centres = robot(field=Grid(centre_offset_m=offset)).centres_m
    assert centres[0].tolist() == [first, first]
    assert centres[-1].tolist() == [last, last]
    assert centres[1].tolist() == [first, first + 30.0]
    assert centres[20].tolist() == [first + 30.0, first]
