"""The floor plan in a file: well-known text (.wkt), GeoJSON (.geojson, .json), or a picture and a scale."""

from pathlib import Path

import numpy as np
import shapely

from deploy.mistake import Mistake
from wire.fields import Point
from world_server.floorplan import PlanError, from_bitmap, from_geojson, from_rings, from_wkt
from world_server.plan_checks import check_plan

PICTURES = (".png", ".pgm", ".bmp")
PLANS = Path(__file__).parent / "scenarios" / "plans"


def load_plan(path: Path, metres_per_px: float | None, obstacle_m: float, detect_m: float) -> shapely.Polygon:
    """The plan of a file, which robots can clear that stay `obstacle_m` from walls and see `detect_m` far.

    Of a picture, `metres_per_px` is the scale. Raises Mistake with the name of the file.
    """
    plan = read_plan(path, metres_per_px)
    try:
        check_plan(plan, obstacle_m, detect_m)
    except PlanError as error:
        raise Mistake(f"{path.name}: {error}") from None
    return plan


def read_plan(path: Path, metres_per_px: float | None) -> shapely.Polygon:
    """The plan of a file, whether robots can clear it or not. Raises Mistake with the name of the file."""
    try:
        return _read(path, metres_per_px)
    except PlanError as error:
        raise Mistake(f"{path.name}: {error}") from None


def polygon_of(rings_m: tuple[tuple[Point, ...], ...]) -> shapely.Polygon:
    """The plan that a scenario spells out: the outer ring, then the islands. Raises Mistake."""
    try:
        return from_rings(rings_m)
    except PlanError as error:
        raise Mistake(f"field.rings_m: {error}") from None


def rings_of(plan: shapely.Polygon) -> tuple[tuple[Point, ...], ...]:
    """A plan as a scenario spells it out."""
    return tuple(
        tuple((x_m, y_m) for x_m, y_m in shapely.get_coordinates(ring)[:-1].tolist())
        for ring in (plan.exterior, *plan.interiors)
    )


def _read(path: Path, metres_per_px: float | None) -> shapely.Polygon:
    kind = path.suffix.lower()
    if kind not in (".wkt", ".geojson", ".json", *PICTURES):
        raise PlanError(
            f"must end in .wkt, .geojson, .json, {', '.join(PICTURES)}, got {kind or 'no ending'}"
        )
    if (kind in PICTURES) != (metres_per_px is not None):
        is_for = "a picture needs metres_per_px" if kind in PICTURES else "metres_per_px is for pictures only"
        raise PlanError(f"{is_for}, got {'none' if metres_per_px is None else f'{metres_per_px:g}'}")
    try:
        if metres_per_px is not None:
            return from_bitmap(_grey(path), metres_per_px)
        content = path.read_bytes()
    except (OSError, ValueError) as error:  # a name that no file can have is a ValueError
        why = getattr(error, "strerror", None) or "it is no such file or is damaged"
        raise PlanError(f"cannot be read: {why}") from None
    return from_wkt(content.decode("latin-1")) if kind == ".wkt" else from_geojson(content)


def _grey(path: Path) -> np.ndarray:
    """The pixels of a picture, 0 to 255."""
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as picture:
            return np.asarray(picture.convert("L"))
    except UnidentifiedImageError:
        raise PlanError("must be a picture, but its content is none") from None
    except (Image.DecompressionBombError, SyntaxError) as error:
        raise PlanError(f"must be a picture of reasonable size, but {error}") from None
