"""The overlapping patrol of earlier work: every robot moves over `overlap` segments and back, in step.

Source: papers/line-patrol.txt, Algorithm 1. Robot j begins at the left end of segment j. Robots synchronise
by time, which they share: a half period lasts as long as `overlap` segments and one turn. Who would run past
the right end of the line stops there and comes back when the others have caught up (lines 4-6).
"""

import math
from collections.abc import Sequence
from typing import Annotated

import msgspec
import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from swarm_agent.line_radio import Report
from swarm_agent.line_routes import Routes
from wire.line import Line
from wire.messages import WAKE_ON_ARRIVAL, Configuration, Follow, Percept

CLOSE_M = 1e-3


class OverlapPatrolParameters(Parameters, frozen=True):
    """`turn_s`: time lost at each end by turning and waiting (c). `backwards`: no turn to drive back."""

    overlap: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 1
    turn_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    backwards: bool = True


class OverlapPatrol(Behaviour):
    """One robot of the formation. It is mute, and never called home."""

    Parameters = OverlapPatrolParameters

    def __init__(
        self,
        parameters: OverlapPatrolParameters,
        configuration: Configuration,
        generator: np.random.Generator,
    ) -> None:
        super().__init__(parameters, configuration, generator)
        line, tick_s = Line(configuration.field, configuration.tower_m), configuration.tick_s
        self.line, self.in_place = line, False
        self.routes = Routes(line, configuration.row, body_m=0.0)
        self.number = configuration.row % len(line.segments) + 1
        last = min(self.number + parameters.overlap - 1, len(line.segments))
        self.left_m, self.right_m = line.segment(self.number).left_m, line.segment(last).right_m
        spans_m = [line.segment(one).right_m for one in range(parameters.overlap, len(line.segments) + 1)]
        lefts_m = [one.left_m for one in line.segments]
        longest_m = max(right - left for right, left in zip(spans_m, lefts_m, strict=False))
        speed_m_s = configuration.max_speed_m_s
        self.half_ticks = math.ceil(round((longest_m / speed_m_s + parameters.turn_s) / tick_s, 6))
        missing_m = longest_m - (self.right_m - self.left_m)
        self.wait_ticks = math.ceil(round(missing_m / speed_m_s / tick_s, 6))
        """How long it stands at the right end, twice: until the others come, and until they have gone."""
        self.laps = 0

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Get into place, then set out at the beginning of each half period; wait in between."""
        tick = percept.tick
        if not self.in_place:
            return self._get_into_place(percept)
        period, phase = divmod(tick, 2 * self.half_ticks)
        back_tick = self.half_ticks + self.wait_ticks
        if phase == 0:
            path, later = self.routes.over(self.left_m, self.right_m), back_tick
        elif phase == back_tick:
            path, later = self.routes.over(self.right_m, self.left_m), 2 * self.half_ticks
        else:
            return Move(wake_tick=tick - phase + (back_tick if phase < back_tick else 2 * self.half_ticks))
        battery_v = percept.senses.battery_v or 0.0
        report = Report("patrol", self.number, battery_v, laps=period) if phase == 0 else None
        motion = Follow(tuple(path), self.parameters.backwards)
        return Move(motion, wake_tick=tick - phase + later, report=report)

    def _get_into_place(self, percept: Percept) -> Move:
        """To the left end of the own segment; with more robots than segments the last ones rest."""
        if self.configuration.row >= len(self.line.segments):
            return Move()
        senses, left = percept.senses, self.line.point(self.left_m)
        position = (senses.pose.x_m, senses.pose.y_m)
        if math.dist(position, left) <= CLOSE_M or (senses.arrived and senses.travelled_m > 0):
            self.in_place = True
            return self.step(percept, ())
        if senses.travelled_m > 0:
            return Move(wake_on=WAKE_ON_ARRIVAL)
        near_m = self.line.segment(self.number).near_m
        path = [*self.routes.out(position, True, self.number), *self.routes.over(near_m, self.left_m), left]
        return Move(Follow(tuple(path)), wake_on=WAKE_ON_ARRIVAL)
