"""Bodies: turn first, then go."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.builders import scenario
from wire.messages import GoTo, Pose, Stay
from wire.scenario import Fan, Robots
from world_server.motion import Body, first_poses, wrapped

metres = st.floats(-500, 500)
angles = st.floats(-math.pi, math.pi)
poses = st.builds(Pose, metres, metres, angles)


def body(x_m=0.0, y_m=0.0, heading_rad=0.0, speed=1.5, turn=1.0) -> Body:
    return Body(Pose(x_m, y_m, heading_rad), speed, turn)


def off(one: Body) -> float:
    """How far the heading is off the direction to the goal."""
    return wrapped(math.atan2(one.goal.y_m - one.y_m, one.goal.x_m - one.x_m) - one.heading_rad)


@given(st.floats(-1e6, 1e6))
def test_a_wrapped_angle_is_the_same_angle_in_minus_pi_to_pi(angle):
    found = wrapped(angle)
    assert -math.pi < found <= math.pi
    assert math.cos(found) == pytest.approx(math.cos(angle), abs=1e-8)
    assert math.sin(found) == pytest.approx(math.sin(angle), abs=1e-8)


@pytest.mark.parametrize(
    "angle", [math.pi, -math.pi, 3 * math.pi, math.nextafter(math.pi, 4), math.nextafter(-math.pi, -4)]
)
def test_half_a_turn_is_plus_pi(angle):
    assert -math.pi < wrapped(angle) <= math.pi
    assert abs(wrapped(angle)) == pytest.approx(math.pi)


def test_a_turn_of_more_than_a_tick_is_pure_rotation():
    one = body()
    one.command(GoTo(0.0, 10.0))  # 1.57 rad to the left at 1 rad a tick
    one.advance(1.0)
    assert (one.x_m, one.y_m, one.heading_rad) == (0.0, 0.0, 1.0)
    one.advance(1.0)
    assert (one.x_m, one.y_m) == pytest.approx((0.0, 1.5))
    assert one.heading_rad == pytest.approx(math.pi / 2)


def test_it_turns_the_shorter_way():
    one = body(heading_rad=3.0)
    one.command(GoTo(-10.0, -10.0))  # at -2.36 rad, 0.93 rad to the left across pi
    one.advance(1.0)
    assert one.heading_rad == pytest.approx(-3 * math.pi / 4)
    assert one.x_m < 0


def test_a_turn_of_exactly_a_tick_leaves_time_to_go():
    one = body(turn=math.pi / 2)
    one.command(GoTo(0.0, 10.0))
    one.advance(1.0)
    assert one.y_m == pytest.approx(1.5)


@given(poses, metres, metres, st.floats(0.1, 20), st.floats(0.05, 4), st.sampled_from([0.1, 1.0, 2.0]))
def test_one_tick_turns_and_goes_within_the_limits_and_never_overshoots(pose, x_m, y_m, speed, turn, tick_s):
    one = Body(pose, speed, turn)
    one.command(GoTo(x_m, y_m))
    assume(not one.at_rest)
    error, before = off(one), math.hypot(x_m - pose.x_m, y_m - pose.y_m)
    one.advance(tick_s)
    after = math.hypot(x_m - one.x_m, y_m - one.y_m)
    gone = math.hypot(one.x_m - pose.x_m, one.y_m - pose.y_m)
    assert -math.pi < one.heading_rad <= math.pi
    assert abs(wrapped(one.heading_rad - pose.heading_rad)) <= turn * tick_s + 1e-9
    assert gone <= speed * tick_s + 1e-9
    if abs(error) > turn * tick_s:
        assert gone == 0
    else:
        assert after == pytest.approx(max(0.0, before - speed * tick_s), abs=1e-6)


@given(poses, metres, metres)
def test_it_reaches_its_goal_exactly_and_then_rests(pose, x_m, y_m):
    one = Body(pose, 20.0, 1.0)
    one.command(GoTo(x_m, y_m))
    for _ in range(90):
        one.advance(1.0)
    assert (one.x_m, one.y_m) == (x_m, y_m)
    assert one.arrived and one.at_rest
    rest = one.pose
    one.advance(1.0)
    assert one.pose == rest


def test_arrival_is_within_reach_and_the_way_is_still_gone_to_its_end():
    one = body()
    one.command(GoTo(10.0, 0.0, within_m=3.0))
    arrivals = []
    for _ in range(7):
        one.advance(1.0)
        arrivals.append(one.arrived)
    assert arrivals == [False] * 4 + [True] * 3
    assert one.x_m == 10.0


def test_a_motion_holds_until_another_replaces_it():
    one = body()
    one.command(GoTo(10.0, 0.0))
    one.command(None)
    one.advance(1.0)
    assert one.x_m == 1.5
    one.command(Stay())
    one.advance(1.0)
    assert (one.x_m, one.at_rest, one.arrived) == (1.5, True, False)


def test_without_a_goal_it_rests():
    one = body()
    one.advance(1.0)
    assert one.pose == Pose(0.0, 0.0, 0.0)
    assert one.at_rest and not one.arrived


def test_what_cannot_move_does_not():
    one = body(speed=0.0)
    one.command(GoTo(10.0, 10.0))
    one.advance(1.0)
    assert one.pose == Pose(0.0, 0.0, 0.0)


@given(st.integers(0, 2**63 - 1), st.integers(1, 20))
def test_robots_start_in_the_fan_of_two_roots_of_n_metres(seed, count):
    """Source: section V-A1: ||x_n(0)|| <= 2 sqrt(N); the first quadrant is our reading."""
    poses = first_poses(scenario(count, seed=seed))
    assert poses["r1"] == Pose(0.0, 0.0, 0.0)
    for node, pose in poses.items():
        assert math.hypot(pose.x_m, pose.y_m) <= 2 * math.sqrt(count + 1)
        assert pose.x_m >= 0 and pose.y_m >= 0, node
        assert -math.pi < pose.heading_rad <= math.pi


def test_the_fan_is_filled_uniformly():
    """Source: section V-A1: uniformly random; half of a disc's area is within 0.707 of its radius."""
    robots = Robots("lr_pt", 800, start=Fan(radius_m=10.0))
    away = [math.hypot(pose.x_m, pose.y_m) for pose in first_poses(scenario(robots)).values()]
    assert sum(one <= 10 / math.sqrt(2) for one in away) / 800 == pytest.approx(0.5, abs=0.05)
    assert 9.9 < max(away) <= 10.0


def test_a_given_pose_is_taken_in_order_of_the_ids():
    robots = Robots("lr_pt", ids=("r10", "r2"))
    poses = first_poses(scenario(robots, poses=[(1.0, 2.0, 0.5), (3.0, 4.0, -0.5)]))
    assert poses == {"r1": Pose(0.0, 0.0, 0.0), "r2": Pose(1.0, 2.0, 0.5), "r10": Pose(3.0, 4.0, -0.5)}
    assert list(poses) == ["r1", "r2", "r10"]


def test_the_same_seed_gives_the_same_poses_and_another_gives_others():
    assert first_poses(scenario(9, seed=4)) == first_poses(scenario(9, seed=4))
    assert first_poses(scenario(9, seed=4)) != first_poses(scenario(9, seed=5))


def test_one_robot_more_moves_nobody_elses_start():
    few = first_poses(scenario(Robots("lr_pt", 3, start=Fan(5.0))))
    more = first_poses(scenario(Robots("lr_pt", 4, start=Fan(5.0))))
    assert few.items() <= more.items()
