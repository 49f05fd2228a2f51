"""The mission "line": how long ago each segment was covered, what robots do, and their batteries.

A segment is as old as the least recently visited of its three sites; all count as visited at tick 0. A robot
that has said nothing yet is in the queue.
"""

from collections.abc import Sequence
from itertools import cycle
from typing import ClassVar

import numpy as np

from deploy.scenes.mission import BLUE, GREEN, GREY, ORANGE, RED, YELLOW, Colour, Mission, Paint, Plot, Strip
from swarm_agent.line_radio import Report
from wire import codec
from wire.line import QUEUE_DEPTH, Line
from wire.messages import Facts
from wire.scenario import BatterySection, Scenario

FRESH_LAPS, STALE_LAPS = 1.0, 4.0
CROWD = 12
"""On a line with more segments numbers stand further off, and with ages only where these are high."""
ASIDE = 1 / 30
"""How far off they stand then, as a share of the picture's width: so that robots' names fit between."""
SMALLEST = 1 / 120
"""The least radius of a robot as a share of the picture's width: below it nobody would see one."""
TURNS_RAD = 2 * np.pi
"""A robot that drives to and fro turns round twice in a lap."""
PALETTE = (
    (80, 170, 255),
    (255, 170, 60),
    (64, 214, 150),
    (255, 105, 130),
    (190, 140, 255),
    (245, 215, 70),
    (90, 220, 230),
    (235, 130, 220),
    (165, 205, 90),
    (200, 160, 130),
)


class LineMission(Mission):
    """A line whose segments are coloured by their age, and robots coloured by their charge."""

    states: ClassVar = {"patrol": GREEN, "out": BLUE, "home": ORANGE, "queue": GREY}
    title = "Map: segments (number, time since covered) and robots (charge), from green to red"
    names_say_trouble = True

    def __init__(self, scenario: Scenario) -> None:
        self._line = Line(scenario.field, (scenario.tower.x_m, scenario.tower.y_m))
        self._tick_s, self._battery = scenario.tick_s, scenario.battery
        nodes, tower = scenario.node_ids, scenario.tower.id
        self._row_of = {node: row for row, node in enumerate(nodes) if node != tower}
        self._doing = ["queue"] * len(nodes)
        self._charge_v, self._modes = np.array([]), bytes(len(nodes))
        self._tick, self._visited_tick = 0, np.zeros((len(self._line.segments), 3), np.int64)
        self._lap_s = _lap_s(self._line, scenario)
        self._lay_out(scenario)
        self.plots = _plots(tuple(self._row_of), scenario.battery)
        self.legend = _legend(self._lap_s, scenario.battery)

    def take(self, facts: Facts, links: np.ndarray) -> None:
        """Fold one tick."""
        self._tick, self._modes = facts.tick, facts.modes
        self._charge_v = np.frombuffer(facts.battery_v, "<f4")
        for _, site in facts.visits:
            self._visited_tick[site // 3, site % 3] = facts.tick
        for node, report in facts.reports:
            if node in self._row_of and (said := _report(report)):
                self._doing[self._row_of[node]] = said.state

    def doing(self, row: int) -> str:
        """What the robot last said that it does."""
        return self._doing[row]

    def colour(self, row: int) -> Colour:
        """By charge, from red (empty) over yellow to green (full); by state where there are no batteries."""
        if self._battery is None or not len(self._charge_v):
            return super().colour(row)
        empty_v, full_v = self._battery.empty_v, self._battery.full_v
        return _blend(float(self._charge_v[row]), (empty_v, (empty_v + full_v) / 2, full_v))

    def paints(self) -> tuple[Paint, ...]:
        """Segments by age: green within a lap, red after STALE_LAPS."""
        stops = np.array((STALE_LAPS, (FRESH_LAPS + STALE_LAPS) / 2, FRESH_LAPS)) * self._lap_s
        least_s = stops[1] if self._crowded else 0.0
        return tuple(
            Paint(_blend(-age_s, -stops), f"{number}: {age_s:.0f} s" if age_s >= least_s else f"{number}")
            for number, age_s in enumerate(self._ages_s().tolist(), start=1)
        )

    def curves(self) -> dict[str, tuple[float, ...]]:
        """Ages, where robots are, and charges."""
        ages_s = self._ages_s()
        living = [self._doing[row] for row in self._row_of.values() if not self._modes[row]]
        patrolling, queueing = living.count("patrol"), living.count("queue")
        under_way = len(living) - patrolling - queueing
        struck = len(self._row_of) - len(living)
        curves = {
            "coverage": (float(ages_s.mean()), float(ages_s.max())),
            "robots": (queueing, under_way, struck),
        }
        if self._battery is not None and len(self._charge_v):
            curves["battery"] = tuple(self._charge_v[list(self._row_of.values())].tolist())
        return curves

    def _ages_s(self) -> np.ndarray:
        return (self._tick - self._visited_tick.min(axis=1)) * self._tick_s

    def _lay_out(self, scenario: Scenario) -> None:
        """Where everything stands, and bounds around it: the queue beside the line too."""
        line, lane_m = self._line, self._line.lane_m
        self._crowded = len(line.segments) > CROWD
        width_m = float(np.ptp([x_m for x_m, _ in scenario.field.points_m]))
        off_m = max(lane_m, ASIDE * width_m) if self._crowded else lane_m
        self.strips = tuple(
            Strip(
                (line.point(one.left_m), *line.along(one.left_m, one.right_m)), line.point(one.mid_m, -off_m)
            )
            for one in line.segments
        )
        self.ways = tuple(
            (line.point(0.0, aside_m), *line.along(0.0, line.length_m, aside_m)) for aside_m in (0.0, lane_m)
        )
        self.places = tuple(line.slot(row) for row in range(len(scenario.robot_ids)))
        deep = min(len(scenario.robot_ids), QUEUE_DEPTH)
        above_m = line.point(line.tower_arc_m, 2 * lane_m + deep * scenario.field.slot_m)
        self.notes = ((above_m, "queue"), (line.point(0.0, 2 * lane_m), "passing lane"))
        tower_m = (scenario.tower.x_m, scenario.tower.y_m)
        labels_m = (one.label_m for one in self.strips)
        seen_m = np.array([*self.ways[0], *self.ways[1], *self.places, *labels_m, tower_m, above_m])
        low, high = seen_m.min(axis=0), seen_m.max(axis=0)
        self.radius_m = max(scenario.robots.body_m / 2, float(high[0] - low[0]) * SMALLEST)
        low, high = low - 2 * self.radius_m, high + 2 * self.radius_m
        self.bounds_m = (*low.tolist(), *high.tolist())


def _lap_s(line: Line, scenario: Scenario) -> float:
    """How long a lap on the longest segment takes: to and fro, with a turn at each end."""
    way_m = 2 * max(one.length_m for one in line.segments)
    return float(way_m / scenario.robots.max_speed_m_s + TURNS_RAD / scenario.robots.max_turn_rad_s)


def _plots(robots: tuple[str, ...], battery: BatterySection | None) -> tuple[Plot, ...]:
    ages = Plot("coverage", "Coverage age in s, by segment", (("mean", GREEN), ("worst", ORANGE)))
    counted = (("in the queue", GREY), ("under way", BLUE), ("out of action", RED))
    numbers = Plot("robots", "Robots not on patrol", counted)
    if battery is None:
        return (ages, numbers)
    series = tuple(zip(robots, cycle(PALETTE), strict=False))
    margin_v = (battery.full_v - battery.empty_v) / 10
    span = (battery.empty_v - margin_v, battery.full_v + margin_v)
    title = f"Battery in V: full {battery.full_v:g}, flat {battery.empty_v:g}"
    return (Plot("battery", title, series, span), ages, numbers)


def _legend(lap_s: float, battery: BatterySection | None) -> str:
    charged = (
        "Robots by what they do, as their lanes are"
        if battery is None
        else f"Robots: green {battery.full_v:g} V, red {battery.empty_v:g} V"
    )
    return (
        f"Segments: number and coverage age, the time since the least recently visited of both ends and the "
        f"middle. Green within a lap ({FRESH_LAPS * lap_s:.0f} s), red after {STALE_LAPS:g} laps "
        f"({STALE_LAPS * lap_s:.0f} s). Grey: gaps, the passing lane beside the line, and the places of the "
        f"queue at the base station. {charged}; violet: flat."
    )


def _report(report: bytes) -> Report | None:
    """None for a robot with other words for observers."""
    try:
        return codec.decode(Report, report)
    except codec.Malformed:
        return None


def _blend(value: float, stops: Sequence[float]) -> Colour:
    """From red over yellow to green, as `value` comes from the first stop to the last."""
    red, green, blue = (
        round(float(np.interp(value, stops, one))) for one in zip(RED, YELLOW, GREEN, strict=True)
    )
    return red, green, blue
