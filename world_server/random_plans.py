"""Random floor plans: rooms on a grid, joined by corridors to a tree, and by one more for every island.

Equal arguments give equal plans. Every plan passes world_server/plan_checks.py, or is drawn again.
"""

from itertools import product

import numpy as np
import shapely

from world_server import chance
from world_server.floorplan import PlanError
from world_server.plan_checks import check_plan

Room = tuple[int, int]
Door = tuple[Room, Room]

CELL_M = 5.0
ROOM_M = (2.0, 4.2)  # least and greatest width of a room
CORRIDOR_M = (0.9, 1.6)
CORNERS = (5, 9)
ASIDE_M = 0.3
ROUND_M = 0.3  # of corners, so that whoever stays less than that from walls touches all of them
ROUGHLY_M = 0.01
GRID_M = 0.001
DRAWS = 20


def random_plan(
    seed: int,
    rooms: tuple[int, int] = (3, 3),
    islands: int = 0,
    obstacle_m: float = 0.25,
    detect_m: float = 0.7,
) -> shapely.Polygon:
    """A plan of (columns, rows) of rooms with so many islands, for robots that stay `obstacle_m` from walls.

    Raises PlanError where so many rooms have no place for so many islands, or no plan suits such robots.
    """
    columns, rows = rooms
    if min(rooms) < 1:
        raise PlanError(f"rooms must be at least 1 in both directions, got {list(rooms)}")
    most = (columns - 1) * (rows - 1)
    if not 0 <= islands <= most:
        raise PlanError(f"islands must be from 0 to {most} for {columns} x {rows} rooms, got {islands}")
    for draw in range(DRAWS):
        plan = _draw(chance.generator(seed, "floor plan", columns, rows, islands, draw), rooms, islands)
        try:
            check_plan(plan, obstacle_m, detect_m)
            if len(plan.interiors) != islands:  # rooms without a door between them may touch by chance
                raise PlanError(f"there must be {islands} islands, got {len(plan.interiors)}")
        except PlanError as error:
            complaint = error
            continue
        return plan
    raise PlanError(f"none of {DRAWS} random plans suits such robots; of the last one: {complaint}")


def _draw(generator: np.random.Generator, rooms: tuple[int, int], islands: int) -> shapely.Polygon:
    places = list(product(range(rooms[0]), range(rooms[1])))
    centres = {
        place: (np.array(place) + 0.5) * CELL_M + generator.uniform(-ASIDE_M, ASIDE_M, 2) for place in places
    }
    parts = [_room(generator, centre) for centre in centres.values()]
    parts += [
        _corridor(generator, centres[one], centres[other])
        for one, other in _doors(generator, places, islands)
    ]
    rough = shapely.union_all(parts)
    smooth = rough.buffer(ROUND_M).buffer(-2 * ROUND_M).buffer(ROUND_M)
    snapped = shapely.set_precision(smooth.simplify(ROUGHLY_M), GRID_M)
    return shapely.set_precision(snapped, 0)  # or whatever is cut out of the plan would be snapped as well


def _doors(generator: np.random.Generator, places: list[Room], islands: int) -> list[Door]:
    """Corridors in random order, as long as they join what is not joined yet, and some of the others."""
    known = set(places)
    doors = [
        ((column, row), other)
        for column, row in places
        for other in ((column + 1, row), (column, row + 1))
        if other in known
    ]
    piece = {place: number for number, place in enumerate(places)}
    tree, others = [], []
    for number in generator.permutation(len(doors)):
        one, other = doors[number]
        if piece[one] == piece[other]:
            others.append(doors[number])
            continue
        tree.append(doors[number])
        merged = piece[other]
        piece = {place: piece[one] if which == merged else which for place, which in piece.items()}
    return tree + others[:islands]


def _room(generator: np.random.Generator, centre: np.ndarray) -> shapely.Polygon:
    """A star of random corners around the centre."""
    corners = int(generator.integers(*CORNERS))
    angles = (np.arange(corners) + generator.uniform(-0.3, 0.3, corners)) * (2 * np.pi / corners)
    radii = generator.uniform(*ROOM_M, corners) / 2
    return shapely.Polygon(centre + radii[:, None] * np.stack((np.cos(angles), np.sin(angles)), axis=1))


def _corridor(generator: np.random.Generator, one: np.ndarray, other: np.ndarray) -> shapely.Polygon:
    line = shapely.LineString((one, other))
    return line.buffer(generator.uniform(*CORRIDOR_M) / 2, cap_style="flat")
