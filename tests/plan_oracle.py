"""What a robot sees in a floor plan, by shadows: slow, plain, and with nothing in common with Sight."""

import math

import numpy as np
import shapely

FAR = 1e3
CORNERS = 64


def seen(
    plan: shapely.Polygon, place: tuple[float, float], range_m: float, around: bool = True
) -> shapely.Geometry:
    """The disc in the plan without the shadows of all walls; the circle is a polygon around or inside it."""
    radius_m = range_m / math.cos(math.pi / CORNERS) if around else range_m
    disc = shapely.Point(place).buffer(radius_m, quad_segs=CORNERS // 4)
    shadows = [
        shapely.Polygon((one, other, other + FAR * (other - place), one + FAR * (one - place)))
        for ring in shapely.get_rings(plan)
        for one, other in zip(
            shapely.get_coordinates(ring)[:-1], shapely.get_coordinates(ring)[1:], strict=True
        )
        if shapely.LineString((one, other)).intersects(disc)
        and abs(np.linalg.det((one - place, other - place))) > 1e-12
    ]
    return disc.intersection(plan).difference(shapely.union_all(shadows))
