"""What robots of mission clear sense in their own frames, with the noise that the scenario asks for.

All of it is rounded to a millionth, so that what a robot senses does not tell how its world is turned.
"""

import math
from typing import NamedTuple

import numpy as np

from wire.channels import number_of
from wire.scenario import Sensors
from world_server import chance
from world_server.discs import Disc
from world_server.nodes import Node
from world_server.walls import Walls, ranges_m

DECIMALS = 6


class Scan(NamedTuple):
    """The last scan of a robot, and where it was measured."""

    place: tuple[float, float]
    measured_m: np.ndarray


class Perception:
    """Scans, odometry and bearings of all robots."""

    def __init__(self, sensors: Sensors, walls: Walls, seed: int) -> None:
        self._sensors, self._walls, self._seed = sensors, walls, seed
        self._angles = np.arange(sensors.rays) * (2 * np.pi / sensors.rays)
        self._units: dict[str, np.ndarray] = {}
        self._scans: dict[str, Scan] = {}

    def scan(self, tick: int, node: Node) -> bytes:
        """The ranges of all rays, as Senses have them. A robot at rest need not measure again."""
        body, sensors = node.body, self._sensors
        place, known = (body.x_m, body.y_m), self._scans.get(node.name)
        if known is None or known.place != place:
            segments, units = self._walls.near(*place), self._rays(node)
            known = Scan(place, ranges_m(segments, place, units, sensors.detect_m))
            self._scans[node.name] = known
        measured_m = known.measured_m
        if sensors.noise_sd_m:
            draws = self._chance("scan", node, tick).standard_normal(sensors.rays)
            measured_m = np.maximum(0.0, measured_m + sensors.noise_sd_m * draws)
        return rounded(measured_m).astype("<f4").tobytes()

    def odometry_m(self, tick: int, node: Node, since: tuple[float, float]) -> tuple[float, float]:
        """How far a robot has come from a place, in its own frame."""
        body: Disc = node.body
        moved = body.inward(body.x_m - since[0], body.y_m - since[1])
        if self._sensors.odometry_sd and moved != (0.0, 0.0):
            spread_m = self._sensors.odometry_sd * math.hypot(*moved)
            draws = self._chance("odometry", node, tick).standard_normal(2)
            moved = (moved[0] + spread_m * draws[0], moved[1] + spread_m * draws[1])
        x_m, y_m = rounded(np.array(moved)).tolist()
        return x_m, y_m

    def bearing(self, tick: int, node: Node, sender: Node) -> tuple[float, float]:
        """Range and bearing of a sender from where both are now."""
        body: Disc = node.body
        x_m, y_m = body.inward(sender.body.x_m - body.x_m, sender.body.y_m - body.y_m)
        range_m, bearing_rad = math.hypot(x_m, y_m), math.atan2(y_m, x_m)
        sensors = self._sensors
        if sensors.noise_sd_m or sensors.bearing_sd_rad:
            draws = self._chance("bearing", node, tick, number_of(sender.name)).standard_normal(2)
            range_m = max(0.0, range_m + sensors.noise_sd_m * draws[0])
            bearing_rad = math.remainder(bearing_rad + sensors.bearing_sd_rad * draws[1], math.tau)
        return round(range_m, DECIMALS), round(bearing_rad, DECIMALS)

    def _rays(self, node: Node) -> np.ndarray:
        units = self._units.get(node.name)
        if units is None:
            angles = self._angles + node.body.heading_rad
            units = self._units[node.name] = np.stack((np.cos(angles), np.sin(angles)), axis=1)
        return units

    def _chance(self, purpose: str, node: Node, tick: int, *more: int) -> np.random.Generator:
        return chance.generator(self._seed, purpose, number_of(node.name), tick, *more)


def rounded(values: np.ndarray) -> np.ndarray:
    """Values to a millionth; there is one zero only."""
    return np.round(values, DECIMALS) + 0.0
