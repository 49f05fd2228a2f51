"""Random floor plans: the same from the same seed, with as many islands as asked for, and fit for robots."""

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from world_server.floorplan import PlanError
from world_server.plan_checks import check_plan
from world_server.random_plans import random_plan


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 3), st.integers(1, 3), st.data())
def test_a_random_plan_is_repeatable_valid_and_has_its_islands(seed, columns, rows, data):
    islands = data.draw(st.integers(0, (columns - 1) * (rows - 1)))
    plan = random_plan(seed, (columns, rows), islands)
    check_plan(plan, 0.25, 0.7)
    assert len(plan.interiors) == islands
    assert shapely.get_precision(plan) == 0, "what is cut out of it is not to be snapped to a grid"
    assert shapely.to_wkt(plan) == shapely.to_wkt(random_plan(seed, (columns, rows), islands))
    west, south, east, north = plan.bounds
    assert 0 <= west and 0 <= south and east <= 5 * columns and north <= 5 * rows


def test_seeds_make_a_difference():
    assert not random_plan(1, (2, 1)).equals(random_plan(2, (2, 1)))


@pytest.mark.parametrize(
    ("rooms", "islands", "complaint"),
    [
        ((0, 3), 0, "rooms must be at least 1 in both directions, got [0, 3]"),
        ((3, 2), 3, "islands must be from 0 to 2 for 3 x 2 rooms, got 3"),
        ((3, 2), -1, "islands must be from 0 to 2 for 3 x 2 rooms, got -1"),
    ],
)
def test_what_cannot_be_is_refused(rooms, islands, complaint):
    with pytest.raises(PlanError, match="^" + complaint.replace("[", r"\[")):
        random_plan(1, rooms, islands)


def test_robots_too_stout_for_every_plan_are_told_why():
    with pytest.raises(
        PlanError, match="none of 20 random plans suits such robots; of the last one: no passage"
    ):
        random_plan(1, (2, 1), obstacle_m=0.8, detect_m=2.0)
