"""Mission "line" as the world plays it: paths and noise, traffic, batteries, and who passed which site."""

import math
from collections.abc import Sequence

import numpy as np

from wire.channels import number_of
from wire.line import Line
from wire.messages import Action, Dock, Pose
from wire.scenario import Scenario
from world_server import chance
from world_server.area import Pairs, Visits
from world_server.battery import Batteries
from world_server.motion import Body
from world_server.nodes import ALIVE, DEAD, Node
from world_server.passes import AT_SITE_M, Passes, Places, Visit
from world_server.path_following import NEAR_M, Drive, PathBody
from world_server.traffic import Traffic

BLOCK = 1024
DOCK_SLACK_M = 0.05


class LinePatrol:
    """What a mission adds to the world: bodies, how they settle, and what counts as a visit."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._line = Line(scenario.field, (scenario.tower.x_m, scenario.tower.y_m))
        self._drive = _drive(scenario)
        self._places = Places(scenario.field.points_m)
        names = scenario.robot_ids
        self._slots = {name: self._line.slot(row) for row, name in enumerate(names)}
        self._slots_m = np.array(list(self._slots.values()))
        self._within_m = scenario.field.slot_m / 2 + DOCK_SLACK_M
        near_m = max(AT_SITE_M, self._drive.reach_m if scenario.robots.noise_sd > 0 else 0.0)
        self._passes = Passes(self._line.sites_m(), near_m, self._line.lane_m, len(names))
        self._arrivals: list[Visit] = []
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
        _, self._arrivals = self._passes.follow(*self._places.locate(self._positions_m()), {})
        for robot in range(len(self._robots)):
            self._fall_flat_if_empty(robot)

    @property
    def restless(self) -> bool:
        """Is the next tick to be settled even though nobody moves or is due? Batteries always drain."""
        return self._batteries is not None or bool(self._arrivals)

    def battery_v(self, row: int) -> float | None:
        """What a node's battery says; the tower has none."""
        if self._batteries is None or row not in self._robot_of:
            return None
        return float(self._batteries.volts[self._robot_of[row]])

    def volts(self) -> bytes:
        """The charge of all nodes as Facts keep it: the tower's is NaN."""
        if self._batteries is None:
            return b""
        volts = np.full(len(self._rows) + 1, np.nan, dtype="<f4")
        volts[self._rows] = self._batteries.volts
        return volts.tobytes()

    def visits(self) -> Visits:
        """The visits of the last tick's motion."""
        arrivals, self._arrivals = self._arrivals, []
        return self._named(arrivals)

    def acted(self, row: int, action: Action) -> None:
        """Docking is charging, at the robot's own place in the queue; any other motion ends it."""
        robot = self._robot_of.get(row)
        if self._batteries is None or robot is None or action.motion is None:
            return
        body, slot = self._robots[robot].body, self._slots[self._robots[robot].name]
        at_place = math.dist((body.x_m, body.y_m), slot) <= self._within_m
        if isinstance(action.motion, Dock) and at_place:
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
        self._fall_flat_if_empty(robot)

    def settle(self, tick: int) -> tuple[Visits, Pairs]:
        """One tick of all bodies. Returns further visits of the tick, and who has come too close to whom."""
        self._traffic.move(self._scenario.tick_s, self._chance(tick))
        positions_m = self._positions_m()
        arcs_m, asides_m = self._places.locate(positions_m)
        on_line = np.abs(asides_m) <= self._line.lane_m / 2
        if self._batteries is not None:
            self._drain(positions_m, on_line)
        turns_m = {
            robot: [self._line.locate(point)[0] for point in node.body.passed]
            for robot, node in enumerate(self._robots)
            if node.body.passed
        }
        departures, arrivals = self._passes.follow(arcs_m, asides_m, turns_m)
        self._arrivals = self._living(arrivals)
        return self._named(self._living(departures)), self._traffic.incidents(positions_m, on_line)

    def _drain(self, positions_m: np.ndarray, on_line: np.ndarray) -> None:
        away = positions_m - self._slots_m
        resting = np.array([node.body.at_rest for node in self._robots])
        queueing = resting & ((away * away).sum(axis=1) <= self._within_m**2)
        dead = np.array([node.mode == DEAD for node in self._robots])
        for robot in self._batteries.use(queueing, on_line, dead):
            self._fall_flat_if_empty(robot)

    def _fall_flat_if_empty(self, robot: int) -> None:
        if self._batteries is not None and self._batteries.is_empty(robot):
            self._robots[robot].run_flat()

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

    def _positions_m(self) -> np.ndarray:
        return np.array([(node.body.x_m, node.body.y_m) for node in self._robots])

    def _living(self, visits: list[Visit]) -> list[Visit]:
        return [visit for visit in visits if self._robots[visit[0]].mode == ALIVE]

    def _named(self, visits: list[Visit]) -> Visits:
        return tuple((self._robots[robot].name, site) for robot, site in sorted(visits))


def _drive(scenario: Scenario) -> Drive:
    robots = scenario.robots
    step_m = robots.max_speed_m_s * scenario.tick_s
    look_ahead_m = max(step_m, scenario.field.lane_m / 2)
    reach_m = step_m / 2 if robots.noise_sd > 0 else NEAR_M
    return Drive(robots.max_speed_m_s, robots.max_turn_rad_s, look_ahead_m, robots.noise_sd, reach_m)
