"""Area metrics against numbers worked out by hand. Source: Kobayashi et al. 2025, equations 1-9."""

import json
import math

import numpy as np
import pytest

from deploy.metrics.area import NAMES, AreaMetrics
from deploy.metrics.intervals import NAMES as OTHERS
from deploy.metrics.word_of_visits import NAMES as WORDS
from deploy.recorder import summarise
from deploy.scenario_file import load_scenario
from swarm_agent.knowledge import News
from tests.builders import course, facts, scenario, table
from tests.live_runs import rehearsed, small
from tower.base_station import Awareness
from wire import codec
from wire.fields import Grid
from wire.scenario import Loss, PlannedFault, RadioSection, Range
from world_server.journal import commits


def metrics(**fields) -> AreaMetrics:
    """Two sites, three robots and a tower."""
    return AreaMetrics(scenario(3, field=Grid(2, 1), **fields))


def knows(**visited: int) -> tuple[str, bytes]:
    return "r1", codec.encode(Awareness(table(**visited), False))


def test_every_site_counts_as_visited_at_the_beginning():
    """Source: section V-A1: all idleness starts at zero."""
    assert metrics().feed(facts(0))[1:] == (0, 0, 0, 0)


def test_idleness_is_the_time_since_the_last_true_visit():
    """Source: equations 1-3: mean and largest over the sites."""
    fold = metrics()
    fold.feed(facts(3, [("r2", 0)]))
    assert fold.feed(facts(9))[1:3] == ((6 + 9) / 2, 9)


def test_delay_is_the_time_since_the_last_visit_that_the_tower_knows_of():
    """Source: equations 5-7: D = t - t_1."""
    fold = metrics()
    fold.feed(facts(3, [("r2", 0), ("r3", 1)]))
    fold.feed(facts(5, reports=[knows(s0=3)]))
    instant = fold.feed(facts(9))
    assert (instant.mean_sa_delay_s, instant.worst_sa_delay_s) == ((6 + 9) / 2, 9)
    assert (instant.graph_idleness_s, instant.worst_idleness_s) == (6, 6)


def test_what_others_than_the_tower_report_is_not_awareness():
    """Source: section IV-A: the table of r_1."""
    fold = metrics()
    fold.feed(facts(3, reports=[("r2", knows(s0=3)[1])]))
    assert fold.feed(facts(9)).mean_sa_delay_s == 9


def test_means_are_over_the_ticks_and_worst_is_the_largest_of_all():
    """Source: equations 2, 4, 6, 8; divided by the number of terms."""
    fold = metrics()
    for tick in range(5):
        fold.feed(
            facts(tick, [("r2", 0), ("r3", 1)] if tick == 3 else [], [knows(s0=3)] if tick == 4 else [])
        )
    summary = fold.summary()
    assert summary["graph_idleness_s"] == (0 + 1 + 2 + 0 + 1) / 5
    assert summary["worst_idleness_s"] == 2
    assert summary["mean_sa_delay_s"] == (0 + 1 + 2 + 3 + (1 + 4) / 2) / 5
    assert summary["worst_sa_delay_s"] == 4


def test_normalised_values_are_multiplied_by_the_robots_over_the_sites():
    """Source: equation 9: (N - 1) / K with the tower among the N."""
    fold = metrics()
    fold.feed(facts(0))
    fold.feed(facts(1))
    summary = fold.summary()
    for name in NAMES:
        assert summary[f"normalised_{name}"] == pytest.approx(summary[name] * 3 / 2)


def test_the_transient_before_metrics_from_s_does_not_count():
    """Source: Table II, t_0; the tick at t_0 itself is the first term."""
    fold = metrics(metrics_from_s=3.0)
    for tick in range(6):
        fold.feed(facts(tick, [("r2", 0), ("r3", 1)] if tick == 3 else []))
    assert fold.summary()["graph_idleness_s"] == (0 + 1 + 2) / 3
    assert fold.summary()["worst_idleness_s"] == 2


def test_ticks_without_facts_are_filled_in():
    """Source: none; a sleeping swarm is not committed, but time goes on."""
    gapped, whole = metrics(metrics_from_s=2.0), metrics(metrics_from_s=2.0)
    for tick in range(21):
        what = facts(tick, [("r2", 0)] if tick == 4 else [], [knows(s0=4)] if tick == 11 else [])
        whole.feed(what)
        if tick in (0, 4, 11, 20):
            gapped.feed(what)
    assert gapped.summary() == whole.summary()


def test_seconds_are_ticks_times_tick_s():
    """Source: none."""
    fold = metrics(tick_s=0.5, metrics_from_s=1.0)
    for tick in range(5):
        fold.feed(facts(tick))
    assert fold.summary()["graph_idleness_s"] == (1.0 + 1.5 + 2.0) / 3
    assert fold.summary()["worst_sa_delay_s"] == 2.0


def test_a_tower_that_begins_anew_knows_nothing_that_it_does_not_say():
    """Source: none; its first report is whole."""
    fold = metrics()
    fold.feed(facts(5, reports=[knows(s0=4, s1=3)]))
    anew = Awareness(News(np.array([0, 2], "<u4").tobytes()), True)
    fold.feed(facts(6, reports=[("r1", codec.encode(anew))]))
    instant = fold.feed(facts(8))
    assert (instant.mean_sa_delay_s, instant.worst_sa_delay_s) == ((8 + 6) / 2, 8)


def test_a_run_that_ends_before_metrics_from_s_has_no_metrics():
    """Source: none; None is honest, zero would be praise."""
    fold = metrics(metrics_from_s=10.0)
    for tick in range(9):
        fold.feed(facts(tick))
    assert set(fold.summary().values()) == {None}
    assert set(fold.summary()) == {*NAMES, *(f"normalised_{name}" for name in NAMES), *OTHERS, *WORDS}


def test_a_tower_that_reports_in_other_words_is_merely_ignorant():
    """Source: none; a third party's tower may report what it likes."""
    fold = metrics()
    fold.feed(facts(3, reports=[("r1", codec.encode({"mood": "good"}))]))
    assert fold.feed(facts(4)).mean_sa_delay_s == 4


@pytest.mark.parametrize("memory", ["lost", "kept"])
@pytest.mark.parametrize("died_at", [21.0, 24.0, 33.0])
def test_no_delay_is_ever_smaller_than_the_idleness_it_reports(tmp_path, memory, died_at):
    """Source: section IV-A: the tower cannot know of a visit that did not happen, with loss and deaths."""
    faults = (
        PlannedFault(died_at, "kill", ("r1", "r3")),
        PlannedFault(died_at + 20, "restart", ("r1", "r3"), memory=memory),
    )
    rules = RadioSection((Range(60.0), Loss(0.3)))
    plan = scenario(3, duration_s=150.0, radio=rules, faults=faults)
    fold = AreaMetrics(plan)
    instants = []
    for one in course(plan, tmp_path).facts:
        instants.append(fold.feed(one))
        assert (fold.known_tick <= fold.visited_tick).all(), f"tick {one.tick}"
        assert instants[-1].mean_sa_delay_s >= instants[-1].graph_idleness_s >= 0
        assert instants[-1].worst_sa_delay_s >= instants[-1].worst_idleness_s
    assert fold.known_tick.any() and fold.visited_tick.any()
    summary = fold.summary()
    assert summary["graph_idleness_s"] == pytest.approx(np.mean([one.graph_idleness_s for one in instants]))
    assert math.isclose(summary["worst_sa_delay_s"], max(one.worst_sa_delay_s for one in instants))


def test_a_robot_that_dies_at_its_goal_and_remembers_reports_no_visit_that_did_not_happen(tmp_path):
    """Source: none; whenever it dies, the mind and the world must agree on when the visit was completed."""
    for died_at in range(8, 32):
        faults = (
            PlannedFault(float(died_at), "kill", ("r2",)),
            PlannedFault(40.0, "restart", ("r2",), memory="kept"),
        )
        plan = scenario(1, duration_s=44.0, faults=faults)
        fold = AreaMetrics(plan)
        for one in course(plan, tmp_path / str(died_at)).facts:
            fold.feed(one)
            assert (fold.known_tick <= fold.visited_tick).all(), f"died at {died_at}, tick {one.tick}"


def test_the_summary_says_how_often_robots_were_asked(tmp_path):
    """Source: none; the tower, which is asked too, is no robot."""
    path = small(tmp_path, duration_s=30)
    run = rehearsed(tmp_path, path)
    metrics = summarise(run, load_scenario(path), "small", 1.0, [])["metrics"]
    assert json.loads((run / "summary.json").read_text())["metrics"] == metrics
    asked = [grant.node for one in commits(run / "journal") for grant in one.grants]
    assert metrics["grants"] == len(asked) - asked.count("r1") > 0
    assert metrics["robot_ticks"] == 31 * 4
    assert set(NAMES) | set(OTHERS) < set(metrics)
