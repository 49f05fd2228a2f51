"""The mission "area": idleness of cells, what the base station knows of it, and who is in contact with it."""

from typing import ClassVar

import numpy as np

from deploy.metrics.area import AreaMetrics
from deploy.scenes.mission import BLUE, GREEN, ORANGE, VIOLET, Mission, Plot
from wire.fields import Grid
from wire.messages import Facts
from wire.scenario import Scenario

CONTACT_S = 30.0


class AreaMission(Mission):
    """A heat map of idleness, and robots that are in contact with the base station or not."""

    plots = (
        Plot("idleness", "Idleness in s: true, by cell", (("mean", GREEN), ("worst", ORANGE))),
        Plot("sa_delay", "SA delay in s: age of what the base knows", (("mean", BLUE), ("worst", VIOLET))),
    )
    states: ClassVar = {"patrol": BLUE, "contact": GREEN}

    def __init__(self, scenario: Scenario) -> None:
        self._metrics = AreaMetrics(scenario)
        self._field, self._tick_s = scenario.field, scenario.tick_s
        self._sites_m = np.array(scenario.field.sites_m())
        self._tower = scenario.node_ids.index(scenario.tower.id)
        self._instant = None
        self._contact_tick: dict[int, int] = {}
        self._tick = 0
        margin_m = scenario.field.cell_m / 2
        low, high = self._sites_m.min(axis=0) - margin_m, self._sites_m.max(axis=0) + margin_m
        self.bounds_m = (*low.tolist(), *high.tolist())
        self.radius_m = (self.bounds_m[2] - self.bounds_m[0]) / 85
        travel_s = len(self._sites_m) * scenario.field.cell_m / scenario.robots.max_speed_m_s
        self.hottest_s = 3 * travel_s / len(scenario.robot_ids)
        self.legend = (
            f"Heat map: time since the last visit, black 0 s, yellow {self.hottest_s:.0f} s and more. "
            f"Robots: green when the base station heard them within the last {CONTACT_S:g} s, else blue."
        )

    def take(self, facts: Facts, links: np.ndarray) -> None:
        """Fold one tick."""
        self._instant = self._metrics.feed(facts)
        self._tick = facts.tick
        for sender in links[links[:, 1] == self._tower, 0].tolist():
            self._contact_tick[sender] = facts.tick

    def doing(self, row: int) -> str:
        """Contact: the base station has heard the robot within the last CONTACT_S."""
        heard = self._contact_tick.get(row)
        recent = heard is not None and (self._tick - heard) * self._tick_s <= CONTACT_S
        return "contact" if recent else "patrol"

    def heat_s(self) -> np.ndarray | None:
        """Idleness of every cell of a grid; None for fields of another shape."""
        if not isinstance(self._field, Grid):
            return None
        idle_s = (self._tick - self._metrics.visited_tick) * self._tick_s
        return idle_s.reshape(self._field.columns, self._field.rows).T.astype(np.float32)

    def curves(self) -> dict[str, tuple[float, ...]]:
        """The four instantaneous metrics."""
        now = self._instant
        return {
            "idleness": (now.graph_idleness_s, now.worst_idleness_s),
            "sa_delay": (now.mean_sa_delay_s, now.worst_sa_delay_s),
        }
