"""The mission "clear": the plan's walls, who is on a line, and how much is left to clear."""

import math
from typing import ClassVar

import numpy as np

from deploy.metrics.clear import ClearMetrics
from deploy.scenes.mission import BLUE, GREEN, ORANGE, RED, Mission, Plot
from wire.messages import Facts
from wire.scenario import Scenario

AROUND_M = 0.5


class ClearMission(Mission):
    """Walls, robots on lines and beside them, the contaminated area over time."""

    plots = (
        Plot("contaminated", "Contaminated area in m²", (("contaminated", RED), ("lost in a tick", ORANGE))),
        Plot("lines", "Robots on lines", (("on lines", GREEN),)),
    )
    states: ClassVar = {"line": GREEN, "beside": BLUE}
    legend = "Grey: walls. Robots: green when they are on a line, else blue."

    def __init__(self, scenario: Scenario) -> None:
        self._metrics, self._nodes = ClearMetrics(scenario), scenario.node_ids
        cos, sin = math.cos(scenario.field.turned_rad), math.sin(scenario.field.turned_rad)
        turn = np.array([[cos, sin], [-sin, cos]])
        rings_m = [np.array([*ring, ring[0]]) @ turn for ring in scenario.field.rings_m]
        self.ways = tuple(tuple((x_m, y_m) for x_m, y_m in ring.tolist()) for ring in rings_m)
        low, high = rings_m[0].min(axis=0) - AROUND_M, rings_m[0].max(axis=0) + AROUND_M
        self.bounds_m = (*low.tolist(), *high.tolist())
        self.radius_m = scenario.robots.body_m / 2

    def take(self, facts: Facts, links: np.ndarray) -> None:
        """Fold one tick."""
        self._metrics.feed(facts)

    def doing(self, row: int) -> str:
        """Has the robot a neighbour on a line?"""
        return "line" if self._metrics.is_on_line(self._nodes[row]) else "beside"

    def curves(self) -> dict[str, tuple[float, ...]]:
        """What is contaminated, what was lost in the last tick, and robots on lines."""
        instant = self._metrics.instant
        return {"contaminated": (instant.contaminated_m2, instant.lost_m2), "lines": (instant.on_lines,)}
