"""Shapes that pictures are made of, as polylines: (points, 2) each, in metres."""

from collections.abc import Sequence

import numpy as np

CORNERS = 40
"""Of what is drawn as a circle."""


def rings_of(outline: bytes) -> list[np.ndarray]:
    """The closed rings of an outline, as `wire.clearing.Clearing` has it."""
    points_m = np.frombuffer(outline, "<f4").reshape(-1, 2).astype(float)
    gaps = np.isnan(points_m[:, 0])
    parts = np.split(points_m, np.flatnonzero(gaps))
    rings = (part[~np.isnan(part[:, 0])] for part in parts)
    return [ring for ring in rings if len(ring)]


def filled(rings_m: Sequence[np.ndarray], step_m: float) -> np.ndarray:
    """What closed rings enclose, holes left out, as level strokes `step_m` apart: (strokes, 2, 2).

    Strokes that are `step_m` thick fill it: the 2D views of Rerun have no polygons.
    """
    if not rings_m:
        return np.zeros((0, 2, 2))
    starts = np.concatenate([ring[:-1] for ring in rings_m])
    ends = np.concatenate([ring[1:] for ring in rings_m])
    low, high = np.minimum(starts[:, 1], ends[:, 1]), np.maximum(starts[:, 1], ends[:, 1])
    heights = np.arange(np.floor(low.min() / step_m) + 0.5, high.max() / step_m) * step_m
    rows, edges = np.nonzero((low <= heights[:, None]) & (heights[:, None] < high))
    share = (heights[rows] - starts[edges, 1]) / (ends[edges, 1] - starts[edges, 1])
    across = starts[edges, 0] + share * (ends[edges, 0] - starts[edges, 0])
    order = np.lexsort((across, rows))
    return np.stack([across[order], heights[rows[order]]], axis=1).reshape(-1, 2, 2)


def circles(places_m: np.ndarray, radius_m: float) -> np.ndarray:
    """Circles around places: (places, points, 2)."""
    angles = np.linspace(0, 2 * np.pi, CORNERS + 1)
    return places_m[:, None] + radius_m * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def area_m2(ring_m: np.ndarray) -> float:
    """What a closed ring encloses."""
    (across, up), (next_across, next_up) = ring_m[:-1].T, ring_m[1:].T
    return abs(float((across * next_up - next_across * up).sum())) / 2


def seen_from(pose: np.ndarray, way_m: tuple[float, float]) -> np.ndarray:
    """Where a way leads that a body at (x_m, y_m, heading_rad) tells, forward and to its left."""
    (forward_m, left_m), (x_m, y_m, heading_rad) = way_m, pose
    cos, sin = np.cos(heading_rad), np.sin(heading_rad)
    return np.array([x_m + cos * forward_m - sin * left_m, y_m + sin * forward_m + cos * left_m])
