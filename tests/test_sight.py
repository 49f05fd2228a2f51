"""What is seen from a place, against discs, shadows worked out by hand, and a slow oracle."""

import math

import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.plan_oracle import seen
from world_server.random_plans import random_plan
from world_server.sight import Sight

HALL = shapely.box(0, 0, 10, 10)
ROOMS = random_plan(4, (2, 2), 1)


def test_in_the_open_it_is_a_disc():
    view = Sight(HALL, 0.7).seen_from((5.0, 5.0))
    assert view.area == pytest.approx(math.pi * 0.49, rel=0.002)
    assert view.area < math.pi * 0.49, "nobody sees farther than the range"


def test_a_thin_wall_hides_what_is_behind_it():
    """A wall 1 m ahead from -0.5 to 0.5 hides what is behind it within 26.6 degrees to both sides."""
    plan = HALL.difference(shapely.box(6.0, 4.5, 6.001, 5.5))
    view = Sight(plan, 2.0).seen_from((5.0, 5.0))
    hidden = math.atan(0.5) * 4 - 0.5
    assert view.area == pytest.approx(math.pi * 4 - hidden, abs=0.03)
    assert not view.intersects(shapely.box(6.01, 4.6, 6.9, 5.4))


def test_it_reaches_into_the_walls_but_no_farther():
    view = Sight(HALL, 0.7).seen_from((0.3, 0.3))
    assert view.bounds[:2] == pytest.approx((-1e-6, -1e-6), abs=1e-9)


def test_outside_the_plan_nothing_is_seen():
    assert Sight(HALL, 0.7).seen_from((11.0, 5.0)).is_empty


@settings(max_examples=40, deadline=None)
@given(st.floats(0, 1), st.floats(0, 1), st.sampled_from([0.3, 0.7, 2.0]))
def test_it_lies_between_two_slow_answers(east, north, range_m):
    """With a circle drawn inside the true one, and with one drawn around it."""
    west, south, far_east, far_north = ROOMS.bounds
    place = (west + east * (far_east - west), south + north * (far_north - south))
    assume(shapely.contains_xy(ROOMS.buffer(-0.01), *place))
    view = Sight(ROOMS, range_m).seen_from(place)
    assert view.is_valid
    assert view.difference(seen(ROOMS, place, range_m)).area < 1e-4
    assert seen(ROOMS, place, range_m, around=False).difference(view).area < 1e-4
