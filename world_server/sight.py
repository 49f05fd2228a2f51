"""What can be seen from a place inside a floor plan: the visibility polygon, cut off at a range."""

import numpy as np
import shapely

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
        self._starts = np.concatenate([ring[:-1] for ring in rings])
        self._ways = np.concatenate([np.diff(ring, axis=0) for ring in rings])
        self._lengths2 = (self._ways**2).sum(axis=1)
        self._ring = np.arange(RING) * (2 * np.pi / RING) - np.pi

    def seen_from(self, place: tuple[float, float]) -> shapely.Polygon:
        """The visibility polygon of a place; empty where the place is not in free space.

        Between two neighbouring directions of corners nothing begins or ends: one wall, or the range, is
        nearest all along. So each such sector is a triangle, and the walls' distances are exact.
        """
        if not shapely.intersects_xy(self._plan, *place):
            return shapely.Polygon()
        starts, ways = self._near(np.asarray(place))
        first = self._directions(starts, ways)
        last = np.append(first[1:], first[0] + 2 * np.pi)
        wall = _nearest(starts, ways, (first + last) / 2, self._range_m)
        ends = np.stack((first, last), axis=1)
        radii = np.full(ends.shape, self._range_m)
        hit = wall >= 0
        start, way = starts[wall[hit], None], ways[wall[hit], None]
        radii[hit] = np.clip(_along(start, way, _unit(ends[hit])), 0, self._range_m)
        return _polygon((_unit(ends) * radii[..., None]).reshape(-1, 2) + place)

    def _near(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Walls within range, from their starts, seen from the place."""
        starts = self._starts - place
        share = np.clip(-(starts * self._ways).sum(axis=1) / self._lengths2, 0, 1)
        nearest = starts + share[:, None] * self._ways
        near = (nearest**2).sum(axis=1) <= self._range_m**2
        return starts[near], self._ways[near]

    def _directions(self, starts: np.ndarray, ways: np.ndarray) -> np.ndarray:
        """All directions, sorted, where a wall begins, ends or crosses the range, and those of the ring."""
        lengths2 = (ways**2).sum(axis=1)
        middle = -(starts * ways).sum(axis=1) / lengths2
        discriminant = middle**2 - ((starts**2).sum(axis=1) - self._range_m**2) / lengths2
        half = np.sqrt(np.maximum(discriminant, 0.0))
        shares = np.clip(np.stack((middle - half, middle + half)), 0, 1)
        points = (starts + shares[..., None] * ways).reshape(-1, 2)
        angles = np.concatenate((self._ring, np.arctan2(points[:, 1], points[:, 0])))
        angles.sort()
        return angles[np.diff(angles, prepend=-np.inf) > NARROWEST_RAD]


def _nearest(starts: np.ndarray, ways: np.ndarray, angles: np.ndarray, range_m: float) -> np.ndarray:
    """For each direction the number of the nearest wall within range, or -1."""
    if not len(starts):
        return np.full(len(angles), -1)
    units = _unit(angles)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = _cross(starts, units) / _cross(units, ways)
    distances = _along(starts, ways, units)
    hit = (shares >= 0) & (shares <= 1) & (distances >= 0) & (distances < range_m)
    distances = np.where(hit, distances, np.inf)
    return np.where(hit.any(axis=1), distances.argmin(axis=1), -1)


def _along(starts: np.ndarray, ways: np.ndarray, units: np.ndarray) -> np.ndarray:
    """How far along unit vectors the lines of walls are; a line that is never crossed is no number."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return _cross(starts, ways) / _cross(units, ways)


def _unit(angles: np.ndarray) -> np.ndarray:
    return np.stack((np.cos(angles), np.sin(angles)), axis=-1)


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]


def _polygon(points: np.ndarray) -> shapely.Polygon:
    """Where two sectors meet in a point, it is there twice. Rounding may cross a jump from wall to wall."""
    steps = np.abs(np.diff(points, axis=0, prepend=points[-1:])).max(axis=1)
    polygon = shapely.Polygon(points[steps > SAME_M])
    return polygon if polygon.is_valid else polygon.buffer(0)
