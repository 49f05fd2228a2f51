"""Other robots as one robot knows them: where they are and how their frames are turned, in its own frame.

Who hears a frame measures range and bearing of its sender. Each tells at which bearing it measured the
others, so two robots that hear each other know the angle between their frames, which never changes. Places
and ways are complex numbers, in metres.
"""

import cmath
import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from swarm_agent.behaviour import Heard
from swarm_agent.sweep.radio import Beacon, Measured
from wire.channels import number_of

UNSEEN, LEVELS = 255, 250
REMEMBERED_TICKS = 64
SEEN_MARGIN_M = 0.03


class Eye:
    """What all robots of a team have in common: the directions of their rays, and how far they see."""

    def __init__(self, rays: int, detect_m: float) -> None:
        self.rays, self.detect_m = rays, detect_m
        self.units = np.exp(2j * math.pi / rays * np.arange(rays))

    def packed(self, ranges_m: np.ndarray) -> bytes:
        """A scan in one byte a ray."""
        levels = np.where(np.isfinite(ranges_m), ranges_m * (LEVELS / self.detect_m), UNSEEN)
        return levels.astype(np.uint8).tobytes()

    def unpacked(self, packed: bytes) -> np.ndarray:
        """Ranges of a packed scan, inf where nothing was seen; all 0 if it has other rays."""
        if len(packed) != self.rays:
            return np.zeros(self.rays)
        levels = np.frombuffer(packed, np.uint8)
        return np.where(levels == UNSEEN, np.inf, (levels + 0.5) * (self.detect_m / LEVELS))

    def ray(self, way: complex) -> int:
        """The ray nearest to a direction."""
        return round(cmath.phase(way) / math.tau * self.rays) % self.rays


class Peer:
    """Another robot, as its frame of `tick` told of it.

    `here`: where it was when that tick was over; `stood`: where its scan was made; `turn`: from its frame to
    ours, a unit complex number.
    """

    def __init__(
        self, number: int, tick: int, here: complex, stood: complex, turn: complex, beacon: Beacon, eye: Eye
    ) -> None:
        self.number, self.tick, self.here, self.turn, self.beacon = number, tick, here, turn, beacon
        self._stood, self._eye = stood, eye

    @cached_property
    def ranges_m(self) -> np.ndarray:
        """Its scan, inf where it saw nothing."""
        return self._eye.unpacked(self.beacon.ranges)

    @cached_property
    def hits(self) -> np.ndarray:
        """The places of walls that it saw."""
        seen = np.isfinite(self.ranges_m)
        return self._stood + self.turn * self.ranges_m[seen] * self._eye.units[seen]

    @property
    def wall(self) -> complex:
        """The place of the wall that it holds."""
        return self.here + self.turn * self.beacon.wall

    @property
    def contact(self) -> complex:
        """The same, exactly: seen from where it was before its last step."""
        return self._stood + self.turn * self.beacon.wall

    def heard_tick(self, number: int) -> int:
        """The last tick of a robot that it had heard when it spoke; -1 for none."""
        return max((one.tick for one in self.beacon.measured if one.number == number), default=-1)

    def place(self, way: complex) -> complex:
        """Where a way ends that it told when it spoke."""
        return self._stood + self.turn * way

    def sees(self, places: np.ndarray) -> np.ndarray:
        """Which of some places it saw, with nothing in between and a margin to spare."""
        ranges_m, rays = self.ranges_m, self._eye.rays
        away = (places - self._stood) / self.turn
        far_m = np.abs(away)
        ray = np.round(np.angle(away) * (rays / math.tau)).astype(int) % rays
        wall_m = np.minimum(np.minimum(ranges_m[ray - 1], ranges_m[(ray + 1) % rays]), ranges_m[ray])
        return (far_m <= self._eye.detect_m - SEEN_MARGIN_M) & (wall_m >= far_m - SEEN_MARGIN_M)


class Peers:
    """Everybody heard of late; `here` is this robot's own place by odometry."""

    def __init__(self, own: int, eye: Eye, dead_ticks: int) -> None:
        self.here = 0j
        self.known: dict[int, Peer] = {}
        self.lost: dict[int, Peer] = {}
        """Those who have not been heard for too long, as they were."""
        self.measured: tuple[Measured, ...] = ()
        """Bearings of all that was heard now, and the last one of who was not: what was said may be lost."""
        self._own, self._eye, self._dead_ticks = own, eye, dead_ticks
        self._trace: dict[int, complex] = {}
        self._bearings: dict[int, dict[int, float]] = {}
        """By the tick in which a frame was sent, and the number of who sent it."""
        self._turns: dict[int, complex] = {}

    def take(self, tick: int, moved: complex, heard: Sequence[Heard]) -> None:
        """A percept: how far we came, and what was heard."""
        self.here += moved
        self._trace[tick - 1] = self.here
        oldest = tick - REMEMBERED_TICKS
        self._trace = {at: place for at, place in self._trace.items() if at > oldest}
        self._bearings = {at: one for at, one in self._bearings.items() if at > oldest}
        now = tuple(Measured(number_of(one.sender), one.sent_tick, one.bearing_rad) for one in heard)
        for told, one in zip(now, heard, strict=True):
            self._bearings.setdefault(told.tick, {})[told.number] = told.bearing_rad
            self._meet(told.number, one)
        last = {one.number: one for one in self.measured if tick - one.tick <= self._dead_ticks}
        missed = last.keys() - {one.number for one in now}
        self.measured = now + tuple(last[number] for number in sorted(missed))
        silent = {number for number, peer in self.known.items() if tick - peer.tick > self._dead_ticks}
        self.lost |= {number: self.known.pop(number) for number in silent}
        for number in self.known:
            self.lost.pop(number, None)

    def _was_at(self, tick: int) -> complex:
        """Its own place when a tick was over: it moves only when granted, so the next one known is it."""
        if tick in self._trace:
            return self._trace[tick]
        return self._trace[min(at for at in self._trace if at >= tick)]

    def _meet(self, sender: int, one: Heard) -> None:
        for measured in one.message.measured:
            if measured.number != self._own:
                continue
            mine = self._bearings.get(measured.tick, {}).get(sender)
            if mine is not None:
                self._turns[sender] = cmath.rect(1.0, mine + math.pi - measured.bearing_rad)
        before = self.known.get(sender)
        if sender not in self._turns or (before is not None and before.tick > one.sent_tick):
            return
        here = self._was_at(one.sent_tick) + cmath.rect(one.range_m, one.bearing_rad)
        follows = before is not None and before.tick == one.sent_tick - 1
        stood = before.here if follows else here
        self.known[sender] = Peer(
            sender, one.sent_tick, here, stood, self._turns[sender], one.message, self._eye
        )
