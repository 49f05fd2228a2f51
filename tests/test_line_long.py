"""The long line: 40 robots, 30 segments with bends, a radio that reaches two segments.

Orders and reports go hop by hop to both ends; a radio that is split for 20 minutes leaves both halves with
their segments. Source: none; papers/line-patrol.txt has messages that reach everybody directly.
"""

import sqlite3
from collections import defaultdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from deploy.metrics.line import LineMetrics
from deploy.run_folder import LEDGER
from deploy.scenario_file import load_scenario, shipped_scenarios
from swarm_agent.line_radio import Report
from tests.live_runs import rehearsed
from wire import codec
from wire.line import Line
from wire.scenario import Scenario
from world_server.journal import commits

DURATION_S = 2700
DEPLOYED_S = 400
SPLIT_S, HEALED_S = 600, 1800
HOPS_TO_THE_END = 6  # 22.8 m from the tower, 3.6 m each but for what is lost by where robots stand
REPORT_S = 1.2 * 10 * 30.6  # robots tell of themselves at least so often, by the longest segment
STEP_S = 5
CHANGED = {"duration_s": DURATION_S}


class Told(NamedTuple):
    """What a robot said of itself."""

    tick: int
    node: str
    report: Report


class Run(NamedTuple):
    """A rehearsal and what is asked of it."""

    scenario: Scenario
    line: Line
    summary: dict[str, Any]
    told: list[Told]
    visits: list[tuple[int, str, int]]
    reaches_m: np.ndarray
    """How far every delivered frame came."""
    ledger: list[tuple[int, str, str, int]]

    def patrolled_by(self, tick: int) -> dict[int, list[str]]:
        """Who says at a tick that it patrols a segment."""
        last = {one.node: one.report for one in self.told if one.tick <= tick}
        found = defaultdict(list)
        for node, report in last.items():
            if report.state == "patrol":
                found[report.segment].append(node)
        return found

    def tower_noted(
        self, kind: str, from_s: float = 0.0, until_s: float = DURATION_S
    ) -> list[tuple[str, int]]:
        """Node and segment of what the tower wrote down in a time."""
        return [
            (node, one) for tick, what, node, one in self.ledger if what == kind and from_s <= tick < until_s
        ]

    def longest_gap_s(self, segment: int, from_s: float, until_s: float) -> int:
        """The longest time in which one of a segment's ends and its middle was not visited."""
        sites = {3 * (segment - 1) + place: [from_s] for place in range(3)}
        for tick, _, site in self.visits:
            if site in sites and from_s < tick < until_s:
                sites[site].append(tick)
        return max(max(np.diff([*ticks, until_s])) for ticks in sites.values())


def rehearsal(folder: Path, **overrides: Any) -> Run:
    """The shipped scenario, so long that both ends are relieved."""
    path = shipped_scenarios()["line-long"]
    folder = rehearsed(folder, path, **(CHANGED | overrides))
    scenario = load_scenario(folder / "scenario.toml")
    metrics, told, visits, reaches_m = LineMetrics(scenario), [], [], [np.empty(0)]
    for commit in commits(folder / "journal"):
        facts = commit.facts
        metrics.feed(facts)
        told += [
            Told(facts.tick, node, codec.decode(Report, said))
            for node, said in facts.reports
            if node != scenario.tower.id
        ]
        visits += [(facts.tick, node, site) for node, site in facts.visits]
        links = np.frombuffer(facts.links, "<u2").reshape(-1, 2)
        places_m = np.frombuffer(facts.poses, "<f8").reshape(-1, 3)[:, :2]
        reaches_m.append(np.hypot(*(places_m[links[:, 0]] - places_m[links[:, 1]]).T))
    ledger = sqlite3.connect(folder / LEDGER)
    entries = ledger.execute(
        'SELECT tick, kind, node, segment FROM history ORDER BY "grant", place'
    ).fetchall()
    ledger.close()
    line = Line(scenario.field, (scenario.tower.x_m, scenario.tower.y_m))
    return Run(scenario, line, metrics.summary(), told, visits, np.concatenate(reaches_m), entries)


def longest_lap_s(run: Run) -> float:
    """To and fro on the longest segment, with two turns of 2 s."""
    return 2 * max(one.length_m for one in run.line.segments) / run.scenario.robots.max_speed_m_s + 4


def recovery_s(run: Run) -> float:
    """A segment's longest time without a visit when its robot is relieved, or moves out.

    Its robot leaves the far end at the end of its lap (1 lap); the next one is told, at worst in a second try
    as the line has a hole just then (retry_s), ends its lap (1), comes (1/2) and traverses the segment to its
    far end (1/2); noise and waiting behind others take another half.
    """
    return 3.5 * longest_lap_s(run) + 30


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A quicker round, so that robots at both ends are recalled before long."""
    tower = load_scenario(shipped_scenarios()["line-long"]).tower
    parameters = tower.parameters | {"round_s": 75}
    folder = tmp_path_factory.mktemp("whole")
    return rehearsal(folder, tower={"behaviour": tower.behaviour, "parameters": parameters})


def test_every_segment_is_manned_and_nobody_comes_to_harm(whole):
    summary = whole.summary
    assert summary["deployment_s"] <= DEPLOYED_S
    assert (summary["flat_robots"], summary["incidents"]) == (0, 0)
    assert summary["longest_gap_s"] <= recovery_s(whole)
    assert whole.tower_noted("lost") == []


def test_no_frame_came_farther_than_the_radio_reaches(whole):
    (radio,) = whole.scenario.radio.rules
    assert len(whole.reaches_m) > 10_000
    assert 0.9 * radio.range_m < whole.reaches_m.max() <= radio.range_m


def test_orders_and_reports_travel_hop_by_hop(whole):
    orders, reports = whole.summary["orders"], whole.summary["reports"]
    assert orders["given"] > 100
    assert orders["given"] - orders["delivered"] <= 2, "those that were on their way at the end"
    assert min(orders["hops_max"], reports["hops_max"]) >= HOPS_TO_THE_END
    assert orders["hops_mean"] > 1


@pytest.mark.parametrize("end", [1, 30])
def test_a_recall_at_an_end_is_heard_there_and_carried_out_and_the_end_is_taken_over(whole, end):
    first = next(one for one in whole.told if one.report.state == "patrol" and one.report.segment == end)
    heard = next(
        one for one in whole.told if one.node == first.node and one.report.order > first.report.order
    )
    assert (heard.report.segment, first.node) in [(end, node) for node, _ in whole.tower_noted("recall")]
    assert heard.report.hops >= HOPS_TO_THE_END
    home = [one for one in whole.told if one.node == first.node and one.tick > heard.tick]
    assert [state for state in ("home", "queue") if any(one.report.state == state for one in home)] == [
        "home",
        "queue",
    ]
    (after,) = whole.patrolled_by(DURATION_S)[end]
    assert after != first.node
    takes_over = next(one for one in whole.told if one.node == after and one.report.segment == end)
    assert takes_over.report.hops >= HOPS_TO_THE_END - 1, "its order came to it one segment further in"


@pytest.fixture(scope="module")
def halves(whole):
    """The robots that patrol the left half and the right half as the radio is split."""
    patrolled = whole.patrolled_by(SPLIT_S)
    left = [node for segment in range(1, 16) for node in patrolled[segment]]
    right = [node for segment in range(16, 31) for node in patrolled[segment]]
    assert (len(left), len(right)) == (15, 15)
    return left, right


@pytest.fixture(scope="module")
def split(whole, halves, tmp_path_factory):
    """The same line, whose left half nobody else hears for 20 minutes."""
    rules = [
        {"kind": "partition", "groups": [halves[0]], "from_s": SPLIT_S, "until_s": HEALED_S},
        {"kind": "range", "range_m": 3.6},
    ]
    return rehearsal(tmp_path_factory.mktemp("split"), radio={"rules": rules})


def test_while_the_radio_is_split_both_halves_keep_their_segments(split, halves):
    assert split.tower_noted("lost") == [], "so many do not die at once"
    for segment, (node, *_) in split.patrolled_by(SPLIT_S).items():
        if node in halves[0]:
            said = [one.report for one in split.told if one.node == node and SPLIT_S < one.tick <= HEALED_S]
            assert {(one.state, one.segment) for one in said} == {("patrol", segment)}
    for segment in range(1, 16):
        assert split.longest_gap_s(segment, SPLIT_S, HEALED_S) <= 1.3 * longest_lap_s(split)
    for segment in range(16, 31):
        assert split.longest_gap_s(segment, SPLIT_S, HEALED_S) <= recovery_s(split)


def test_the_reachable_half_goes_on_being_relieved(split, halves):
    recalled = {node for node, _ in split.tower_noted("recall", SPLIT_S, HEALED_S)}
    assert recalled and recalled <= set(halves[1])


def test_after_the_split_no_segment_is_patrolled_twice_for_longer_than_a_lap(split):
    twice = defaultdict(int)
    for tick in range(HEALED_S, DURATION_S, STEP_S):
        patrolled = split.patrolled_by(tick)
        for segment in range(1, 31):
            twice[segment] = twice[segment] + STEP_S if len(patrolled[segment]) > 1 else 0
            assert twice[segment] <= longest_lap_s(split)


def test_after_the_split_the_roster_is_whole_and_the_cut_off_half_is_relieved(split, halves):
    heard = {node for node, _ in split.tower_noted("heard", HEALED_S, HEALED_S + REPORT_S)}
    assert heard >= set(halves[0])
    recalled = [node for node, _ in split.tower_noted("recall", HEALED_S) if node in halves[0]]
    back = [one.node for one in split.told if one.report.state == "queue" and one.tick > HEALED_S]
    assert set(recalled) & set(back), "recalled and come home"
    for segment in range(1, 31):
        assert split.longest_gap_s(segment, HEALED_S, DURATION_S) <= recovery_s(split)
