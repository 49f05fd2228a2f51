"""Bodies on paths: exact where chance is off, on their line where it is on."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wire.messages import Dock, Follow, GoTo, Pose, Stay
from world_server.path_following import NEAR_M, Drive, PathBody

PI = math.pi
points = st.tuples(st.floats(-50, 50), st.floats(-50, 50))
poses = st.builds(Pose, st.floats(-50, 50), st.floats(-50, 50), st.floats(-PI, PI))


def body(x_m=0.0, y_m=0.0, heading_rad=0.0, speed=1.0, turn=1.0, noise=0.0, ahead=1.0) -> PathBody:
    return PathBody(Pose(x_m, y_m, heading_rad), Drive(speed, turn, ahead, noise))


def ticks_to_arrive(one: PathBody, tick_s=1.0, at_most=10_000) -> int:
    ticks = 0
    while not one.arrived and ticks < at_most:
        one.advance(tick_s)
        ticks += 1
    return ticks


@pytest.mark.parametrize(("speed", "tick_s", "ticks"), [(1.0, 1.0, 7), (0.1, 0.1, 930), (0.3, 0.5, 61)])
def test_a_leg_of_a_whole_number_of_ticks_takes_exactly_so_many(speed, tick_s, ticks):
    one = body(speed=speed)
    one.command(Follow(((speed * tick_s * ticks, 0.0),)))
    assert ticks_to_arrive(one, tick_s) == ticks
    assert (one.x_m, one.y_m, one.at_rest) == (speed * tick_s * ticks, 0.0, True)


def test_half_a_turn_takes_exactly_pi_by_the_turn_rate():
    """Out 2 m, turn in 2 s, back 2 m: six ticks, not one more."""
    one = body(turn=PI / 2)
    one.command(Follow(((2.0, 0.0), (0.0, 0.0))))
    course = []
    for _ in range(6):
        one.advance(1.0)
        course.append((one.x_m, one.heading_rad))
    assert [x_m for x_m, _ in course] == pytest.approx([1, 2, 2, 2, 1, 0])
    assert [abs(heading) for _, heading in course] == pytest.approx([0, 0, PI / 2, PI, PI, PI])
    assert one.arrived


def test_what_a_turn_leaves_of_a_tick_is_driven():
    one = body(turn=PI / 0.25)
    one.command(Follow(((1.5, 0.0), (-10.0, 0.0))))
    one.advance(1.0)
    one.advance(1.0)  # half a second to the point, a quarter to turn, a quarter back
    assert (one.x_m, one.passed) == (pytest.approx(1.25), [(1.5, 0.0)])


def test_to_and_fro_for_a_day_keeps_to_its_time():
    """A period of 2 (T + c), with T = 10 s and c = 0.5 s, ten thousand times."""
    one = body(turn=PI / 0.5)
    one.command(Follow(((10.0, 0.0), (0.0, 0.0)) * 1000))
    for _ in range(1000 * 21 - 1):
        one.advance(1.0)
    assert not one.arrived and one.x_m == pytest.approx(0.5, abs=1e-6)
    one.advance(1.0)
    assert one.arrived and (one.x_m, one.y_m) == (0.0, 0.0)


def test_a_slight_bend_costs_nothing_and_a_sharp_one_its_turn():
    slight, sharp = body(turn=PI / 2), body(turn=PI / 2)
    slight.command(Follow(((3.0, 0.0), (3.0 + 2 * math.cos(0.7), 2 * math.sin(0.7)))))
    sharp.command(Follow(((3.0, 0.0), (3.0, 2.0))))
    assert ticks_to_arrive(slight) == 5
    assert ticks_to_arrive(sharp) == 6


def test_backwards_reverses_at_no_cost():
    one = body(turn=PI / 2)
    one.command(Follow(((2.0, 0.0), (0.0, 0.0)), backwards=True))
    assert ticks_to_arrive(one) == 4
    assert (one.x_m, one.heading_rad) == (0.0, 0.0)


def test_backwards_turns_where_that_is_less():
    """The way is 120 degrees off: 60 degrees to go there in reverse, a third of a second at pi a second."""
    one = body(turn=PI / 3)
    way = (math.cos(2 * PI / 3), math.sin(2 * PI / 3))
    one.command(Follow((way,), backwards=True))
    assert ticks_to_arrive(one) == 2
    assert one.heading_rad == pytest.approx(-PI / 3)


def test_progress_is_counted_from_the_last_command():
    one = body()
    one.command(Follow(((3.0, 0.0), (3.0, 4.0))))
    seen = []
    for _ in range(10):
        one.advance(1.0)
        seen.append(one.travelled_m)
    assert seen[:3] == pytest.approx([1, 2, 3])
    assert seen == sorted(seen) and seen[-1] == pytest.approx(7.0)
    one.command(Follow(((3.0, 0.0),)))
    assert one.travelled_m == 0.0


def test_who_stands_or_docks_has_arrived_and_who_is_there_arrives_at_once():
    one = body()
    assert one.arrived and one.at_rest
    assert not one.command(Stay()) and not one.command(Dock()) and not one.command(None)
    assert one.command(Follow(((0.0, 0.0),))) and one.command(GoTo(0.0, 0.0))
    assert not one.command(GoTo(5.0, 0.0, 2.0))
    assert not one.arrived
    assert ticks_to_arrive(one) == 3 and not one.at_rest
    one.command(Stay())
    assert one.goal is None and one.at_rest


def test_an_errand_that_was_broken_off_goes_on():
    one, other = body(), body()
    for each in (one, other):
        each.command(Follow(((3.0, 0.0), (3.0, 4.0))))
        each.advance(1.0)
    errand = one.halt()
    assert one.at_rest and one.goal is None
    one.resume(errand)
    assert (one.goal, one.travelled_m) == (other.goal, other.travelled_m)
    assert ticks_to_arrive(one) == ticks_to_arrive(other)


def test_a_step_can_be_undone():
    one = body(turn=2.0)
    one.command(Follow(((1.5, 0.0), (0.0, 0.0))))
    one.advance(1.0)
    before = one.state
    one.advance(1.0)
    after = one.state
    one.put_back(before)
    assert one.state == before and one.passed == []
    one.advance(1.0)
    assert one.state == after


@given(poses, st.lists(points, min_size=1, max_size=8), st.booleans(), st.sampled_from([0.1, 1.0, 3.0]))
def test_it_ends_at_the_last_point_and_never_goes_too_fast(pose, path_m, backwards, tick_s):
    one = PathBody(pose, Drive(5.0, 2.0, 5.0 * tick_s))
    one.command(Follow(tuple(path_m), backwards))
    places = [(pose.x_m, pose.y_m), *path_m]
    length_m = sum(math.dist(*pair) for pair in zip(places, places[1:], strict=False))
    most_s = length_m / 5.0 + (len(path_m) + 1) * PI / 2.0
    travelled_m = 0.0
    for _ in range(math.ceil(most_s / tick_s) + 1):
        x_m, y_m = one.x_m, one.y_m
        one.advance(tick_s)
        assert math.hypot(one.x_m - x_m, one.y_m - y_m) <= 5.0 * tick_s + 2 * NEAR_M
        assert -PI <= one.heading_rad <= PI
        assert one.travelled_m >= travelled_m - 2 * NEAR_M
        travelled_m = one.travelled_m
    assert one.arrived and one.at_rest
    assert math.dist((one.x_m, one.y_m), path_m[-1]) <= NEAR_M
    assert one.travelled_m == pytest.approx(length_m, abs=1e-6)


@pytest.mark.parametrize("tick_s", [0.1, 0.5, 1.0])
def test_noise_keeps_its_size_and_its_line(tick_s):
    """A robot as in the paper, 0.1 m/s and a lane of 0.3 m, to and fro on a segment for eight hours."""
    ticks, half_lane_m = round(8 * 3600 / tick_s), 0.15
    drive = Drive(0.1, PI / 2, max(0.1 * tick_s, half_lane_m), 0.125, 0.05 * tick_s)
    one = PathBody(Pose(0.0, 0.0, 0.0), drive)
    aside, steps = [], []
    for draw in np.random.Generator(np.random.Philox(5)).standard_normal((ticks, 2)).tolist():
        if one.at_rest:
            one.command(Follow(((1.0 if one.x_m < 0.5 else 0.0, 0.0),), backwards=True))
        before = one.travelled_m
        one.advance(tick_s, draw)
        aside.append(one.y_m)
        if not one.at_rest and not one.passed:
            steps.append(one.travelled_m - before)
    assert np.std(aside) < half_lane_m / 6
    assert max(map(abs, aside)) < half_lane_m
    assert np.mean(steps) / tick_s == pytest.approx(0.1, rel=0.05)
    clipped = 0.125 / math.sqrt(tick_s)  # of full speed; where it is large, standing still cuts it off
    assert np.std(steps) / (0.1 * tick_s) == pytest.approx(clipped, rel=0.15)


def test_noise_ends_a_path_at_its_end_and_does_not_go_beyond_it():
    one = PathBody(Pose(0.0, 0.0, 0.0), Drive(0.1, PI, 0.15, 0.125, 0.05))
    generator = np.random.Generator(np.random.Philox(1))
    ends = []
    for lap in range(200):
        one.command(Follow((((lap + 1) % 2 * 1.0, 0.0),), backwards=True))
        while not one.arrived:
            one.advance(1.0, generator.standard_normal(2).tolist())
        ends.append(abs(one.x_m - (lap + 1) % 2))
    assert max(ends) < 0.01  # it comes askew, a tenth of what a tick is good for
