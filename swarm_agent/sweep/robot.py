"""One robot of a sweep team: all that it knows and is, and how well its links hold.

A barrier is a chain of links. A link between two robots holds where both see a place from which the other is
seen too: the middle between them, or one moved forward around a corner behind the line. How well it holds is
its margin, in metres: so far may one of the robots go, and the place is still seen by both.
"""

import math
from typing import Any

import numpy as np

from swarm_agent.surveillance_graph import SurveillanceGraph
from swarm_agent.sweep.geometry import clearance_m, nearest
from swarm_agent.sweep.peers import Eye, Peer, Peers
from swarm_agent.sweep.radio import BARRIER, NOBODY, SIDES, WALL, Flow, Role, Side, Stage
from wire.channels import number_of
from wire.messages import Configuration

BENDS, BEND_M = 7, 0.08  # places tried for a link around a corner, and how far apart they are
SIGHT_M = 0.06  # free space that a line of sight needs on both sides
UNRANKED, NEVER = 9999, -1_000_000
BARRED_TICKS = 20  # a leader that somebody walks past is not barred
WORN_M = 0.02  # of the range: rounding of what is told, and the rays' distance

Link = tuple[Peer, Peer]


class Robot:
    """The state of one robot. `beside`: its neighbours; `old`: those it was linked to, until they agree."""

    def __init__(self, configuration: Configuration, parameters: Any) -> None:
        field = configuration.field
        self.number, self.parameters = number_of(configuration.node), parameters
        self.eye = Eye(field.rays, field.detect_m)
        self.peers = Peers(self.number, self.eye, parameters.dead_ticks)
        self.graph = SurveillanceGraph(configuration.node)
        self.is_robust = parameters.spacing == "robust"
        self.step_m = configuration.max_speed_m_s * configuration.tick_s
        self.body_m = configuration.body_m
        self.reach_m = field.detect_m - self.step_m / 2 - WORN_M
        self.tick = self.born = 0
        self.ranges_m = np.full(field.rays, np.inf)
        self.hits = np.empty(0, dtype=complex)
        self.dead: set[int] = set()
        self.bodies: dict[int, tuple[int, complex]] = {}
        """When each of the dead was last heard, and where its body lies."""
        self.bumps: list[tuple[int, complex]] = []
        """When and where it met a body of which it did not know."""
        self.gone: set[int] = set()
        """Numbers of lines that have dissolved where they stood."""
        self.events: list[str] = []
        self.claim = ""
        self.epoch = self.anchor = 0
        self.couriers: tuple[int, ...] = ()
        self.moved = 0
        self.contact = 0j
        self.become("free")

    def become(self, role: Role, stage: Stage = "") -> None:
        """Begin something new, beside nobody and on no line."""
        self.role, self.stage, self.since_role = role, stage, self.tick
        self.beside: dict[Side, int] = dict.fromkeys(SIDES, NOBODY)
        self.old: dict[int, Side] = {}
        self.refused: set[int] = set()
        self.second: dict[int, Side] = {}
        """Those beyond its neighbours that a robust line links to, too, until all agree that it need not."""
        self.held: dict[Side, complex] = {}
        """The places of the walls of leaders beside it that it holds, too."""
        self.linked_tick = self.held_tick = self.tick
        self.needed_tick: dict[Side, int] = dict.fromkeys(SIDES, self.tick)
        """When the line last would not have held without its neighbour."""
        self.line, self.since = 0, -1
        self.pinned = self.halt = self.close = self.ready = self.closing = False
        self.meets, self.met_tick, self.other_met_tick = NOBODY, self.tick, NEVER
        self.obstacle: complex | None = None
        self.open = True
        self.order, self.taut, self.pushed, self.angle_rad = 0, 0, self.tick, 0.0
        self.free_tick = self.tick
        """When it last went along its wall as a leader, or did not want to."""
        self.ahead, self.rank, self.tail = NOBODY, UNRANKED, 1
        self.crumbs: list[complex] = []
        self.flows: dict[Side, Flow | None] = dict.fromkeys(SIDES)
        """What this robot tells on, by the end of the line that it is about."""
        self.told: dict[Side, Flow | None] = dict.fromkeys(SIDES)
        """What its neighbours tell."""

    @property
    def here(self) -> complex:
        """Its own place by odometry."""
        return self.peers.here

    def peer(self, number: int) -> Peer | None:
        """Another robot, if it was heard of late."""
        return self.peers.known.get(number)

    def neighbour(self, side: Side) -> Peer | None:
        """Who stands beside it; None for a wall, nobody, and one who is not heard."""
        return self.peer(self.beside[side])

    @property
    def fallen(self) -> list[complex]:
        """The places of the bodies of the dead."""
        return [place for _, place in (*self.bodies.values(), *self.bumps)]

    def links(self) -> list[Link]:
        """All links of lines, the left end first, both of whose ends it knows and hold them."""
        found = []
        for left in self.peers.known.values():
            right = self.peer(left.beacon.right)
            if right is None or left.beacon.epoch != self.epoch or right.beacon.left != left.number:
                continue
            if left.beacon.role in BARRIER and right.beacon.role in BARRIER:
                found.append((left, right))
        return found

    def wall_side(self) -> Side:
        """Of a leader: the side of its wall."""
        return "left" if self.beside["left"] == WALL else "right"

    @property
    def on_line(self) -> bool:
        """Is it a part of a barrier?"""
        return self.role in BARRIER

    @property
    def is_main(self) -> bool:
        """Does it stand on the line that moves?"""
        main = self.graph.main
        return main is not None and self.on_line and main.line == self.line

    @property
    def is_barred(self) -> bool:
        """Has it wanted to go along its wall for a while, and not come on?"""
        return self.tick - self.free_tick > BARRED_TICKS * self.parameters.hop_ticks

    @property
    def team(self) -> int:
        """Robots that are not known to be dead."""
        return self.parameters.team - len(self.dead)

    @property
    def place(self) -> int:
        """Its place on the line, counted from the left leader; 0 where that is not known."""
        if self.beside["left"] == WALL:
            return 1
        return 1 + self.told["left"].count if self.told["left"] else 0

    @property
    def count(self) -> int:
        """Robots on its line, as far as it is told."""
        return 1 + sum(flow.count for flow in self.told.values() if flow)

    @property
    def is_whole(self) -> bool:
        """Does it have news from both ends of its line?"""
        return all(self.beside[side] == WALL or self.told[side] is not None for side in SIDES)

    def last_moved(self) -> int:
        """The last tick in which any robot of its line moved, as far as it is told."""
        return max([self.moved, *(flow.moved for flow in self.told.values() if flow)])

    @property
    def is_quiet(self) -> bool:
        """Is all it is told of its line from when nobody moved any more?"""
        news = [flow.since for flow in self.told.values() if flow]
        return self.is_whole and not self.old and min([self.news_tick, *news]) > self.last_moved() + 1

    @property
    def news_tick(self) -> int:
        """From when all is that it knows of those on its line whose sight adds to its own."""
        near_m = 2 * self.eye.detect_m
        near = [one for one in self.peers.known.values() if abs(one.here - self.here) < near_m]
        ours = [one for one in near if one.beacon.line == self.line and one.beacon.role in BARRIER]
        return min((one.tick for one in ours), default=self.tick)

    def any_told(self, what: str) -> bool:
        """Do the neighbours tell of somebody on the line who is, or wants, that?"""
        return any(getattr(flow, what) for flow in self.told.values() if flow)

    def sees(self, place: complex) -> bool:
        """Can it hold a wall at that place?"""
        away = place - self.here
        ray, rays = self.eye.ray(away), self.eye.rays
        seen_m = max(self.ranges_m[(ray + one) % rays] for one in (-1, 0, 1))
        return abs(away) <= self.reach_m - self.step_m and seen_m >= abs(away) - 0.05

    def walls(self, *peers: Peer) -> np.ndarray:
        """The places of walls that it sees, and that some others see."""
        return np.concatenate((self.hits, *(peer.hits for peer in peers)))

    def nearest_wall(self) -> complex | None:
        """The nearest place of a wall that it sees, or else that others see."""
        own = nearest(self.hits, self.here)
        return own if own is not None else nearest(self.walls(*self.peers.known.values()), self.here)

    def needed_m(self, peer: Peer) -> float:
        """The margin that a link needs: so far another robot may have come by the end of this tick."""
        return self.step_m * (self.tick - peer.tick)

    def margin_m(
        self, left: complex, right: complex, walls: np.ndarray, enough_m: float | None = None
    ) -> float:
        """How well a link holds; what is `enough_m`, or else a step, is as good as any more."""
        enough_m = self.step_m if enough_m is None else enough_m
        way = right - left
        if abs(way) < 1e-9:
            return self.reach_m
        forward, best = 1j * way / abs(way), -math.inf
        for bend in range(BENDS):
            over = (left + right) / 2 + forward * BEND_M * bend
            margin = self.reach_m - abs(over - left)
            if margin <= best:
                break
            gap = min(clearance_m(walls, left, over), clearance_m(walls, over, right)) - SIGHT_M
            best = max(best, min(margin, gap))
            if best >= enough_m:
                break
        return best

    def over(self, left: complex, right: complex, walls: np.ndarray) -> complex | None:
        """The place around which a link is bent; None where it is straight."""
        way = right - left
        if abs(way) < 1e-9:
            return None
        forward = 1j * way / abs(way)
        for bend in range(BENDS):
            over = (left + right) / 2 + forward * BEND_M * bend
            gap = min(clearance_m(walls, left, over), clearance_m(walls, over, right))
            if gap >= SIGHT_M + self.step_m:
                return over if bend else None
        return None

    def link_m(self, peer: Peer, side: Side, here: complex | None = None) -> float:
        """The margin of the link to a robot on one side, from here or from another place."""
        here = self.here if here is None else here
        ends = (peer.here, here) if side == "left" else (here, peer.here)
        return self.margin_m(*ends, self.walls(peer), max(self.step_m, self.needed_m(peer)))

    def toward(self, peer: Peer, side: Side) -> complex:
        """The way to a neighbour, or to where the link to it is bent."""
        ends = (peer.here, self.here) if side == "left" else (self.here, peer.here)
        over = self.over(*ends, self.walls(peer))
        way = (peer.here if over is None else over) - self.here
        return way if way else 1e-9 + 0j
