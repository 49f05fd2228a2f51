"""Algorithm 1 of the paper read to the letter leaks, and our reading does not: the exact referee says so.

Source: papers/pursuit-evasion.txt, Algorithm 1: `length(l) > (r_all) r_follow` begins a search. So many
robots have one gap less than they are.
"""

import numpy as np
import pytest

from deploy.studies.pursuit.literal import gap_m, leaks, longest_line_m, read_literally, room, widening
from world_server.referee import NOTHING_M2

FOLLOW_M, DETECT_M = 1.0, 0.7


@pytest.mark.parametrize(("robots", "stretched_m"), [(2, 2.0), (3, 1.5), (4, 4 / 3), (5, 1.25)])
def test_the_letter_stretches_small_teams_the_most_and_ours_none(robots, stretched_m):
    assert gap_m(robots, FOLLOW_M, literal=True) == pytest.approx(stretched_m)
    assert gap_m(robots, FOLLOW_M, literal=False) == FOLLOW_M
    assert leaks(robots, FOLLOW_M, DETECT_M, literal=True) == (robots in (2, 3))
    assert not leaks(robots, FOLLOW_M, DETECT_M, literal=False)


@pytest.mark.parametrize("robots", [2, 3])
def test_two_or_three_robots_lose_what_they_cleared_before_the_letter_lets_them_search(robots):
    """Everything behind them becomes contaminated at once, when neighbours are 2 r_detect apart."""
    team = widening(robots, FOLLOW_M, DETECT_M)
    ours, printed = (team.at(longest_line_m(robots, FOLLOW_M, literal)) for literal in (False, True))
    assert (team.lost_m2[: ours + 1] < NOTHING_M2).all() and team.contaminated_m2[ours] < room(robots).area
    opened = int(np.flatnonzero(team.lost_m2)[0])
    assert ours < opened <= printed
    one_step_m = team.gap_m[opened] - team.gap_m[opened - 1]
    assert team.gap_m[opened] == pytest.approx(2 * DETECT_M, abs=2 * one_step_m)
    seen_m2 = room(robots * FOLLOW_M).area - team.contaminated_m2[printed]
    assert seen_m2 <= robots * np.pi * DETECT_M**2, "nothing is clear but what they see"
    assert team.contaminated_m2[printed] > team.contaminated_m2[opened - 1]


def test_larger_teams_hold_even_so_but_have_little_overlap_left():
    team = read_literally(FOLLOW_M, DETECT_M).teams[2]
    assert team.robots == 4 and team.gap_m[-1] == pytest.approx(4 / 3, abs=0.02)
    assert (team.lost_m2 < NOTHING_M2).all()


def test_where_robots_see_further_the_letter_does_no_harm():
    assert not leaks(2, FOLLOW_M, 1.1, literal=True)
    assert (widening(2, FOLLOW_M, 1.1).lost_m2 < NOTHING_M2).all()
