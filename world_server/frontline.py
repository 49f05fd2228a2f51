"""What lies ahead of lines of robots, and is held by nobody.

On its way a line sees ground ahead of it, and may for a while cut off some more from the rest. It does not
claim to hold such ground, so it is no breach when it is lost again. What counts is what robots say of their
lines and where they really are: as far as a line is whole, from wall to wall, it parts the plan.
"""

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
import shapely

from wire.fields import Point

BESIDE_M = 0.01  # from a link, to see what is ahead of it and what behind
WIDTH_M = 1e-4
BEYOND_M = 0.1  # into a wall, so that no slit is left there: ends move on after they have measured

Line = Sequence[Point]
"""From the wall at its left end over its robots to the wall at its right end, the contaminated side ahead."""


def whole_lines(robots: dict[str, tuple[str, str, Point, Point]]) -> list[Line]:
    """All lines from wall to wall. `robots`: by name who is on its left and right, its place, its wall."""
    lines = []
    for name, (left, *_) in robots.items():
        chain: list[str] = []
        while left == "wall" and name in robots and name not in chain:
            chain.append(name)
            name = robots[name][1]
        if chain and name == "wall":
            places = [robots[one][2] for one in chain]
            lines.append([robots[chain[0]][3], *places, robots[chain[-1]][3]])
    return lines


def ahead_of(plan: shapely.Polygon, lines: Iterable[Line]) -> shapely.Geometry:
    """The parts of a plan that are ahead of some line and behind none."""
    lines = [_lengthened(line) for line in lines]
    if not lines:
        return shapely.Polygon()
    cut = shapely.union_all([shapely.LineString(line).buffer(WIDTH_M) for line in lines])
    parts = shapely.get_parts(plan.difference(cut))
    front, back = (shapely.MultiPoint(_beside(lines, side)) for side in (BESIDE_M, -BESIDE_M))
    return shapely.union_all([part for part in parts if part.intersects(front) and not part.intersects(back)])


def _lengthened(line: Line) -> np.ndarray:
    """The line, with both ends a little into their walls: float64, (points, 2)."""
    points = np.array(line, dtype=float)
    for end, robot in ((0, 1), (-1, -2)):
        way = points[end] - points[robot]
        points[end] += BEYOND_M / max(float(np.hypot(*way)), 1e-9) * way
    return points


def _beside(lines: Iterable[np.ndarray], aside_m: float) -> list[np.ndarray]:
    """Points to the left of the middle of each link between robots; negative: to the right."""
    points = []
    for line in lines:
        robots = line[1:-1]
        links = pairwise(robots) if len(robots) > 1 else [(line[0], line[-1])]
        for start, end in links:
            way = end - start
            length_m = max(float(np.hypot(*way)), 1e-9)
            points.append((start + end) / 2 + aside_m / length_m * np.array([-way[1], way[0]]))
    return points
