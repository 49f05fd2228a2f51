"""Laps, idling, recalls, deployment and recovery of a line patrol, folded from facts.

Source: papers/line-patrol.txt, sections III-B, IV-B and V-A (Tables I and II). Visits, deaths, flat
batteries and incidents are true; what robots do (queue, out, patrol, home) is what they report of themselves.

    lap time     from one count of laps to the next on one segment; the first from the report of "patrol"
    idle share   robot time in state "queue" / robot time, both of robots neither dead nor flat
    return time  from the report of "home" to the report of "queue"
    deployment   the first time at which every segment has a robot in state "patrol"
    recall       a change from "patrol" to "home"
    orders       given: by the tower, each once however often it was said; delivered: that its robot has told
                 of, so that one overtaken by the next before it was heard never is; hops: how often an order
                 was said again on its way, 0 when it was heard directly
    reports      heard: by the tower, with their hops

Standard deviations are the population's. Idle times, gaps, intervals and frequencies count from the end of
deployment on (`visits` has their formulas), all else from the beginning. A frozen robot is alive and stays
in the state that it last reported; one that has reported nothing since its start is in none. What holds at
the end of a tick holds until the next one. None is what was never measured.
"""

from collections import Counter
from typing import Any, TypeVar

from deploy.metrics.spread import Spread, span
from deploy.metrics.vacancies import Cause, Vacancies, Vacancy, segment_of
from deploy.metrics.visits import Visits
from deploy.metrics.words import Words
from swarm_agent.line_radio import Report, State
from tower.desk import Desk
from wire import codec
from wire.messages import Facts
from wire.scenario import Scenario
from world_server.nodes import DEAD, FLAT

Told = TypeVar("Told", Desk, Report)
ENDED_BY: dict[int, Cause] = {DEAD: "death", FLAT: "flat"}


class LineMetrics:
    """The fold. Feed it facts in order; ask for the metrics at any time."""

    def __init__(self, scenario: Scenario) -> None:
        segments = scenario.field.segments
        self._segments = segments if isinstance(segments, int) else len(segments)
        self._tick_s = scenario.tick_s
        self._nodes = scenario.node_ids
        self._robots = {node: _Robot() for node in scenario.robot_ids}
        self._visits, self._vacancies = Visits(self._segments), Vacancies()
        self._tower, self._words = scenario.tower.id, Words()
        self._laps, self._returns = Spread(), Spread()
        self._tick = self._settled_tick = 0
        self._modes = b""
        self._away_most, self._recalls, self._flat, self._incidents = 0, 0, 0, 0
        self.deployed_tick: int | None = None

    @property
    def vacancies(self) -> list[Vacancy]:
        """Every vacancy so far, in the order in which they began."""
        return self._vacancies.all

    def feed(self, facts: Facts) -> None:
        """Take in one tick. In ticks between this and the last one nothing happened."""
        self._tick = facts.tick
        for node, site in facts.visits:  # on the way to this tick, so before what is decided at it
            if node in self._robots and self._robots[node].works_on(segment_of(site)):
                self._vacancies.visit(facts.tick, node, site)
        if facts.reports or facts.faults or facts.modes != self._modes:
            self._change(facts)
        for _, site in facts.visits:
            self._visits.add(facts.tick, site)
        self._incidents += len(facts.incidents)

    def tables(self) -> dict[str, Any]:
        """Nothing beside the numbers."""
        return {}

    def summary(self) -> dict[str, Any]:
        """The run's metrics; None where there was nothing to measure."""
        self._pass_time()
        tick_s, tick = self._tick_s, self._tick
        gaps_s = self._visits.longest_gaps_s(tick, tick_s)
        return {
            "lap_time_mean_s": self._laps.mean_s(tick_s),
            "lap_time_sd_s": self._laps.sd_s(tick_s),
            "idle_share": _share(
                sum(one.idle_ticks for one in self._robots.values()),
                sum(one.working_ticks for one in self._robots.values()),
            ),
            "return_time_mean_s": self._returns.mean_s(tick_s),
            "deployment_s": None if self.deployed_tick is None else self.deployed_tick * tick_s,
            "longest_gap_s": None if self.deployed_tick is None else max(gaps_s),
            "longest_gap_by_segment_s": {str(one): gap_s for one, gap_s in enumerate(gaps_s, start=1)},
            "recovery_s": span(self._vacancies.recovery_ticks(), tick_s),
            "recovery_full_lap_s": span(self._vacancies.recovery_full_lap_ticks(), tick_s),
            "recalls": self._recalls,
            "away_most": self._away_most,
            "flat_robots": self._flat,
            "incidents": self._incidents,
            **self._words.summary(),
            "visit_interval_s": self._visits.intervals_s(tick_s),
            "visit_frequency_hz": self._visits.frequency_hz(tick, tick_s),
            "robots": {node: one.summary(tick_s) for node, one in self._robots.items()},
        }

    def _change(self, facts: Facts) -> None:
        """Take in what robots say and what befalls them."""
        self._pass_time()
        self._modes = facts.modes
        before = self._patrolled()
        died, left = self._kill(facts), self._listen(facts)
        causes = self._befall(facts) | left | died
        after = self._patrolled()
        for segment in sorted(before.keys() - after.keys()):
            causing = [causes[node] for node in before[segment] if node in causes]
            self._vacancies.begin(segment, causing[-1], facts.tick)
        if self.deployed_tick is None and len(after) == self._segments:
            self.deployed_tick = facts.tick
            self._visits.begin(facts.tick)
        states = Counter(robot.state for robot in self._robots.values())
        self._away_most = max(self._away_most, states["home"])

    def _pass_time(self) -> None:
        """Let time go by until now, in which nobody changed."""
        passed, self._settled_tick = self._tick - self._settled_tick, self._tick
        for robot in self._robots.values():
            robot.pass_time(passed if self.deployed_tick is not None else 0)

    def _patrolled(self) -> dict[int, list[str]]:
        """Every segment that is being patrolled, and by whom."""
        found: dict[int, list[str]] = {}
        for node, robot in self._robots.items():
            if robot.state == "patrol" and 1 <= robot.segment <= self._segments:
                found.setdefault(robot.segment, []).append(node)
        return found

    def _kill(self, facts: Facts) -> dict[str, Cause]:
        """Deaths before the tick, of robots too that were started again at once; returns who died."""
        killed = {one.node for one in facts.faults if one.verb == "kill"} & self._robots.keys()
        for node in killed:
            self._robots[node].stop("death")
        return dict.fromkeys(sorted(killed), "death")

    def _befall(self, facts: Facts) -> dict[str, Cause]:
        """Who is dead or flat at the end of the tick; returns whom that took from their work."""
        causes: dict[str, Cause] = {}
        for node, mode in zip(self._nodes, facts.modes, strict=False):
            robot, condition = self._robots.get(node), ENDED_BY.get(mode)
            if robot is None or condition == robot.ended_by:
                continue
            robot.ended_by = condition
            if condition is not None:
                causes[node] = condition
                robot.stop(condition)
                self._flat += condition == "flat"
        return causes

    def _listen(self, facts: Facts) -> dict[str, Cause]:
        """What robots say of themselves; returns who has left a segment, and why."""
        causes: dict[str, Cause] = {}
        for node, said in facts.reports:
            if node == self._tower and (desk := _decoded(said, Desk)):
                self._words.tower_tells(desk.orders, desk.hops)
            robot, report = self._robots.get(node), _decoded(said, Report)
            if robot is None or report is None:
                continue
            self._words.robot_tells(report.order, report.hops)
            if robot.state == "patrol" and (report.state, report.segment) != ("patrol", robot.segment):
                causes[node] = "recall" if report.state in ("home", "queue") else "shift"
                self._recalls += report.state == "home"
            lap_ticks, return_ticks = robot.hear(facts.tick, report)
            if lap_ticks is not None:
                self._laps.add(lap_ticks)
            if return_ticks is not None:
                self._returns.add(return_ticks)
        return causes


class _Robot:
    """What is known of one robot."""

    def __init__(self) -> None:
        self.ended_by: Cause | None = None
        self.state: State | None = None
        self.segment = 0
        self.idle_ticks, self.working_ticks = 0, 0
        self._counted = 0
        self._lap_tick = self._home_tick = 0  # when its lap began, and when its way home
        self._laps, self._returns = Spread(), Spread()

    def pass_time(self, ticks: int) -> None:
        """Let time go by, in which nothing changes."""
        if self.ended_by is None:
            self.working_ticks += ticks
            self.idle_ticks += ticks * (self.state == "queue")

    def works_on(self, segment: int) -> bool:
        """Does it patrol this segment, or come to do so?"""
        return self.state in ("out", "patrol") and self.segment == segment

    def stop(self, cause: Cause) -> None:
        """It is dead or flat, and does nothing any more."""
        self.ended_by, self.state, self.segment = cause, None, 0

    def hear(self, tick: int, report: Report) -> tuple[int | None, int | None]:
        """Take in its report. Returns the ticks of a lap and of a way home, where one ends with it."""
        lap_ticks = return_ticks = None
        if self.state == "patrol" and report.laps == self._counted + 1:
            lap_ticks = tick - self._lap_tick
            self._laps.add(lap_ticks)
        if self.state == "home" and report.state == "queue":
            return_ticks = tick - self._home_tick
            self._returns.add(return_ticks)
        if (report.state, report.segment, report.laps) != (self.state, self.segment, self._counted):
            self._lap_tick = tick
        if report.state == "home" and self.state != "home":
            self._home_tick = tick
        self.state, self.segment, self._counted = report.state, report.segment, report.laps
        return lap_ticks, return_ticks

    def summary(self, tick_s: float) -> dict[str, float | int | None]:
        """Its own figures, as in the paper's Table I."""
        return {
            "lap_time_mean_s": self._laps.mean_s(tick_s),
            "lap_time_sd_s": self._laps.sd_s(tick_s),
            "laps": self._laps.count,
            "idle_share": _share(self.idle_ticks, self.working_ticks),
            "idle_s": self.idle_ticks * tick_s,
            "return_time_mean_s": self._returns.mean_s(tick_s),
        }


def _decoded(said: bytes, kind: type[Told]) -> Told | None:
    """None for a node with other words for observers: nothing is known of what it does."""
    try:
        return codec.decode(kind, said)
    except codec.Malformed:
        return None


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None
