"""DTAP: dynamic task assignment with partition: robots auction, one by one, the sites they go to next.

Source: Farinelli, Iocchi and Nardi 2017 (Autonomous Robots 41(6)), as the first author's DTASSIPart_Agent in
patrolling_sim decides, in the world of Kobayashi et al. 2025: frames reach direct neighbours only, and a site
that was won is driven to directly. Our choices: an auction lasts whole ticks, enough for a request and its
answer to cross; bids are not cut to 16 bits; and what several robots say in one tick counts as said in order
of their numbers. The original leaves that order to chance; robots that begin at one place with equal bids
would, all at once, lose every auction to each other for ever.
"""

import math
from collections.abc import Sequence
from typing import Annotated

import msgspec
import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from swarm_agent.behaviours.dtag import Arrival, Plan, SharedIdleness, Site, Weight
from swarm_agent.knowledge import AssumedIdleness, Bulletin, Reporter
from swarm_agent.ways import ways_of
from wire.channels import number_of
from wire.messages import WAKE_ON_ARRIVAL, WAKE_ON_FRAME, Configuration, GoTo, Percept, Pose

Cost = Annotated[float, msgspec.Meta(ge=0)]  # which also refuses NaN
NO_BID, NOBODY = 999999.0, -1
ROUND_TRIP_TICKS = 2


class Request(msgspec.Struct, frozen=True, array_like=True, tag="request"):
    """Who can do `site` for less than `bid_m`?"""

    site: Site
    bid_m: Cost


class Bid(msgspec.Struct, frozen=True, array_like=True, tag="bid"):
    """The sender can do `site` for `bid_m`."""

    site: Site
    bid_m: Cost


class DtapParameters(Parameters, frozen=True):
    """The authors' numbers, in seconds and metres.

    `idleness_weight`: the worth of a second of idleness. `hop_weight`: that of a hop of the way, times the
    number of sites. `timeout_s`: the longest that an auction waits for bids. `history`: by what share a bid
    must be lower than the best one known to replace it. `exact_center_quirk`: as in the released code, the
    centre of a robot's sites cannot be the one that it was before, unless the robot stands there.
    """

    idleness_weight: Weight = 1.0
    hop_weight: Weight = -2.0
    timeout_s: Annotated[float, msgspec.Meta(ge=0, le=1e6)] = 3.0
    history: Annotated[float, msgspec.Meta(ge=0, le=1e6)] = 0.0
    exact_center_quirk: bool = False


class Partition:
    """The best bid known for each site; a robot's tasks are the sites for which that bid is its own.

    Tasks are not done with by a visit: they are the robot's share of the field, and `centre` is its middle.
    """

    def __init__(self, robot: int, costs_m: np.ndarray, parameters: DtapParameters, current: int) -> None:
        self._robot = robot
        self._costs_m = costs_m
        self._given = parameters
        self.bid_m = np.full(len(costs_m), NO_BID)
        self.owner = np.full(len(costs_m), NOBODY)
        self._said_tick = np.full(len(costs_m), -1)
        self.tasks = np.zeros(len(costs_m), dtype=bool)
        self.task_count = 0
        self.current = self.centre = current

    def own_bid_m(self, site: int, going: tuple[int, ...]) -> float:
        """What `site` costs this robot, the more the more tasks it has; nothing where it is going anyway."""
        if site in going:
            return 0.0
        return float(self._costs_m[site, self.centre] * (1 + self.task_count))

    def claim(self, site: int, bid_m: float, tick: int) -> None:
        """An auction begins with the own bid, whatever was known: so no owner that died blocks a site."""
        self._set(site, bid_m, self._robot, tick)

    def hear(self, site: int, bid_m: float, robot: int, tick: int) -> None:
        """A bid that is lower replaces the best known, and an equal one that was said later."""
        least_m = (1 + self._given.history) * bid_m
        later = (tick, robot) > (self._said_tick[site], self.owner[site])
        if self.bid_m[site] > least_m or (self.bid_m[site] == least_m and later):
            self._set(site, bid_m, robot, tick)
        self.settle()

    def answer(self, site: int, going: tuple[int, ...], tick: int) -> Bid | None:
        """The own bid for a site that another asked for, if it is the best known."""
        self.hear(site, self.own_bid_m(site, going), self._robot, tick)
        if not self.owns(site):
            return None
        self._said_tick[site] = tick
        return Bid(site, float(self.bid_m[site]))

    def owns(self, site: int) -> bool:
        """Is the best bid known for `site` this robot's?"""
        return bool(self.owner[site] == self._robot)

    def settle(self) -> None:
        """See which sites are tasks; when any has changed, find the centre."""
        tasks = self.owner == self._robot
        if (tasks != self.tasks).any():
            self.tasks, self.task_count = tasks, int(tasks.sum())
            self.centre = self._find_centre()

    def _find_centre(self) -> int:
        """Of the tasks and where the robot is, what is nearest to all tasks together; the first of equals."""
        tasks = np.flatnonzero(self.tasks)
        quirk = self._given.exact_center_quirk
        candidates = np.append(self.current, tasks[tasks != self.centre] if quirk else tasks)
        return int(candidates[np.argmin(self._costs_m[np.ix_(candidates, tasks)].sum(axis=1))])

    def _set(self, site: int, bid_m: float, robot: int, tick: int) -> None:
        self.bid_m[site], self.owner[site], self._said_tick[site] = bid_m, robot, tick


class Dtap(Behaviour):
    """One patrolling robot. While it drives to a site it auctions the one after."""

    Parameters = DtapParameters
    Radio = Bulletin[tuple[Arrival | Request | Bid, ...]]

    def __init__(
        self, parameters: DtapParameters, configuration: Configuration, generator: np.random.Generator
    ) -> None:
        super().__init__(parameters, configuration, generator)
        self.sites_m = np.array(configuration.field.sites_m())
        self.ways = ways_of(configuration.field)
        self.knowledge = AssumedIdleness(len(self.sites_m))
        self.reporter = Reporter(configuration.tower, self.knowledge)
        self.words: list[Arrival | Request | Bid] = []
        """What is to be said at this tick."""
        self.current = self.next_site = self.site_after = -1
        self.is_there = False
        """Has the next site been reached? Then the robot waits there for the end of the auction."""
        self.auction_from = self.candidate = -1
        self.auction_ends_tick: int | None = None
        self.selected = np.zeros(len(self.sites_m), dtype=bool)

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Note an arrival, answer others, end the own auction when it is time, and set out when it is won."""
        tick, motion, self.words = percept.tick, None, []
        if self.current < 0:
            self.begin(tick, percept.senses.pose)
        elif percept.senses.arrived and not self.is_there:
            self.is_there = True
            self.knowledge.note_visit(self.next_site, tick)
        self.listen(tick, heard)
        if self.auction_ends_tick is not None and tick >= self.auction_ends_tick:
            self.end_auction(tick)
        if self.auction_ends_tick is None and (self.is_there or self.next_site < 0):
            motion = self.set_out(tick)
        say = self.reporter.frames(tick, heard, tuple(self.words) or None)
        report = Plan(self.next_site, self.site_after)
        return Move(motion, say, self.auction_ends_tick, WAKE_ON_FRAME | WAKE_ON_ARRIVAL, report)

    def begin(self, tick: int, pose: Pose) -> None:
        """Auction the first site from the nearest one; the robot stands still meanwhile."""
        self.current = int(np.argmin(np.abs(self.sites_m - (pose.x_m, pose.y_m)).sum(axis=1)))
        sites = len(self.sites_m)
        first_idle_ticks = round(2 * sites / self.configuration.tick_s)
        self.idleness = SharedIdleness(sites, tick, first_idle_ticks)
        number = number_of(self.configuration.node)
        self.partition = Partition(number, self.ways.costs_m, self.parameters, self.current)
        self.begin_auction(self.current, tick)

    def listen(self, tick: int, heard: Sequence[Heard]) -> None:
        """Take over idleness and bids, and answer requests. What is about a site that is none is ignored."""
        for sender, sent_tick, bulletin, *_ in heard:
            for word in bulletin.message or ():
                if isinstance(word, Arrival):
                    self.idleness.hear(word.zero_tick, sent_tick)
                elif word.site < len(self.sites_m):
                    self.partition.hear(word.site, word.bid_m, number_of(sender), sent_tick)
                    if isinstance(word, Request):
                        answer = self.partition.answer(word.site, self.going, tick)
                        self.words += [] if answer is None else [answer]

    @property
    def going(self) -> tuple[int, int]:
        """Where the robot goes and where after that: it takes nothing for these."""
        return self.next_site, self.site_after

    def set_out(self, tick: int) -> GoTo:
        """The next site is reached, or is the first: tell the table, drive on, auction the one after.

        As in the original the site just reached is told with its idleness since the robot set out for it, and
        becomes zero as the auction begins.
        """
        if self.next_site < 0:
            self.next_site, self.site_after = self.site_after, -1
        else:
            self.idleness.reset(self.current, tick)
            self.current = self.partition.current = self.next_site
            self.next_site = self.site_after
            self.idleness.reset(self.next_site, tick)
        self.is_there = False
        self.words.append(Arrival(self.idleness.zero_tick.tobytes(), self.next_site))
        self.begin_auction(self.next_site, tick)
        x_m, y_m = self.sites_m[self.next_site].tolist()
        return GoTo(x_m, y_m, self.configuration.field.visit_within_m)

    def begin_auction(self, start: int, tick: int) -> None:
        """Auction the best site as seen from `start`."""
        self.idleness.reset(self.current, tick)
        self.auction_from = start
        self.selected[:] = False
        self.selected[[self.current, start]] = True
        self.request_best(tick)

    def request_best(self, tick: int) -> None:
        """Ask for the best site that was not asked for yet, and wait for bids."""
        self.candidate = self.best_unselected(tick)
        bid_m = self.partition.own_bid_m(self.candidate, self.going)
        self.partition.claim(self.candidate, bid_m, tick)
        self.words.append(Request(self.candidate, bid_m))
        wait_s = min(self.parameters.timeout_s, 1.0 + 0.1 * self.partition.task_count)
        wait_ticks = math.ceil(wait_s / self.configuration.tick_s - 1e-9)
        self.auction_ends_tick = tick + max(ROUND_TRIP_TICKS, wait_ticks)

    def end_auction(self, tick: int) -> None:
        """The site is won, or taken although another bid less, or the next best is auctioned."""
        won = self.partition.owns(self.candidate)
        if won:
            self.partition.settle()
        if won or self.is_greedy(self.candidate, tick):
            self.site_after, self.auction_ends_tick = self.candidate, None
        else:
            self.request_best(tick)

    def best_unselected(self, tick: int) -> int:
        """The site of largest utility, the lowest of equals. After all were asked for it begins again."""
        if self.selected.all():
            self.selected[:] = False
            self.selected[self.current] = True
        given = self.parameters
        worth = given.idleness_weight * self.idle_s(tick)
        worth += given.hop_weight * self.ways.hops[self.auction_from] * len(self.sites_m)
        best = int(np.argmax(np.where(self.selected, -math.inf, worth)))
        self.selected[best] = True
        return best

    def is_greedy(self, site: int, tick: int) -> bool:
        """Is a site so idle and so near that the robot goes there whoever else does?

        Not where another is going anyway.
        """
        idle_s = self.idle_s(tick)
        very_idle = idle_s[site] > idle_s.mean() + 2 * idle_s.std()
        near = self.ways.hops[self.auction_from, site] <= 1
        return bool(near and very_idle and self.partition.bid_m[site] != 0)

    def idle_s(self, tick: int) -> np.ndarray:
        """Idleness as this robot knows it, in seconds: (sites,)."""
        return self.idleness.idle_ticks(tick) * self.configuration.tick_s
