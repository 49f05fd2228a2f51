"""The referees of a run: exact, on a raster, or both; and pictures of what they say."""

from collections.abc import Callable, Sequence

import numpy as np
import shapely

from wire.clearing import Clearing
from wire.scenario import Scenario, Sensors
from world_server.deployment import plan_of, turned, turned_point
from world_server.frontline import Line, ahead_of
from world_server.raster_referee import RasterReferee
from world_server.referee import NOTHING_M2, Place, Places, Referee, Verdict

SIMPLIFIED_M = 0.01
DRAWN_EVERY_S = 1.0
"""Outlines are for pictures."""


class Judges:
    """Steps the referees that a scenario asks for. The exact one decides, where there is one.

    They judge in the frame of the plan before it is turned: neither are their circles round, nor do cells of
    a raster turn, and what they say is not to depend on it.
    """

    def __init__(self, scenario: Scenario, places_m: Places, alive: Sequence[bool]) -> None:
        sensors, plan = scenario.sensors or Sensors(), plan_of(scenario.field)
        kinds = {"exact": (Referee,), "raster": (RasterReferee,), "both": (Referee, RasterReferee)}
        self._turned_rad = scenario.field.turned_rad
        self._every_ticks, self._outline = scenario.tick_of(DRAWN_EVERY_S), b""
        self._plan = plan
        self._places, self._alive = self._turned_back(places_m), list(alive)
        self._referees = [
            kind(plan, sensors.detect_m, self._places, alive) for kind in kinds[sensors.referee]
        ]
        self._verdicts: list[Verdict] = [referee.verdict for referee in self._referees]

    @property
    def cleared_share(self) -> float:
        """How much of the plan is clear."""
        return 1 - self._verdicts[0].contaminated_m2 / self._plan.area

    def step(self, places_m: Places, corners_m: Sequence[Places], alive: Sequence[bool]) -> None:
        """One tick, at whose end robots are at these places, and live or not.

        `corners_m`: where each one's way was not straight. Where nothing has changed, nothing changes.
        """
        before, self._places = self._places, self._turned_back(places_m)
        if before == self._places and alive == self._alive:
            self._verdicts = [referee.verdict for referee in self._referees]
            return
        corners = [self._turned_back(corners) for corners in corners_m]
        self._verdicts = [
            referee.step(before, self._places, self._alive, alive, corners) for referee in self._referees
        ]
        self._alive = list(alive)

    def said(self, tick: int, lines: Callable[[], list[Line]]) -> Clearing:
        """The verdicts of the last step, as Facts keep them. `lines`: those that robots say they form."""
        verdict = self._verdicts[0]
        raster_m2 = self._verdicts[1].contaminated_m2 if len(self._verdicts) > 1 else None
        ahead_m2 = 0.0
        if verdict.breached_m2 > NOTHING_M2:
            ahead = ahead_of(self._plan, [self._turned_back(line) for line in lines()])
            lost = [part for part in shapely.get_parts(self._referees[0].lost) if part.area > 0]
            ahead_m2 = sum(part.area for part in lost if ahead.contains(part.representative_point()))
        return Clearing(*verdict, raster_m2, self._drawn(tick), ahead_m2)

    def _drawn(self, tick: int) -> bytes:
        """The outline, once in a while and if it is new."""
        if tick % self._every_ticks:
            return b""
        outline = outline_of(turned(self._referees[0].shape, self._turned_rad))
        if outline == self._outline:
            return b""
        self._outline = outline
        return outline

    def _turned_back(self, points_m: Places) -> list[Place]:
        if self._turned_rad == 0:
            return list(points_m)
        return [turned_point(point, -self._turned_rad) for point in points_m]


def outline_of(shape: shapely.Geometry) -> bytes:
    """The rings of a geometry, simplified, as Clearing has them."""
    rings = shapely.get_rings(shapely.get_parts(shape.simplify(SIMPLIFIED_M)))
    gap = np.full((1, 2), np.nan)
    points = [part for ring in rings for part in (shapely.get_coordinates(ring), gap)]
    return np.concatenate(points or [gap]).astype("<f4").tobytes()
