"""How a floor plan was cleared, from facts: causes of loss, claims, events, the graph, robots on lines."""

from typing import Any

import msgspec
import numpy as np
import pytest

from deploy.metrics import MISSIONS
from deploy.metrics.clear import ClearMetrics, Instant
from deploy.recorder import summarise
from deploy.scenario_file import to_toml
from swarm_agent.graph_copy import Delta, Edge, Version, Vertex
from tests.builders import course, facts
from tests.clear_builders import clearing
from wire import codec
from wire.clearing import Clearing, Standing
from wire.messages import Facts, Fault
from wire.scenario import PlannedFault, Sensors
from world_server.nodes import DEAD

ON_LINE = Standing("centre", 1, True, "r2", "r4")


def tick(
    number: int,
    left_m2: float = 5.0,
    lost_m2: float = 0.0,
    given_up_m2: float = 0.0,
    said: dict[str, Standing] | None = None,
    verbs: tuple[str, ...] = (),
    dead: tuple[int, ...] = (),
    raster_m2: float | None = None,
) -> Facts:
    """The facts of a tick. `dead`: rows of four robots behind the tower."""
    reports = [(node, codec.encode(standing)) for node, standing in (said or {}).items()]
    return msgspec.structs.replace(
        facts(number, reports=reports),
        clearing=Clearing(left_m2, lost_m2, given_up_m2, raster_m2),
        faults=tuple(Fault(number, verb, "r3") for verb in verbs),
        modes=bytes(DEAD if row in dead else 0 for row in range(5)),
    )


def folded(*ticks: Facts, sensors: Sensors = Sensors()) -> dict[str, Any]:
    fold = ClearMetrics(clearing(4, sensors=sensors))
    for one in ticks:
        fold.feed(one)
    return fold.summary()


def lost(**causes: float) -> dict[str, Any]:
    return {
        cause: pytest.approx(causes.get(cause, 0.0)) for cause in ("kill", "release", "retreat", "breach")
    }


def test_the_metrics_are_those_and_no_others():
    assert list(folded()) == [
        "cleared",
        "claim",
        "clear_time_s",
        "contaminated_area_m2",
        "recontaminated_m2",
        "breaches",
        "robots_deployed",
        "robots_on_lines_peak",
        "splits",
        "searches",
        "searches_failed",
        "dissolved",
        "graph",
    ]
    assert MISSIONS["clear"] is ClearMetrics


def test_of_a_run_of_no_ticks_nothing_is_known():
    summary = folded()
    assert summary["cleared"] is False and summary["contaminated_area_m2"] is None
    assert summary["claim"] == "none" and summary["clear_time_s"] is None


def test_a_death_that_opens_no_barrier_loses_only_what_somebody_had_in_sight_as_a_retreat_does():
    """Source: specs of mission clear, 4.4: `kill` is what a death loses that opened the barrier."""
    summary = folded(tick(1, lost_m2=0.4, given_up_m2=0.4, verbs=("kill",)))
    assert summary["recontaminated_m2"] == lost(retreat=0.4) and summary["breaches"] == 0


def test_ground_lost_in_a_tick_with_a_death_is_lost_by_it_whatever_else_happened():
    releasing = {"r2": Standing(releasing=True)}
    summary = folded(tick(1, lost_m2=3.0, given_up_m2=1.0, said=releasing, verbs=("kill",)))
    assert summary["recontaminated_m2"] == lost(kill=3.0) and summary["breaches"] == 0


def test_what_is_lost_before_neighbours_can_know_of_a_death_is_lost_by_it():
    beside = {"r2": Standing("leader", left="wall", right="r3")}
    closed = {"r2": Standing("leader", left="wall", right="r4")}
    died = tick(1, lost_m2=1.0, said=beside, verbs=("kill",), dead=(2,))
    later = tick(2, lost_m2=0.5, dead=(2,)), tick(3, lost_m2=0.25, said=closed, dead=(2,))
    assert folded(died, *later)["recontaminated_m2"] == lost(kill=1.5, breach=0.25)


@pytest.mark.parametrize(("verb", "cause"), [("freeze", "kill"), ("slow", "breach"), ("thaw", "breach")])
def test_a_process_that_is_stopped_watches_no_more_one_that_is_slow_does(verb, cause):
    assert folded(tick(1, lost_m2=3.0, verbs=(verb,)))["recontaminated_m2"] == lost(**{cause: 3.0})


def test_ground_lost_while_some_robot_says_that_it_releases_is_released():
    """Also in later ticks in which it says nothing; but not when it has said otherwise, or is dead."""
    begin, end = {"r2": Standing(releasing=True)}, {"r2": Standing()}
    said = tick(1, lost_m2=1.0, said=begin), tick(2, lost_m2=2.0)
    assert folded(*said)["recontaminated_m2"] == lost(release=3.0)
    assert folded(*said, tick(3, lost_m2=4.0, said=end))["recontaminated_m2"] == lost(release=3.0, breach=4.0)
    assert folded(*said, tick(3, lost_m2=4.0, dead=(1,)))["recontaminated_m2"] == lost(
        release=3.0, breach=4.0
    )


def test_what_was_in_sight_until_then_is_a_retreat_and_the_rest_a_breach():
    summary = folded(tick(1, lost_m2=3.0, given_up_m2=1.0), tick(2, lost_m2=0.5, given_up_m2=0.5))
    assert summary["recontaminated_m2"] == lost(retreat=1.5, breach=2.0)
    assert summary["breaches"] == 1


@pytest.mark.parametrize(
    ("referee", "lost_m2", "breaches"),
    [("exact", 0.9e-6, 0), ("both", 1.1e-6, 1), ("raster", 2 * 0.05**2, 0), ("raster", 3 * 0.05**2, 1)],
)
def test_what_may_be_rounding_is_no_breach(referee, lost_m2, breaches):
    assert folded(tick(1, lost_m2=lost_m2), sensors=Sensors(referee=referee))["breaches"] == breaches


def test_clear_is_what_the_referee_says_and_a_claim_what_the_team_says_first():
    done, failed = {"r2": Standing(claim="done")}, {"r3": Standing(claim="failed")}
    summary = folded(tick(4, 1.0), tick(8, 0.9e-7), tick(12, 0.0, said=done), tick(16, 0.0, said=failed))
    assert summary["cleared"] and summary["clear_time_s"] == 2.0 and summary["claim"] == "done"
    summary = folded(tick(4, 1.0, said=done))
    assert not summary["cleared"] and summary["clear_time_s"] is None and summary["claim"] == "done"
    assert summary["contaminated_area_m2"] == 1.0


def test_events_are_counted_from_reports_and_reports_of_others_are_not_read():
    said = {"r2": Standing(events=("split", "search", "merge")), "r3": Standing(events=("search_failed",))}
    again = {"r2": Standing(events=("search", "dissolve", "split"))}
    summary = folded(
        tick(1, said=said), tick(2, said=again), tick(3, said={"r1": Standing(events=("split",))})
    )
    counted = [summary[name] for name in ("splits", "searches", "searches_failed", "dissolved")]
    assert counted == [2, 2, 1, 1]
    junk = msgspec.structs.replace(tick(1), reports=(("r2", b"\x01\x90"), ("r3", b""), ("r4", b"\xff" * 9)))
    assert folded(junk)["splits"] == 0


def test_a_robot_is_on_a_line_when_it_has_a_neighbour_there_and_lives():
    four = dict.fromkeys(("r2", "r3", "r4"), ON_LINE) | {"r5": Standing("reserve", 1, True)}
    assert folded(tick(1, said=four), tick(2, dead=(1, 2)))["robots_on_lines_peak"] == 3
    fold = ClearMetrics(clearing(4))
    for one in (tick(1, said=four), tick(2, lost_m2=0.5, dead=(1, 2), raster_m2=4.5)):
        fold.feed(one)
    assert fold.instant == Instant(0.5, 5.0, 4.5, 0.5, 1)
    assert [fold.is_on_line(node) for node in ("r2", "r3", "r4", "r5")] == [False, False, True, False]
    np.testing.assert_array_equal(
        fold.tables()["curve"][:, [0, 1, 3, 4]], [(0.25, 5, 0, 3), (0.5, 5, 0.5, 1)]
    )
    assert folded()["robots_deployed"] == 4


def delta(events: int, *kinds: str) -> bytes:
    vertices = tuple(Vertex(number, 2) for number in range(len(kinds) + 1))
    edges = tuple(Edge(number, number + 1, 1, kind) for number, kind in enumerate(kinds))
    return codec.encode(Delta(Version(), Version(events, "r2"), 0, None, vertices, edges))


def test_the_graph_is_the_newest_that_any_robot_reported():
    ticks = [
        tick(1, said={"r2": Standing(graph=delta(3, "move", "split", "cycle"))}),
        tick(2, said={"r3": Standing(graph=delta(2, "move"))}),
        tick(3, said={"r4": Standing(graph=b"\x01junk")}),
    ]
    assert folded(*ticks)["graph"] == {"vertices": 4, "edges": 3, "cycle_edges": 1}
    assert folded()["graph"] == {"vertices": 0, "edges": 0, "cycle_edges": 0}


def test_a_run_is_folded_into_a_summary_and_its_curve(tmp_path):
    """Against the referee's own words in the journal."""
    kill = PlannedFault(5.0, "kill", ("r2",))
    given = clearing(4, faults=(kill,), parameters={"claim_tick": 30, "events": {"r3@7": ["split"]}})
    run = course(given, tmp_path)
    (tmp_path / "scenario.toml").write_text(to_toml(given))
    metrics = summarise(tmp_path, given, "clear", 1.0, [])["metrics"]
    assert metrics["claim"] == "done" and metrics["splits"] == 1 and not metrics["cleared"]
    assert metrics["contaminated_area_m2"] == run.facts[-1].clearing.contaminated_m2
    assert metrics["recontaminated_m2"]["retreat"] >= run.facts[20].clearing.lost_m2 > 0
    total_m2 = sum(one.clearing.lost_m2 for one in run.facts)
    assert sum(metrics["recontaminated_m2"].values()) == pytest.approx(total_m2, abs=1e-5)
    curve = np.load(tmp_path / "clear.npz")["curve"]
    assert curve.shape == (len(run.facts), 5)
    assert curve[:, 1].tolist() == [one.clearing.contaminated_m2 for one in run.facts]
