"""Visits on the line: passing counts once, turning twice, resting and going on once; and when."""

from hypothesis import given
from hypothesis import strategies as st

from tests.builders import STRAIGHT, course, on_line
from wire.fields import Polyline
from wire.line import Line
from wire.scenario import PlannedFault
from world_server.passes import AT_SITE_M, Passes

LEFT_1, MID_1, RIGHT_1, LEFT_2, MID_2, RIGHT_2 = range(6)
ENDS = [(10.0, 0.0), (0.0, 0.0)]
LONE = Polyline(((0.0, 0.0), (40.0, 0.0)), ((10.0, 20.0),))
"""One segment in the middle of a line."""


def followed(arcs, near_m=AT_SITE_M, asides=None) -> list[tuple[int, list[int], list[int]]]:
    """Departures and arrivals in each step of one robot past sites at 10, 15 and 20."""
    passes = Passes([10.0, 15.0, 20.0], near_m, 0.3, 1)
    asides = asides or [0.0] * len(arcs)
    steps = [passes.follow(0, arc, aside) for arc, aside in zip(arcs, asides, strict=True)]
    return [(step, *visits) for step, visits in enumerate(steps) if visits != ([], [])]


def test_passing_counts_once_however_it_falls_on_the_ticks():
    assert followed([9.5, 10.5, 11.5]) == [(1, [], [0])]
    assert followed([9.0, 10.0, 11.0]) == [(1, [], [0])]
    assert followed([11.0, 10.0, 9.0]) == [(1, [], [0])]
    assert followed([9.0, 21.0]) == [(1, [], [0, 1, 2])]
    assert sorted(followed([21.0, 9.0])[0][2]) == [0, 1, 2]


def test_a_rest_on_the_way_counts_once():
    assert followed([9.0, 10.0, 10.0, 10.0, 11.0]) == [(1, [], [0])]


def test_a_turn_counts_twice_as_arrival_and_as_departure():
    assert followed([9.0, 10.0, 9.0]) == [(1, [], [0]), (2, [0], [])]
    assert followed([11.0, 10.0, 10.0, 11.0]) == [(1, [], [0]), (3, [0], [])]


def test_a_turn_within_a_tick_counts_twice():
    passes = Passes([10.0], AT_SITE_M, 0.3, 1)
    passes.follow(0, 9.7, 0.0)
    assert passes.follow(0, 9.8, 0.0, [10.0]) == ([], [0, 0])
    assert passes.follow(0, 9.0, 0.0) == ([], [])


def test_a_turn_short_of_a_site_is_no_visit():
    assert followed([9.0, 9.99, 9.0]) == []


def test_with_noise_a_turn_near_a_site_is_a_turn_at_it():
    assert followed([9.0, 9.97, 9.0], near_m=0.05) == [(1, [], [0]), (2, [0], [])]
    assert followed([9.0, 9.97, 10.02, 11.0], near_m=0.05) == [(1, [], [0])]


def test_who_begins_at_a_site_or_comes_to_it_from_beside_has_visited_it_once():
    assert followed([10.0, 11.0]) == [(0, [], [0])]
    assert followed([10.0, 10.0, 9.0], asides=[0.6, 0.4, 0.0]) == [(1, [], [0])]


def test_the_passing_lane_counts_and_the_queue_does_not():
    assert followed([9.5, 10.5], asides=[0.3, 0.3]) == [(1, [], [0])]
    assert followed([9.5, 10.5], asides=[-0.3, -0.3]) == [(1, [], [0])]
    assert followed([9.5, 10.5], asides=[0.6, 0.6]) == []
    assert followed([9.5, 10.5, 11.0], asides=[0.6, 0.6, 0.0]) == []


@given(st.lists(st.floats(5.0, 25.0), min_size=2, max_size=30))
def test_visits_are_the_crossings_of_a_site(arcs):
    """Away from the site itself, each crossing is one visit."""
    arcs = [arc for arc in arcs if min(abs(arc - site) for site in (10, 15, 20)) > 1e-3]
    for number, site in enumerate((10.0, 15.0, 20.0)):
        crossings = sum((one - site) * (other - site) < 0 for one, other in zip(arcs, arcs[1:], strict=False))
        found = [site for _, departures, arrivals in followed(arcs) for site in departures + arrivals]
        assert found.count(number) == crossings


def test_ends_are_visited_twice_each_period_and_the_middle_each_leg(tmp_path):
    """Source: the paper's analysis: gaps 2 x T and 2 (1 - x) T, T at the middle, 0 and 2 T at the ends."""
    script = {"r2": {"follow": {"0": ENDS * 10}, "backwards": True}}
    run = course(on_line(script, [(0.0, 0.0)]), tmp_path)
    ticks = {
        site: [tick for tick, _, one in run.visits() if one == site] for site in (LEFT_1, MID_1, RIGHT_1)
    }
    assert ticks[MID_1] == [5, 15, 25, 35]
    assert ticks[RIGHT_1] == [10, 10, 30, 30]
    assert ticks[LEFT_1] == [0, 20, 20, 40, 40]


def test_a_turn_by_a_second_order_counts_as_one_by_a_path(tmp_path):
    script = {
        "wake_on": 2,
        "wake_ticks": [10, 20, 30],
        "follow": {"0": [(10.0, 0.0)], "10": [(0.0, 0.0)], "20": [(10.0, 0.0)], "30": [(0.0, 0.0)]},
        "backwards": True,
    }
    run = course(on_line({"r2": script}, [(0.0, 0.0)]), tmp_path)
    assert [tick for tick, _, site in run.visits() if site == RIGHT_1] == [10, 10, 30, 30]
    assert [tick for tick, _, site in run.visits() if site == LEFT_1] == [0, 20, 20, 40]
    assert run.facts[-1].tick == 40


def test_a_rest_at_an_end_puts_the_departure_off(tmp_path):
    script = {"wake_ticks": [14], "follow": {"0": [(10.0, 0.0)], "14": [(0.0, 0.0)]}, "backwards": True}
    run = course(on_line({"r2": script}, [(0.0, 0.0)]), tmp_path)
    assert [tick for tick, _, site in run.visits() if site == RIGHT_1] == [10, 14]


def test_neighbouring_segments_share_their_end_and_both_are_visited(tmp_path):
    run = course(on_line({"r2": {"follow": {"0": [(20.0, 0.0)]}}}, [(0.0, 0.0)]), tmp_path, 30)
    assert run.visits() == [
        (0, "r2", LEFT_1),
        (5, "r2", MID_1),
        (10, "r2", RIGHT_1),
        (10, "r2", LEFT_2),
        (15, "r2", MID_2),
        (20, "r2", RIGHT_2),
        (20, "r2", 6),
    ]


def test_the_last_arrival_is_not_lost_when_all_come_to_rest(tmp_path):
    run = course(on_line({"r2": {"follow": {"0": [(10.0, 0.0)]}}}, [(5.5, 0.0)], field=LONE), tmp_path, 40)
    assert run.visits() == [(5, "r2", 0)]
    assert run.facts[-2].tick == 5


def test_only_the_living_visit(tmp_path):
    faults = (PlannedFault(3.0, "freeze", ("r2",)), PlannedFault(12.0, "thaw", ("r2",)))
    run = course(on_line({"r2": {"follow": {"0": [(20.0, 0.0)]}}}, [(1.0, 0.0)], faults=faults), tmp_path, 30)
    assert [site for _, _, site in run.visits()] == [MID_2, RIGHT_2, 6]


def test_a_noisy_robot_visits_every_end_twice_and_every_middle_once(tmp_path):
    """A segment of a metre at 0.1 m/s with noise on both velocities: no lap is missed, none counts twice."""
    field = Polyline(((0.0, 0.0), (3.0, 0.0)), ((1.0, 2.0),))
    laps = [(2.0, 0.0), (1.0, 0.0)] * 100
    body = {"max_speed_m_s": 0.1, "max_turn_rad_s": 1.57, "noise_sd": 0.125}
    given = on_line(
        {"r2": {"follow": {"0": laps}}},
        [(0.5, 0.0)],
        field=field,
        tower_m=(1.5, 0.5),
        robots=body,
        duration_s=4000.0,
    )
    run = course(given, tmp_path)
    sites = [site for _, _, site in run.visits()]
    assert sites == [0, 1] + [2, 2, 1, 0, 0, 1] * 99 + [2, 2, 1, 0]
    assert Line(field, (1.5, 0.5)).sites_m() == [1.0, 1.5, 2.0]
    assert STRAIGHT.gap_m == 0.0
