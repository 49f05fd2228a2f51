"""How long a segment stays uncovered after a robot has left it, noise off: the paper's T to 3 T, and the way.

Source: papers/line-patrol.txt, section III-B. T is the time for one segment, one way, c that of a turn.
"""

from collections import defaultdict

import pytest

from deploy.metrics.line import LineMetrics
from tests.line_courses import Run, line_run, rehearsed_line, times

HOPS = 4.0
"""A tick for the report, one for the order, one for the robot to set out, one for what is left of a tick."""


def waits_s(run: Run) -> list[tuple[float, float]]:
    """For every vacancy that began with somebody in the queue: until it was covered, and how much of that
    time the robot that covered it was on its way.
    """
    metrics, queues, changes = LineMetrics(run.scenario), {}, defaultdict(list)
    for one, (tick, doing) in zip(run.facts, run.states(), strict=True):
        metrics.feed(one)
        queues[tick] = sum(state == "queue" for state, _ in doing.values())
        for node, what in doing.items():
            if not changes[node] or changes[node][-1][1] != what:
                changes[node].append((tick, what))
    found = []
    for vacancy in metrics.vacancies:
        if vacancy.covered_tick is None or queues[vacancy.began_tick] == 0:
            continue
        came = [
            (out_tick, patrol_tick)
            for (out_tick, out), (patrol_tick, _) in zip(
                changes[vacancy.filled_by], changes[vacancy.filled_by][1:], strict=False
            )
            if out == ("out", vacancy.segment) and patrol_tick <= vacancy.covered_tick
        ]
        way = came[-1][1] - max(came[-1][0], vacancy.began_tick) if came else 0
        found.append((float(vacancy.covered_tick - vacancy.began_tick), float(way)))
    return found


@pytest.mark.parametrize("seed", [1, 2])
def test_with_a_robot_in_the_queue_every_vacancy_is_covered_within_three_traverses_turns_and_the_way(
    seed, tmp_path
):
    given = line_run("8r6s", 5400, 3.0, "tower.parameters.rule=base", "robots.noise_sd=0", seed=seed)
    run = rehearsed_line(tmp_path, given)
    bounds, found = times(given), waits_s(run)
    assert len(found) > 20
    for covered, way in found:
        assert bounds.segment <= covered, "nobody is faster than one traverse"
        assert covered - way <= 3 * (bounds.segment + bounds.turn) + HOPS


def test_leap_frog_covers_a_segment_as_soon_as_one_has_come_from_the_queue(tmp_path):
    given = line_run("8r6s", 5400, 3.0, "tower.parameters.rule=leapfrog", "robots.noise_sd=0")
    bounds, found = times(given), waits_s(rehearsed_line(tmp_path, given))
    assert len(found) >= 8
    assert all(covered - way <= bounds.segment + bounds.turn + HOPS for covered, way in found)
