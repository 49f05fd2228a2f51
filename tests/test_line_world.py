"""Mission "line" in the world: traffic on the line, what nodes are told, and that nothing depends on luck."""

import itertools
import math

import numpy as np
import pytest

from tests.builders import AWAKE, TALK, course, on_line, scenario
from wire.fields import Polyline
from wire.line import Line
from wire.messages import WAKE_ON_ARRIVAL, WAKE_ON_BLOCKED, WAKE_ON_SENSOR, Follow
from wire.scenario import BatterySection, PlannedFault
from world_server.journal import commits
from world_server.world import World

BODY = {"body_m": 0.4}
SLOW = {"body_m": 0.4, "max_speed_m_s": 0.1}
TO_THE_RIGHT, TO_THE_LEFT = {"follow": {"0": [(20.0, 0.0)]}}, {"follow": {"0": [(0.0, 0.0)]}}
BENT = Polyline(((0.0, 0.0), (6.0, 0.0), (6.0, 6.0), (12.0, 6.0)), 3, lane_m=0.3)
LINE = Line(BENT, (20.0, 0.0))


def apart(run, one: int, other: int) -> list[float]:
    places = zip(run.positions(one), run.positions(other), strict=True)
    return [float(np.hypot(x - u, y - v)) for (x, y), (u, v) in places]


# Bodies on one line


@pytest.mark.parametrize(("speed", "noise"), [(0.1, 0.0), (0.35, 0.0), (1.0, 0.0), (3.0, 0.0), (0.1, 0.125)])
def test_head_on_they_stop_short_of_each_other(tmp_path, speed, noise):
    body = {"body_m": 0.4, "max_speed_m_s": speed, "noise_sd": noise}
    run = course(
        on_line({"r2": TO_THE_RIGHT, "r3": TO_THE_LEFT}, [(8.0, 0.0), (11.0, 0.0)], robots=body), tmp_path
    )
    nearest = min(apart(run, 1, 2))
    assert 0.4 - 1e-9 <= nearest < 0.4 + 2 * speed * (1 + 5 * noise)
    assert not any(one.incidents for one in run.facts)


def test_without_a_body_distance_they_pass_freely(tmp_path):
    run = course(on_line({"r2": TO_THE_RIGHT, "r3": TO_THE_LEFT}, [(8.0, 0.0), (11.0, 0.0)]), tmp_path)
    assert run.positions(1)[-1] == (20.0, 0.0) and run.positions(2)[-1] == (0.0, 0.0)


@pytest.mark.parametrize("verb", ["kill", "freeze"])
def test_who_is_dead_or_frozen_is_in_the_way_as_well(tmp_path, verb):
    faults = (PlannedFault(0.0, verb, ("r3",)),)
    given = on_line({"r2": TO_THE_RIGHT}, [(8.0, 0.0), (10.0, 0.0)], robots=SLOW, faults=faults)
    run = course(given, tmp_path)
    assert run.positions(1)[-1][0] == pytest.approx(9.6, abs=0.1)
    assert min(apart(run, 1, 2)) >= 0.4 - 1e-9


def test_the_passing_lane_leads_past(tmp_path):
    scripts = {"r2": {"follow": {"0": [(8.5, 0.3), (12.0, 0.3), (12.5, 0.0)]}}}
    run = course(on_line(scripts, [(8.0, 0.0), (10.0, 0.0)], robots=SLOW, duration_s=100.0), tmp_path)
    assert run.positions(1)[-1] == (12.5, 0.0)
    assert min(apart(run, 1, 2)) == pytest.approx(0.3, abs=0.01)
    assert not any(one.incidents for one in run.facts)


def test_nobody_enters_the_line_beside_another(tmp_path):
    scripts = {"r2": {"follow": {"0": [(10.3, 0.0)]}}}
    run = course(on_line(scripts, [(10.2, 0.6), (10.0, 0.0)], robots=SLOW), tmp_path)
    assert run.positions(1)[-1][1] > 0.15
    assert not any(one.incidents for one in run.facts)


def test_it_goes_on_by_itself_when_the_way_is_clear(tmp_path):
    scripts = {"r2": TO_THE_RIGHT, "r3": {"wake_ticks": [30], "follow": {"30": [(30.0, 0.0)]}}}
    run = course(on_line(scripts, [(8.0, 0.0), (10.0, 0.0)], robots=BODY, duration_s=60.0), tmp_path)
    assert run.positions(1)[29] == (9.0, 0.0)
    assert run.positions(1)[-1] == (20.0, 0.0)


def test_a_blockage_wakes_once_and_is_named(tmp_path):
    scripts = {"r2": TO_THE_RIGHT | {"wake_on": WAKE_ON_BLOCKED, "wake_ticks": [25]}, "r3": {}}
    run = course(on_line(scripts, [(8.0, 0.0), (10.0, 0.0)], robots=BODY), tmp_path)
    assert run.grants("r2") == {0: "start", 2: "blocked", 25: "wake"}
    assert [log.blocked_by for log in run.logs("r2").values()] == [None, "r3", "r3"]
    assert run.logs("r2")[2].in_sight == ("r3",)


def test_a_second_blockage_further_on_wakes_again(tmp_path):
    going = {"wake_ticks": [10, 20], "follow": {"10": [(14.0, 0.0)]}}
    scripts = {"r2": TO_THE_RIGHT | {"wake_on": WAKE_ON_BLOCKED}, "r3": going}
    run = course(on_line(scripts, [(8.0, 0.0), (10.0, 0.0)], robots=BODY), tmp_path)
    assert run.grants("r2") == {0: "start", 2: "blocked", 16: "blocked"}


def test_a_new_order_into_the_same_blockage_wakes_again(tmp_path):
    again = {"follow": {"0": [(20.0, 0.0)], "9": [(20.0, 0.0)]}, "wake_ticks": [9]}
    run = course(
        on_line({"r2": again | {"wake_on": WAKE_ON_BLOCKED}}, [(8.0, 0.0), (10.0, 0.0)], robots=BODY),
        tmp_path,
    )
    assert run.grants("r2") == {0: "start", 2: "blocked", 9: "wake", 10: "blocked"}


def test_who_follows_a_slow_one_is_not_woken_at_every_step(tmp_path):
    body = {"body_m": 0.4, "max_speed_m_s": 0.1, "noise_sd": 0.125}
    scripts = {"r2": TO_THE_RIGHT | {"wake_on": WAKE_ON_BLOCKED}, "r3": TO_THE_RIGHT}
    run = course(on_line(scripts, [(8.0, 0.0), (8.45, 0.0)], robots=body, duration_s=100.0), tmp_path)
    assert run.positions(1)[-1][0] > 14
    assert 1 <= len(run.grants("r2")) <= 2 + (100 * 0.1) / 0.4
    assert min(apart(run, 1, 2)) >= 0.4 - 1e-9


def test_too_close_is_an_incident_once(tmp_path):
    places = [(8.0, 0.0), (8.3, 0.0), (8.0, 0.3), (8.0, 0.6)]
    scripts = {"r2": {"wake_ticks": [5], "follow": {"5": [(7.0, 0.0)]}}}
    run = course(on_line(scripts, places, robots=SLOW), tmp_path)
    assert [(one.tick, one.incidents) for one in run.facts if one.incidents] == [(0, (("r2", "r3"),))]


def test_two_of_the_dead_are_no_incident(tmp_path):
    faults = (PlannedFault(0.0, "kill", ("r2", "r3")),)
    run = course(on_line({}, [(8.0, 0.0), (8.3, 0.0)], robots=BODY, faults=faults), tmp_path)
    assert not any(one.incidents for one in run.facts)


def test_a_swarm_in_disorder_keeps_its_distance(tmp_path):
    """Eight robots drive up and down one bent line, with noise, for ten minutes."""
    along = [(1.0, 0.0), (3.0, 0.0), (5.0, 0.0), (6.0, 1.0), (6.0, 3.0), (6.0, 5.0), (7.0, 6.0), (9.0, 6.0)]
    whole = [(0.0, 0.0), (6.0, 0.0), (6.0, 6.0), (12.0, 6.0)]
    scripts = {
        f"r{number}": {
            "follow": {"0": (whole if number % 2 else whole[::-1]) * 3},
            "backwards": number % 3 == 0,
        }
        for number in range(2, 10)
    }
    body = {"body_m": 0.5, "max_speed_m_s": 0.2, "noise_sd": 0.125}
    run = course(on_line(scripts, along, field=BENT, robots=body, duration_s=600.0, tick_s=0.5), tmp_path)
    courses = [run.positions(row) for row in range(9)]
    on_it = [
        [place for row in range(1, 9) if abs(LINE.locate(place := courses[row][tick])[1]) <= 0.15]
        for tick in range(0, 1201, 7)
    ]
    assert sum(map(len, on_it)) > 500
    for places in on_it:
        for one, other in itertools.combinations(places, 2):
            assert math.dist(one, other) >= 0.5 - 1e-9
    assert not any(one.incidents for one in run.facts)


# What nodes are told


def test_a_robot_is_told_of_tower_queue_and_bodies(tmp_path):
    run = course(on_line({}, 3, tower_m=(20.0, 0.5), robots=BODY), tmp_path, 1)
    told = {grant.node: grant.configuration for one in commits(run.journal) for grant in one.grants}
    assert told["r1"].max_speed_m_s == 0
    assert [told[name].row for name in ("r2", "r3", "r4")] == [0, 1, 2]
    assert all(one.tower_m == (20.0, 0.5) and one.body_m == 0.4 for one in told.values())
    assert run.positions(2)[0] == Line(told["r3"].field, told["r3"].tower_m).slot(1) == (20.0, 0.6 + 0.3)


def test_arrival_wakes_and_progress_is_told(tmp_path):
    script = {"wake_on": WAKE_ON_ARRIVAL, "wake_ticks": [4], "follow": {"0": [(10.0, 0.0)]}}
    run = course(on_line({"r2": script}, [(0.0, 0.0)]), tmp_path)
    assert run.grants("r2") == {0: "start", 4: "wake", 10: "arrival"}
    assert [(log.arrived, log.travelled_m) for log in run.logs("r2").values()] == [
        (True, 0.0),
        (False, 4.0),
        (True, 10.0),
    ]


def test_goals_are_the_ends_of_paths(tmp_path):
    run = course(on_line({"r2": {"follow": {"0": [(5.0, 0.0), (9.0, 0.0)]}}}, [(0.0, 0.0)]), tmp_path, 3)
    goals = np.frombuffer(run.facts[-1].goals).reshape(-1, 2)
    assert goals[1].tolist() == [9.0, 0.0] and np.isnan(goals[0]).all()


def test_a_watcher_sees_who_comes(tmp_path):
    scripts = {"r2": {"wake_on": WAKE_ON_SENSOR}, "r3": {"follow": {"0": [(9.5, 0.0)]}}}
    run = course(on_line(scripts, [(10.0, 0.0), (5.0, 0.0)]), tmp_path)
    assert run.grants("r2") == {0: "start", 4: "sensor"}
    assert run.logs("r2")[4].in_sight == ("r3",)


def test_a_path_in_mission_area_leads_straight_to_its_end():
    world = World(scenario(1, poses=[(0.0, 0.0, 0.0)]))
    body = world.nodes["r2"].body
    body.command(Follow(((50.0, 0.0), (0.0, 9.0))))
    assert (body.goal.x_m, body.goal.y_m) == (0.0, 9.0)


# Time and determinism


def test_without_batteries_a_resting_team_costs_nothing_and_with_them_every_tick_counts(tmp_path):
    run = course(on_line({}, 3), tmp_path / "without", 40)
    assert [one.tick for one in run.facts] == [0, 40]
    run = course(on_line({}, 3, battery=BatterySection()), tmp_path / "with", 40)
    assert [one.tick for one in run.facts] == list(range(41))


def noisy(scripts, places, **fields):
    robots = {"body_m": 0.4, "max_speed_m_s": 0.1, "max_turn_rad_s": 1.0, "noise_sd": 0.125}
    return on_line(scripts, places, robots=robots, battery=BatterySection(), **fields)


def test_the_same_run_twice_is_the_same_to_the_last_byte(tmp_path):
    scripts = {"r2": TO_THE_RIGHT | TALK, "r3": TO_THE_LEFT | AWAKE}
    given = noisy(scripts, [(8.0, 0.0), (11.0, 0.0)])
    one, same = course(given, tmp_path / "a"), course(given, tmp_path / "b")
    other = course(noisy(scripts, [(8.0, 0.0), (11.0, 0.0)], seed=2), tmp_path / "c")
    assert one.run_hash == same.run_hash != other.run_hash


def test_noise_depends_on_the_robot_and_the_tick_only(tmp_path):
    """Whoever else moves, and however long it stood: the same robot has the same luck at the same tick."""
    late = {"wake_ticks": [10], "follow": {"10": [(20.0, 0.0)]}}
    alone = course(noisy({"r3": late}, [(0.0, 0.0), (8.0, 0.0)]), tmp_path / "a")
    among = course(noisy({"r3": late, "r2": TO_THE_RIGHT}, [(0.0, 0.0), (8.0, 0.0)]), tmp_path / "b")
    more = course(noisy({"r3": late}, [(0.0, 0.0), (8.0, 0.0), (30.0, 0.0)]), tmp_path / "c")
    assert alone.positions(2) == among.positions(2) == more.positions(2)
    steps = np.diff([x_m for x_m, _ in alone.positions(2)])[10:]
    assert np.std(steps) == pytest.approx(0.125 * 0.1, rel=0.4)


def test_noise_goes_on_across_the_blocks_in_which_it_is_drawn(tmp_path):
    given = noisy({"r2": {"follow": {"0": [(40.0, 0.0)] * 1}}}, [(0.0, 0.0)], duration_s=2100.0)
    run = course(given, tmp_path)
    steps = np.diff([x_m for x_m, _ in run.positions(1)])[:390]
    assert len(set(np.round(steps, 12))) > 380
    long = noisy({"r2": {"follow": {"0": [(40.0, 0.0), (0.0, 0.0)] * 3}}}, [(0.0, 0.0)], duration_s=2100.0)
    moved = np.diff([x_m for x_m, _ in course(long, tmp_path / "long").positions(1)])
    assert not np.allclose(np.abs(moved[:300]), np.abs(moved[1024:1324]))
    assert np.abs(moved[1000:1060]).min() > 0
