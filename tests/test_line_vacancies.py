"""Vacancies and recovery of a line patrol. Source: papers/line-patrol.txt, section III-B: T to 3 T."""

import pytest

from tests.line_facts import DEPLOYED, LEFT, MID, R3_DEAD, R3_FLAT, RIGHT, fed, patrol, visits
from wire.messages import Fault

NO_SPAN = {"min": None, "median": None, "max": None, "count": 0}


def test_a_vacancy_lasts_until_one_robot_has_traversed_the_segment_whole():
    """Source: section III-B: T in the best case; the lap is complete another T later."""
    fold = fed(
        DEPLOYED,
        (20, {"r2": ("home", 0, 1)}, visits(("r2", 1, LEFT))),
        (25, {"r4": ("out", 1, 0)}, visits(("r2", 1, MID))),
        (30, {}, visits(("r2", 1, RIGHT))),
        (33, patrol(r4=1), visits(("r4", 1, RIGHT))),
        (38, {}, visits(("r4", 1, MID))),
        (43, {}, visits(("r4", 1, LEFT), ("r4", 1, LEFT))),
        (48, {}, visits(("r4", 1, MID))),
        (53, {}, visits(("r4", 1, RIGHT), ("r4", 1, RIGHT))),
    )
    (vacancy,) = fold.vacancies
    assert (vacancy.segment, vacancy.cause, vacancy.began_tick) == (1, "recall", 20)
    assert (vacancy.covered_tick, vacancy.lap_tick, vacancy.filled_by) == (43, 53, "r4")
    assert fold.summary()["recovery_s"] == {"min": 23, "median": 23, "max": 23, "count": 1}
    assert fold.summary()["recovery_full_lap_s"] == {"min": 33, "median": 33, "max": 33, "count": 1}


def test_turning_at_the_middle_or_two_halves_of_two_robots_are_no_traverse():
    """Source: none; one end, the middle, the other end, one robot."""
    fold = fed(
        DEPLOYED,
        (20, {"r2": ("home", 0, 0)}),
        (25, patrol(r4=1, r3=1), visits(("r4", 1, LEFT))),
        (26, {}, visits(("r4", 1, MID))),
        (27, {}, visits(("r4", 1, LEFT))),
        (30, {}, visits(("r4", 1, MID), ("r3", 1, RIGHT))),
        (35, {}, visits(("r3", 1, LEFT))),
    )
    assert fold.vacancies[0].covered_tick is None
    assert fold.summary()["recovery_s"] == NO_SPAN
    fed((40, {}, visits(("r4", 1, RIGHT))), fold=fold)
    assert fold.summary()["recovery_s"] == {"min": 20, "median": 20, "max": 20, "count": 1}


@pytest.mark.parametrize(
    ("befalls", "cause"),
    [
        ((20, {"r3": ("home", 0, 0)}), "recall"),
        ((20, {"r3": ("out", 1, 0)}), "shift"),
        ((20, patrol(r3=1)), "shift"),
        ((20, {}, {"modes": R3_DEAD}), "death"),
        ((20, {}, {"modes": R3_DEAD, "faults": (Fault(20, "kill", "r3"),)}), "death"),
        ((20, {}, {"faults": (Fault(20, "kill", "r3"), Fault(20, "restart", "r3"))}), "death"),
        ((20, {}, {"modes": R3_FLAT}), "flat"),
        ((20, patrol(r3=2), {"modes": R3_FLAT}), "flat"),
    ],
)
def test_a_segment_is_vacant_when_its_robot_leaves_dies_or_goes_flat(befalls, cause):
    """Source: Algorithm 2, lines 6, 7 and 14: by recall or shift; by failure."""
    fold = fed(DEPLOYED, befalls)
    assert [(one.segment, one.cause, one.began_tick) for one in fold.vacancies] == [(2, cause, 20)]
    assert fold.summary()["flat_robots"] == (cause == "flat")


def test_no_vacancy_where_another_robot_patrols():
    """Source: section III-A, leap-frog: two robots may be on a segment for a short time."""
    fold = fed(DEPLOYED, (10, patrol(r4=1)), (20, {"r2": ("home", 0, 0)}))
    fed((30, {"r4": ("home", 0, 0)} | patrol(r2=1)), fold=fold)
    assert fold.vacancies == []


def test_while_a_vacancy_is_open_no_other_begins_and_afterwards_one_does():
    """Source: none; the replacement that dies too early does not make two vacancies of one."""
    whole = [(one, {}, visits(("r4", 1, place))) for one, place in ((50, LEFT), (55, MID), (60, RIGHT))]
    fold = fed(
        DEPLOYED,
        (20, {"r2": ("home", 0, 0)}),
        (30, patrol(r4=1)),
        (35, {"r4": ("home", 0, 0)}),
        (45, patrol(r4=1)),
        *whole,
        (70, {"r4": ("home", 0, 0)}),
    )
    assert [(one.began_tick, one.covered_tick) for one in fold.vacancies] == [(20, 60), (70, None)]
    assert fold.summary()["recovery_s"]["count"] == 1


@pytest.mark.parametrize(
    "says", [("home", 1, 0), ("home", 0, 0), ("out", 2, 0), ("patrol", 2, 1), ("queue", 1, 0)]
)
def test_who_only_passes_covers_nothing(says):
    """Source: none; a robot on the passing lane, on its way to elsewhere, is gone the next moment."""
    passing = [(30 + 5 * place, {}, visits(("r3", 1, place))) for place in (RIGHT, MID, LEFT)]
    fold = fed(DEPLOYED, (20, {"r2": ("home", 0, 0)}), (25, {"r3": says}), *passing)
    assert fold.vacancies[0].covered_tick is None


def test_who_is_still_on_the_way_to_the_segment_begins_to_cover_it_as_it_arrives():
    """Source: none; the word that it patrols may come after the visit of the end at which it arrived."""
    fold = fed(
        DEPLOYED,
        (20, {"r2": ("home", 0, 0)}),
        (25, {"r4": ("out", 1, 0)}),
        (30, {}, visits(("r4", 1, RIGHT))),
        (31, patrol(r4=1)),
        (35, {}, visits(("r4", 1, MID))),
        (40, {}, visits(("r4", 1, LEFT))),
    )
    assert (fold.vacancies[0].covered_tick, fold.vacancies[0].filled_by) == (40, "r4")
