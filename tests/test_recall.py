"""Algorithm 3: which robot is called home, line by line. b_l = 8.5 V, e = 0.1 V."""

from hypothesis import given
from hypothesis import strategies as st

from tower.recall import robot_to_recall

LOW_V, MARGIN_V = 8.5, 0.1


def recalled(*levels: float) -> int:
    """Place, from 1, of the recalled robot in the list; 0: nobody."""
    node = robot_to_recall({f"r{number}": one for number, one in enumerate(levels, 2)}, LOW_V, MARGIN_V)
    return int(node[1:]) - 1 if node else 0


def test_the_list_is_sorted_by_battery():
    """Source: papers/line-patrol.txt, Algorithm 3, line 1"""
    assert recalled(8.9, 8.8, 8.4) == 3


def test_only_the_first_three_count():
    """Source: papers/line-patrol.txt, Algorithm 3, line 2"""
    assert recalled(8.55, 8.58, 8.70, 8.71, 8.72) == recalled(8.55, 8.58, 8.70) == 1


def test_the_lower_threshold_itself_is_not_below_it():
    """Source: papers/line-patrol.txt, Algorithm 3, line 3"""
    assert recalled(8.5, 8.9, 8.9) == 0
    assert recalled(8.4999, 8.9, 8.9) == 1


def test_below_the_lower_threshold_the_first_goes_however_near_the_others_are():
    """Source: papers/line-patrol.txt, Algorithm 3, line 4"""
    assert recalled(8.49, 8.50, 8.51) == 1


def test_at_the_upper_threshold_nobody_goes():
    """Source: papers/line-patrol.txt, Algorithm 3, line 5"""
    assert recalled(8.6, 8.61, 8.62) == 0
    assert recalled(8.5999, 8.61, 8.62) == 2


def test_the_second_battery_decides():
    """Source: papers/line-patrol.txt, Algorithm 3, line 6"""
    assert (recalled(8.52, 8.53, 8.9), recalled(8.52, 8.88, 8.9)) == (1, 0)


def test_a_second_one_half_a_margin_away_is_not_near():
    """Source: papers/line-patrol.txt, Algorithm 3, line 7"""
    assert recalled(8.5, 8.5 + MARGIN_V / 2, 8.56) == 0
    assert recalled(8.5, 8.5499, 8.9) == 1


def test_a_third_one_half_a_margin_away_is_not_near():
    """Source: papers/line-patrol.txt, Algorithm 3, line 8"""
    assert recalled(8.5, 8.5, 8.5 + MARGIN_V / 2) == 1


def test_of_three_near_ones_the_second_goes():
    """Source: papers/line-patrol.txt, Algorithm 3, line 9"""
    assert recalled(8.51, 8.55, 8.59) == 2


def test_of_two_near_ones_the_first_goes():
    """Source: papers/line-patrol.txt, Algorithm 3, line 11"""
    assert recalled(8.51, 8.55, 8.61) == 1


def test_equal_batteries_stand_in_order_of_node_number():
    """Source: none; the paper says nothing of ties."""
    assert robot_to_recall({"r10": 8.5, "r9": 8.5, "r2": 8.5}, LOW_V, MARGIN_V) == "r9"


def test_fewer_than_three_robots():
    """Source: none; where a battery is missing, it is not near."""
    assert (recalled(), recalled(8.4), recalled(8.55), recalled(8.7)) == (0, 1, 0, 0)
    assert (recalled(8.55, 8.56), recalled(8.55, 8.65), recalled(8.4, 8.41)) == (1, 0, 1)


levels_v = st.lists(st.floats(8.3, 9.0), max_size=8)


@given(levels_v, st.randoms())
def test_the_order_in_which_batteries_are_told_is_irrelevant(levels, chance):
    known = [(f"r{number}", level) for number, level in enumerate(levels, 2)]
    once = robot_to_recall(dict(known), LOW_V, MARGIN_V)
    chance.shuffle(known)
    assert robot_to_recall(dict(known), LOW_V, MARGIN_V) == once


@given(levels_v)
def test_who_is_recalled_is_one_of_the_two_lowest_and_below_both_thresholds_and_a_margin(levels):
    place = recalled(*levels)
    if place:
        lowest = sorted(levels)
        assert levels[place - 1] in lowest[:2]
        assert lowest[0] < LOW_V + MARGIN_V
        assert levels[place - 1] < LOW_V + 1.5 * MARGIN_V
    else:
        assert not levels or min(levels) >= LOW_V
