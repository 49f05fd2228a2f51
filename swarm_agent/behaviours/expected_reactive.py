"""ER: expected reactive patrol: go to the neighbouring cell that will be most idle on arrival, for its way.

Source: Yan and Zhang 2016, "Multi-robot patrolling based on the expected idleness" (IJARS 13(6)), and their
released code, as a comparator in the world of Kobayashi et al. 2025: candidates are the eight adjacent cells,
or the neighbours on a graph, travel time is the length of the way over the largest speed, and nobody waits.
On arrival a robot says which cell it visited and when it will be at the next: its reservation, which ends at
that time whatever has become of the robot. Bodies of this mission pass each other freely, so the recovery of
the released code from being stuck has nothing to do here and is left out.
"""

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import msgspec
import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from swarm_agent.knowledge import AssumedIdleness, Bulletin, Reporter
from wire.messages import WAKE_ON_ARRIVAL, WAKE_ON_FRAME, Configuration, GoTo, Percept, Pose

Seconds = Annotated[float, msgspec.Meta(ge=0, le=2.0**53)]  # which also refuses NaN
Site = Annotated[int, msgspec.Meta(ge=-1)]


class ExpectedReactiveParameters(Parameters, frozen=True):
    """Two choices that the sources leave open.

    `distance_min_m`: no edge counts as shorter. 0: every edge as it is. The authors take the mean edge (36.05
    on the 20 x 20 cells of 30 m); their released code takes it in pixels, larger than any edge, so that all
    travel times are equal: any value above the diagonal of a cell is that variant.
    `relay`: use all the tables that are heard (Algorithm 1 of LR-PT), the tower's too. Without it, as in the
    original, only visits that a neighbour itself just made; tables are for the tower alone.
    """

    distance_min_m: Annotated[float, msgspec.Meta(ge=0, le=1e9)] = 0.0
    relay: bool = False


class Decision(msgspec.Struct, frozen=True, array_like=True):
    """Said once, on arrival: the cell just visited (-1: none), the next cell, and the time of arrival there.

    The time of visit and decision is that of the frame.
    """

    visited: Site
    target: Site
    arrival_s: Seconds


class Intention(NamedTuple):
    """Where a neighbour said it goes, and when it will be there."""

    target: int
    arrival_s: float


class Aim(msgspec.Struct, frozen=True, array_like=True):
    """What observers are told: the next cell and the expected time of arrival."""

    target: int
    arrival_s: float


class ExpectedReactive(Behaviour):
    """One patrolling robot."""

    Parameters = ExpectedReactiveParameters
    Radio = Bulletin[Decision]

    def __init__(
        self,
        parameters: ExpectedReactiveParameters,
        configuration: Configuration,
        generator: np.random.Generator,
    ) -> None:
        super().__init__(parameters, configuration, generator)
        self.centres_m = configuration.field.sites_m()
        self.knowledge = AssumedIdleness(len(self.centres_m))
        self.reporter = Reporter(configuration.tower, self.knowledge)
        self.intentions: dict[str, Intention] = {}
        self.target = self.since_tick = -1
        self.arrival_s = 0.0

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """One timestep: hear decisions, decide on arrival, say it with the table, drive on."""
        tick, pose = percept.tick, percept.senses.pose
        self.listen(heard)
        decision = None
        if self.target < 0:
            decision = self._set_out(tick, pose)
        elif math.dist((pose.x_m, pose.y_m), self.centres_m[self.target]) <= self._visit_within_m:
            self.knowledge.note_visit(self.target, tick)
            decision = self._go_on(tick)
        x_m, y_m = self.centres_m[self.target]
        motion = GoTo(x_m, y_m, self._visit_within_m)
        aim = Aim(self.target, self.arrival_s)
        if self.parameters.relay:
            return Move(motion, (self._relayed(tick, heard, decision),), tick + 1, report=aim)
        frames = self.reporter.frames(tick, heard, decision)
        return Move(motion, frames, wake_on=WAKE_ON_FRAME | WAKE_ON_ARRIVAL, report=aim)

    def _relayed(self, tick: int, heard: Sequence[Heard], decision: Decision | None) -> Bulletin:
        """What Algorithm 1 of LR-PT says at every tick: the whole table, before that of others is merged."""
        table = self.knowledge.newest(len(self.centres_m))
        self.knowledge.merge(*[one.message.news for one in heard])
        return Bulletin(table, (), self.since_tick, decision)

    def listen(self, heard: Sequence[Heard]) -> None:
        """Take in visits and intentions that neighbours said themselves; a later intention replaces."""
        sites = len(self.centres_m)
        for sender, sent_tick, bulletin, *_ in heard:
            decision = bulletin.message
            if decision is None or max(decision.visited, decision.target) >= sites:
                continue
            if decision.visited >= 0 and sent_tick > self.knowledge.visited_tick[decision.visited]:
                self.knowledge.note_visit(decision.visited, sent_tick)
            self.intentions[sender] = Intention(decision.target, decision.arrival_s)

    def expected_s(self, tick: int) -> np.ndarray:
        """When each cell was last visited as far as we know, or will be next: seconds, (cells,).

        An intention counts while its time of arrival lies ahead; of several the earliest.
        """
        tick_s = self.configuration.tick_s
        now_s = tick * tick_s
        expected_s = np.maximum(self.knowledge.visited_tick, max(self.since_tick, 0)) * tick_s
        for target, arrival_s in self.intentions.values():
            ahead = target >= 0 and arrival_s > now_s
            if ahead and (expected_s[target] < now_s or arrival_s < expected_s[target]):
                expected_s[target] = arrival_s
        return expected_s

    def utilities(self, tick: int, here: int) -> dict[int, float]:
        """Expected idleness on arrival per second of travel, for each cell next to `here`.

        The absolute value makes a cell that another will reach only after us slightly attractive.
        """
        expected_s, now_s = self.expected_s(tick), tick * self.configuration.tick_s
        utility = {}
        for site, way_m in self.configuration.field.neighbours(here):
            travel_s = max(way_m, self.parameters.distance_min_m) / self.configuration.max_speed_m_s
            utility[site] = float(abs(now_s + travel_s - expected_s[site]) / travel_s)
        return utility

    def choose(self, tick: int, here: int) -> int:
        """The adjacent cell of largest utility; one of the best at random where several are equal."""
        utility = self.utilities(tick, here)
        if not utility:
            return here
        most = max(utility.values())
        best = [site for site, value in utility.items() if value == most]
        return best[0] if len(best) == 1 else int(self.generator.choice(best))

    def _set_out(self, tick: int, pose: Pose) -> Decision:
        """The first decision: the nearest cell, unvisited as yet."""
        away_m = [math.dist((pose.x_m, pose.y_m), centre) for centre in self.centres_m]
        self.target = int(np.argmin(away_m))
        self.since_tick = tick
        travel_s = away_m[self.target] / self.configuration.max_speed_m_s
        self.arrival_s = tick * self.configuration.tick_s + travel_s
        return Decision(-1, self.target, self.arrival_s)

    def _go_on(self, tick: int) -> Decision:
        """The decision on arrival. The time of arrival that is said is that of the way as it is."""
        here, self.target = self.target, self.choose(tick, self.target)
        ways_m = dict(self.configuration.field.neighbours(here))
        travel_s = ways_m.get(self.target, 0.0) / self.configuration.max_speed_m_s
        self.arrival_s = tick * self.configuration.tick_s + travel_s
        return Decision(here, self.target, self.arrival_s)

    @property
    def _visit_within_m(self) -> float:
        return self.configuration.field.visit_within_m
