"""ER: its decisions by hand, its reservations, short rehearsals. Source: Yan and Zhang 2016, their code."""

import math
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace as changed

from deploy.metrics.area import AreaMetrics
from swarm_agent.behaviour import Heard
from swarm_agent.behaviours.expected_reactive import (
    Aim,
    Decision,
    ExpectedReactive,
    ExpectedReactiveParameters,
    Intention,
)
from swarm_agent.knowledge import Bulletin, News
from tests.builders import NO_NEWS, configuration, course, entries, from_tower, percept, scenario, table
from wire import codec
from wire.fields import Grid
from wire.scenario import PlannedFault, Robots

BESIDE_21 = (0, 1, 2, 20, 22, 40, 41, 42)


def patroller(seed: int = 1, max_speed_m_s: float = 1.5, field: Grid | None = None, **parameters: Any):
    """A newborn ER robot r2 that knows of nothing but its start at tick 0."""
    told = configuration(
        "r2", "expected_reactive", field=field or Grid(), max_speed_m_s=max_speed_m_s, tick_s=1.0
    )
    given = ExpectedReactiveParameters(**parameters)
    return ExpectedReactive(given, told, np.random.Generator(np.random.Philox(seed)))


def knowing(one: ExpectedReactive, **visits: int) -> ExpectedReactive:
    """The robot after it learned of visits: s3=17 says that site 3 was visited at tick 17."""
    one.knowledge.merge(table(**visits))
    return one


def decided(
    sender: str, sent_tick: int, visited: int, target: int, arrival_s: float, news: News = NO_NEWS
) -> Heard:
    """A robot's decision as it is heard."""
    return Heard(sender, sent_tick, Bulletin(news, (), 0, Decision(visited, target, arrival_s)))


def arrived(one: ExpectedReactive, tick: int) -> Decision:
    """What the robot says on reaching its target at `tick`."""
    return one.step(percept(tick, *one.centres_m[one.target]), []).say[0].message


# The decision


def test_utility_is_the_expected_idleness_on_arrival_over_the_time_of_travel():
    """Source: U = |(now + dt) - est| / dt. Straight: dt = 20 s. Diagonal: dt = 20 sqrt(2) s."""
    one = knowing(patroller(), s20=900, s0=900)
    utility = one.utilities(1000, 21)
    assert utility[20] == pytest.approx((1000 + 20 - 900) / 20) == 6.0
    assert utility[0] == pytest.approx((100 + 20 * math.sqrt(2)) / (20 * math.sqrt(2)))
    assert utility[22] == pytest.approx(1020 / 20)


def test_the_candidates_are_the_adjacent_cells():
    """Source: our choice for the field of LR-PT; fewer at an edge, fewest in a corner."""
    one = patroller()
    assert tuple(one.utilities(1000, 21)) == BESIDE_21
    assert tuple(one.utilities(1000, 0)) == (1, 20, 21)
    assert tuple(one.utilities(1000, 10)) == (9, 11, 29, 30, 31)


def test_of_equally_idle_cells_the_near_ones_are_best_and_chance_decides_between_them():
    """Source: ties uniformly at random."""
    one = patroller()
    chosen = [one.choose(1000, 21) for _ in range(400)]
    assert set(chosen) == {1, 20, 22, 41}
    assert all(60 < chosen.count(site) < 140 for site in set(chosen))


def test_a_cell_that_another_will_reach_first_is_expected_to_be_fresh():
    """Source: est = ETA while it lies ahead: |1020 - 1010| / 20 = 0.5 where it would be 51."""
    one = patroller()
    assert one.utilities(1000, 21)[22] == 51.0
    one.listen([decided("r3", 990, -1, 22, 1010.0)])
    assert one.utilities(1000, 21)[22] == 0.5


def test_a_cell_that_another_will_reach_after_us_has_a_small_positive_utility():
    """Source: the absolute value: |1020 - 1025| / 20."""
    one = patroller()
    one.listen([decided("r3", 990, -1, 22, 1025.0)])
    assert one.utilities(1000, 21)[22] == 0.25


def test_an_expired_intention_is_ignored_and_expires_at_its_very_time():
    """Source: only ETA > now counts."""
    one = patroller()
    one.listen([decided("r3", 980, -1, 22, 1000.0)])
    assert one.expected_s(999)[22] == 1000.0
    assert one.expected_s(1000)[22] == 0.0


def test_of_several_intentions_for_one_cell_the_earliest_counts():
    """Source: the earliest ETA that lies ahead, in whatever order they were heard."""
    for first, second in ((1010.0, 1015.0), (1015.0, 1010.0)):
        one = patroller()
        one.listen([decided("r3", 990, -1, 22, first), decided("r4", 990, -1, 22, second)])
        assert one.expected_s(1000)[22] == 1010.0
        assert one.expected_s(1012)[22] == 1015.0


def test_a_robot_has_one_intention_and_a_later_one_replaces_it():
    """Source: intention[robot] is overwritten."""
    one = patroller()
    one.listen([decided("r3", 990, -1, 22, 1010.0), decided("r3", 991, -1, 41, 1011.0)])
    assert one.intentions == {"r3": Intention(41, 1011.0)}
    assert one.expected_s(1000)[22] == 0.0


def test_a_cell_visited_right_now_stays_so_although_somebody_intends_it():
    """Source: est < now is strict: a visit at now is not replaced by an ETA ahead."""
    one = knowing(patroller(), s22=1000)
    one.listen([decided("r3", 990, -1, 22, 1010.0)])
    assert one.expected_s(1000)[22] == 1000.0
    assert one.expected_s(1001)[22] == 1010.0


def test_the_only_neighbour_is_taken_whatever_is_known_of_it():
    """Source: degree 1."""
    one = patroller(field=Grid(2, 1))
    one.listen([decided("r3", 990, 1, 1, 1020.0)])
    assert one.choose(1000, 0) == 1
    assert patroller(field=Grid(1, 1)).choose(1000, 0) == 0


@pytest.mark.parametrize(("distance_min_m", "travel_s"), [(0.0, 28.5), (5.7, 28.5), (76.0, 380.0)])
def test_the_numbers_of_the_authors_map_grid(distance_min_m, travel_s):
    """Source: edges of 5.7 m at 0.2 m/s; the released code compares them with 76 pixels."""
    field = Grid(5, 5, cell_m=5.7)
    one = patroller(max_speed_m_s=0.2, field=field, distance_min_m=distance_min_m)
    knowing(one, s7=400)
    assert one.utilities(1000, 12)[7] == pytest.approx((600 + travel_s) / travel_s)


def test_with_the_released_distance_the_way_counts_for_nothing():
    """Source: released code: argmax U is the cell whose last visit is oldest, near or diagonal."""
    visits = dict.fromkeys((f"s{site}" for site in BESIDE_21 if site), 900)
    metric, released = patroller(), patroller(distance_min_m=400.0)
    for one in (metric, released):
        knowing(one, **visits | {"s0": 890})
    assert metric.choose(1000, 21) in (1, 20, 22, 41)
    assert released.choose(1000, 21) == 0


# What is said and heard


def test_the_first_decision_is_the_nearest_cell_and_is_announced_without_a_visit():
    """Source: on start; ETA = now + straight way / speed."""
    one = patroller()
    move = one.step(percept(7, 14.0, 33.0), [])
    assert move.say[0].message == Decision(-1, 1, 7 + math.dist((14.0, 33.0), (15.0, 45.0)) / 1.5)
    assert (move.motion.x_m, move.motion.y_m) == (15.0, 45.0)
    assert not any(entries(move.say[0].news).values())


def test_arrival_is_said_once_with_the_visit_and_the_next_reservation():
    """Source: idleness and intention are published at each visit; the place is that of the cell."""
    one = patroller()
    one.step(percept(0, 45.0, 45.0), [])
    x_m, y_m = one.centres_m[21]
    assert one.step(percept(5, x_m - 3.01, y_m), []).say == ()
    said = one.step(percept(6, x_m - 3.0, y_m), []).say[0]
    assert said.message == Decision(21, one.target, 26.0) and one.target in (1, 20, 22, 41)
    assert entries(said.news)[21] == 6
    assert one.step(percept(7, x_m - 2.0, y_m), []).say == ()


def test_the_released_distance_changes_the_choice_and_not_what_is_reserved():
    """Source: ETA = now + straight / v, without the least distance."""
    one = patroller(field=Grid(1, 9), distance_min_m=400.0)
    one.step(percept(0, 15.0, 15.0), [])
    assert arrived(one, 10) == Decision(0, 1, 30.0)


def test_a_robot_that_starts_late_takes_every_cell_for_visited_at_its_start_and_says_nothing_of_it():
    """Source: on start last_visit = now; the tower is told of true visits alone."""
    one = patroller()
    said = one.step(percept(500, 45.0, 45.0), []).say[0]
    assert one.expected_s(600).tolist() == [500.0] * 400
    assert set(entries(said.news).values()) == {0}


def test_only_visits_that_a_neighbour_itself_just_made_are_used():
    """Source: no relay: of a frame the decision counts, not the table; the tower's table counts neither."""
    heard = [decided("r3", 99, 5, 6, 119.0, table(s7=50)), from_tower(99, table(s8=60))]
    one, relaying = patroller(), patroller(relay=True)
    for robot in (one, relaying):
        robot.step(percept(0), [])
        robot.step(percept(100), heard)
    assert np.flatnonzero(one.knowledge.visited_tick).tolist() == [5]
    assert np.flatnonzero(relaying.knowledge.visited_tick).tolist() == [5, 7, 8]
    assert one.knowledge.visited_tick[5] == relaying.knowledge.visited_tick[5] == 99
    assert one.intentions == relaying.intentions == {"r3": Intention(6, 119.0)}


def test_an_older_visit_does_not_replace_a_newer_one():
    """Source: last_visit = max(last_visit, visit_time)."""
    one = knowing(patroller(), s5=120)
    one.listen([decided("r3", 99, 5, 6, 119.0)])
    assert one.knowledge.visited_tick[5] == 120


@pytest.mark.parametrize("arrival_s", [math.nan, math.inf, -1.0, 1e300])
def test_a_time_of_arrival_that_is_none_is_not_understood(arrival_s):
    """Source: none; one NaN would make an expected idleness a NaN."""
    with pytest.raises(codec.Malformed):
        codec.decode(ExpectedReactive.Radio, codec.encode(decided("r3", 9, 0, 1, arrival_s).message))


def test_cells_that_do_not_exist_are_not_heard_of():
    """Source: none; a frame from a field of another size."""
    one = patroller()
    one.listen([decided("r3", 9, 400, 1, 30.0), decided("r4", 9, 1, 400, 30.0)])
    assert not one.intentions and not one.knowledge.visited_tick.any()


# Whole runs


def test_every_cell_of_a_small_field_is_visited_and_the_tower_learns_of_it(tmp_path):
    given = scenario(Robots("expected_reactive", 3), field=Grid(6, 6), duration_s=900.0)
    run, metrics = course(given, tmp_path), AreaMetrics(given)
    for one in run.facts:
        metrics.feed(one)
    assert {site for _, _, site in run.visits()} == set(range(36))
    assert {node for _, node, _ in run.visits()} == {"r2", "r3", "r4"}
    assert metrics.known_tick.min() > 0 and (metrics.known_tick <= metrics.visited_tick).all()


def test_a_reservation_keeps_a_neighbour_off_until_its_time_and_then_attracts_it():
    """Source: an intention of a robot that never arrives ends at its ETA."""
    one = knowing(patroller(), **{f"s{site}": 900 for site in BESIDE_21 if site != 22})
    assert one.choose(1000, 21) == 22
    one.listen([decided("r3", 990, -1, 22, 1010.0)])
    assert one.choose(1000, 21) != 22 and one.choose(1009, 21) != 22
    assert one.choose(1010, 21) == 22


def aims(run, node: str) -> dict[int, Aim]:
    """What a robot reported, by tick."""
    told = ((one.tick, name, report) for one in run.facts for name, report in one.reports)
    return {tick: codec.decode(Aim, report) for tick, name, report in told if name == node}


def test_a_cell_reserved_by_a_robot_that_is_killed_is_patrolled_by_the_other(tmp_path):
    """Killed two seconds after it said where it goes, with the word heard; the dead body lies on its way."""
    places = ((15.0, 15.0, 0.0), (75.0, 75.0, 0.0))
    unharmed = scenario(2, "expected_reactive", poses=places, field=Grid(3, 3), duration_s=600.0)
    before = course(unharmed, tmp_path / "unharmed")
    decided_tick = next(tick for tick, node, _ in before.visits() if node == "r3" and tick > 100)
    reserved = aims(before, "r3")[decided_tick]
    kill = PlannedFault(decided_tick + 2.0, "kill", ("r3",))
    run = course(changed(unharmed, faults=(kill,)), tmp_path / "killed")
    assert aims(run, "r3")[decided_tick] == reserved and max(aims(run, "r3")) == decided_tick + 1
    after = [(tick, node, site) for tick, node, site in run.visits() if tick > decided_tick]
    assert {node for _, node, _ in after} == {"r2"}
    visits = [tick for tick, _, site in after if site == reserved.target]
    assert reserved.arrival_s < visits[0] < reserved.arrival_s + 9 * 30
    assert {site for _, _, site in after} == set(range(9))
