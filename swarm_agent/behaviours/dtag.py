"""DTAG: dynamic task assignment, greedy: go to the best of all sites, and tell others that it is taken.

Source: Farinelli, Iocchi and Nardi 2017 (Autonomous Robots 41(6)), as the first author's DTAGreedy_Agent in
patrolling_sim decides, in the world of Kobayashi et al. 2025: frames reach direct neighbours only. Times are
kept as ticks in place of the original's tenths of seconds in 16 bits, so nothing saturates at 3200 s and a
frame's tick on the way does not count.
"""

import math
from collections.abc import Sequence
from typing import Annotated

import msgspec
import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from swarm_agent.knowledge import AssumedIdleness, Bulletin, Reporter
from swarm_agent.ways import ways_of
from wire.channels import number_of
from wire.messages import WAKE_ON_ARRIVAL, WAKE_ON_FRAME, Configuration, GoTo, Percept, Pose

Site = Annotated[int, msgspec.Meta(ge=0)]
Weight = Annotated[float, msgspec.Meta(ge=-1e9, le=1e9)]
NEVER_VISITED_S = 100.0
"""The idleness of every site where a robot begins."""


class SharedIdleness:
    """Idleness that robots tell each other, kept as the tick at which it was zero: int32, (sites,).

    It is zero at a visit, and also where a robot goes: that is the reservation, and it ages like a visit, so
    a robot that dies on its way holds nothing for long.
    """

    def __init__(self, sites: int, tick: int, first_idle_ticks: int) -> None:
        self.zero_tick = np.full(sites, tick - first_idle_ticks, dtype="<i4")

    def idle_ticks(self, tick: int) -> np.ndarray:
        """int64, (sites,)."""
        return tick - self.zero_tick.astype(np.int64)

    def reset(self, site: int, tick: int) -> None:
        """The idleness of `site` is zero now."""
        self.zero_tick[site] = tick

    def hear(self, told: bytes, sent_tick: int) -> None:
        """Take over what is less idle at a neighbour; a table of another size or of times to come is none."""
        if len(told) == self.zero_tick.nbytes:
            theirs = np.frombuffer(told, dtype="<i4")
            if theirs.max() <= sent_tick:
                np.maximum(self.zero_tick, theirs, out=self.zero_tick)


class Arrival(msgspec.Struct, frozen=True, array_like=True, tag="arrival"):
    """Said on arrival: the sender's `SharedIdleness.zero_tick`, and where it goes now."""

    zero_tick: bytes
    next_site: Site


class Plan(msgspec.Struct, frozen=True, array_like=True):
    """What observers are told: where the robot goes, and where after that (-1: not decided)."""

    next_site: int
    site_after: int = -1


class DtagParameters(Parameters, frozen=True):
    """What a second of idleness, a metre of way and a metre from the robot's own first place are worth.

    The numbers are the authors'. Their ways are in pixels of the map (0.05 to 0.15 m); ours are in metres.
    """

    idleness_weight: Weight = 1.0
    cost_weight: Weight = -0.75
    start_weight: Weight = -5.0


class Dtag(Behaviour):
    """One patrolling robot."""

    Parameters = DtagParameters
    Radio = Bulletin[Arrival]

    def __init__(
        self, parameters: DtagParameters, configuration: Configuration, generator: np.random.Generator
    ) -> None:
        super().__init__(parameters, configuration, generator)
        self.sites_m = np.array(configuration.field.sites_m())
        self.costs_m = ways_of(configuration.field).costs_m
        self.knowledge = AssumedIdleness(len(self.sites_m))
        self.reporter = Reporter(configuration.tower, self.knowledge)
        self.current = self.next_site = self.said_tick = -1

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Hear, give way to who goes to the same site, choose the next one on arrival and say so."""
        tick, message, before = percept.tick, None, self.next_site
        begins = self.current < 0
        arrived = percept.senses.arrived and not begins
        if begins:
            self.begin(tick, percept.senses.pose)
        self.listen(tick, heard, gives_way=not arrived)
        if arrived:
            self.knowledge.note_visit(self.next_site, tick)
            self.current = self.next_site
        if begins or arrived:
            self.next_site = self.choose(tick)
            message = self.announce(tick)
            self.said_tick = tick
        say = self.reporter.frames(tick, heard, message)
        motion = None if self.next_site == before and not arrived else self._drive()
        again = tick + 1 if self.next_site == self.current else None  # a field of one site
        return Move(motion, say, again, WAKE_ON_FRAME | WAKE_ON_ARRIVAL, Plan(self.next_site))

    def begin(self, tick: int, pose: Pose) -> None:
        """Where the robot first stands is what it later prefers to be near."""
        self.from_start_m = np.hypot(*(self.sites_m - (pose.x_m, pose.y_m)).T)
        self.current = int(np.argmin(self.from_start_m))
        first_idle_ticks = round(NEVER_VISITED_S / self.configuration.tick_s)
        self.idleness = SharedIdleness(len(self.sites_m), tick, first_idle_ticks)

    def listen(self, tick: int, heard: Sequence[Heard], gives_way: bool = True) -> None:
        """Take over what neighbours know. Who hears that another goes to the same site gives it up.

        As in the original it then reckons as if it had been there. A robot that has just arrived has nothing
        left to give up.
        """
        for sender, sent_tick, bulletin, *_ in heard:
            told = bulletin.message
            if told is None:
                continue
            self.idleness.hear(told.zero_tick, sent_tick)
            later = (sent_tick, number_of(sender)) > (self.said_tick, number_of(self.configuration.node))
            if gives_way and later and told.next_site == self.next_site:
                self.current = self.next_site
                self.next_site = self.choose(tick)

    def utility(self, tick: int) -> np.ndarray:
        """What each site is worth from where the robot is: (sites,)."""
        given = self.parameters
        idle_s = self.idleness.idle_ticks(tick) * self.configuration.tick_s
        ways = given.cost_weight * self.costs_m[self.current] + given.start_weight * self.from_start_m
        return given.idleness_weight * idle_s + ways

    def choose(self, tick: int) -> int:
        """The best site other than the one where the robot is, the lowest of several equal ones."""
        self.idleness.reset(self.current, tick)
        utility = self.utility(tick)
        utility[self.current] = -math.inf
        return int(np.argmax(utility))

    def announce(self, tick: int) -> Arrival:
        """The table, with the next site as if it were visited already: nobody else shall go there."""
        told = self.idleness.zero_tick.copy()
        told[self.next_site] = tick
        return Arrival(told.tobytes(), self.next_site)

    def _drive(self) -> GoTo:
        x_m, y_m = self.sites_m[self.next_site].tolist()
        return GoTo(x_m, y_m, self.configuration.field.visit_within_m)
