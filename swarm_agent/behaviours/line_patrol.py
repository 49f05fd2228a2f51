"""Long-term patrol of an open polyline: queue, drive out, patrol a segment, move out one, go home.

Source: papers/line-patrol.txt, Algorithms 2 and 3: what of them a robot does. Laps are never interrupted: a
lap begins and ends at the segment's near end, where a robot that is called home or is low leaves; a robot
that moves out leaves at the far end, where the next segment begins (section III-B).
"""

import math
from collections.abc import Sequence
from typing import Annotated

import msgspec
import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from swarm_agent.line_radio import Envelope, Order, Place, Relay, Report, Roll, State, Word
from swarm_agent.line_routes import Routes
from wire.channels import number_of
from wire.line import Line
from wire.messages import (
    WAKE_ON_ARRIVAL,
    WAKE_ON_BLOCKED,
    WAKE_ON_FRAME,
    Configuration,
    Dock,
    Follow,
    Motion,
    Percept,
    Senses,
)

WAKE_ON = WAKE_ON_FRAME | WAKE_ON_ARRIVAL | WAKE_ON_BLOCKED
LATE = 1.5
"""A patrolling robot that is held up reports when its report is late by this factor; turns take time too."""
HOME = 0
"""The segment of an order to come home."""


class LinePatrolParameters(Parameters, frozen=True):
    """Batteries are reported every `report_laps` laps. Below `home_v` a robot goes home after its lap,
    whatever the tower says; in the queue it takes a new battery below `swap_below_v`. `backwards`: it drives
    back over its segment without turning. The rest limits the flooding of frames: hops, age, and how long the
    tower's own voice counts as contact.
    """

    report_laps: Annotated[int, msgspec.Meta(ge=1, le=10_000)] = 10
    home_v: Annotated[float, msgspec.Meta(ge=0)] = 8.5
    swap_below_v: Annotated[float, msgspec.Meta(ge=0)] = 8.7
    backwards: bool = False
    hops_most: Annotated[int, msgspec.Meta(ge=0, le=1000)] = 64
    age_s: Annotated[float, msgspec.Meta(gt=0)] = 60.0
    contact_s: Annotated[float, msgspec.Meta(gt=0)] = 600.0


class LinePatrol(Behaviour):
    """One robot of the line, whatever its present role."""

    Parameters = LinePatrolParameters
    Radio = Envelope

    def __init__(
        self, parameters: LinePatrolParameters, configuration: Configuration, generator: np.random.Generator
    ) -> None:
        super().__init__(parameters, configuration, generator)
        given, tick_s = parameters, configuration.tick_s
        self.line = Line(configuration.field, configuration.tower_m)
        self.routes = Routes(self.line, configuration.row, configuration.body_m)
        ticks = math.ceil(given.age_s / tick_s), given.hops_most, math.ceil(given.contact_s / tick_s)
        self.relay = Relay(configuration.node, configuration.tower, *ticks)
        longest_m = max(one.length_m for one in self.line.segments)
        lap_s = 2 * longest_m / configuration.max_speed_m_s
        self._report_ticks = math.ceil(given.report_laps * lap_s / tick_s)
        self.state: State | None = None
        self.segment = HOME
        self.laps = 0
        self.low = False
        self.order = self._hops = 0
        self.pending: int | None = None
        """Where the last order sends this robot, as long as it has not gone: a segment, or HOME."""
        self._obstacles: dict[float, int] = {}
        self._outbound_m = 0.0
        """How far along the present path the far end of the segment comes."""
        self._leaves_far_end = self._yields = False
        self._docking = False
        self._told_tick = -self._report_ticks
        self._overdue = self._tell = False

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Listen, act on what was heard and on where the body is, and report when there is reason to."""
        tick, senses = percept.tick, percept.senses
        position = (senses.pose.x_m, senses.pose.y_m)
        self._arc_m = self.line.locate(position)[0]
        self._overdue = tick >= self._report_due(tick)
        place = self._place(position)
        before = (self.state, self.segment, self.laps)
        for word in self.relay.hear(tick, heard, place):
            self._take(word)
        motion = self._begin(senses, position) if self.state is None else self._act(senses, position)
        report = self._report(senses)
        tell = self._tell or (self._overdue and not self._docking)
        changed = tell or before != (self.state, self.segment, self.laps)
        messages = (report,) if tell else ()
        self._told_tick = tick if tell else self._told_tick
        self._tell = False
        relay = not self.relay.in_contact(tick, place.apart_m)
        say = self.relay.outbox(tick, messages, place, relay)
        wake_tick = tick + 1 if self._docking else self._report_due(tick)
        wake_tick = min(wake_tick, self.relay.next_tick() or wake_tick)
        return Move(motion, say, wake_tick, WAKE_ON, report if changed else None)

    def _place(self, position: tuple[float, float]) -> Place:
        distance_m = abs(self._arc_m - self.line.tower_arc_m)
        apart_m = math.dist(position, self.configuration.tower_m)
        return Place(distance_m, apart_m, self.state == "queue")

    def _begin(self, senses: Senses, position: tuple[float, float]) -> Motion | None:
        """A newborn mind waits in the queue if its body stands there, and else goes home."""
        self._tell = True
        slot = self.line.slot(self.configuration.row)
        if math.dist(slot, position) <= self.configuration.field.slot_m / 2:
            self.state = "queue"
            return self._in_queue(senses, position)
        return self._go_home(position)

    def _act(self, senses: Senses, position: tuple[float, float]) -> Motion | None:
        if self._yields:
            return self._go_home(position, sidestep=True)
        match self.state:
            case "queue":
                return self._in_queue(senses, position)
            case "out":
                return self._on_the_way_out(senses, position)
            case "patrol":
                return self._on_patrol(senses, position)
            case "home":
                return self._on_the_way_home(senses, position)

    def _take(self, word: Word) -> None:
        """An order to us, a roll call, or somebody's claim to our segment."""
        match word.message:
            case Order(number, to, segment) if to == self.configuration.node:
                self._tell = True
                if number > self.order:
                    self.order, self._hops = number, word.hops
                    self.pending = segment if segment <= len(self.line.segments) else HOME
            case Roll(answer):
                self._tell = self._tell or answer
            case Report(state, segment, order=order) if segment == self.segment != HOME:
                if state in ("patrol", "out") and self.state in ("patrol", "out"):
                    self._settle_claim(word.origin, order)

    def _settle_claim(self, other: str, order: int) -> None:
        """Two robots believe they own one segment: the newer order holds, then the lower number.

        Who yields goes at once, in the middle of its lap: the segment is the other's to cover.
        """
        own = self.configuration.node
        self._yields |= (order, -number_of(other)) > (self.order, -number_of(own))
        self._tell = True

    def _in_queue(self, senses: Senses, position: tuple[float, float]) -> Motion | None:
        if self._docking:  # the new battery is in: now its charge can be told
            self._docking, self._tell = False, True
        if self.pending:
            return self._go_out(position, from_queue=True)
        self.pending = None
        if self._overdue and senses.battery_v is not None:
            self._docking = senses.battery_v < self.parameters.swap_below_v
        return Dock() if self._docking else None

    def _on_the_way_out(self, senses: Senses, position: tuple[float, float]) -> Motion | None:
        if self.pending == HOME:
            return self._go_home(position)
        if self.pending is not None and self.pending != self.segment:
            return self._go_out(position, from_queue=False)
        self.pending = None
        near_m = self.line.segment(self.segment).near_m
        if senses.blocked_by is not None:
            self._note_obstacle(senses)
            if abs(self._arc_m - near_m) > 3 * self.configuration.body_m:
                return self._follow(self.routes.over(self._arc_m, near_m, self._obstacles))
        elif not senses.arrived:
            return None
        self.state, self.laps, self._tell = "patrol", 0, True
        return self._lap(near_m)

    def _on_patrol(self, senses: Senses, position: tuple[float, float]) -> Motion | None:
        if self.pending == self.segment:
            self.pending = None
        if senses.blocked_by is not None:
            self._note_obstacle(senses)
            self._tell = True  # if it is a robot that believes this segment is its own, this settles it
            return self._rest_of_lap(senses)
        if senses.arrived:
            return self._at_end_of_way(senses, position)
        if self._moves_out() and not self._leaves_far_end:
            return self._rest_of_lap(senses)
        return None

    def _at_end_of_way(self, senses: Senses, position: tuple[float, float]) -> Motion:
        if not self._leaves_far_end:
            self.laps += 1
        self.low = senses.battery_v is not None and senses.battery_v <= self.parameters.home_v
        if self.low or self.pending == HOME:
            return self._go_home(position)
        if self.pending is not None and (self._leaves_far_end or not self._moves_out()):
            return self._go_out(position, from_queue=False)
        if self.laps % self.parameters.report_laps == 0:
            self._tell = True
        self._obstacles = {
            arc: since
            for arc, since in self._obstacles.items()
            if self.laps - since < self.parameters.report_laps
        }
        if self._moves_out():
            return self._to_far_end(self._arc_m)
        return self._lap(self._arc_m)

    def _on_the_way_home(self, senses: Senses, position: tuple[float, float]) -> Motion | None:
        self.pending = None
        if senses.blocked_by is not None:
            return self._follow(self.routes.home(position, sidestep=True))
        if not senses.arrived:
            return None
        self.state, self.laps, self.low, self._docking = "queue", 0, False, True
        return Dock()

    def _go_out(self, position: tuple[float, float], from_queue: bool) -> Motion:
        assert self.pending, "nowhere to go"
        self.state, self.segment, self.pending, self.laps = "out", self.pending, None, 0
        self._forget_lap()
        return self._follow(self.routes.out(position, from_queue, self.segment))

    def _go_home(self, position: tuple[float, float], sidestep: bool = False) -> Motion:
        self.state, self.segment, self.pending, self._yields = "home", HOME, None, False
        self._forget_lap()
        return self._follow(self.routes.home(position, sidestep))

    def _forget_lap(self) -> None:
        self._tell, self._leaves_far_end, self._obstacles = True, False, {}

    def _moves_out(self) -> bool:
        """Is this robot to take a segment further out, so that it leaves at its far end?"""
        if not self.pending or self.pending == self.segment:
            return False
        return self.segment in self.line.inward(self.pending)

    def _lap(self, from_m: float) -> Motion:
        """There and back, from the near end."""
        own = self.line.segment(self.segment)
        out = self.routes.over(from_m, own.far_m, self._obstacles)
        self._leaves_far_end, self._outbound_m = False, _length_m(self.line.point(from_m), out)
        return self._follow(out + self.routes.over(own.far_m, own.near_m, self._obstacles))

    def _to_far_end(self, from_m: float) -> Motion:
        self._leaves_far_end = True
        return self._follow(self.routes.over(from_m, self.line.segment(self.segment).far_m, self._obstacles))

    def _rest_of_lap(self, senses: Senses) -> Motion:
        """The lap from here on, as far as it will be driven: to the far end if the robot then moves out."""
        own, here_m = self.line.segment(self.segment), self._arc_m
        if senses.travelled_m <= self._outbound_m + 1e-6 or self._leaves_far_end:
            return self._to_far_end(here_m) if self._moves_out() else self._lap(here_m)
        back = self.routes.over(here_m, own.near_m, self._obstacles)
        self._outbound_m = 0.0
        if not self._moves_out():
            return self._follow(back)
        self._leaves_far_end = True
        return self._follow(back + self.routes.over(own.near_m, own.far_m, self._obstacles))

    def _note_obstacle(self, senses: Senses) -> None:
        seen = {one.node: (one.x_m, one.y_m) for one in senses.in_sight}
        if senses.blocked_by in seen:
            self._obstacles[self.line.locate(seen[senses.blocked_by])[0]] = self.laps

    def _follow(self, path: Sequence[tuple[float, float]]) -> Motion:
        return Follow(tuple(path), self.parameters.backwards and self.state == "patrol")

    def _report_due(self, tick: int) -> int:
        """The tick of the next report that comes by time; a patrolling robot's come by laps, unless late."""
        late = LATE if self.state == "patrol" else 1.0
        return max(tick, self._told_tick + math.ceil(late * self._report_ticks))

    def _report(self, senses: Senses) -> Report:
        battery_v = senses.battery_v or 0.0
        return Report(self.state, self.segment, battery_v, self.order, self.laps, self.low, self._hops)


def _length_m(start: tuple[float, float], path: Sequence[tuple[float, float]]) -> float:
    return math.fsum(math.dist(one, other) for one, other in zip([start, *path], path, strict=False))
