"""The mission "area": idleness of cells, what the base station knows of it, and who is in contact with it."""

from typing import ClassVar

import msgspec
import numpy as np

from deploy.metrics.area import AreaMetrics
from deploy.scenes.mission import BLUE, GREEN, ORANGE, VIOLET, Colour, Mission, Plot, Point, hot
from wire.fields import Graph, Grid
from wire.messages import Facts
from wire.scenario import Scenario

CONTACT_S = 30.0


class AreaMission(Mission):
    """A heat map of idleness, and robots that are in contact with the base station or not."""

    plots = (
        Plot("idleness", "Idleness in s: true, by site", (("mean", GREEN), ("worst", ORANGE))),
        Plot("sa_delay", "SA delay in s: age of what the base knows", (("mean", BLUE), ("worst", VIOLET))),
    )
    states: ClassVar = {"patrol": BLUE, "contact": GREEN}

    def __init__(self, scenario: Scenario) -> None:
        self._metrics = AreaMetrics(scenario)
        self._field, self._tick_s = scenario.field, scenario.tick_s
        self._tower = scenario.node_ids.index(scenario.tower.id)
        self._instant = None
        self._contact_tick: dict[int, int] = {}
        self._tick = 0
        step_m = _step_m(scenario.field)
        places_m = np.array(_everywhere_m(scenario.field))
        low, high = places_m.min(axis=0) - step_m / 2, places_m.max(axis=0) + step_m / 2
        self.bounds_m = (*low.tolist(), *high.tolist())
        self.radius_m = float((high - low).max()) / 85
        travel_s = len(scenario.field.sites_m()) * step_m / scenario.robots.max_speed_m_s
        self.hottest_s = 3 * travel_s / len(scenario.robot_ids)
        if isinstance(scenario.field, Graph):
            self.sites, self.ways = _drawn(scenario.field)
        shown = "Discs" if self.sites else "Heat map"
        self.legend = (
            f"{shown}: time since the last visit, black 0 s, yellow {self.hottest_s:.0f} s and more. "
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
        """Idleness of every cell of a grid, 0 for holes; None for fields of another shape."""
        if not isinstance(self._field, Grid):
            return None
        heat_s = np.zeros((self._field.rows, self._field.columns), dtype=np.float32)
        columns, rows = np.array(self._field.cells).T
        heat_s[rows, columns] = self._idle_s()
        return heat_s

    def glow(self) -> tuple[Colour, ...]:
        """Idleness of every node of a graph, on the scale of the heat map."""
        return tuple(hot(idle_s / self.hottest_s) for idle_s in self._idle_s()) if self.sites else ()

    def _idle_s(self) -> np.ndarray:
        return (self._tick - self._metrics.visited_tick) * self._tick_s

    def curves(self) -> dict[str, tuple[float, ...]]:
        """The four instantaneous metrics."""
        now = self._instant
        return {
            "idleness": (now.graph_idleness_s, now.worst_idleness_s),
            "sa_delay": (now.mean_sa_delay_s, now.worst_sa_delay_s),
        }


def _everywhere_m(field: Grid | Graph) -> list[Point]:
    """All sites, and all holes."""
    return (msgspec.structs.replace(field, holes=()) if isinstance(field, Grid) else field).sites_m()


def _step_m(field: Grid | Graph) -> float:
    """How far it is from a site to the next, about."""
    if isinstance(field, Grid):
        return field.cell_m
    straight_m = [field.straight_m(edge) for edge in field.edges]
    return sum(straight_m) / len(straight_m) if straight_m else 1.0


def _drawn(graph: Graph) -> tuple[tuple[Point, ...], tuple[tuple[Point, ...], ...]]:
    """The nodes, and the edges as lines."""
    nodes_m = graph.nodes_m
    return nodes_m, tuple((nodes_m[start], nodes_m[end]) for start, end, _ in graph.edges)
