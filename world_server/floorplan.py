"""Floor plans: the free space as one polygon with holes, in metres, from text or from the pixels of a bitmap.

What is read here is one polygon and no more; whether robots can serve it says world_server/plan_checks.py.
Reading files belongs to deploy.
"""

import re

import msgspec
import numpy as np
import shapely

POLYGON = re.compile(r"\s*(MULTI)?POLYGON\b", re.IGNORECASE)
FARTHEST_M = 1e6
MOST_POINTS = 20_000
MOST_PIXELS = 4096**2
FREE_FROM = 128  # of 255: half grey is free
SHOWN = 80


class PlanError(Exception):
    """What is wrong with a floor plan, in one line: the place, the value, and what would be right."""

    def __init__(self, text: str) -> None:
        super().__init__(" ".join(text.split()))


Ring = tuple[tuple[float, ...], ...]


class _Polygon(msgspec.Struct, tag_field="type", tag="Polygon"):
    coordinates: tuple[Ring, ...]

    def rings(self) -> list[tuple[Ring, ...]]:
        return [self.coordinates]


class _MultiPolygon(msgspec.Struct, tag_field="type", tag="MultiPolygon"):
    coordinates: tuple[tuple[Ring, ...], ...]

    def rings(self) -> list[tuple[Ring, ...]]:
        return list(self.coordinates)


class _Feature(msgspec.Struct, tag_field="type", tag="Feature"):
    geometry: _Polygon | _MultiPolygon

    def rings(self) -> list[tuple[Ring, ...]]:
        return self.geometry.rings()


class _FeatureCollection(msgspec.Struct, tag_field="type", tag="FeatureCollection"):
    features: tuple[_Feature, ...]

    def rings(self) -> list[tuple[Ring, ...]]:
        return [rings for feature in self.features for rings in feature.rings()]


_GEOJSON = msgspec.json.Decoder(_Polygon | _MultiPolygon | _Feature | _FeatureCollection)


def from_wkt(text: str) -> shapely.Polygon:
    """The plan of a well-known text with one polygon, in metres. Raises PlanError."""
    if not POLYGON.match(text):
        raise PlanError(f"must begin with POLYGON, got {ascii(text[:20])}")
    try:
        with np.errstate(invalid="ignore"):  # what is not a number is refused as a point
            return _one_polygon(shapely.from_wkt(text))
    except shapely.errors.ShapelyError as error:
        raise PlanError(f"must be the text of a polygon, but {_first_line(error)}") from None


def from_geojson(text: str | bytes) -> shapely.Polygon:
    """The plan of a GeoJSON document with one polygon. Its coordinates are metres, not degrees.

    Raises PlanError. Source: RFC 7946.
    """
    try:
        rings = _GEOJSON.decode(text).rings()
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise PlanError(f"must be GeoJSON with a polygon, but {_first_line(error)}") from None
    return from_rings(*rings)


def from_rings(*polygons: tuple[Ring, ...]) -> shapely.Polygon:
    """The plan of one polygon, given as its outer ring and its islands. Raises PlanError."""
    try:
        made = [shapely.Polygon(*_shell_and_holes(rings)) for rings in polygons]
        return _one_polygon(shapely.MultiPolygon(made))
    except (shapely.errors.ShapelyError, ValueError) as error:
        raise PlanError(f"must be the rings of a polygon, but {_first_line(error)}") from None


def from_bitmap(grey: np.ndarray, metres_per_px: float) -> shapely.Polygon:
    """The plan of a picture: `grey` has the shape (rows, columns), 0 is wall and 255 free, the top row first.

    The lower left corner of the picture is the origin. Outlines of pixels are stairs, which no robot can
    follow as a wall: they are simplified by at most one pixel. Raises PlanError.
    """
    if grey.ndim != 2 or not 0 < grey.size <= MOST_PIXELS:
        raise PlanError(f"must have from 1 to {MOST_PIXELS} grey pixels, got {list(grey.shape)}")
    if not 0 < metres_per_px <= FARTHEST_M:
        raise PlanError(f"metres_per_px must be > 0 and <= {FARTHEST_M:g}, got {metres_per_px}")
    free = np.pad(grey[::-1] >= FREE_FROM, ((0, 0), (1, 1))).astype(np.int8)
    changes = np.diff(free, axis=1)
    rows, left_px = np.nonzero(changes == 1)
    _, right_px = np.nonzero(changes == -1)
    runs = shapely.box(left_px, rows, right_px, rows + 1)
    pixels = _one_polygon(shapely.union_all(runs))
    return shapely.transform(pixels.simplify(1.0), lambda points_px: points_px * metres_per_px)


def _shell_and_holes(rings: tuple[Ring, ...]) -> tuple[Ring, tuple[Ring, ...]]:
    flat = [tuple(point[:2] for point in ring) for ring in rings]
    return (flat[0], tuple(flat[1:])) if flat else ((), ())


def _one_polygon(geometry: shapely.Geometry) -> shapely.Polygon:
    """The one polygon of a geometry, flat; its points can be worked with."""
    parts = [one for one in shapely.get_parts(geometry) if not one.is_empty]
    if len(parts) != 1:
        sizes = ", ".join(f"{one.area:.3g}" for one in parts[:5])
        found = f"{len(parts)} (areas {sizes}{', ...' if len(parts) > 5 else ''})" if parts else "none"
        raise PlanError(f"must be one polygon, one piece of free space, got {found}")
    plan = shapely.force_2d(parts[0])
    points = shapely.get_coordinates(plan)
    if len(points) > MOST_POINTS:
        raise PlanError(f"must have at most {MOST_POINTS} points, got {len(points)}")
    wrong = ~(np.abs(points) <= FARTHEST_M).all(axis=1)  # not a number is wrong too
    if wrong.any():
        raise PlanError(f"all points must be within {FARTHEST_M:g} m, got {_at(points[wrong][0])}")
    return plan


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or ["it is none"])[0][:SHOWN]


def _at(point: np.ndarray) -> str:
    return f"[{point[0]:.4g}, {point[1]:.4g}]"
