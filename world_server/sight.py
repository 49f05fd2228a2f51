"""What can be seen from a place inside a floor plan: the visibility polygon, cut off at a range."""

import numpy as np
import shapely

from world_server.walls import Walls

RING = 64  # corners of the polygon inside the circle of the range
NARROWEST_RAD = 1e-9
SAME_M = 1e-10
BEYOND_WALL_M = 1e-6


class Sight:
    """Sees straight up to a range, stopped by walls.

    The circle is a polygon inside it, so that nobody sees farther than the range. What is seen reaches a
    millionth of a metre into the walls, so that no gap is left between what is seen and the wall: points that
    are computed never lie exactly on it.
    """

    def __init__(self, plan: shapely.Polygon, range_m: float) -> None:
        self._plan, self._range_m = plan, range_m
        shapely.prepare(plan)
        grown = plan.buffer(BEYOND_WALL_M, join_style="mitre")
        rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(grown)]
        self._walls = Walls(rings, range_m)
        self._ring = np.arange(RING) * (2 * np.pi / RING) - np.pi
        self._circle = range_m * np.stack((np.cos(self._ring), np.sin(self._ring)), axis=1)

    def seen_from(self, place: tuple[float, float]) -> shapely.Polygon:
        """The visibility polygon of a place; empty where the place is not in free space.

        Between two neighbouring directions of corners nothing begins or ends: one wall, or the range, is
        nearest all along. So each such sector is a triangle, and the walls' distances are exact.
        """
        if not shapely.intersects_xy(self._plan, *place):
            return shapely.Polygon()
        starts, ways = self._near(np.array(place))
        if not len(starts):
            return shapely.Polygon(self._circle + place)
        first = self._directions(starts, ways)
        last = np.concatenate((first[1:], first[:1]))
        wall = _nearest(starts, ways, first + last, self._range_m)
        hit = np.flatnonzero(wall >= 0)
        start, way = starts[wall[hit]], ways[wall[hit]]
        corners = np.empty((len(first), 2, 2))
        for side, units in enumerate((first, last)):
            corners[:, side] = self._range_m * units
            away_m = np.clip(_along(start, way, units[hit]), 0.0, self._range_m)
            corners[hit, side] = away_m[:, None] * units[hit]
        return _polygon(corners.reshape(-1, 2) + place)

    def _near(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Walls within range, from their starts, seen from the place."""
        segments = self._walls.near(*place.tolist())
        starts, ways = segments[:, :2] - place, segments[:, 2:] - segments[:, :2]
        share = np.clip(-(starts * ways).sum(axis=1) / (ways**2).sum(axis=1), 0, 1)
        nearest = starts + share[:, None] * ways
        near = (nearest**2).sum(axis=1) <= self._range_m**2
        return starts[near], ways[near]

    def _directions(self, starts: np.ndarray, ways: np.ndarray) -> np.ndarray:
        """Unit vectors, anticlockwise, to where walls begin, end or leave the range, and to the ring."""
        lengths2 = (ways**2).sum(axis=1)
        middle = -(starts * ways).sum(axis=1) / lengths2
        discriminant = middle**2 - ((starts**2).sum(axis=1) - self._range_m**2) / lengths2
        half = np.sqrt(np.maximum(discriminant, 0.0))
        shares = np.clip(np.concatenate((middle - half, middle + half)), 0.0, 1.0)
        points = np.concatenate((starts, starts)) + shares[:, None] * np.concatenate((ways, ways))
        angles = np.concatenate((self._ring, np.arctan2(points[:, 1], points[:, 0])))
        angles.sort()
        angles = angles[np.concatenate(([True], angles[1:] - angles[:-1] > NARROWEST_RAD))]
        return np.stack((np.cos(angles), np.sin(angles)), axis=1)


def _nearest(starts: np.ndarray, ways: np.ndarray, directions: np.ndarray, range_m: float) -> np.ndarray:
    """For each direction the number of the nearest wall within range, or -1."""
    if not len(starts):
        return np.full(len(directions), -1)
    lengths = np.hypot(directions[:, 0], directions[:, 1])[:, None]
    directions = directions[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = _cross(starts, directions) / _cross(directions, ways)
    distances = _along(starts, ways, directions) * lengths
    hit = (shares >= 0) & (shares <= 1) & (distances >= 0) & (distances < range_m)
    distances = np.where(hit, distances, np.inf)
    return np.where(hit.any(axis=1), distances.argmin(axis=1), -1)


def _along(starts: np.ndarray, ways: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """How many times a direction reaches the line of a wall; one that never does gives no number."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return _cross(starts, ways) / _cross(directions, ways)


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]


def _polygon(points: np.ndarray) -> shapely.Polygon:
    """Where two sectors meet in a point, it is there twice. Rounding may cross a jump from wall to wall."""
    steps = np.abs(points - np.concatenate((points[-1:], points[:-1]))).max(axis=1)
    polygon = shapely.Polygon(points[steps > SAME_M])
    return polygon if polygon.is_valid else polygon.buffer(0)
