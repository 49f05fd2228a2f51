"""Sweep lines: robots without a map or a position clear a building that they have never seen.

All robots run this; roles come about by talking. What each part does stands in swarm_agent/sweep.

Source: Kolling and Carpin, "Multi-robot pursuit-evasion without maps", ICRA 2010. The errors of its
pseudocode, and where we do otherwise: docs/clear.md.
"""

import math
from collections.abc import Sequence
from typing import Annotated, Literal, Self

import msgspec
import numpy as np

from swarm_agent.behaviour import Air, Behaviour, Heard, Move
from swarm_agent.behaviour import Parameters as BaseParameters
from swarm_agent.graph_copy import NOTHING, Version
from swarm_agent.sweep import events, fallen, flows, gait, links
from swarm_agent.sweep.beginning import Beginning
from swarm_agent.sweep.captain import Captain
from swarm_agent.sweep.outlook import Outlook, look, obstacle
from swarm_agent.sweep.radio import WALL, Beacon, Lacking, Spoken
from swarm_agent.sweep.reserve import Reserve
from swarm_agent.sweep.resting import Slot, Strides
from swarm_agent.sweep.robot import Robot
from wire import codec
from wire.clearing import Standing
from wire.messages import Configuration, Percept, Shift

Metres = Annotated[float, msgspec.Meta(gt=0)]
Ticks = Annotated[int, msgspec.Meta(ge=1, le=100_000)]
STILL_M = 1e-6
FOLLOW_M = {"plain": 1.0, "robust": 0.55}
RARELY = 1e-6  # false deaths by loss alone, for each link and hour
DELAYED_TICKS = 5  # for so long a frame may be late for any other reason


class Parameters(BaseParameters, frozen=True):
    """Robots on a line stand at most `follow_m` apart; leaders stay `obstacle_m` from walls.

    `spacing`: "robust" for a line that holds without any one of its robots, "plain" (as None is) for one that
    need not. `follow_m` is 1 m in a plain line, and 0.55 m in a robust one, unless it is given.

    A robot leaves a line whose neighbours are `slack_m` nearer than they may be. `choose`: which part of a
    split line moves on, the one with more or with fewer robots. `team`: how many robots there are; None: all
    of the scenario. `dead_ticks`: who is silent for longer is dead. `hop_ticks`: how long news takes from one
    robot to the next, the slowest robot included. None: as the scenario's radio and faults call for.
    `patience_ticks`: how long to wait for one more robot that should come; `beginnings`: how often to begin
    again elsewhere before the team says that it failed.
    """

    spacing: Literal["plain", "robust"] | None = None
    follow_m: Metres | None = None
    obstacle_m: Metres = 0.25
    slack_m: Metres = 0.1
    choose: Literal["more", "fewer"] = "more"
    team: Annotated[int, msgspec.Meta(ge=1)] | None = None
    dead_ticks: Ticks | None = None
    hop_ticks: Ticks | None = None
    patience_ticks: Ticks = 1000
    beginnings: Annotated[int, msgspec.Meta(ge=0)] = 4

    def settled(self, team_size: int) -> Self:
        """The team is everybody but the tower, unless it is given; a plain line is said by leaving it out."""
        spacing = None if self.spacing == "plain" else self.spacing
        return msgspec.structs.replace(
            self,
            spacing=spacing,
            follow_m=self.follow_m or FOLLOW_M[spacing or "plain"],
            team=self.team or max(1, team_size - 1),
        )

    def in_air(self, air: Air) -> Self:
        """Nobody is taken for dead whose frames are only late, or lost as often as one must reckon with."""
        hop_ticks = self.hop_ticks or air.latency_ticks + air.grant_ticks - 1
        frames = 1
        if air.loss > 0:
            if air.loss >= 1:
                raise ValueError("a team whose radio loses every frame cannot clear anything")
            frames = math.ceil(math.log(RARELY * air.tick_s / 3600) / math.log(air.loss))
        dead_ticks = self.dead_ticks or hop_ticks + air.grant_ticks * (frames - 1) + DELAYED_TICKS
        return msgspec.structs.replace(self, hop_ticks=hop_ticks, dead_ticks=dead_ticks)


class SweepLine(Behaviour):
    """A robot of a sweep team."""

    Parameters = Parameters
    Radio = Spoken

    def __init__(
        self, parameters: Parameters, configuration: Configuration, generator: np.random.Generator
    ) -> None:
        super().__init__(parameters, configuration, generator)
        self.robot = Robot(configuration, parameters)
        self.beginning, self.captain = Beginning(), Captain()
        self.reserve, self.slot, self.strides = Reserve(), Slot(), Strides()
        self._outlook: Outlook | None = None
        self._wanted = 0j
        self._drawn = NOTHING
        """The newest version of the graph that observers know from this robot."""
        self._lacking: list[Version] = []
        """Versions of listeners that are no robots."""

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Look, listen, agree with the neighbours, move, and tell."""
        robot = self.robot
        self._sense(percept, heard)
        self.beginning.hear(robot, self.reserve)
        if robot.role == "leader" and robot.stage == "forming":
            self.beginning.await_second(robot)
        elif robot.beside["left"] or robot.beside["right"]:
            self._stand_in_line()
        self._claim()
        way = self._way()
        self._wanted = way
        if abs(way) > STILL_M:
            robot.moved = robot.tick
        flows.tell(robot)
        return Move(Shift(way.real, way.imag), (self._beacon(),), robot.tick + 1, report=self._standing())

    def _sense(self, percept: Percept, heard: Sequence[Heard]) -> None:
        robot, senses = self.robot, percept.senses
        if percept.why == "start":
            robot.born = percept.tick
        robot.tick, robot.events = percept.tick, []
        beacons = [one for one in heard if isinstance(one.message, Beacon)]
        self._lacking = [one.message.version for one in heard if isinstance(one.message, Lacking)]
        robot.peers.take(percept.tick, complex(*senses.odometry_m), beacons)
        robot.ranges_m = np.frombuffer(senses.scan, "<f4").astype(float)
        seen = np.isfinite(robot.ranges_m)
        robot.hits = robot.here + robot.ranges_m[seen] * robot.eye.units[seen]
        fallen.bump(robot, self._wanted, complex(*senses.odometry_m))
        for peer in robot.peers.known.values():
            if peer.beacon.delta is not None:
                robot.graph.take(peer.beacon.delta)

    def _stand_in_line(self) -> None:
        """Tend the links, and see what is to be decided."""
        robot, before = self.robot, self.robot.role
        lost = trouble = links.tend(robot)
        if not lost and robot.on_line:
            flows.hear(robot)
            robot.order = robot.told["right"].order if robot.told["right"] else robot.order
            self._outlook = look(robot)
            robot.open = bool(self._outlook.frontier.any())
            robot.obstacle = obstacle(robot, self._outlook)
            events.decide(robot, self._outlook)
            if robot.role == "leader" and robot.beside["right"] == WALL:
                trouble = self.captain.command(robot)
        if trouble:
            self.beginning.again(robot, trouble, home=bool(lost))
        elif robot.role == "reserve" and before != "reserve":
            self.reserve.begin(robot)
            if before == "joining":
                self.reserve.refused(robot)

    def _claim(self) -> None:
        """All is done when a line has dissolved and no other is left; whoever hears of it agrees."""
        robot = self.robot
        main = robot.graph.main
        if robot.role == "reserve" and main is not None and main.line in robot.gone:
            robot.graph.dissolve()  # it had nothing ahead any more when it was chosen
            events.choose_next(robot)
        left = robot.graph.main is not None or set(robot.graph.lines()) - robot.gone
        if robot.role == "reserve" and robot.graph.cleared() and not left:
            robot.claim = "done"

    def _way(self) -> complex:
        robot = self.robot
        if robot.role == "free":
            return self.beginning.first(robot)
        if robot.role == "anchor":
            return self.beginning.gather(robot)
        if robot.role == "reserve":
            asked = self.beginning.second(robot)
            return self.reserve.way(robot) if asked is None else asked
        if robot.role == "leader" and robot.stage != "forming" and self._outlook is not None:
            outlook = look(robot) if robot.since_role == robot.tick else self._outlook
            return gait.lead(robot, outlook, self.strides)
        if robot.role in ("centre", "leaving"):
            return gait.keep(robot, self.slot)
        return 0j

    def _beacon(self) -> Beacon:
        robot = self.robot
        version = robot.graph.version
        robots = [one.beacon.version for one in robot.peers.known.values() if one.beacon.version < version]
        older = robots or [one for one in self._lacking if one < version]  # robots come first
        wall = robot.contact - robot.here
        return Beacon(
            robot.role,
            robot.line,
            robot.since,
            robot.beside["left"],
            robot.beside["right"],
            robot.ahead,
            robot.rank,
            robot.tail,
            robot.eye.packed(robot.ranges_m),
            robot.peers.measured,
            robot.flows["left"],
            robot.flows["right"],
            robot.pinned,
            robot.close,
            robot.ready,
            wall.real,
            wall.imag,
            robot.stage,
            robot.meets,
            robot.epoch,
            robot.anchor,
            robot.couriers,
            self.reserve.round.hand,
            tuple(sorted(robot.dead)),
            fallen.told(robot),
            tuple(sorted(robot.gone)),
            version,
            robot.graph.delta_since(min(older)) if older else None,
        )

    def _standing(self) -> Standing:
        robot = self.robot
        nothing_held = robot.graph.main is None and not robot.graph.lines()
        newest, wall = robot.graph.version, robot.contact - robot.here
        wrote = newest.writer == self.configuration.node and newest != self._drawn
        self._drawn = newest
        return Standing(
            robot.role,
            robot.line,
            robot.is_main,
            _name(robot.beside["left"]),
            _name(robot.beside["right"]),
            robot.claim,
            nothing_held,
            tuple(one for one in robot.events if one != "closed"),
            codec.encode(robot.graph.delta_since(NOTHING)) if wrote else b"",
            (wall.real, wall.imag) if robot.role == "leader" else (0.0, 0.0),
            robot.epoch,
        )


def _name(number: int) -> str:
    return "wall" if number == WALL else f"r{number}" if number > 0 else ""
