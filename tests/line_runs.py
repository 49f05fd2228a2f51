"""Synthetic runs of a line patrol: bodies that drive, say what they do, and lose charge."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from deploy.scenario_file import to_toml
from swarm_agent.line_radio import Report
from wire import codec
from wire.fields import Polyline
from wire.line import Line
from wire.messages import Facts
from wire.scenario import BatterySection, InQueue, RadioSection, Range, Robots, Scenario, TowerSection
from world_server.journal import Journal
from world_server.records import Commit

STILL = "swarm_agent.behaviours.stand_still:StandStill"
FULL_V, LOW_V, EMPTY_V = 9.0, 8.5, 8.0
SPEED_M_S = 0.1
RANGE_M = 2.0


def line_scenario(duration_s: float = 600.0, battery: bool = True, **fields: object) -> Scenario:
    """Eight robots and a tower at the middle of a line with six segments."""
    robots = Robots(STILL, 8, start=InQueue(), max_speed_m_s=SPEED_M_S, max_turn_rad_s=2.0, body_m=0.2)
    told = {
        "field": Polyline(((0.0, 0.0), (6.0, 0.0)), 6, gap_m=0.2),
        "tower": TowerSection("r1", STILL, {}, 3.0, 0.0),
        "radio": RadioSection((Range(RANGE_M),)),
    }
    charge = BatterySection(FULL_V, EMPTY_V) if battery else None
    return Scenario("line", duration_s, robots=robots, battery=charge, **(told | fields))


class Body:
    """One robot: in the queue, out on the lane, to and fro on its segment, home on the lane."""

    def __init__(self, line: Line, row: int, charge_v: float) -> None:
        self.line, self.row, self.charge_v = line, row, charge_v
        self.state, self.segment, self.mode = "queue", 0, 0
        self.arc_m, self.goal_m = line.tower_arc_m, line.tower_arc_m

    @property
    def place_m(self) -> tuple[float, float]:
        """Where it is."""
        if self.state == "queue":
            return self.line.slot(self.row)
        return self.line.point(self.arc_m, 0.0 if self.state == "patrol" else self.line.lane_m)

    def send(self, segment: int) -> None:
        """Let it take a segment."""
        self.state, self.segment = "out", segment
        self.goal_m = self.line.segment(segment).near_m

    def drive(self, drain_v_s: float) -> list[int]:
        """One second; returns the sites that it visits."""
        if self.mode:
            return []
        self.charge_v -= drain_v_s * (0.3 if self.state == "queue" else 1.0)
        if self.charge_v <= EMPTY_V:
            self.mode = 3
        before_m = self.arc_m
        self.arc_m += float(np.clip(self.goal_m - self.arc_m, -SPEED_M_S, SPEED_M_S))
        if self.state == "patrol":
            return self._patrol(before_m)
        if self.arc_m == self.goal_m and self.state != "queue":
            self.state = {"out": "patrol", "home": "queue"}[self.state]
            self.charge_v = self.charge_v if self.state == "patrol" else FULL_V
        return []

    def _patrol(self, before_m: float) -> list[int]:
        one, first = self.line.segment(self.segment), 3 * (self.segment - 1)
        low, high = sorted((before_m, self.arc_m))
        places = enumerate((one.left_m, one.mid_m, one.right_m))
        visits = [first + site for site, arc_m in places if low <= arc_m <= high]
        if self.arc_m == self.goal_m:
            self.goal_m = one.near_m if self.goal_m == one.far_m else one.far_m
            if self.charge_v < LOW_V and self.arc_m == one.near_m:
                self.state, self.segment, self.goal_m = "home", 0, self.line.tower_arc_m
        return visits


class Struck(NamedTuple):
    """From `tick` on, the robot in `row` has this mode."""

    tick: int
    row: int
    mode: int


def line_facts(given: Scenario, struck: tuple[Struck, ...] = (), drain_v_s: float = 0.001) -> Iterator[Facts]:
    """All facts of a synthetic run."""
    line = Line(given.field, (given.tower.x_m, given.tower.y_m))
    bodies = [Body(line, row, FULL_V - 0.03 * row) for row in range(len(given.robot_ids))]
    said = {}
    for tick in range(given.last_tick + 1):
        for one in struck:
            if one.tick == tick:
                bodies[one.row - 1].mode = one.mode
        served = {body.segment for body in bodies}
        waiting = [body for body in bodies if body.state == "queue" and not body.mode]
        vacant = [one for one in (1, 6, 2, 5, 3, 4) if one not in served]
        if tick % 10 == 5 and waiting and vacant:
            max(waiting, key=lambda body: body.charge_v).send(vacant[0])
        visits = [(given.node_ids[body.row + 1], site) for body in bodies for site in body.drive(drain_v_s)]
        reports = []
        for body in bodies:
            report = codec.encode(Report(body.state, body.segment, round(body.charge_v, 1)))
            if not body.mode and said.get(body.row) != report:
                said[body.row] = report
                reports.append((given.node_ids[body.row + 1], report))
        yield _facts(given, tick, bodies, tuple(visits), tuple(reports))


def _facts(given: Scenario, tick: int, bodies: list[Body], visits: tuple, reports: tuple) -> Facts:
    places_m = np.array([(given.tower.x_m, given.tower.y_m), *(body.place_m for body in bodies)])
    poses = np.column_stack([places_m, np.zeros(len(places_m))])
    apart_m = np.hypot(*(places_m[:, None] - places_m[None]).transpose(2, 0, 1))
    talking = np.array([True, *(not body.mode and (tick + body.row) % 5 == 0 for body in bodies)])
    near = (apart_m <= RANGE_M) & ~np.eye(len(places_m), dtype=bool) & talking[:, None] & talking[None]
    links = np.argwhere(near).astype("<u2")
    charges_v = np.array([np.nan, *(body.charge_v for body in bodies)], "<f4")
    return Facts(
        tick,
        poses.tobytes(),
        np.full((len(places_m), 2), np.nan).tobytes(),
        bytes([0, *(body.mode for body in bodies)]),
        links.tobytes(),
        visits,
        reports,
        (),
        (0, len(links), 0, 0, 0, 0),
        charges_v.tobytes() if given.battery is not None else b"",
    )


def write_line_run(folder: Path, given: Scenario, facts: list[Facts]) -> None:
    """A run folder with the scenario and a journal of these facts."""
    toml = to_toml(given)
    (folder / "scenario.toml").write_text(toml)
    with (folder / "journal").open("ab") as stream:
        journal = Journal(stream, given, toml, facts[0].poses)
        for one in facts:
            journal.append(Commit(one.tick, (), (), (b"", b"", b"", b""), one))
        journal.close(facts[-1].tick, completed=True)
