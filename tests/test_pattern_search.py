"""The pattern search: it finds what is least, within its bounds and its budget, and asks nothing twice."""

import math
from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from deploy.pattern_search import Axis, search

QUARTER, HUNDREDTH = Fraction(1, 4), Fraction(1, 100)
PLENTY = 10_000

decimals = st.decimals(-50, 50, places=2).map(Fraction)


class Asked:
    """A function that remembers what it was asked, sweep by sweep."""

    def __init__(self, function):
        self.function = function
        self.sweeps = []

    def __call__(self, points):
        self.sweeps.append(points)
        return [self.function(point) for point in points]

    @property
    def points(self):
        return [point for sweep in self.sweeps for point in sweep]


@st.composite
def axis(draw, whole=st.booleans()):
    """Any axis; whole ones have whole bounds and starts."""
    is_whole = draw(whole)
    numbers = st.integers(-50, 50).map(Fraction) if is_whole else decimals
    low, start, high = sorted(draw(st.lists(numbers, min_size=3, max_size=3)))
    return Axis(start, low, high + 1, is_whole)


def bowl(centre, weights):
    """A quadratic bowl, least at its centre."""
    return lambda point: float(
        sum(weight * (at - middle) ** 2 for at, middle, weight in zip(point, centre, weights, strict=True))
    )


def rough(point):
    """As uneven as can be; every third point or so is refused."""
    return float(hash(point) % 7) if hash(point) % 3 else math.inf


def least(values):
    return min(values, key=values.get)


@st.composite
def bowls(draw, whole=st.booleans()):
    """Axes and a bowl over them, whose centre may lie beyond the bounds."""
    axes = draw(st.lists(axis(whole), min_size=1, max_size=3))
    centre = [draw(decimals) for _ in axes]
    weights = [draw(st.integers(1, 5)) for _ in axes]
    return axes, centre, weights


@given(bowls(whole=st.just(False)))
def test_the_bottom_of_a_bowl_is_found_to_the_last_step(drawn):
    """Half the last step at most is between the result and the bottom, or the bound before it."""
    axes, centre, weights = drawn
    found = least(search(axes, Asked(bowl(centre, weights)), QUARTER, HUNDREDTH, PLENTY))
    last_step = Fraction(1, 64)
    for at, middle, one in zip(found, centre, axes, strict=True):
        bottom = min(max(middle, one.low), one.high)
        assert abs(at - bottom) <= last_step * (one.high - one.low) / 2 + Fraction(1, 10**6)


@given(bowls(whole=st.just(True)))
def test_of_whole_numbers_the_very_best_is_found(drawn):
    axes, centre, weights = drawn
    function = bowl(centre, weights)
    found = least(search(axes, Asked(function), QUARTER, HUNDREDTH, PLENTY))
    best = [
        min(range(int(one.low), int(one.high) + 1), key=lambda at, middle=middle: abs(at - middle))
        for one, middle in zip(axes, centre, strict=True)
    ]
    assert function(found) == function(tuple(map(Fraction, best)))


@given(bowls(), st.integers(1, 60), st.sampled_from([QUARTER, Fraction("0.3"), Fraction(1)]), st.data())
def test_bounds_and_budget_are_kept_and_nothing_is_asked_twice(drawn, budget, step, data):
    """Whatever the function, refusals included."""
    axes, centre, weights = drawn
    function = data.draw(st.sampled_from([bowl(centre, weights), rough, lambda point: 1.0]))
    asked = Asked(function)
    values = search(axes, asked, step, HUNDREDTH, budget)
    assert 1 <= len(asked.points) <= budget
    assert all(asked.sweeps), "no sweep of nothing"
    assert list(values.items()) == [(point, function(point)) for point in asked.points]
    assert len({tuple(map(float, point)) for point in asked.points}) == len(asked.points)
    assert asked.points[0] == tuple(one.start for one in axes)
    for point in asked.points:
        for at, one in zip(point, axes, strict=True):
            assert one.low <= at <= one.high
            assert at.denominator == 1 or not one.whole


@given(bowls(), st.integers(1, 20), st.integers(1, 40))
def test_a_larger_budget_goes_on_where_a_smaller_one_ended(drawn, some, more):
    axes, centre, weights = drawn
    function = bowl(centre, weights)
    short = search(axes, Asked(function), QUARTER, HUNDREDTH, some)
    long = search(axes, Asked(function), QUARTER, HUNDREDTH, some + more)
    assert list(long)[: len(short)] == list(short)


def test_on_a_plateau_it_stays_and_ends_with_the_smallest_step():
    """Five steps are at least a hundredth: 1/4, 1/8, 1/16, 1/32, 1/64; each has two neighbours."""
    asked = Asked(lambda point: 7.0)
    values = search([Axis(Fraction(5), Fraction(0), Fraction(10))], asked, QUARTER, HUNDREDTH, PLENTY)
    assert [len(sweep) for sweep in asked.sweeps] == [1, 2, 2, 2, 2, 2]
    assert least(values) == (5,)


def test_all_neighbours_of_a_point_are_one_sweep():
    """The first sweep of three axes is the start, the second its six neighbours, a step down and up each."""
    asked = Asked(lambda point: 0.0)
    search([Axis(Fraction(4), Fraction(0), Fraction(8))] * 3, asked, QUARTER, QUARTER, PLENTY)
    around = [(2, 4, 4), (6, 4, 4), (4, 2, 4), (4, 6, 4), (4, 4, 2), (4, 4, 6)]
    assert asked.sweeps == [[(4, 4, 4)], around]


def test_it_goes_to_the_best_neighbour_and_not_to_the_first_better_one():
    asked = Asked(lambda point: float(-point[0] - 3 * point[1]))
    search([Axis(Fraction(4), Fraction(0), Fraction(8))] * 2, asked, QUARTER, QUARTER, 8)
    assert asked.sweeps[2] == [(2, 6), (6, 6), (4, 8)]


def test_what_is_refused_is_not_gone_to_and_does_not_end_the_search():
    """The bottom is at 8; 6, a step from the start, is refused: a smaller step comes to 5 and stays."""
    asked = Asked(lambda point: math.inf if point[0] == 6 else float(8 - point[0]))
    axis = Axis(Fraction(4), Fraction(0), Fraction(8), whole=True)
    values = search([axis], asked, QUARTER, HUNDREDTH, PLENTY)
    assert asked.points == [(4,), (2,), (6,), (3,), (5,)]
    assert least(values) == (5,)


def test_decimal_steps_come_back_to_the_very_same_point():
    """0.1 + 0.2 - 0.2 is 0.1 here, which it is not in floating-point numbers."""
    start = Fraction("0.1")
    asked = Asked(lambda point: {start: 1.0, Fraction("0.3"): 0.0}.get(point[0], 2.0))
    search([Axis(start, Fraction(0), Fraction(1))], asked, Fraction("0.2"), Fraction("0.2"), PLENTY)
    assert asked.points == [(start,), (0,), (Fraction("0.3"),), (Fraction("0.5"),)]
