"""The referees against areas that can be worked out by hand: one robot or two in a straight corridor.

Both judge; the raster one is coarser, so that its tolerance is that of its cells.
"""

import math
from functools import partial

import numpy as np
import pytest
import shapely

from deploy.plan_file import PLANS, load_plan
from world_server import chance
from world_server.raster_referee import RasterReferee
from world_server.referee import NOTHING_M2, Referee, Verdict, Watch

DETECT_M = 0.7
LENS_M = 0.6348  # integral of sqrt(0.49 - u^2) from -1/2 to 1/2
CORRIDOR = shapely.box(0, 0, 10, 1)
FINE, COARSE = partial(RasterReferee, cell_m=0.02), partial(RasterReferee, cell_m=0.05)
EXACT_AND_COARSE = pytest.mark.parametrize(
    ("referee", "within_m2"), [(Referee, 0.005), (COARSE, 0.08)], ids=["exact", "coarse"]
)
EXACT_AND_FINE = pytest.mark.parametrize(
    ("referee", "within_m2"), [(Referee, 0.005), (FINE, 0.03)], ids=["exact", "fine"]
)


def steps(start_m: float, end_m: float, by_m: float = 0.05) -> list[float]:
    """From start to end in equal steps, the last one shorter."""
    return [*(start_m + by_m * number for number in range(math.ceil((end_m - start_m) / by_m - 1e-9))), end_m]


class Team:
    """Robots abreast, driven along x under a referee."""

    def __init__(self, referee, plan, start_m, ys_m):
        self.places_m = [(start_m, y_m) for y_m in ys_m]
        self.alive = [True] * len(ys_m)
        self.referee = referee(plan, DETECT_M, self.places_m, self.alive)

    def to(self, places_m, alive=None) -> Verdict:
        alive = alive or self.alive
        verdict = self.referee.step(self.places_m, places_m, self.alive, alive)
        self.places_m, self.alive = places_m, alive
        return verdict

    def drive(self, way_m) -> list[Verdict]:
        return [self.to([(x_m, y_m) for _, y_m in self.places_m]) for x_m in way_m[1:]]


def driven(referee, plan=CORRIDOR, start_m=0.35, ys_m=(0.5,)) -> tuple[Team, list[Verdict]]:
    way_m = steps(start_m, 5.0)
    team = Team(referee, plan, start_m, ys_m)
    return team, team.drive(way_m)


@EXACT_AND_COARSE
def test_a_robot_clears_a_narrow_corridor_behind_it(referee, within_m2):
    _, verdicts = driven(referee)
    assert verdicts[-1].contaminated_m2 == pytest.approx(5 - LENS_M, abs=within_m2)
    assert all(verdict.recontaminated_m2 < NOTHING_M2 for verdict in verdicts)
    assert not any(verdict.cleared for verdict in verdicts)


@EXACT_AND_COARSE
def test_at_the_end_of_the_corridor_all_is_clear_and_stays_so(referee, within_m2):
    team, _ = driven(referee)
    assert team.drive(steps(5.0, 9.65))[-1].cleared
    assert team.to(team.places_m, [False]).contaminated_m2 == 0


@EXACT_AND_COARSE
def test_when_the_robot_is_killed_everything_is_lost_at_once(referee, within_m2):
    team, _ = driven(referee)
    verdict = team.to(team.places_m, [False])
    assert verdict.contaminated_m2 == pytest.approx(10.0, abs=1e-6)
    assert verdict.recontaminated_m2 == pytest.approx(5 + LENS_M, abs=within_m2)
    assert verdict.given_up_m2 == pytest.approx(2 * LENS_M, abs=2 * within_m2)
    assert verdict.breached_m2 == pytest.approx(5 - LENS_M, abs=within_m2)


@EXACT_AND_COARSE
def test_who_jumps_has_watched_nothing(referee, within_m2):
    team, _ = driven(referee)
    verdict = team.to([(7.0, 0.5)])
    assert verdict.contaminated_m2 == pytest.approx(10 - 2 * LENS_M, abs=2 * within_m2)


@EXACT_AND_FINE
@pytest.mark.parametrize(("step_m", "left_m2"), [(0.3, 4.066), (0.9, 3.466), (1.0, 8.732)])
def test_one_long_step_holds_as_long_as_what_is_seen_throughout_spans_the_corridor(
    referee, within_m2, step_m, left_m2
):
    """The lens seen from both ends is 0.536 m high on each side for 0.9 m, 0.490 m for 1.0 m.

    Coarse cells shorten the range by so much that they lose the corridor at 0.9 m.
    """
    team, _ = driven(referee)
    assert team.to([(5 + step_m, 0.5)]).contaminated_m2 == pytest.approx(left_m2, abs=2 * within_m2)


@EXACT_AND_COARSE
def test_in_a_corridor_wider_than_a_robot_sees_it_clears_nothing_behind_it(referee, within_m2):
    _, verdicts = driven(referee, shapely.box(0, 0, 10, 1.45), ys_m=(0.725,))
    seen_m2 = math.pi * DETECT_M**2
    assert verdicts[-1].contaminated_m2 == pytest.approx(14.5 - seen_m2, abs=2 * within_m2)
    assert all(verdict.breached_m2 < NOTHING_M2 for verdict in verdicts), "it only gives up what it saw"


@EXACT_AND_COARSE
@pytest.mark.parametrize(("gap_m", "left_m2"), [(1.25, 7.671), (1.30, 7.907)])
def test_two_abreast_hold_a_line(referee, within_m2, gap_m, left_m2):
    _, verdicts = driven(referee, shapely.box(0, 0, 10, gap_m + 0.5), 0.05, (0.25, 0.25 + gap_m))
    assert verdicts[-1].contaminated_m2 == pytest.approx(left_m2, abs=2 * within_m2)


@pytest.mark.parametrize(("gap_m", "left_m2"), [(1.34, 8.097), (1.36, 8.194)])
def test_two_abreast_hold_a_line_up_to_twice_their_range(gap_m, left_m2):
    """Cells of a raster are too coarse for a barrier so thin."""
    _, verdicts = driven(Referee, shapely.box(0, 0, 10, gap_m + 0.5), 0.05, (0.25, 0.25 + gap_m))
    assert verdicts[-1].contaminated_m2 == pytest.approx(left_m2, abs=0.002)


@EXACT_AND_COARSE
def test_two_abreast_beyond_twice_their_range_hold_nothing(referee, within_m2):
    _, verdicts = driven(referee, shapely.box(0, 0, 10, 1.95), 0.05, (0.25, 1.7))
    assert verdicts[-1].contaminated_m2 == pytest.approx(17.279, abs=3 * within_m2)


@EXACT_AND_COARSE
def test_a_pocket_behind_the_first_line_undoes_it(referee, within_m2):
    """Started 0.35 m from the end with a gap of 1.35 m, the middle of the end wall was never seen."""
    _, verdicts = driven(referee, shapely.box(0, 0, 10, 1.85), 0.35, (0.25, 1.6))
    assert verdicts[-1].contaminated_m2 == pytest.approx(16.29, abs=3 * within_m2)


def test_a_way_through_a_wall_or_round_an_island_is_a_jump():
    wall, pillar = shapely.box(3, 0, 3.1, 0.6), shapely.box(6.4, 0.5, 6.6, 0.52)
    watch = Watch(CORRIDOR.difference(shapely.union_all([wall, pillar])))
    assert watch.unbroken((2.0, 0.5), (2.01, 0.5))
    assert watch.unbroken((2.0, 0.5), (2.0, 0.5))
    assert not watch.unbroken((2.995, 0.5), (3.105, 0.5)), "through the wall"
    assert not watch.unbroken((6.5, 0.6), (6.53, 0.6)), "as far as the pillar is wide"
    assert Watch(CORRIDOR).unbroken((2.0, 0.5), (9.0, 0.5)), "where nothing can be gone around"


def test_both_referees_agree_on_the_cave():
    """Twelve robots go about; cells of 5 cm make discs smaller by 3.6 cm all around, and no more."""
    cave = load_plan(PLANS / "cave.wkt", None, 0.25, DETECT_M)
    within, draw = cave.buffer(-0.25), chance.generator(1, "walk")
    points_m = draw.uniform(0, 14.6, (200, 2))
    places_m = [tuple(place) for place in points_m[shapely.contains_xy(within, points_m)][:12].tolist()]
    alive = [True] * 12
    exact, coarse = Referee(cave, DETECT_M, places_m, alive), COARSE(cave, DETECT_M, places_m, alive)
    for _ in range(10):
        ahead_m = np.array(places_m) + draw.normal(0, 0.03, (12, 2))
        moves = shapely.contains_xy(within, ahead_m)
        later_m = [
            tuple(ahead) if free else place
            for place, ahead, free in zip(places_m, ahead_m.tolist(), moves, strict=True)
        ]
        areas_m2 = [one.step(places_m, later_m, alive, alive).contaminated_m2 for one in (exact, coarse)]
        places_m = later_m
        smaller_discs_m2 = 12 * 2 * math.pi * DETECT_M * 0.036
        assert -0.3 < areas_m2[1] - areas_m2[0] < smaller_discs_m2


@EXACT_AND_COARSE
def test_round_a_corner_a_robot_watches_only_what_it_sees_from_there_too(referee, within_m2):
    """Both ends of its way see the whole width of the corridor; its corner is too far from the other wall."""
    team, _ = driven(referee)
    alive = [True]
    held = team.referee.step([(5.0, 0.5)], [(5.0, 0.5)], alive, alive, [((5.05, 0.55),)])
    assert held.recontaminated_m2 < NOTHING_M2
    lost = team.referee.step([(5.0, 0.5)], [(5.0, 0.5)], alive, alive, [((5.05, 0.95),)])
    assert lost.contaminated_m2 == pytest.approx(10 - 2 * LENS_M, abs=2 * within_m2)
    assert lost.given_up_m2 < NOTHING_M2


@EXACT_AND_COARSE
def test_a_way_with_a_corner_in_a_wall_is_a_jump(referee, within_m2):
    team, _ = driven(referee)
    lost = team.referee.step([(5.0, 0.5)], [(5.0, 0.5)], [True], [True], [((5.0, 1.1),)])
    assert lost.contaminated_m2 == pytest.approx(10 - 2 * LENS_M, abs=2 * within_m2)


def test_what_the_raster_draws_is_its_contaminated_cells():
    """Also where a column of cells is contaminated in several pieces, and where nothing is."""
    team, _ = driven(COARSE, shapely.box(0, 0, 10, 1.45), ys_m=(0.725,))
    shape = team.referee.shape
    assert shape.area == pytest.approx(team.referee.verdict.contaminated_m2)
    assert shapely.intersects_xy(shape, [1.0, 5.0, 5.0], [0.7, 0.02, 1.43]).all()
    assert not shapely.intersects_xy(shape, 5.0, 0.725)
    alone = COARSE(shapely.box(0, 0, 0.8, 0.8), DETECT_M, [(0.4, 0.4)], [True])
    assert alone.shape.is_empty and alone.verdict.cleared
