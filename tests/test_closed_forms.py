"""The overlapping patrol against its closed forms, noise off, without drain.

Source: papers/line-patrol.txt, Algorithm 1 and section III-B, worked out: with m = min(j, o) robots over
segment j, T for one segment and c for one turn,

    mean interval: (o T + c) / m, so the frequency is m / (o T + c)
    longest gap at fraction x of the segment: max(2 (o - m) T + (2 - 2x) T + c, 2x T + c)
    variance for j >= o, c = 0: T^2 (1 - 2x)^2 / o
"""

from itertools import pairwise
from math import pi
from pathlib import Path

import numpy as np
import pytest

from tests.builders import course, scenario
from wire.fields import Polyline
from wire.line import Line
from wire.scenario import Robots, TowerSection

SEGMENTS, T, PERIODS = 5, 10, 12
SPEED_M_S, SEGMENT_M = 0.1, 1.0
FRACTIONS = {0: 0.0, 1: 0.5, 2: 1.0}  # of a segment's length, by site


def formation(folder: Path, overlap: int, turn_s: int, backwards: bool) -> dict[tuple[int, int], list[int]]:
    """Ticks of all visits once the formation has settled, by segment and site (left, middle, right)."""
    half_m = SEGMENTS * SEGMENT_M / 2
    field = Polyline(((-half_m, 0.0), (half_m, 0.0)), SEGMENTS)
    line = Line(field, (0.0, 0.0))
    robots = Robots(
        "overlap_patrol",
        SEGMENTS,
        max_speed_m_s=SPEED_M_S,
        max_turn_rad_s=pi / turn_s if turn_s else pi,
        sensor_range_m=0.0,
    )
    period = 2 * (overlap * T + turn_s)
    given = scenario(
        robots,
        parameters={"overlap": overlap, "turn_s": float(turn_s), "backwards": backwards},
        poses=[(*line.point(one.left_m), 0.0) for one in line.segments],
        field=field,
        mission="line",
        tower=TowerSection(behaviour="swarm_agent.behaviours.stand_still:StandStill"),
        duration_s=float(period * (PERIODS + 2)),
    )
    visits: dict[tuple[int, int], list[int]] = {}
    for tick, node, site in course(given, folder).visits():
        segment, place = site // 3 + 1, site % 3
        covers = (
            segment - overlap < int(node[1:]) - 1 <= segment
        )  # an end is also the end of the next segment
        if tick > period and covers:
            visits.setdefault((segment, place), []).append(tick)
    return visits


CASES = [
    pytest.param(
        overlap, turn_s, backwards, id=f"o{overlap}-c{turn_s}-{'reversing' if backwards else 'turning'}"
    )
    for overlap in (1, 2, 3)
    for turn_s, backwards in ((0, True), (4, False), (6, True))
]


@pytest.mark.parametrize(("overlap", "turn_s", "backwards"), CASES)
def test_visits_have_the_intervals_gaps_and_frequencies_of_the_closed_forms(
    overlap, turn_s, backwards, tmp_path
):
    visits = formation(tmp_path, overlap, turn_s, backwards)
    assert len(visits) == 3 * SEGMENTS
    whole = 2 * (overlap * T + turn_s)
    for (segment, place), ticks in visits.items():
        over, x = min(segment, overlap), FRACTIONS[place]
        gaps = np.diff(ticks)
        expected = (overlap * T + turn_s) / over
        assert np.mean(gaps[: len(gaps) // (2 * over) * 2 * over]) == pytest.approx(expected, abs=1)
        longest = max(2 * (overlap - over) * T + (2 - 2 * x) * T + turn_s, 2 * x * T + turn_s)
        assert max(gaps) == pytest.approx(longest, abs=1), f"segment {segment} at {x}"
        per_period = sum(ticks[0] < tick <= ticks[0] + whole * (PERIODS - 1) for tick in ticks) / (
            PERIODS - 1
        )
        assert per_period == pytest.approx(2 * over, abs=2 / (PERIODS - 1))


@pytest.mark.parametrize("overlap", [1, 2, 3])
def test_without_turns_the_spread_of_the_intervals_is_the_closed_forms(overlap, tmp_path):
    visits = formation(tmp_path, overlap, 0, True)
    for segment in range(overlap, SEGMENTS + 1):
        for place, x in FRACTIONS.items():
            gaps = np.diff(visits[segment, place])
            gaps = gaps[: len(gaps) // (2 * overlap) * 2 * overlap]
            assert np.std(gaps) == pytest.approx(T * abs(1 - 2 * x) / overlap**0.5, abs=1)


def test_robots_in_formation_never_drift(tmp_path):
    ticks = formation(tmp_path, 2, 0, True)[3, 1]
    assert {later - sooner for sooner, later in pairwise(ticks[::4])} == {4 * T}
