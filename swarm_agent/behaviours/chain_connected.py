"""Chain connected: a layered patrol that keeps a connection to the tower over several hops. Ours.

Kobayashi et al. 2025 compare with a "layered patrol with continuous connectivity" whose rules are published
nowhere; this is no reading of it, but a patrol of our own with the same aim. Three rules:

- **Links.** A robot hangs on the tower or on a robot of a lower number, so links never form a ring. All say
  where they are and which site is next, and a next site is chosen only where every link stays within reach,
  from both ends' places and next sites to the other's: however the two move, they stay in range.
- **Chain.** The robots of the lowest numbers reach for the site that has waited longest among those that a
  chain of all present can reach: each goes where the next one can be within reach of its own post.
- **Others** patrol by the utility of LR-PT without its preference for near or far (alpha = 1), wherever a
  link lets them. Who hangs on a robot stays within reach of its goal too: the parent leads.
"""

import math
from collections.abc import Sequence
from typing import Annotated

import msgspec
import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from swarm_agent.company import CUT_OFF, Company, Word
from swarm_agent.knowledge import AssumedIdleness, Bulletin
from swarm_agent.relay_posts import RelayPosts, Roads, Ways
from wire.channels import number_of
from wire.messages import Configuration, GoTo, Percept, Pose

Positive = Annotated[float, msgspec.Meta(gt=0)]
Point = tuple[float, float]
ROUNDING_M = 1e-6


class ChainConnectedParameters(Parameters, frozen=True):
    """What the robots take for granted of the radio, and how long they wait for each other.

    `range_m` minus `margin_m` is the longest link that is planned. As both ends say where they go next, the
    margin has to cover only what they do before they have heard each other. `lost_after_s`: a node not heard
    for so long is out of reach. `absent_after_s`: a robot that nobody was in touch with for so long is not
    counted on. `look_again_s`: how often who cannot go on looks whether it can now. `patience_s`: how long
    the chain reaches for a site before nobody strays from its post any more; twice as long, and all begin
    again from the tower.
    """

    range_m: Positive = 180.0
    margin_m: Annotated[float, msgspec.Meta(ge=0)] = 10.0
    lost_after_s: Positive = 3.0
    absent_after_s: Positive = 30.0
    look_again_s: Positive = 3.0
    patience_s: Positive = 600.0


class Place(msgspec.Struct, frozen=True, array_like=True):
    """What observers are told: layer (-1 cut off), parent, next site, goal, and the place in the chain."""

    layer: int
    parent: str | None
    next: int
    goal: int
    chain_place: int


class Superior(msgspec.Struct, frozen=True):
    """A node that one may hang on: its layer, where it is and goes next, and the site it leads to."""

    node: str
    layer: int
    points_m: tuple[Point, ...]
    goal_m: Point


class ChainConnected(Behaviour):
    """One patrolling robot."""

    Parameters = ChainConnectedParameters
    Radio = Bulletin[Word]

    def __init__(
        self,
        parameters: ChainConnectedParameters,
        configuration: Configuration,
        generator: np.random.Generator,
    ) -> None:
        super().__init__(parameters, configuration, generator)
        self.sites_m = np.array(configuration.field.sites_m())
        self.points_m: list[Point] = configuration.field.sites_m()
        self.reach_m = max(0.0, parameters.range_m - parameters.margin_m)
        self.roads = Roads(configuration.field)
        self.plan = RelayPosts(self.sites_m, self.roads, configuration.tower_m, self.reach_m)
        self.home = self._nearest(configuration.tower_m)
        self.knowledge = AssumedIdleness(len(self.sites_m))
        waits_s = parameters.lost_after_s, parameters.absent_after_s
        waits = [math.ceil(one / configuration.tick_s) for one in waits_s]
        self.company = Company(configuration.node, configuration.tower, len(self.points_m), *waits)
        self.look_again_ticks = math.ceil(parameters.look_again_s / configuration.tick_s)
        self.patience_ticks = math.ceil(parameters.patience_s / configuration.tick_s)
        self.at = self.next = self.goal = -1
        self.parent: str | None = None
        self.place = -1
        self.since_tick = self.look_tick = self.reaching_tick = -1
        self.reaching: list[int] = []
        self.gathered = False
        self.waiting = False

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Listen, decide where a site is reached or a link is lost, and say what others have to know."""
        tick, pose = percept.tick, percept.senses.pose
        self.company.listen(tick, heard)
        self.knowledge.merge(*[one.message.news for one in heard])
        here_m = (pose.x_m, pose.y_m)
        if self.next < 0:
            self.since_tick = tick
            self.at = self.next = self.goal = self._nearest(here_m)
        elif self._apart_m(here_m, self.next) <= self.configuration.field.visit_within_m:
            if not self.waiting:
                self.knowledge.note_visit(self.next, tick)
                self.at, self.waiting, self.look_tick = self.next, True, tick
                if self._meets_lower():
                    self.look_tick = tick + 1
            if tick >= self.look_tick:
                self.decide(tick, here_m)
        elif not self._is_held(here_m):
            self.catch_hold(here_m)
        return self._move(tick, pose)

    def decide(self, tick: int, here_m: Point) -> None:
        """Choose goal, next site and parent at a site that has been reached."""
        superiors, posts = self._superiors(here_m), self.posts(tick)
        self.place = self._place(tick, len(posts))
        impatience = self._impatience(tick, posts)
        if impatience >= 2 or not superiors:
            self._go_home(tick, superiors)
            return
        above, fit, sound = self._limits(tick, superiors)
        sound[self.at] = True
        ways = self.roads.ways(self.at, sound)
        zone = fit & self._duty(posts, strict=impatience >= 1)
        worth = self.utilities(tick, np.where(zone, ways.far_m, np.inf))
        if np.isfinite(worth).any():
            goal = int(np.argmax(worth))
            self._go(tick, goal, ways.first_step(goal), superiors)
            return
        wish = posts[self.place] if self.place >= 0 else self.at
        goal = self._closest(wish, fit if fit.any() else above)
        stop = self._last_open(posts, ways) if impatience >= 1 else self._closest(goal, ways.far_m < np.inf)
        self._go(tick, goal, ways.first_step(stop), superiors)

    def catch_hold(self, here_m: Point) -> None:
        """On the way with no sound link: find another parent, or turn back, or else make for the tower."""
        superiors = self._superiors(here_m)
        for site in (self.next, self.at):
            for one in superiors:
                if self._within(one, self.points_m[site]):
                    self.next, self.parent = site, one.node
                    return
        tower_m = self.configuration.tower_m
        self.parent = None
        self.next = min(self.next, self.at, key=lambda site: self._apart_m(tower_m, site))

    def posts(self, tick: int) -> list[int]:
        """The chain to the site that has waited longest of all that those present can reach."""
        reachable = self.plan.links <= len(self.company.roll(tick))
        if not reachable.any():
            return []
        waiting = np.where(reachable, self.knowledge.idle_ticks(tick), -1)
        return self.plan.chain(int(np.argmax(waiting)))

    def utilities(self, tick: int, far_m: np.ndarray) -> np.ndarray:
        """Equation 11 of LR-PT with alpha = 1; minus infinity for what is infinitely far or here: (sites,).

        Sites that others in hearing go to are left to them, unless nothing else remains.
        """
        travel_s = far_m / self.configuration.max_speed_m_s
        idle_s = self.knowledge.idle_ticks(tick) * self.configuration.tick_s
        possible = np.isfinite(travel_s) & (travel_s > 0)
        worth = np.full(len(far_m), -np.inf)
        worth[possible] = (idle_s[possible] + travel_s[possible]) / travel_s[possible]
        left = worth.copy()
        left[[site for _, word in self.company.others() for site in (word.goal, word.next)]] = -np.inf
        return left if np.isfinite(left).any() else worth

    def _go(self, tick: int, goal: int, step: int, superiors: list[Superior]) -> None:
        """Take a step, and hang on who leads there, best on the one nearest to the tower."""
        self.goal, self.next = goal, step
        self.waiting = step == self.at
        self.look_tick = tick + self.look_again_ticks
        leading = [one for one in superiors if self._within(one, self.points_m[step])]
        best = min(leading, key=lambda one: (not self._leads(one, step), one.layer), default=None)
        self.parent = None if best is None else best.node

    def _limits(self, tick: int, superiors: list[Superior]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Sites that a superior lets one go to, that one leads to, and that children allow too: (sites,)."""
        above, fit = np.zeros((2, len(self.points_m)), dtype=bool)
        for one in superiors:
            near = self.plan.near(*one.points_m)
            above |= near
            fit |= near & self.plan.near(one.goal_m)
        below = [point for word in self.company.children(tick) for point in self._points(word)]
        return above, fit, above & self.plan.near(*below)

    def _superiors(self, here_m: Point) -> list[Superior]:
        """The tower and the lower-numbered robots that one can hang on from here, in this order."""
        found = []
        if self.company.hears_tower():
            tower_m = self.configuration.tower_m
            found.append(Superior(self.configuration.tower, 0, (tower_m,), tower_m))
        own = number_of(self.configuration.node)
        for name, word in self.company.others():
            if number_of(name) < own and word.layer != CUT_OFF:
                found.append(Superior(name, word.layer, self._points(word), self.points_m[word.goal]))
        return [one for one in found if self._within(one, here_m)]

    def _points(self, word: Word) -> tuple[Point, Point]:
        return (word.x_m, word.y_m), self.points_m[word.next]

    def _within(self, superior: Superior, point_m: Point) -> bool:
        return all(math.dist(one, point_m) <= self.reach_m + ROUNDING_M for one in superior.points_m)

    def _leads(self, superior: Superior, site: int) -> bool:
        return math.dist(superior.goal_m, self.points_m[site]) <= self.reach_m + ROUNDING_M

    def _is_held(self, here_m: Point) -> bool:
        """Will the link to the parent hold all the way from here to the next site?"""
        parents = (one for one in self._superiors(here_m) if one.node == self.parent)
        return any(self._within(one, self.points_m[self.next]) for one in parents)

    def _duty(self, posts: list[int], strict: bool) -> np.ndarray:
        """Where the place in the chain lets one be; anywhere behind its end: bool, (sites,)."""
        if self.place < 0:
            return np.ones(len(self.points_m), dtype=bool)
        return self.plan.around(posts[: self.place + 1] if strict else posts, self.place)

    def _impatience(self, tick: int, posts: list[int]) -> int:
        """How many times the patience is over that the chain has been reaching for the same site.

        From 1 on nobody strays from its post, to which ways are known to lead; at 2 all begin again from the
        tower, once.
        """
        if posts[-1:] != self.reaching:
            self.reaching, self.reaching_tick, self.gathered = posts[-1:], tick, False
        times = min(2, (tick - self.reaching_tick) // self.patience_ticks)
        self.gathered = self.gathered or (times == 2 and self.at == self.home)
        return 1 if self.gathered else times

    def _last_open(self, posts: list[int], ways: Ways) -> int:
        """The post nearest to one's own, from the tower's side, to which a way leads now."""
        own = posts if self.place < 0 else posts[: self.place + 1]
        return next((post for post in reversed(own) if ways.far_m[post] < np.inf), self.at)

    def _go_home(self, tick: int, superiors: list[Superior]) -> None:
        """A step towards the tower, whatever becomes of the links."""
        ways = self.roads.ways(self.at, np.ones(len(self.points_m), dtype=bool))
        self._go(tick, self.home, ways.first_step(self.home), superiors)

    def _place(self, tick: int, links: int) -> int:
        """The place in the chain, 0 next to the tower, or -1: behind its end."""
        own = number_of(self.configuration.node)
        place = sum(number_of(one) < own for one, _ in self.company.roll(tick))
        return place if place < links else -1

    def _meets_lower(self) -> bool:
        """Is a robot of a lower number at this site or about to be? It chooses first, a tick earlier."""
        own = number_of(self.configuration.node)
        return any(number_of(name) < own and word.next == self.at for name, word in self.company.others())

    def _closest(self, wish: int, among: np.ndarray) -> int:
        """The site closest to a wish among these; of equal ones that where one is, else the lowest."""
        far_m = np.where(among, np.hypot(*(self.sites_m - self.sites_m[wish]).T), np.inf)
        return self.at if far_m[self.at] == far_m.min() else int(np.argmin(far_m))

    def _nearest(self, point_m: Point) -> int:
        return int(np.argmin(np.hypot(*(self.sites_m - point_m).T)))

    def _apart_m(self, point_m: Point, site: int) -> float:
        return math.dist(point_m, self.points_m[site])

    def _move(self, tick: int, pose: Pose) -> Move:
        company = self.company
        said = self.next, self.goal, company.layer, company.beacon_tick, self.parent
        word = Word(pose.x_m, pose.y_m, *said, tuple(company.roll(tick)))
        say = Bulletin(self.knowledge.newest(len(self.sites_m)), (), self.since_tick, word)
        there = GoTo(*self.points_m[self.next], self.configuration.field.visit_within_m)
        motion = None if self.waiting else there  # who waits goes on to the very place: one visit, no slack
        shown = Place(company.layer, self.parent, self.next, self.goal, self.place)
        return Move(motion, (say,), tick + 1, report=shown)
