"""The referees of a run: exact, on a raster, or both; and pictures of what they say."""

from collections.abc import Sequence

import numpy as np
import shapely

from wire.clearing import Clearing
from wire.scenario import Sensors
from world_server.raster_referee import RasterReferee
from world_server.referee import Place, Places, Referee, Verdict

SIMPLIFIED_M = 0.01
"""Outlines are for pictures."""


class Judges:
    """Steps the referees that a scenario asks for. The exact one decides, where there is one."""

    def __init__(
        self,
        sensors: Sensors,
        plan: shapely.Polygon,
        places_m: Places,
        alive: Sequence[bool],
        every_ticks: int,
    ) -> None:
        kinds = {"exact": (Referee,), "raster": (RasterReferee,), "both": (Referee, RasterReferee)}
        self._referees = [
            kind(plan, sensors.detect_m, places_m, alive) for kind in kinds[sensors.referee]
        ]
        self._verdicts: list[Verdict] = [referee.verdict for referee in self._referees]
        self._alive = list(alive)
        self._area_m2 = plan.area
        self._every_ticks, self._outline = every_ticks, b""

    @property
    def cleared_share(self) -> float:
        """How much of the plan is clear."""
        return 1 - self._verdicts[0].contaminated_m2 / self._area_m2

    def step(
        self, before_m: Places, after_m: Places, corners_m: Sequence[Sequence[Place]], alive: Sequence[bool]
    ) -> None:
        """One tick. `corners_m`: where each robot's way was not straight. At rest nothing changes."""
        if before_m == after_m and alive == self._alive:
            self._verdicts = [referee.verdict for referee in self._referees]
            return
        self._verdicts = [
            referee.step(before_m, after_m, self._alive, alive, corners_m) for referee in self._referees
        ]
        self._alive = list(alive)

    def said(self, tick: int) -> Clearing:
        """The verdicts of the last step, as Facts keep them."""
        verdict = self._verdicts[0]
        raster_m2 = self._verdicts[1].contaminated_m2 if len(self._verdicts) > 1 else None
        return Clearing(*verdict, raster_m2, self._drawn(tick))

    def _drawn(self, tick: int) -> bytes:
        """The outline, once in a while and if it is new."""
        if tick % self._every_ticks:
            return b""
        outline = outline_of(self._referees[0].shape)
        if outline == self._outline:
            return b""
        self._outline = outline
        return outline


def outline_of(shape: shapely.Geometry) -> bytes:
    """The rings of a geometry, simplified, as Clearing has them."""
    rings = shapely.get_rings(shapely.get_parts(shape.simplify(SIMPLIFIED_M)))
    gap = np.full((1, 2), np.nan)
    points = [part for ring in rings for part in (shapely.get_coordinates(ring), gap)]
    return np.concatenate(points or [np.empty((0, 2))]).astype("<f4").tobytes()
