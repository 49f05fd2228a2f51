"""The referee on a grid of cells: the same rule as in world_server/referee.py, by other means.

It shares nothing with the exact one but the rule and the judgement of jumps, so that each checks the other.
A cell is in the plan if its centre is, and seen if its centre is, by half a diagonal within the range, so
that all of it is. Contamination spreads to the four neighbours: cells that touch at a corner are a barrier.
"""

from collections.abc import Sequence
from functools import partial, reduce

import numpy as np
import shapely

from world_server.referee import Corners, Place, Places, Verdict, Watch, living, unbroken_ways

HALF_DIAGONAL = 0.71  # of a cell
LOOK_PER_CELL = 2
UNCHECKED_CELLS = 1.5  # before the one looked at: walls of stairs would hide the cells along them
FEWEST_ACROSS_RANGE = 14


class RasterReferee:
    """Keeps the contaminated cells; robots see `detect_m` far, not through walls.

    A barrier of robots surely holds if no gap is wider than 2 (detect_m - step_m / 2 - 0.71 cell_m).
    """

    def __init__(
        self,
        plan: shapely.Polygon,
        detect_m: float,
        places_m: Places,
        alive: Sequence[bool],
        cell_m: float = 0.05,
    ) -> None:
        if cell_m > detect_m / FEWEST_ACROSS_RANGE * (1 + 1e-9):
            raise ValueError(f"cell_m must be <= {detect_m / FEWEST_ACROSS_RANGE:.4g}, got {cell_m}")
        self._cell_m, self._range_m = cell_m, detect_m - HALF_DIAGONAL * cell_m
        self._watch = Watch(plan)
        west_m, south_m, east_m, north_m = plan.bounds
        self._margin = int(np.ceil(detect_m / cell_m)) + 1
        self._origin = np.array([west_m, south_m]) - self._margin * cell_m
        size = np.ceil(np.array([east_m - west_m, north_m - south_m]) / cell_m - 1e-9).astype(int)
        columns, rows = size + 2 * self._margin
        xs_m, ys_m = (
            self._origin[axis] + (np.arange(n) + 0.5) * cell_m for axis, n in enumerate((columns, rows))
        )
        self._free = shapely.contains_xy(plan, *np.meshgrid(xs_m, ys_m, indexing="ij"))
        self._views: dict[Place, np.ndarray] = {}
        self._places = living(places_m, alive)
        self._contaminated = self._free & ~self._mask([self._view(place) for place in self._places])
        self._lost = np.zeros_like(self._free)

    @property
    def verdict(self) -> Verdict:
        """The state, as a verdict in which nothing has changed."""
        return Verdict(self._area_m2(self._contaminated), 0.0, 0.0)

    def step(
        self,
        before_m: Places,
        after_m: Places,
        alive_before: Sequence[bool],
        alive_after: Sequence[bool],
        corners_m: Corners = (),
    ) -> Verdict:
        """One tick in which each robot went from one place to another; all in the same order of robots."""
        contaminated, places = self._contaminated, self._places
        ways = unbroken_ways(self._watch, before_m, after_m, alive_before, alive_after, corners_m)
        watched = self._mask([self._seen_along(way) for way in ways if way[0] in places])
        self._places = living(after_m, alive_after)
        reached = _flood(contaminated & ~watched, self._free & ~watched)
        self._contaminated = reached & ~self._mask([self._view(place) for place in self._places])
        lost = self._contaminated & ~contaminated
        given_up = lost & self._mask([self._view(place) for place in places]) if lost.any() else lost
        self._lost = lost & ~given_up
        self._views = {place: view for place, view in self._views.items() if place in self._places}
        return Verdict(*map(self._area_m2, (self._contaminated, lost, given_up)))

    @property
    def shape(self) -> shapely.Geometry:
        """What is contaminated, as the cells have it."""
        return self._drawn(self._contaminated)

    @property
    def lost(self) -> shapely.Geometry:
        """What was lost in the last step and had not been in sight."""
        return self._drawn(self._lost)

    def _drawn(self, cells: np.ndarray) -> shapely.Geometry:
        """Cells as one shape; columns of cells are joined first, which is faster."""
        edges = np.diff(cells.astype(np.int8), axis=1)  # there is a margin around the plan
        first, last = ((np.argwhere(edges == step) + (0, 1)) for step in (1, -1))
        south_west, north_east = (corners * self._cell_m + self._origin for corners in (first, last + (1, 0)))
        return shapely.union_all(shapely.box(*south_west.T, *north_east.T))

    def _area_m2(self, cells: np.ndarray) -> float:
        return float(np.count_nonzero(cells) * self._cell_m**2)

    def _seen_along(self, way: Places) -> np.ndarray:
        """What is seen all along a way."""
        return reduce(partial(np.intersect1d, assume_unique=True), [self._view(place) for place in way])

    def _mask(self, views: Sequence[np.ndarray]) -> np.ndarray:
        """The cells of all views together."""
        seen = np.zeros_like(self._free)
        for view in views:
            seen.ravel()[view] = True
        return seen

    def _view(self, place: Place) -> np.ndarray:
        view = self._views.get(place)
        if view is None:
            view = self._views[place] = self._seen_from(np.array(place))
        return view

    def _seen_from(self, place: np.ndarray) -> np.ndarray:
        """Numbers of the free cells in range to which the straight way is free."""
        here = (place - self._origin) / self._cell_m
        first = np.maximum(np.floor(here).astype(int) - self._margin, 0)
        last = np.minimum(first + 2 * self._margin + 1, self._free.shape)
        away_x, away_y = (np.arange(*ends) + 0.5 - at for *ends, at in zip(first, last, here, strict=True))
        far = np.hypot(away_x[:, None], away_y)
        free = self._free[first[0] : last[0], first[1] : last[1]]
        within = far <= self._range_m / self._cell_m
        columns, rows = np.nonzero(within & free)
        nearest = far[within & ~free].min(initial=np.inf)
        doubtful = np.flatnonzero(far[columns, rows] > nearest - HALF_DIAGONAL)
        ways = np.stack((away_x[columns[doubtful]], away_y[rows[doubtful]]), axis=1)
        seen = np.ones(len(columns), dtype=bool)
        seen[doubtful] = self._is_free(here, ways)
        return (columns[seen] + first[0]) * self._free.shape[1] + rows[seen] + first[1]

    def _is_free(self, here: np.ndarray, ways: np.ndarray) -> np.ndarray:
        """Is each of these ways free, looked at here and there? In cells; walls may be close to its end."""
        far = np.hypot(ways[:, 0], ways[:, 1])
        checked = np.maximum(far - UNCHECKED_CELLS, 0.0) / np.maximum(far, 1e-12)
        shares = np.linspace(0, 1, LOOK_PER_CELL * self._margin + 1) * checked[:, None]
        columns = (here[0] + shares * ways[:, :1]).astype(int)
        rows = (here[1] + shares * ways[:, 1:]).astype(int)
        return self._free[columns, rows].all(axis=1)


def _flood(sources: np.ndarray, open_cells: np.ndarray) -> np.ndarray:
    """All open cells that can be reached from the sources through sides of cells.

    Around the plan there is a margin of cells that are not open, so that neighbours by number are neighbours.
    """
    columns = open_cells.shape[1]
    reached, open_cells = sources.copy().ravel(), open_cells.ravel()
    entered = np.zeros_like(reached)
    for step in (-columns, -1, 1, columns):
        entered |= np.roll(reached, step)
    rim = np.flatnonzero(entered & open_cells & ~reached)
    reached[rim] = True
    while rim.size:
        near = np.concatenate((rim - columns, rim - 1, rim + 1, rim + columns))
        rim = np.unique(near[open_cells[near] & ~reached[near]])
        reached[rim] = True
    return reached.reshape(sources.shape)
