"""Line metrics against numbers worked out by hand. Source: papers/line-patrol.txt, III-B, IV-B and V-A."""

import json
import math
from collections import defaultdict

import msgspec
import pytest
from rich.console import Console

from deploy.metrics import MISSIONS
from deploy.metrics.area import AreaMetrics
from deploy.metrics.clear import ClearMetrics
from deploy.metrics.line import LineMetrics
from deploy.report import ProgressLine, metrics_table
from swarm_agent.line_radio import Report
from tests.builders import facts
from tests.line_facts import DEPLOYED, LEFT, MID, R3_DEAD, R3_FLAT, RIGHT, fed, patrol, plan, queue, visits
from tower.desk import Desk
from wire import codec

KEYS = """
lap_time_mean_s lap_time_sd_s idle_share return_time_mean_s deployment_s longest_gap_s
longest_gap_by_segment_s recovery_s recovery_full_lap_s recalls away_most flat_robots incidents
orders reports visit_interval_s visit_frequency_hz robots
""".split()
NO_SPAN = {"min": None, "median": None, "max": None, "count": 0}


def to_and_fro(traverse: int, laps: int) -> LineMetrics:
    """r2 and r3 patrol their segments in `traverse` ticks one way; turns count as two visits."""
    happened, said = defaultdict(list), defaultdict(dict)
    for node, segment in (("r2", 1), ("r3", 2)):
        happened[0].append((node, segment, LEFT))
        for lap in range(laps):
            began = 2 * lap * traverse
            happened[began + traverse // 2].append((node, segment, MID))
            happened[began + traverse] += [(node, segment, RIGHT)] * 2
            happened[began + 3 * traverse // 2].append((node, segment, MID))
            happened[began + 2 * traverse] += [(node, segment, LEFT)] * 2
            said[began + 2 * traverse][node] = ("patrol", segment, lap + 1)
    said[0] = DEPLOYED[1]
    return fed(*((tick, said[tick], visits(*told)) for tick, told in sorted(happened.items())))


def test_each_mission_has_its_metrics():
    """Source: none."""
    assert {"area": AreaMetrics, "line": LineMetrics, "clear": ClearMetrics} == MISSIONS


def test_a_run_in_which_nothing_happened_has_no_metrics_and_no_nan():
    """Source: none; None is honest, zero would be praise."""
    for fold in (LineMetrics(plan()), fed((0, {}), (500, {}))):
        summary = fold.summary()
        assert list(summary) == KEYS
        for name in ("lap_time_mean_s", "lap_time_sd_s", "idle_share", "return_time_mean_s", "deployment_s"):
            assert summary[name] is None
        assert summary["longest_gap_s"] is None
        assert summary["longest_gap_by_segment_s"] == {"1": None, "2": None}
        assert summary["recovery_s"] == summary["recovery_full_lap_s"] == NO_SPAN
        assert summary["visit_frequency_hz"] == {"mean": None, "min": None, "variance": None}
        nothing = {"mean": None, "sd": None, "max": None}
        assert summary["visit_interval_s"]["2"] == dict.fromkeys(("end_left", "mid", "end_right"), nothing)
        unheard = {"hops_mean": None, "hops_max": None}
        assert summary["orders"] == {"given": 0, "delivered": 0} | unheard
        assert summary["reports"] == {"heard": 0} | unheard
        assert [summary[name] for name in ("recalls", "away_most", "flat_robots", "incidents")] == [0] * 4
        assert summary["robots"]["r4"]["laps"] == 0
        assert json.loads(json.dumps(summary, allow_nan=False)) == summary


def test_a_robot_to_and_fro_visits_its_ends_after_nothing_and_two_traverses_and_its_middle_after_one():
    """Source: section III-B: ends 0 and a lap, T on average; the middle always T."""
    traverse, laps = 10, 20
    summary = to_and_fro(traverse, laps).summary()
    for segment in ("1", "2"):
        intervals = summary["visit_interval_s"][segment]
        assert intervals["mid"] == {"mean": traverse, "sd": 0, "max": traverse}
        assert intervals["end_left"] == {"mean": traverse, "sd": traverse, "max": 2 * traverse}
        assert intervals["end_right"]["mean"] == pytest.approx(2 * traverse * (laps - 1) / (2 * laps - 1))
        assert intervals["end_right"]["max"] == 2 * traverse
    assert summary["longest_gap_s"] == 2 * traverse
    assert summary["longest_gap_by_segment_s"] == {"1": 2 * traverse, "2": 2 * traverse}


def test_frequency_is_visits_over_time():
    """Source: section III-B: maximal average, maximal minimum, variance of the frequency over the sites."""
    traverse, laps = 10, 20
    watched_s = 2 * traverse * laps
    each = [(2 * laps + one) / watched_s for one in (1, 0, 0)]
    mean = sum(each) / 3
    frequency = to_and_fro(traverse, laps).summary()["visit_frequency_hz"]
    assert frequency["mean"] == pytest.approx(mean)
    assert frequency["min"] == 1 / traverse
    assert frequency["variance"] == pytest.approx(sum((one - mean) ** 2 for one in each) / 3)


def test_laps_of_a_steady_robot_all_take_two_traverses():
    """Source: section III: a lap is the patrol of a segment in both directions."""
    summary = to_and_fro(10, 20).summary()
    assert (summary["lap_time_mean_s"], summary["lap_time_sd_s"]) == (20, 0)
    assert (summary["robots"]["r2"]["laps"], summary["robots"]["r4"]["laps"]) == (20, 0)


def test_laps_count_from_the_report_of_patrol_and_anew_on_every_segment():
    """Source: Table I: mean and standard deviation, overall and of each robot."""
    fold = fed(
        DEPLOYED,
        (10, {"r2": ("patrol", 1, 1), "r3": ("patrol", 2, 1)}),
        (26, {"r2": ("patrol", 1, 2)}),
        (27, {"r2": ("out", 2, 0)}),
        (40, patrol(r2=2)),
        (52, {"r2": ("patrol", 2, 1)}),
    )
    summary = fold.summary()
    laps = [10, 16, 12, 10]
    assert summary["lap_time_mean_s"] == sum(laps) / 4
    sd = math.sqrt(sum((one - 12) ** 2 for one in laps) / 4)
    assert summary["lap_time_sd_s"] == pytest.approx(sd)
    assert summary["robots"]["r2"]["laps"] == 3
    assert summary["robots"]["r2"]["lap_time_mean_s"] == pytest.approx(38 / 3)
    assert summary["robots"]["r3"]["lap_time_sd_s"] == 0


def test_a_last_lap_counts_when_it_ends_with_the_recall():
    """Source: section III-B: laps are completed before a robot leaves."""
    summary = fed(DEPLOYED, (20, {"r2": ("home", 0, 1)})).summary()
    assert (summary["lap_time_mean_s"], summary["recalls"]) == (20, 1)


def test_the_way_home_is_from_the_report_of_home_to_that_of_queue():
    """Source: Table I: average return time."""
    fold = fed(
        DEPLOYED,
        (20, {"r2": ("home", 0, 0)}),
        (23, {"r2": ("home", 0, 0), "r3": ("home", 0, 0)}),
        (65, queue("r2")),
        (80, queue("r3")),
    )
    summary = fold.summary()
    assert summary["return_time_mean_s"] == (45 + 57) / 2
    assert summary["robots"]["r2"]["return_time_mean_s"] == 45
    assert summary["robots"]["r4"]["return_time_mean_s"] is None
    assert (summary["recalls"], summary["away_most"]) == (2, 2)


def test_a_way_home_that_ends_in_death_is_none():
    """Source: none."""
    fold = fed(
        DEPLOYED, (20, {"r3": ("home", 0, 0)}), (30, {}, {"modes": R3_DEAD}), (60, {}), (70, queue("r3"))
    )
    assert fold.summary()["return_time_mean_s"] is None


def test_deployment_ends_when_all_segments_are_patrolled_at_once():
    """Source: sections IV-B and V-A: deployment of 6 robots on 4 segments, 3.25 and 3.5 min."""
    begun = [(0, queue("r2", "r3", "r4")), (5, {"r2": ("out", 1, 0)}), (30, patrol(r2=1))]
    assert fed(*begun, (90, {"r3": ("out", 2, 0)})).summary()["deployment_s"] is None
    assert fed(*begun, (40, patrol(r3=1))).summary()["deployment_s"] is None
    assert fed(*begun, (40, patrol(r3=2)), (60, patrol(r4=2))).summary()["deployment_s"] == 40


def test_idling_is_the_share_of_the_queue_in_robot_time_after_deployment():
    """Source: section IV-C: (r - s) / r with r robots and s segments."""
    fold = fed((0, queue("r2", "r3", "r4")), (50, patrol(r2=1, r3=2)), (350, {}))
    summary = fold.summary()
    assert summary["idle_share"] == pytest.approx(1 / 3)
    assert [summary["robots"][node]["idle_share"] for node in ("r2", "r3", "r4")] == [0, 0, 1]
    assert summary["robots"]["r4"]["idle_s"] == 300


def test_the_dead_and_the_flat_have_no_time():
    """Source: section IV-C: the failed robot's idle time is missing from the totals."""
    for modes in (bytes((0, 0, 0, 2)), bytes((0, 0, 0, 3))):
        fold = fed(DEPLOYED, (100, {}, {"modes": modes}), (400, {}, {"modes": modes}))
        assert fold.summary()["idle_share"] == pytest.approx(100 / (400 + 400 + 100))


def test_a_frozen_robot_stays_in_its_state():
    """Source: none; it is alive, and what it last said holds."""
    fold = fed(DEPLOYED, (100, {}, {"modes": bytes((0, 1, 0, 1))}), (200, {}))
    assert fold.summary()["idle_share"] == pytest.approx(1 / 3)
    assert fold.vacancies == []


def test_what_robots_say_in_other_words_is_passed_over():
    """Source: none; a third party's robot may report what it likes."""
    fold = fed(DEPLOYED)
    fold.feed(facts(5, reports=[("r2", codec.encode({"mood": "good"})), ("r1", b"")]))
    assert fold.vacancies == []


def test_the_flat_are_counted_by_events_and_incidents_by_pairs():
    """Source: section IV-C: a robot ran out of power in the queue."""
    fold = fed(
        DEPLOYED,
        (20, {}, {"modes": R3_FLAT, "incidents": (("r2", "r3"), ("r3", "r4"))}),
        (30, {}, {"modes": R3_FLAT}),
        (40, {}, {"modes": R3_DEAD, "incidents": (("r2", "r3"),)}),
        (50, {}),
        (60, {}, {"modes": R3_FLAT}),
    )
    assert (fold.summary()["flat_robots"], fold.summary()["incidents"]) == (2, 3)


def test_a_gap_that_is_still_open_at_the_end_counts():
    """Source: section III-B: no point is left unvisited for too long."""
    fold = fed((0, {}), (100, patrol(r2=1, r3=2), visits(("r2", 1, MID))), (130, {}, visits(("r2", 1, MID))))
    fed((190, {}), fold=fold)
    assert fold.summary()["longest_gap_by_segment_s"] == {"1": 90, "2": 90}
    assert fold.summary()["visit_interval_s"]["1"]["mid"] == {"mean": 30, "sd": 0, "max": 30}


def test_seconds_are_ticks_times_tick_s():
    """Source: none."""
    ticks = (
        DEPLOYED,
        (20, {"r2": ("home", 0, 1)}),
        (50, queue("r2"), visits(("r3", 2, MID))),
        (90, {}, visits(("r3", 2, MID))),
    )
    one, half = fed(*ticks).summary(), fed(*ticks, tick_s=0.5).summary()
    for name in ("lap_time_mean_s", "return_time_mean_s", "longest_gap_s"):
        assert half[name] == one[name] / 2 > 0
    assert half["idle_share"] == one["idle_share"]
    assert half["visit_frequency_hz"]["mean"] == 2 * one["visit_frequency_hz"]["mean"]
    assert half["visit_interval_s"]["2"]["mid"]["mean"] == 20


def test_ticks_without_facts_are_filled_in():
    """Source: none; in a tick without facts nothing happened."""
    whole, gapped = LineMetrics(plan()), LineMetrics(plan())
    happens = {0: DEPLOYED[1], 40: {"r2": ("home", 0, 1)}, 77: queue("r2"), 99: {}}
    for tick in range(100):
        fed((tick, happens.get(tick, {})), fold=whole)
        if tick in happens:
            fed((tick, happens[tick]), fold=gapped)
    assert gapped.summary() == whole.summary()


@pytest.mark.parametrize("fold", [LineMetrics(plan()), to_and_fro(10, 20)])
def test_the_table_of_a_run_shows_everything_with_its_unit(fold):
    """Source: none."""
    asked = {"grants": 30, "robot_ticks": 100}
    told = {
        "scenario": "line",
        "mission": "line",
        "seed": 1,
        "sim_s": 400.0,
        "metrics": fold.summary() | asked,
    }
    console = Console(width=120)
    with console.capture() as shown:
        console.print(metrics_table(told))
    text = shown.get()
    for word in ("lap time", "idle", "recovery", "recalls", "visit frequency", "robot-ticks", "30.0"):
        assert word in text
    if fold.deployed_tick is not None:
        assert "20.00 ± 0.00" in text and "s, mean ± sd" in text


def test_the_progress_line_counts_flat_robots_as_gone():
    """Source: none; nor does a dead tower make one robot fewer."""
    progress = ProgressLine(Console(), plan(), 1000)
    told = msgspec.structs.replace(facts(10), modes=bytes((2, 0, 3, 2)))
    assert progress._words(told, progress._began + 1.0).endswith("1 robots alive")


def test_asking_for_the_summary_changes_nothing():
    """Source: none."""
    fold = fed(DEPLOYED, (100, {}))
    assert fold.summary() == fold.summary()
    fed((200, queue("r3")), fold=fold)
    assert fold.summary() == fed(DEPLOYED, (100, {}), (200, queue("r3"))).summary()


def test_orders_count_once_when_their_robot_tells_of_them():
    """Source: none; order 7 was overtaken by order 9 before it was heard."""
    fold = LineMetrics(plan())

    def happens(tick, *reports):
        fold.feed(facts(tick, reports=[(node, codec.encode(one)) for node, one in reports]))

    happens(1, ("r1", Desk((), (), (), (), hops=(0, 3), orders=(5, 6, 7))), ("r2", Report("queue", 0, 9.0)))
    happens(3, ("r2", Report("out", 1, 9.0, order=5, hops=4)), ("r3", Report("out", 2, 9.0, order=6)))
    happens(9, ("r2", Report("patrol", 1, 9.0, order=5, hops=4)), ("r1", Desk((), (), (), (), orders=(9,))))
    happens(12, ("r4", Report("out", 2, 9.0, order=9, hops=2)))
    summary = fold.summary()
    assert summary["orders"] == {"given": 4, "delivered": 3, "hops_mean": 2, "hops_max": 4}
    assert summary["reports"] == {"heard": 2, "hops_mean": 1.5, "hops_max": 3}
