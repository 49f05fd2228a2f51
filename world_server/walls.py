"""The walls of a floor plan as segments, found by place, and the nearest one in many directions."""

import math
from collections.abc import Sequence

import numpy as np

CELL_M = 0.5
ON_END_M = 1e-9  # a ray through the corner of two walls meets at least one of them


class Walls:
    """Segments of all rings, of which those within `reach_m` of a place are found quickly."""

    def __init__(self, rings_m: Sequence[np.ndarray], reach_m: float) -> None:
        """`rings_m`: closed rings, each (points, 2)."""
        starts = np.concatenate([ring[:-1] for ring in rings_m])
        ends = np.concatenate([ring[1:] for ring in rings_m])
        self._segments = np.concatenate((starts, ends), axis=1)
        self._reach_m = reach_m + CELL_M * math.sqrt(0.5)
        self._found: dict[tuple[int, int], np.ndarray] = {}

    def near(self, x_m: float, y_m: float) -> np.ndarray:
        """All segments within reach, and perhaps a few more: x and y of start and end, (segments, 4)."""
        cell = (math.floor(x_m / CELL_M), math.floor(y_m / CELL_M))
        found = self._found.get(cell)
        if found is None:
            middle = (np.array(cell) + 0.5) * CELL_M
            near = _away_m(self._segments, middle) <= self._reach_m
            found = self._found[cell] = self._segments[near]
        return found


def ranges_m(
    segments: np.ndarray, place: tuple[float, float], units: np.ndarray, most_m: float
) -> np.ndarray:
    """How far the nearest of the segments is in each direction; infinite where none is within `most_m`.

    `segments`: (segments, 4) as `Walls.near` has them; `units`: unit vectors, (rays, 2).
    """
    starts_x, starts_y = segments[:, 0] - place[0], segments[:, 1] - place[1]
    ways_x, ways_y = segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]
    units_x, units_y = units[:, :1], units[:, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        slants = 1 / (units_x * ways_y - units_y * ways_x)
        shares = (starts_x * units_y - starts_y * units_x) * slants
        away_m = (starts_x * ways_y - starts_y * ways_x) * slants
        slack = ON_END_M / np.hypot(ways_x, ways_y)
        hit = (shares >= -slack) & (shares <= 1 + slack) & (away_m >= 0) & (away_m <= most_m)
    return np.where(hit, away_m, np.inf).min(axis=1, initial=np.inf)


def _away_m(segments: np.ndarray, place: np.ndarray) -> np.ndarray:
    """How far each segment is from a place."""
    starts, ways = segments[:, :2] - place, segments[:, 2:] - segments[:, :2]
    lengths2 = np.maximum((ways**2).sum(axis=1), 1e-300)
    shares = np.clip(-(starts * ways).sum(axis=1) / lengths2, 0, 1)
    return np.linalg.norm(starts + shares[:, None] * ways, axis=1)
