"""Mission "line" as the world plays it: paths and noise, traffic, batteries, and who passed which site."""

import math
from collections.abc import Sequence

import numpy as np

from wire.channels import number_of
from wire.line import Line
from wire.messages import Action, Dock, Pose
from wire.scenario import Scenario
from world_server import chance
from world_server.battery import NOTHING, PATROLLING, QUEUEING, TRAVELLING, Batteries
from world_server.mission import Mission, Pairs, Visits
from world_server.motion import Body
from world_server.nodes import ALIVE, DEAD, Node
from world_server.passes import AT_SITE_M, Passes
from world_server.path_following import NEAR_M, Drive, PathBody
from world_server.traffic import Traffic

BLOCK = 1024
DOCK_SLACK_M = 0.05


class LinePatrol(Mission):
    """Bodies follow paths, keep their distance, lose charge, and pass sites."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario)
        self._line = Line(scenario.field, (scenario.tower.x_m, scenario.tower.y_m))
        self._drive = _drive(scenario)
        names = scenario.robot_ids
        self._slots = {name: self._line.slot(row) for row, name in enumerate(names)}
        self._within_m = scenario.field.slot_m / 2 + DOCK_SLACK_M
        near_m = max(AT_SITE_M, self._drive.reach_m if scenario.robots.noise_sd > 0 else 0.0)
        self._passes = Passes(self._line.sites_m(), near_m, self._line.lane_m, len(names))
        self._arrivals: list[tuple[str, int]] = []
        section = scenario.battery
        self._batteries = section and Batteries(section, names, scenario.seed, scenario.tick_s)
        self._rows = [row for row, name in enumerate(scenario.node_ids) if name != scenario.tower.id]
        self._robot_of = {row: robot for robot, row in enumerate(self._rows)}
        self._robots: list[Node] = []
        self._draws, self._draws_block = np.empty(0), -1
        self._still = [(0.0, 0.0)] * len(names)

    def body(self, name: str, pose: Pose) -> Body:
        """The body of a node."""
        return Body(pose, 0.0, 0.0) if name == self._scenario.tower.id else PathBody(pose, self._drive)

    def begin(self, nodes: Sequence[Node]) -> None:
        """All nodes stand where they begin."""
        self._robots = [nodes[row] for row in self._rows]
        self._traffic = Traffic(self._line, self._scenario.robots.body_m, self._robots)
        self._on_line = [False] * len(self._robots)
        for robot in range(len(self._robots)):
            self._watch(robot)
            self._fall_flat_if_empty(robot)

    @property
    def restless(self) -> bool:
        """Is the next tick to be settled even though nobody moves or is due? Batteries always drain."""
        return self._batteries is not None or bool(self._arrivals)

    def battery_v(self, row: int) -> float | None:
        """What a node's battery says; the tower has none."""
        if self._batteries is None or row not in self._robot_of:
            return None
        return self._batteries.volts[self._robot_of[row]]

    def volts(self) -> bytes:
        """The charge of all nodes as Facts keep it: the tower's is NaN."""
        if self._batteries is None:
            return b""
        volts = [math.nan] * (len(self._rows) + 1)
        for row, charge_v in zip(self._rows, self._batteries.volts, strict=True):
            volts[row] = charge_v
        return np.array(volts, dtype="<f4").tobytes()

    def visits(self, tick: int) -> Visits:
        """The visits of the last tick's motion."""
        arrivals, self._arrivals = self._arrivals, []
        return tuple(arrivals)

    def acted(self, row: int, action: Action) -> None:
        """Docking is charging, at the robot's own place in the queue; any other motion ends it."""
        robot = self._robot_of.get(row)
        if self._batteries is None or robot is None or action.motion is None:
            return
        if isinstance(action.motion, Dock) and self._queueing(self._robots[robot]):
            self._batteries.dock(robot)
        else:
            self._batteries.undock(robot)

    def restarted(self, row: int, in_queue: bool) -> None:
        """A new process finds the body where it lay, or carried to its place in the queue and charged."""
        robot = self._robot_of.get(row)
        if robot is None:
            return
        if in_queue:
            node = self._robots[robot]
            node.body.carry_to(Pose(*self._slots[node.name], 0.0))
            node.recharge()
            if self._batteries is not None:
                self._batteries.refill(robot)
            self._watch(robot)
        self._fall_flat_if_empty(robot)

    def settle(self, tick: int) -> tuple[Visits, Pairs]:
        """One tick of all bodies. Returns further visits of the tick, and who has come too close to whom."""
        departures = [
            visit
            for robot in self._traffic.move(self._scenario.tick_s, self._chance(tick))
            for visit in self._watch(robot)
        ]
        if self._batteries is not None:
            for robot, node in enumerate(self._robots):
                self._batteries.use(robot, self._doing(robot, node))
                self._fall_flat_if_empty(robot)
        return tuple(departures), self._traffic.incidents(self._on_line)

    def _watch(self, robot: int) -> list[tuple[str, int]]:
        """Where a robot has come to. Returns its departures from sites; its arrivals are kept for later."""
        node = self._robots[robot]
        arc_m, aside_m = self._line.locate((node.body.x_m, node.body.y_m))
        self._on_line[robot] = abs(aside_m) <= self._line.lane_m / 2
        passed = node.body.passed
        turns_m = [self._line.locate(point)[0] for point in passed] if passed else ()
        departures, arrivals = self._passes.follow(robot, arc_m, aside_m, turns_m)
        if node.mode != ALIVE:
            return []
        self._arrivals += [(node.name, site) for site in arrivals]
        return [(node.name, site) for site in departures]

    def _doing(self, robot: int, node: Node) -> int:
        """What a robot does, by the world's own judgement."""
        if node.mode == DEAD:
            return NOTHING
        if self._on_line[robot]:
            return PATROLLING
        return QUEUEING if node.body.at_rest and self._queueing(node) else TRAVELLING

    def _queueing(self, node: Node) -> bool:
        """Is a robot at its own place in the queue?"""
        slot_m = self._slots[node.name]
        return math.dist((node.body.x_m, node.body.y_m), slot_m) <= self._within_m

    def _fall_flat_if_empty(self, robot: int) -> None:
        node = self._robots[robot]
        if self._batteries is not None and not node.flat and self._batteries.is_empty(robot):
            node.run_flat()

    def _chance(self, tick: int) -> Sequence[Sequence[float]]:
        """Two normal numbers for every robot, whether it moves or not: blocks are drawn ahead of time."""
        if self._scenario.robots.noise_sd == 0:
            return self._still
        block, row = divmod(tick, BLOCK)
        if self._draws_block != block:
            drawn = [
                chance.generator(self._scenario.seed, "motion", number_of(node.name), block).standard_normal(
                    (BLOCK, 2)
                )
                for node in self._robots
            ]
            self._draws, self._draws_block = np.stack(drawn, axis=1), block
        return self._draws[row].tolist()


def _drive(scenario: Scenario) -> Drive:
    robots = scenario.robots
    step_m = robots.max_speed_m_s * scenario.tick_s
    look_ahead_m = max(step_m, scenario.field.lane_m / 2)
    reach_m = step_m / 2 if robots.noise_sd > 0 else NEAR_M
    return Drive(robots.max_speed_m_s, robots.max_turn_rad_s, look_ahead_m, robots.noise_sd, reach_m)
