"""LR-PT: where robots go. Equations of Kobayashi et al. 2025."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_agent.behaviours.lr_pt import LrPtParameters
from tests.builders import CENTRE_0, chosen, from_robot, from_tower, percept, robot, visited
from wire.fields import Grid
from wire.messages import Sighting

# Equations 10 and 11


def test_utility_is_alpha_times_idleness_and_travel_over_travel():
    """Source: equations 11a and 11b, by hand for one cell."""
    one = robot(team_size=10)  # p_M = 703, sigma = 304
    one.priority_s = 103.0
    visited(one, s21=940)  # cell 21 is column 1, row 1: its centre is (45, 45)
    pose = percept(1000, 45.0, 15.0).senses.pose
    travel_s = 30.0 / 1.5
    alpha = math.exp(-((45.0 - 600.0) ** 2) / (2 * 304.0**2))
    assert one.utilities(1000, pose)[21] == pytest.approx(alpha * (60 + travel_s) / travel_s)


def test_alpha_prefers_cells_at_the_chebyshev_distance_of_the_remaining_priority():
    """Source: equation 11b and its figure: p_M = 600 s, sigma = 200 m."""
    one = robot(report_priority_max_s=600.0, spread_m=200.0, search_radius_m=2000.0)
    pose = percept(0, -1e9, 0.0).senses.pose  # so far away that travel outweighs idleness: utility is alpha
    one.parameters = LrPtParameters(report_priority_max_s=600.0, spread_m=200.0, search_radius_m=1e12)
    at = dict(zip(map(tuple, one.centres_m.tolist()), one.utilities(0, pose), strict=True))
    assert at[585.0, 15.0] == pytest.approx(math.exp(-(15.0**2) / 80000), abs=1e-6)
    assert at[15.0, 15.0] == pytest.approx(math.exp(-(585.0**2) / 80000), abs=1e-6)
    assert at[405.0, 15.0] == at[15.0, 405.0] == at[405.0, 405.0]
    one.priority_s = 600.0  # the full duty to report: near the tower
    near = dict(zip(map(tuple, one.centres_m.tolist()), one.utilities(0, pose), strict=True))
    assert max(near.values()) == near[15.0, 15.0] == pytest.approx(math.exp(-(15.0**2) / 80000), abs=1e-6)


def test_the_goal_is_the_cell_of_largest_utility():
    """Source: equation 10."""
    one = robot(search_radius_m=2000.0, report_priority_max_s=600.0, spread_m=1e6)
    visited(one, **{f"s{site}": 999 for site in range(400) if site != 250})
    assert chosen(one)[0] == 250


def test_cells_beyond_the_search_radius_are_no_goals_and_the_radius_itself_is_inside():
    """Source: equation 10, delta = 180 m."""
    one = robot(spread_m=1e6)
    utility = one.utilities(1000, percept(1000, *CENTRE_0).senses.pose)
    away = np.hypot(*(one.centres_m - CENTRE_0).T)
    assert (np.isfinite(utility) == (away <= 180.0)).all()
    assert np.isfinite(utility[6])  # six cells of 30 m


def test_the_cell_just_completed_is_no_candidate():
    """Source: our specification of equation 10."""
    one = robot(spread_m=1e6)
    visited(one, **{f"s{site}": 1000 for site in range(400)})
    assert chosen(one, completed=0)[0] != 0


def test_equal_utilities_are_decided_by_the_generator_of_the_node():
    """Source: equation 10; the tie is our choice: at random among the best."""
    goals = {chosen(robot(seed=seed), tick=0, completed=None)[0] for seed in range(30)}
    assert len(goals) > 1
    assert chosen(robot(seed=7), tick=0) == chosen(robot(seed=7), tick=0)


def test_with_no_cell_in_reach_the_nearest_other_cell_is_the_goal():
    """Source: none; a search radius smaller than a cell must not stop a robot."""
    assert chosen(robot(search_radius_m=5.0), completed=0)[0] in (1, 20)


def test_the_target_is_the_next_cell_in_the_direction_of_the_goal():
    """Source: section IV-C, temporary target; rounding to 45 degrees is our choice."""
    one = robot()
    centre = 10 * 20 + 10
    assert one.on_the_way(centre, 19 * 20 + 10) == 11 * 20 + 10
    assert one.on_the_way(centre, 10 * 20) == 10 * 20 + 9
    assert one.on_the_way(centre, 15 * 20 + 15) == 11 * 20 + 11
    assert one.on_the_way(centre, 15 * 20 + 12) == 11 * 20 + 10  # 21.8 degrees
    assert one.on_the_way(centre, 14 * 20 + 12) == 11 * 20 + 11  # 26.6 degrees
    assert one.on_the_way(centre, 11 * 20 + 9) == 11 * 20 + 9


@given(st.data())
def test_a_step_on_the_way_stays_in_the_grid_and_comes_strictly_nearer(data):
    """Source: section IV-C."""
    field = Grid(data.draw(st.integers(1, 30)), data.draw(st.integers(1, 30)))
    cells = st.tuples(st.integers(0, field.columns - 1), st.integers(0, field.rows - 1))
    (here_x, here_y), (goal_x, goal_y) = data.draw(cells), data.draw(cells)
    step = robot(field=field).on_the_way(here_x * field.rows + here_y, goal_x * field.rows + goal_y)
    x, y = divmod(step, field.rows)
    assert 0 <= x < field.columns
    assert max(abs(x - here_x), abs(y - here_y)) <= 1
    before = max(abs(goal_x - here_x), abs(goal_y - here_y))
    assert max(abs(goal_x - x), abs(goal_y - y)) == max(0, before - 1)


def test_the_first_target_starts_from_the_cell_in_which_the_robot_stands():
    """Source: our choice; at the start no cell has been completed."""
    one = robot()
    one.step(percept(0, 100.0, 100.0), [])  # cell (3, 3)
    column, row = divmod(one.target, 20)
    assert max(abs(column - 3), abs(row - 3)) <= 1


# Lock breakers


def lonely(name: str = "r2", breaker: str = "none", **parameters):
    """A robot at cell (10, 10) to which (12, 10) looks best, then (10, 12), then nothing much."""
    one = robot(name, lock_breaker=breaker, spread_m=1e6, **parameters)
    visited(one, **{f"s{site}": 1000 for site in range(400)})
    one.knowledge.visited_tick[12 * 20 + 10] = 0
    one.knowledge.visited_tick[10 * 20 + 12] = 100
    return one


HERE = 10 * 20 + 10
AT = (315.0, 315.0)
EAST, NORTH = (12 * 20 + 10, 11 * 20 + 10), (10 * 20 + 12, 10 * 20 + 11)


def test_without_a_lock_breaker_announced_goals_are_ignored():
    """Source: equation 10 as printed."""
    heard = [from_robot("r3", 999, goal=EAST[0], target=EAST[1])]
    assert chosen(lonely(), at=AT, heard=heard, completed=HERE) == EAST


def test_excl_skips_the_goals_that_neighbours_announced():
    """Source: our option lock_breaker."""
    heard = [from_robot("r3", 999, goal=EAST[0], target=EAST[1])]
    assert chosen(lonely(breaker="excl"), at=AT, completed=HERE) == EAST
    assert chosen(lonely(breaker="excl"), at=AT, heard=heard, completed=HERE) == NORTH


def test_excl_falls_back_to_the_best_goal_when_all_are_announced():
    """Source: our option lock_breaker."""
    heard = [from_robot("r3", 999, goal=site) for site in range(400)]
    assert chosen(lonely(breaker="excl"), at=AT, heard=heard, completed=HERE) == EAST


def test_excl_ignores_goals_that_are_no_cells():
    """Source: none; a neighbour may say anything."""
    heard = [from_robot("r3", 999, goal=goal) for goal in (-1, 400, 10**9)]
    assert chosen(lonely(breaker="excl"), at=AT, heard=heard, completed=HERE) == EAST


def test_exclnext_takes_the_best_goal_whose_next_cell_is_no_neighbours_target():
    """Source: our option lock_breaker."""
    same_goal = [from_robot("r3", 999, goal=EAST[0], target=0)]
    same_step = [from_robot("r3", 999, goal=0, target=EAST[1])]
    assert chosen(lonely(breaker="exclnext"), at=AT, heard=same_goal, completed=HERE) == EAST
    assert chosen(lonely(breaker="exclnext"), at=AT, heard=same_step, completed=HERE) == NORTH


def test_exclnext_falls_back_to_the_best_goal_when_all_steps_are_taken():
    """Source: our option lock_breaker."""
    around = [HERE + dx * 20 + dy for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
    heard = [from_robot("r3", 999, target=site) for site in around]
    assert chosen(lonely(breaker="exclnext"), at=AT, heard=heard, completed=HERE) == EAST


@pytest.mark.parametrize(
    ("seen", "expected"),
    [
        ((), EAST),
        ((Sighting("r3", 315.0, 345.0),), NORTH),
        ((Sighting("r3", 315.0, 345.1),), EAST),
        ((Sighting("r9", 315.0, 315.0),), EAST),
        ((Sighting("r1", 315.0, 315.0),), EAST),
    ],
    ids=["alone", "lower at 30 m", "lower beyond", "higher", "tower"],
)
def test_rank_gives_way_to_lower_numbered_robots_within_30_m(seen, expected):
    """Source: our option lock_breaker: with q of them, the (q + 1)-th best distinct step."""
    one = lonely("r4", "rank")
    assert chosen(one, at=AT, completed=HERE, in_sight=seen) == expected


def test_announcements_are_made_of_the_choice_of_this_tick():
    """Source: our option lock_breaker; Algorithm 2, line 18: (p, omega) goes with it."""
    one = robot()
    (said,) = one.step(percept(3), [from_tower(2)]).say
    assert said.message.goal == one.goal
    assert said.message.target == one.target
    assert (said.message.priority_s, said.message.contact_tick) == (0.0, 3)
