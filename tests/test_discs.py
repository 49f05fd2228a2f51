"""Bodies among walls and bodies: they go as far as they can, slide along walls, and are never inside them."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.clear_builders import BODY_M, BOX
from wire.fields import Point
from wire.messages import Follow, GoTo, Pose, Shift, Stay
from world_server.discs import Disc, way_of
from world_server.random_plans import random_plan
from world_server.walls import Walls

TICK_S = 0.25
STEP_M = 0.05
RADIUS_M = BODY_M / 2
ROUNDING_M = 1e-8


def walls_of(plan: shapely.Polygon) -> Walls:
    return Walls([shapely.get_coordinates(ring) for ring in shapely.get_rings(plan)], RADIUS_M + STEP_M)


BOXED = walls_of(shapely.Polygon(BOX))


def disc(x_m: float, y_m: float, front_rad: float = 0.0) -> Disc:
    return Disc(Pose(x_m, y_m, front_rad), STEP_M / TICK_S)


def driven(one: Disc, ticks: int, others: tuple[Point, ...] = (), walls: Walls = BOXED) -> list[list[Point]]:
    return [one.drive(TICK_S, walls, others, BODY_M) for _ in range(ticks)]


def test_it_goes_straight_by_what_it_is_told_in_its_own_frame_and_rests():
    one = disc(1.0, 1.0, math.pi / 2)
    one.command(Shift(0.52, -0.3))
    driven(one, 5)
    assert math.dist((one.x_m, one.y_m), (1, 1)) == pytest.approx(5 * STEP_M)
    assert not one.arrived
    driven(one, 20)
    assert (one.x_m, one.y_m) == pytest.approx((1.3, 1.52))
    assert one.arrived and one.at_rest and one.heading_rad == math.pi / 2


def test_it_keeps_its_motion_until_told_otherwise_and_knows_no_places():
    one = disc(1.0, 1.0)
    one.command(Shift(1.0, 0.0))
    driven(one, 1)
    one.command(None)
    driven(one, 1)
    assert one.x_m == pytest.approx(1.1)
    for motion in (Stay(), GoTo(3.0, 1.0), Follow(((3.0, 1.0),))):
        one.command(Shift(1.0, 0.0))
        one.command(motion)
        assert one.at_rest and driven(one, 1) == [[]]


def test_a_wall_stops_it_at_its_radius():
    one = disc(3.83, 1.0)
    one.command(Shift(1.0, 0.0))
    driven(one, 5)
    assert one.x_m == pytest.approx(4 - RADIUS_M, abs=ROUNDING_M)
    assert one.y_m == 1.0 and not one.arrived


def test_it_slides_along_a_wall_and_says_where_its_way_is_not_straight():
    one = disc(3.88, 1.0)
    one.command(Shift(0.3, 0.3))
    corner, end = driven(one, 1)[0]
    assert corner == pytest.approx((3.9, 1.02), abs=ROUNDING_M)
    assert end[0] == pytest.approx(3.9, abs=ROUNDING_M)
    assert end[1] - corner[1] == pytest.approx((STEP_M - math.hypot(0.02, 0.02)) * math.sqrt(0.5))
    driven(one, 200)
    assert (one.x_m, one.y_m) == pytest.approx((3.9, 1.3), abs=1e-6), "as near as it can come"
    assert driven(one, 1) == [[]]


def test_in_a_corner_it_stops():
    one = disc(3.8, 2.8)
    one.command(Shift(1.0, 0.7))
    driven(one, 20)
    assert (one.x_m, one.y_m) == pytest.approx((3.9, 2.9), abs=ROUNDING_M)
    assert driven(one, 1) == [[]]


def test_round_the_end_of_a_wall_it_slides_on_a_circle():
    spike = walls_of(shapely.Polygon(((0, 0), (4, 0), (4, 3), (2.01, 3), (2, 1.5), (1.99, 3), (0, 3))))
    one = disc(1.95, 1.2)
    one.command(Shift(0.0, 0.6))
    for _ in range(40):
        driven(one, 1, walls=spike)
        assert math.dist((one.x_m, one.y_m), (2, 1.5)) >= RADIUS_M - ROUNDING_M
    assert one.x_m < 1.9 + ROUNDING_M and one.y_m > 1.5


def test_another_body_stops_it_at_its_width_and_it_does_not_slide_past():
    one = disc(1.0, 1.0)
    one.command(Shift(1.0, 0.0))
    driven(one, 20, ((1.5, 1.1),))
    assert math.dist((one.x_m, one.y_m), (1.5, 1.1)) == pytest.approx(BODY_M, abs=ROUNDING_M)
    assert one.y_m == 1.0
    one.command(Shift(-0.5, 0.0))
    driven(one, 1, ((1.5, 1.1),))
    assert math.dist((one.x_m, one.y_m), (1.5, 1.1)) > BODY_M


def test_it_goes_on_when_the_way_is_free_again():
    one = disc(1.0, 1.0)
    one.command(Shift(1.0, 0.0))
    driven(one, 20, ((1.5, 1.0),))
    driven(one, 20)
    assert one.arrived and one.x_m == pytest.approx(2.0)


PLANS = [random_plan(seed, (2, 2), seed % 2) for seed in (1, 2)]
ROOMS = [plan.buffer(-RADIUS_M - 1e-6) for plan in PLANS]
ALL_WALLS = [walls_of(plan) for plan in PLANS]


@settings(max_examples=40)
@given(st.integers(0, len(PLANS) - 1), st.integers(0, 2**32 - 1))
def test_discs_never_overlap_and_are_never_in_a_wall(number, seed):
    """A crowd that pushes in all directions, to and fro, in a random plan."""
    draw = np.random.default_rng(seed)
    start = scattered(ROOMS[number], 12, draw)
    crowd = [disc(*place, draw.random() * math.tau) for place in start]
    for _ in range(40):
        for place, one in enumerate(crowd):
            if draw.random() < 0.2:
                one.command(Shift(*draw.normal(scale=0.3, size=2).tolist()))
            others = [(other.x_m, other.y_m) for row, other in enumerate(crowd) if row != place]
            before = (one.x_m, one.y_m)
            way = one.drive(TICK_S, ALL_WALLS[number], others, BODY_M)
            legs_m = sum(math.dist(*leg) for leg in zip([before, *way], way, strict=False))
            assert legs_m <= STEP_M + ROUNDING_M
            for point in way:
                assert min(math.dist(point, other) for other in others) >= BODY_M - ROUNDING_M
                assert PLANS[number].boundary.distance(shapely.Point(point)) >= RADIUS_M - ROUNDING_M
                assert shapely.intersects_xy(PLANS[number], *point)


def scattered(room: shapely.Geometry, count: int, draw: np.random.Generator) -> list[Point]:
    """Places for bodies close to each other."""
    west_m, south_m, east_m, north_m = room.bounds
    middle: Point | None = None
    found: list[Point] = []
    while len(found) < count:
        around = (west_m, south_m, east_m, north_m) if middle is None else None
        place = draw.uniform(around[:2], around[2:]) if around else middle + draw.normal(scale=0.6, size=2)
        apart_m = min((math.dist(place, other) for other in found), default=math.inf)
        if shapely.intersects_xy(room, *place) and apart_m >= BODY_M:
            middle = place if middle is None else middle
            found.append((float(place[0]), float(place[1])))
    return found


@given(st.floats(0, math.tau), st.floats(0.001, 0.3))
def test_turned_walls_and_steps_give_the_turned_way(angle_rad, length_m):
    def turned(point):
        cos, sin = math.cos(1.0), math.sin(1.0)
        return cos * point[0] - sin * point[1], sin * point[0] + cos * point[1]

    segments = BOXED.near(3.7, 2.6).tolist()
    also = [(*turned(one[:2]), *turned(one[2:])) for one in segments]
    step = (length_m * math.cos(angle_rad), length_m * math.sin(angle_rad))
    plain = way_of((3.7, 2.6), step, segments, [(3.5, 2.5)], BODY_M)
    other = way_of(turned((3.7, 2.6)), turned(step), also, [turned((3.5, 2.5))], BODY_M)
    assert len(plain) == len(other)
    for one, same in zip(plain, other, strict=True):
        assert turned(one) == pytest.approx(same, abs=1e-9)
