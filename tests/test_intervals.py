"""Idleness at events and intervals between visits, against numbers worked out by hand and a slow computation.

Sources: M2Bench, arXiv 2605.09633 (events), and the monitor of patrolling_sim (intervals).
"""

import statistics

import pytest
from hypothesis import given
from hypothesis import strategies as st

from deploy.metrics.area import AreaMetrics
from deploy.metrics.intervals import NAMES, Intervals
from deploy.report import metrics_table
from tests.builders import facts, scenario
from wire.fields import Grid

SITES = 2


def measured(visits: dict[int, list[int]], last_tick: int, **fields) -> dict[str, float | int | None]:
    """The metrics of two sites visited at these ticks; what is visited in one tick has a robot each."""
    fold = AreaMetrics(scenario(2, field=Grid(SITES, 1), **fields))
    for tick, sites in sorted(visits.items()):
        fold.feed(facts(tick, [(f"r{2 + place}", site) for place, site in enumerate(sites)]))
    if last_tick not in visits:
        fold.feed(facts(last_tick))
    summary = fold.summary()
    return {name: summary[name] for name in NAMES}


def intervals(told: dict[str, float | int | None]) -> list[float | int | None]:
    """Mean, worst mean, largest, and their number."""
    return [told[name] for name in NAMES[4:]]


def test_only_intervals_between_two_visits_count():
    """Source: the monitor: neither the time before the first visit nor the time after the last one."""
    assert intervals(measured({50: [0], 53: [0], 60: [0], 62: [1], 66: [1]}, 200)) == [
        ((3 + 7) / 2 + 4) / 2,
        5,
        7,
        3,
    ]


def test_the_mean_is_over_nodes_not_over_intervals():
    """Source: the monitor: avg_idleness is the unweighted mean of the means of the nodes."""
    often_and_rarely = {tick: [0] for tick in range(1, 10)} | {11: [1], 31: [1]}
    assert intervals(measured(often_and_rarely, 31)) == [(1 + 20) / 2, 20, 20, 9]


def test_a_node_without_an_interval_is_left_out_of_the_mean():
    """Source: none; zero would be praise, and there is nothing to measure."""
    assert intervals(measured({3: [0], 5: [1], 9: [0]}, 20)) == [6, 6, 6, 1]


def test_without_intervals_there_is_neither_mean_nor_largest():
    """Source: none; each site was visited once, or never."""
    assert intervals(measured({3: [0], 5: [1]}, 20)) == [None, None, None, 0]
    assert intervals(measured({}, 20)) == [None, None, None, 0]


def test_two_visits_in_one_tick_are_an_interval_of_nothing():
    """Source: the monitor: each message that a goal was reached is a sample."""
    assert intervals(measured({4: [0, 0], 10: [0]}, 10)) == [3, 3, 6, 2]


def test_intervals_that_begin_before_the_beginning_do_not_count():
    """Source: none; the monitor's "go" is our metrics_from_s, and a visit at that very tick counts."""
    visits = {2: [0, 1], 6: [1], 9: [0], 13: [0], 14: [1]}
    assert intervals(measured(visits, 20, metrics_from_s=6.0)) == [(4 + 8) / 2, 8, 8, 2]
    assert intervals(measured(visits, 20, metrics_from_s=7.0)) == [4, 4, 4, 1]


def test_idleness_at_events_is_that_before_the_visits():
    """Source: M2Bench: idleness at an event is taken before the arrivals; each counts for the time since."""
    told = measured({4: [0], 10: [1]}, 10)
    assert told["instantaneous_graph_idleness_s"] == (6 + 10) / 2
    assert told["instantaneous_worst_idleness_s"] == 10
    assert told["average_graph_idleness_s"] == (4 * 4 + (6 + 10) / 2 * 6) / 10
    assert told["worst_idleness_at_events_s"] == 10
    assert measured({4: [0], 10: [1]}, 14)["worst_idleness_at_events_s"] == 10
    assert measured({4: [0], 10: [1]}, 14, metrics_from_s=11.0)["worst_idleness_at_events_s"] == 10


def test_the_end_of_a_run_is_an_event():
    """Source: none; M2Bench ends at an arrival, a run of ours where it ends."""
    told = measured({4: [0], 10: [1]}, 12)
    assert told["instantaneous_graph_idleness_s"] == (8 + 2) / 2
    assert told["instantaneous_worst_idleness_s"] == 8
    assert told["average_graph_idleness_s"] == (4 * 4 + 8 * 6 + 5 * 2) / 12


def test_events_before_the_beginning_are_remembered_but_not_averaged():
    """Source: none; the first stretch begins at metrics_from_s, with the idleness there is."""
    told = measured({4: [0], 10: [1]}, 12, metrics_from_s=5.0)
    assert told["average_graph_idleness_s"] == (8 * 5 + 5 * 2) / 7
    assert told["instantaneous_worst_idleness_s"] == 8


def test_a_run_of_no_length_has_an_instant_but_no_average():
    """Source: none."""
    told = measured({4: [0]}, 6, metrics_from_s=6.0)
    assert [told[name] for name in NAMES[:3]] == [4, None, 6]


def test_a_run_that_ends_before_the_beginning_measures_nothing():
    """Source: none; also of a run without a single tick."""
    assert set(measured({1: [0], 3: [0]}, 5, metrics_from_s=6.0).values()) == {None}
    assert set(Intervals(SITES, 0).summary(-1, 1.0).values()) == {None}


def test_seconds_are_ticks_times_tick_s():
    """Source: none; visits are a number, not a time."""
    whole = measured({4: [0], 7: [1], 10: [0]}, 12)
    halves = measured({4: [0], 7: [1], 10: [0]}, 12, tick_s=0.5)
    assert whole["visits"] == halves.pop("visits") == 1
    assert halves == {name: whole[name] / 2 for name in halves}


def test_regular_visits_have_intervals_of_sites_times_leg_over_robots():
    """Source: an identity: n nodes, R robots, a visit of each robot every tau: intervals of n tau / R."""
    fold = Intervals(12, 0)
    for leg in range(200):
        fold.feed(7 * (leg + 1), [leg % 12, (leg + 4) % 12, (leg + 8) % 12])
    told = fold.summary(7 * 200, 1.0)
    assert told["node_interval_mean_s"] == told["node_interval_worst_mean_s"] == 12 * 7 / 3
    assert told["node_interval_max_s"] == 12 * 7 / 3
    assert told["visits"] == 3 * 200 - 12


def test_the_table_shows_the_intervals_in_one_row():
    """Source: none; nothing measured is a dash."""
    for last_tick, words in ((9, "5.0 / 7.0"), (1, "- / -")):
        fold = AreaMetrics(scenario(2, field=Grid(SITES, 1)))
        visits = {0: [0], 1: [1], 3: [0], 8: [1]} if last_tick == 9 else {}
        for tick in range(last_tick + 1):
            fold.feed(facts(tick, [("r2", site) for site in visits.get(tick, [])]))
        told = {"scenario": "small", "seed": 1, "sim_s": 9.0, "mission": "area", "metrics": fold.summary()}
        table = metrics_table(told)
        cells = [list(column.cells)[-1] for column in table.columns]
        assert cells == ["node interval, mean / max", words, ""]


def slowly(visits: dict[int, list[int]], sites: int, from_tick: int, last_tick: int, tick_s: float) -> list:
    """The definitions as they are written, from all visits at once."""

    def idle(site: int, tick: int) -> int:
        return tick - max([0, *(one for one, where in visits.items() if site in where and one < tick)])

    events = sorted({one for one in visits if one >= from_tick} | {last_tick})
    began = [from_tick, *events]
    at_end = [idle(site, last_tick) for site in range(sites)]
    areas = [
        statistics.fmean(idle(site, event) for site in range(sites)) * (event - before)
        for before, event in zip(began, events, strict=False)
    ]
    counted = [(one, site) for one in sorted(visits) if one >= from_tick for site in visits[one]]
    each = {site: [one for one, where in counted if where == site] for site in range(sites)}
    gaps = {
        site: [after - before for before, after in zip(ticks, ticks[1:], strict=False)]
        for site, ticks in each.items()
        if len(ticks) > 1
    }
    means = [statistics.fmean(some) for some in gaps.values()]
    ticks = [
        statistics.fmean(at_end),
        sum(areas) / (last_tick - from_tick) if last_tick > from_tick else None,
        max(at_end),
        max(idle(site, event) for site in range(sites) for event in events),
        statistics.fmean(means) if means else None,
        max(means, default=None),
        max((one for some in gaps.values() for one in some), default=None),
    ]
    return [None if one is None else one * tick_s for one in ticks] + [sum(map(len, gaps.values()))]


@given(
    sites=st.integers(1, 5),
    visits=st.dictionaries(st.integers(0, 40), st.lists(st.integers(0, 4), min_size=1, max_size=3)),
    from_tick=st.integers(0, 40),
    after=st.integers(0, 9),
    tick_s=st.sampled_from([1.0, 0.5, 0.1]),
)
def test_the_fold_says_what_the_definitions_say(sites, visits, from_tick, after, tick_s):
    """Source: the definitions at the top of intervals.py."""
    visits = {tick: [site % sites for site in where] for tick, where in visits.items()}
    last_tick = max([from_tick, *visits]) + after
    fold = Intervals(sites, from_tick)
    for tick in sorted(visits):
        fold.feed(tick, visits[tick])
    told = fold.summary(last_tick, tick_s)
    assert tuple(told) == NAMES
    for value, wanted in zip(told.values(), slowly(visits, sites, from_tick, last_tick, tick_s), strict=True):
        assert value == (None if wanted is None else pytest.approx(wanted, rel=1e-12, abs=1e-12))
