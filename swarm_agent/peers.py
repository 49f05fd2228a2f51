"""Other robots as one robot knows them: where they are and how their frames are turned, in its own frame.

Who hears a frame measures range and bearing of its sender. Each tells at which bearing it measured the
others, so two robots that hear each other know the angle between their frames, which never changes.
"""

import cmath
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from swarm_agent.sweep_radio import Beacon, Measured

UNSEEN = 255
LEVELS = 250
HISTORY_TICKS = 64


def number(name: str) -> int:
    """The number in a node's name."""
    return int(name.lstrip("abcdefghijklmnopqrstuvwxyz_"))


class Eye:
    """What all robots of a team have in common: the directions of their rays, and how far they see."""

    def __init__(self, rays: int, detect_m: float) -> None:
        self.rays, self.detect_m = rays, detect_m
        self.units = np.exp(2j * math.pi / rays * np.arange(rays))

    def packed(self, ranges_m: np.ndarray) -> bytes:
        """A scan in one byte a ray, rounded down."""
        levels = np.where(np.isfinite(ranges_m), ranges_m * (LEVELS / self.detect_m), UNSEEN)
        return levels.astype(np.uint8).tobytes()

    def unpacked(self, packed: bytes) -> np.ndarray:
        """Ranges of a packed scan, inf where nothing was seen. Of a wrong length: a scan of nothing."""
        if len(packed) != self.rays:
            return np.full(self.rays, np.inf)
        levels = np.frombuffer(packed, np.uint8)
        return np.where(levels == UNSEEN, np.inf, (levels + 0.5) * (self.detect_m / LEVELS))

    def ray(self, way: complex) -> int:
        """The ray nearest to a direction."""
        return round(cmath.phase(way) / math.tau * self.rays) % self.rays


class Peer:
    """Another robot, as its last frame told of it. `here`: where it is; `turn`: from its frame to ours."""

    def __init__(self, number: int, tick: int, here: complex, stood: complex, turn: complex, beacon: Beacon) -> None:
        self.number, self.tick, self.here, self.stood = number, tick, here, stood
        self.turn, self.beacon = turn, beacon
        self._hits: np.ndarray | None = None

    def hits(self, eye: Eye) -> np.ndarray:
        """The places of walls that it saw, in our frame."""
        if self._hits is None:
            self.ranges_m = eye.unpacked(self.beacon.ranges)
            seen = np.isfinite(self.ranges_m)
            self._hits = self.stood + self.turn * self.ranges_m[seen] * eye.units[seen]
        return self._hits

    def sees(self, eye: Eye, places: np.ndarray) -> np.ndarray:
        """Which of some places it saw without anything in between."""
        self.hits(eye)
        away = (places - self.stood) / self.turn
        far = np.abs(away)
        ray = np.round(np.angle(away) * (eye.rays / math.tau)).astype(int) % eye.rays
        around = np.minimum(self.ranges_m[ray - 1], self.ranges_m[(ray + 1) % eye.rays])
        wall = np.minimum(around, self.ranges_m[ray])
        return (far <= eye.detect_m - 0.03) & (wall >= far - 0.03)


class Peers:
    """Everybody heard of late; `here` is this robot's own place by odometry."""

    def __init__(self, own: int, eye: Eye) -> None:
        self.eye, self.own = eye, own
        self.here = 0j
        self.known: dict[int, Peer] = {}
        self.measured: tuple[Measured, ...] = ()
        self._trace: dict[int, complex] = {}
        self._bearings: dict[tuple[int, int], float] = {}
        self._turns: dict[int, complex] = {}

    def take(self, tick: int, moved: complex, heard: Sequence[Any]) -> None:
        """A percept: how far we came, and what was heard."""
        self.here += moved
        self._trace[tick - 1] = self.here
        for old in [one for one in self._trace if one < tick - HISTORY_TICKS]:
            del self._trace[old]
        self._bearings = {key: one for key, one in self._bearings.items() if key[1] > tick - HISTORY_TICKS}
        told = []
        for one in heard:
            sender = number(one.sender)
            self._bearings[sender, one.sent_tick] = one.bearing_rad
            told.append(Measured(sender, one.sent_tick, one.bearing_rad))
            self._meet(sender, one)
        self.measured = tuple(told)

    def _meet(self, sender: int, one: Any) -> None:
        for measured in one.message.measured:
            if measured.number == self.own:
                mine = self._bearings.get((sender, measured.tick))
                if mine is not None:
                    self._turns[sender] = cmath.rect(1.0, mine + math.pi - measured.bearing_rad)
        stood_at = self._trace.get(one.sent_tick, self.here)
        here = stood_at + cmath.rect(one.range_m, one.bearing_rad)
        before = self.known.get(sender)
        if before is not None and before.tick > one.sent_tick:
            return
        stood = before.here if before is not None and before.tick == one.sent_tick - 1 else here
        if sender in self._turns:
            self.known[sender] = Peer(sender, one.sent_tick, here, stood, self._turns[sender], one.message)
