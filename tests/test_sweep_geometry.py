"""Rolling along walls, clearances and angles, as sweep robots compute them."""

import cmath
import math
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from swarm_agent.sweep.geometry import (
    NOTHING,
    clearance_m,
    crossed,
    crosses,
    nearest,
    roll,
    shortened,
    turn_rad,
    unit,
)
from tests.sweep_builders import wall

KEEP_M, STEP_M = 0.25, 0.05
PLACES = st.builds(complex, st.integers(-9, 9), st.integers(-9, 9))
SLACK_M = 0.012  # 0.3 of a step of 5 degrees, and the rounding that roll allows itself
HANDS = pytest.mark.parametrize("hand", ["left", "right"])


def rolled(
    walls: np.ndarray, here: complex, contact: complex, hand: str, steps: int
) -> tuple[list[complex], list[complex]]:
    """The places of a disc that rolls so many steps, and the contacts of all."""
    places, contacts = [here], [contact]
    for _ in range(steps):
        way, contact = roll(places[-1], walls, contact, hand, KEEP_M, STEP_M)
        places.append(places[-1] + way)
        contacts.append(contact)
    return places, contacts


def seen_by(hand: str, *places: complex | np.ndarray):
    """Places drawn for a disc that keeps walls on its right, for either hand: the left sees a mirror."""
    turned = [place if hand == "right" else -np.conj(place) for place in places]
    return [complex(place) if np.ndim(place) == 0 else place for place in turned]


def away_m(walls: np.ndarray, place: complex) -> float:
    return float(np.abs(walls - place).min())


@HANDS
def test_along_a_straight_wall_a_disc_keeps_its_distance(hand):
    """Source: specs of mission clear, 3.7 item 3: along the wall at distance r_obstacle."""
    walls, here, contact = seen_by(hand, wall(-2, 4), 0.25j, 0j)
    places, contacts = rolled(walls, here, contact, hand, 40)
    ahead = 1 if hand == "right" else -1
    assert [away_m(walls, place) for place in places] == pytest.approx([KEEP_M] * 41, abs=SLACK_M)
    assert places[-1].real * ahead == pytest.approx(40 * STEP_M, abs=0.01)
    assert abs(contacts[-1] - places[-1]) < KEEP_M + 0.03


@HANDS
def test_round_a_convex_corner_a_disc_goes_on_an_arc(hand):
    """Source: specs of mission clear, 3.7 item 3: rounding convex corners on an arc of radius r_obstacle."""
    walls, here, contact, corner = seen_by(
        hand, np.concatenate((wall(-2, 0), wall(0, -2j))), -0.5 + 0.25j, -0.5 + 0j, 0j
    )
    places, contacts = rolled(walls, here, contact, hand, 32)
    assert max(abs(away_m(walls, place) - KEEP_M) for place in places) <= SLACK_M
    turning = [place for one, place in zip(contacts, places, strict=True) if abs(one - corner) < 0.01]
    assert len(turning) >= 7, "a quarter of a circle of 0.25 m is eight steps long"
    down = unit(places[-1] - places[-2])
    assert abs(down - -1j) < 0.1
    assert abs(places[-1].real) == pytest.approx(KEEP_M, abs=SLACK_M)


@HANDS
def test_at_a_concave_corner_a_disc_changes_over_to_the_other_wall(hand):
    """Source: specs of mission clear, 3.7 item 3: switch wall when the front clearance < r_obstacle."""
    walls, here, contact = seen_by(
        hand, np.concatenate((wall(-2, 1), wall(1, 1 + 2j))), -0.5 + 0.25j, -0.5 + 0j
    )
    places, contacts = rolled(walls, here, contact, hand, 50)
    assert min(away_m(walls, place) for place in places) >= KEEP_M - SLACK_M
    assert abs(places[-1].real) == pytest.approx(0.75, abs=SLACK_M)
    assert places[-1].imag > 1.0
    assert abs(contacts[-1].real) == pytest.approx(1.0)


@HANDS
def test_round_the_end_of_a_thin_wall_a_disc_comes_back_on_the_other_side(hand):
    walls, here, contact = seen_by(hand, wall(-2, 0), -0.3 + 0.25j, -0.3 + 0j)
    places, _ = rolled(walls, here, contact, hand, 36)
    assert max(abs(away_m(walls, place) - KEEP_M) for place in places) <= SLACK_M
    assert places[-1].imag == pytest.approx(-0.25, abs=SLACK_M)
    assert abs(places[-1].real) > 0.3


@HANDS
def test_a_disc_that_is_too_near_comes_away_from_the_wall_while_it_goes(hand):
    walls, here, contact = seen_by(hand, wall(-2, 4), 0.12j, 0j)
    places, _ = rolled(walls, here, contact, hand, 30)
    gaps = [away_m(walls, place) for place in places]
    assert all(later >= before - 0.002 for before, later in pairwise(gaps))
    assert gaps[-1] == pytest.approx(KEEP_M, abs=SLACK_M)


def test_a_disc_that_sees_no_wall_goes_to_where_the_wall_was():
    way, contact = roll(0j, NOTHING, 0.6 + 0.8j, "left", KEEP_M, STEP_M)
    assert way == pytest.approx(STEP_M * (0.6 + 0.8j)) and contact == 0.6 + 0.8j


def test_a_disc_between_walls_that_are_too_near_goes_where_there_is_most_room():
    narrow = np.concatenate((wall(-1 + 0.1j, 1 + 0.1j), wall(-1 - 0.1j, 1 - 0.1j)))
    way, _ = roll(0j, narrow, 0.1j, "left", KEEP_M, STEP_M)
    assert abs(way) == pytest.approx(STEP_M) and abs(way.imag) < 1e-9


@pytest.mark.parametrize(
    ("place", "gap_m"), [(0.5 + 0.3j, 0.3), (-0.3 + 0.4j, 0.5), (1.6 - 0.8j, 1.0), (0.25 + 0j, 0.0)]
)
def test_the_clearance_of_a_way_is_the_distance_of_the_nearest_place_from_all_of_it(place, gap_m):
    far = np.array([place, 5 + 5j])
    assert clearance_m(far, 0j, 1 + 0j) == pytest.approx(gap_m)
    assert clearance_m(far, 1 + 0j, 0j) == pytest.approx(gap_m)


def test_of_no_way_the_clearance_is_that_of_its_place_and_of_nothing_infinite():
    assert clearance_m(np.array([3 + 4j]), 0j, 0j) == 5
    assert clearance_m(NOTHING, 0j, 1j) == math.inf
    assert nearest(NOTHING, 0j) is None
    assert nearest(np.array([3j, 1j, 2j]), 1.4j) == 1j


@pytest.mark.parametrize("degrees", [0.0, 1.0, 89.0, 135.0, 180.0, 225.0, 300.0, 359.0])
def test_angles_are_signed_and_less_than_a_whole_turn(degrees):
    """Source: specs of mission clear, 3.2 item 4: in [0, 2 pi), not the smaller angle of two lines."""
    first = cmath.rect(2.0, 0.7)
    turn = cmath.rect(0.3, math.radians(degrees))
    assert turn_rad(first, first * turn, "left") % math.tau == pytest.approx(math.radians(degrees))
    assert turn_rad(first, first / turn, "right") % math.tau == pytest.approx(math.radians(degrees))
    if degrees:
        assert turn_rad(first, first * turn, "right") == pytest.approx(math.tau - math.radians(degrees))


def test_a_way_that_is_cut_short_keeps_its_direction():
    assert shortened(3 + 4j, 1.0) == pytest.approx(0.6 + 0.8j)
    assert shortened(0.3 + 0.4j, 1.0) == 0.3 + 0.4j
    assert unit(-5j) == -1j and unit(0j) == 1


def in_a_row(*places: complex) -> bool:
    """Are three of some places on a straight line?"""
    return any(
        ((one - first) * (other - first).conjugate()).imag == 0
        for first, one, other in combinations(places, 3)
    )


@given(start=PLACES, ends=st.lists(PLACES, min_size=1, max_size=12), other=st.tuples(PLACES, PLACES))
def test_which_of_many_ways_cross_another_is_as_it_is_for_each_of_them(start, ends, other):
    ends = [end for end in ends if not in_a_row(start, end, *other)]
    assume(ends)
    expected = [crosses(start, end, *other) for end in ends]
    assert crossed(start, np.array(ends), *other).tolist() == expected


def test_ways_that_only_touch_do_not_cross():
    ends = np.array([1j, 2j, -1j, 1 + 2j, 2 + 1j, 0j])
    assert crossed(0j, ends, -1 + 1j, 1 + 1j).tolist() == [False, True, False, True, False, False]
