"""Chain connected: a layered patrol that keeps a connection to the tower over several hops. Ours.

Kobayashi et al. 2025 compare with a "layered patrol with continuous connectivity" whose rules are published
nowhere; this is no reading of it, but a patrol of our own with the same aim. Three rules:

- **Links.** A robot hangs on the tower or on a robot of a lower number, so links never form a ring. All say
  where they are and which site is next, and choose a next site only where each link stays within reach from
  either end's place and next site to the other's: however the two move on their way, they stay in range.
- **Chain.** The robots of the lowest numbers reach for the site that has waited longest among those that a
  chain of all present can reach: each goes where the next one can be within reach of its own post.
- **Others** patrol by the utility of LR-PT without its preference for near or far (alpha = 1), wherever a link
  lets them. Who hangs on a robot stays within reach of its goal too: the parent leads, the child follows.
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
    """What the robots take for granted of the radio.

    `range_m` minus `margin_m` is the longest link that is planned. As both ends say where they go next, the
    margin has to cover only what they do before they have heard each other.
    `lost_after_s`: a node not heard for so long is out of reach. `absent_after_s`: a robot that nobody has
    been in touch with for so long is not counted on.
    """

    range_m: Positive = 180.0
    margin_m: Annotated[float, msgspec.Meta(ge=0)] = 10.0
    lost_after_s: Positive = 3.0
    absent_after_s: Positive = 30.0
    look_again_s: Positive = 3.0


class Place(msgspec.Struct, frozen=True, array_like=True):
    """What observers are told: layer (-1 cut off), parent, next site, goal, and the place in the chain."""

    layer: int
    parent: str | None
    next: int
    goal: int
    chain_place: int


class Superior(msgspec.Struct, frozen=True):
    """A node that one may hang on: where it is and goes next, the site it leads to, how far from the tower."""

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
        tick_s = configuration.tick_s
        self.sites_m = np.array(configuration.field.sites_m())
        self.points_m: list[Point] = configuration.field.sites_m()
        self.reach_m = max(0.0, parameters.range_m - parameters.margin_m)
        self.plan = RelayPosts(self.sites_m, configuration.tower_m, self.reach_m)
        self.roads = Roads(configuration.field)
        self.knowledge = AssumedIdleness(len(self.sites_m))
        ticks = (math.ceil(one / tick_s) for one in (parameters.lost_after_s, parameters.absent_after_s))
        self.company = Company(configuration.node, configuration.tower, *ticks)
        self.look_again_ticks = math.ceil(parameters.look_again_s / tick_s)
        self.at = self.next = self.goal = -1
        self.parent: str | None = None
        self.place = -1
        self.since_tick = self.look_tick = -1
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
        elif not self._holds(here_m, self.next, self.parent):
            self.catch_hold(here_m)
        return self._move(tick, pose)

    def decide(self, tick: int, here_m: Point) -> None:
        """Choose goal, next site and parent at a site that has been reached."""
        here = self.at
        superiors = self._superiors(here_m)
        above, fit, sound = self._limits(tick, superiors)
        sound[here] = True
        ways = self.roads.ways(here, sound)
        if not superiors:
            home = self._nearest(self.configuration.tower_m)
            ways = self.roads.ways(here, np.ones_like(sound))
            self._go(tick, home, ways.first_step(home), [])
            return
        posts = self.posts(tick)
        self.place = self._place(tick, len(posts))
        zone = fit & self.plan.around(posts, self.place) if self.place >= 0 else fit
        worth = self.utilities(tick, np.where(zone, ways.far_m, np.inf))
        if np.isfinite(worth).any():
            goal = int(np.argmax(worth))
            self._go(tick, goal, ways.first_step(goal), superiors)
            return
        wish = posts[self.place] if self.place >= 0 else here
        goal = self._closest(wish, fit if fit.any() else above)
        self._go(tick, goal, self._approach(goal, ways), superiors)

    def catch_hold(self, here_m: Point) -> None:
        """On the way with no sound link: find another parent, or turn back, or else make for the tower."""
        for site in (self.next, self.at):
            for superior in self._superiors(here_m):
                if self._holds(here_m, site, superior.node):
                    self.next, self.parent = site, superior.node
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
        """The tower and the lower-numbered robots that one can hang on from here, in order of their numbers."""
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

    def _holds(self, here_m: Point, site: int, parent: str | None) -> bool:
        """Would the link to this parent hold all the way from here to the site?"""
        return any(
            one.node == parent and self._within(one, self.points_m[site]) for one in self._superiors(here_m)
        )

    def _place(self, tick: int, links: int) -> int:
        """The place in the chain, 0 next to the tower, or -1: behind its end."""
        own = number_of(self.configuration.node)
        place = sum(number_of(one) < own for one, _ in self.company.roll(tick))
        return place if place < links else -1

    def _meets_lower(self) -> bool:
        """Is a robot of a lower number at this site or about to be? It chooses first, a tick earlier."""
        own = number_of(self.configuration.node)
        return any(number_of(name) < own and word.next == self.at for name, word in self.company.others())

    def _approach(self, goal: int, ways: Ways) -> int:
        """The first step to where one can wait nearest to a goal that is out of reach."""
        far_m = np.hypot(*(self.sites_m - self.sites_m[goal]).T)
        far_m[~np.isfinite(ways.far_m)] = np.inf
        nearest = int(np.argmin(far_m))
        return ways.first_step(nearest) if far_m[nearest] < far_m[ways.start] else ways.start

    def _closest(self, wish: int, among: np.ndarray) -> int:
        """The site closest to a wish among these."""
        far_m = np.hypot(*(self.sites_m - self.sites_m[wish]).T)
        return int(np.argmin(np.where(among, far_m, np.inf)))

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
        motion = None if self.waiting else there  # who waits goes on to the very place, and visits it but once
        shown = Place(company.layer, self.parent, self.next, self.goal, self.place)
        return Move(motion, (say,), tick + 1, report=shown)
