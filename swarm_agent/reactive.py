"""The simple patrol rules: at each site a robot chooses among its neighbours, by what it knows itself.

Source: Portugal and Rocha's patrolling_sim and the papers it implements; their robots drive on graphs, and on
a grid a cell's neighbours are the up to eight around it. What a robot has visited it tells the tower, as in
Kobayashi et al. 2025, section V-A; what it learns of others' visits is the rule's business.
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from swarm_agent.knowledge import AnyBulletin, AssumedIdleness, Reporter
from wire.messages import WAKE_ON_ARRIVAL, WAKE_ON_FRAME, Configuration, GoTo, Percept, Pose


class ReactiveParameters(Parameters, frozen=True):
    """`ties`: of several equally good neighbours any at random is taken, or the one of lowest number."""

    ties: Literal["random", "lowest"] = "random"


class Reactive(Behaviour):
    """A robot that goes from site to neighbouring site. A rule says how good each neighbour is.

    One that begins at a site goes on from there without having visited it, any other to the nearest first.
    Where robots sense all last visits, these stand in for what a robot knows by itself.
    """

    Parameters = ReactiveParameters
    Radio = AnyBulletin

    def __init__(
        self, parameters: ReactiveParameters, configuration: Configuration, generator: np.random.Generator
    ) -> None:
        super().__init__(parameters, configuration, generator)
        self.sites_m = configuration.field.sites_m()
        self.knowledge = AssumedIdleness(len(self.sites_m))
        self.reporter = Reporter(configuration.tower, self.knowledge)
        self.target = -1

    @abstractmethod
    def worth(self, sites: np.ndarray, idle_s: np.ndarray, costs_m: np.ndarray) -> np.ndarray:
        """How good each neighbour is: its number, its idleness, and how far it is."""

    def hear(self, heard: Sequence[Heard]) -> None:
        """Learn from what other robots say; most rules do not."""

    def announce(self, completed: int) -> Any:
        """What others are told when a visit is complete and the next site chosen; most rules are mute."""
        return None

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Note a visit that is complete, choose the next site, and say what others or the tower lack."""
        tick, pose, message = percept.tick, percept.senses.pose, None
        if percept.senses.shared_last_visit:
            self.knowledge.replace(percept.senses.shared_last_visit)
        self.hear(heard)
        if self.target < 0:
            nearest = self._nearest(pose)
            self.target = self._next(nearest, tick) if self._is_at(pose, nearest) else nearest
        elif self._is_at(pose, self.target):
            completed = self.target
            self.knowledge.note_visit(completed, tick)
            self.target = self._next(completed, tick)
            message = self.announce(completed)
        x_m, y_m = self.sites_m[self.target]
        motion = GoTo(x_m, y_m, self.configuration.field.visit_within_m)
        frames = self.reporter.frames(tick, heard, message)
        return Move(motion, frames, wake_on=WAKE_ON_FRAME | WAKE_ON_ARRIVAL)

    def _next(self, here: int, tick: int) -> int:
        """The best neighbour of a site. A lone site is visited again."""
        neighbours = self.configuration.field.neighbours(here)
        if not neighbours:
            return here
        sites, costs_m = (np.array(column) for column in zip(*neighbours, strict=True))
        idle_s = self.knowledge.idle_ticks(tick)[sites] * self.configuration.tick_s
        worth = self.worth(sites, idle_s, costs_m)
        best = sites[worth == worth.max()]
        return int(best[0] if self.parameters.ties == "lowest" else self.generator.choice(best))

    def _nearest(self, pose: Pose) -> int:
        return min(range(len(self.sites_m)), key=lambda site: self._apart_m(pose, site))

    def _is_at(self, pose: Pose, site: int) -> bool:
        return self._apart_m(pose, site) <= self.configuration.field.visit_within_m

    def _apart_m(self, pose: Pose, site: int) -> float:
        x_m, y_m = self.sites_m[site]
        return float(np.hypot(x_m - pose.x_m, y_m - pose.y_m))
