"""The mission "clear": what is still contaminated, the lines that clear it, and the graph that robots draw.

What is contaminated is what the referee says; roles, lines and the graph are what robots say of themselves.
"""

import math
from contextlib import suppress
from typing import ClassVar

import numpy as np

from deploy.metrics.clear import BREACH_M2, NOTHING_M2, ClearMetrics
from deploy.scenes.mission import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    VIOLET,
    WHITE,
    YELLOW,
    Mission,
    Pen,
    Plot,
    Sketch,
    Strokes,
)
from deploy.scenes.shapes import area_m2, circles, filled, rings_of, seen_from
from deploy.scenes.sketch import CANVAS, FOOT, sketched
from swarm_agent.graph_copy import Delta
from swarm_agent.sweep.radio import BARRIER
from wire import codec
from wire.clearing import Overheard, Standing
from wire.messages import Facts
from wire.scenario import Scenario, Sensors

HELD = (*BARRIER, "joining")
"""Whom a robot on a line links to; one that joins it is not on it before both of its neighbours do."""
AROUND_M = 0.5
LEVELS = 250
"""How many strokes fill the plan from bottom to top."""
CLEAR_FLOOR, DIRTY_FLOOR, FRONT = (20, 46, 44), (110, 30, 38), (240, 90, 80)
WALL, SIGHT = (165, 170, 185), (64, 128, 116)
MAIN, STANDING = WHITE, ORANGE
TOLD_M2 = 0.5
"""A loss in one tick that is worth a line in the event log."""
LOST = {
    "kill": ("WARN", "with the robot that died"),
    "release": ("INFO", "given up on purpose"),
    "retreat": ("INFO", "by a retreat"),
    "breach": ("ERROR", "a breach"),
}
"""How bad causes of losses are, and their words."""
HAPPENINGS = {
    "split": ("INFO", "splits its line at an obstacle"),
    "search": ("INFO", "lets its line search for an obstacle"),
    "search_failed": ("INFO", "gives up the search: no obstacle"),
    "dissolve": ("INFO", "dissolves its line: nothing is left ahead"),
    "merge": ("INFO", "joins its line to one from the other side"),
    "restart": ("WARN", "lets the team begin again"),
}
CLAIMS = {"done": ("INFO", "claims that all is clear"), "failed": ("WARN", "claims that the team has failed")}


class ClearMission(Mission):
    """A floor, red where intruders may be, and robots in the colours of their roles."""

    states: ClassVar = {
        "leader": YELLOW,
        "centre": GREEN,
        "joining": (150, 235, 160),
        "leaving": (60, 160, 170),
        "reserve": BLUE,
        "anchor": (255, 130, 200),
        "free": GREY,
    }
    pens: ClassVar = {
        "floor": Pen(1),
        "contaminated": Pen(2),
        "front": Pen(3, 1.5),
        "sight": Pen(4, 0.8),
        "walls": Pen(5, 2.5),
        "lines": Pen(20, 3.0),
    }
    title = "Map: red may hide intruders, dark green is clear; white: main line, orange: standing lines"
    names_say_trouble = True
    shows_traffic = False
    canvas = (CANVAS[0], CANVAS[1] + FOOT)
    graph_title = "Surveillance graph: regions v, robots needed"
    legend = (
        "Red floor: an intruder may be there, as the referee knows; the robots do not. Circles: how far they "
        "see. White: the line that moves; orange: lines that stand and hold what is clear, wall to wall. "
        "Robots by role: yellow leaders, green centres, blue reserve, pink the anchor that the others gather "
        "around. Graph, as some robot last told it: a box `v2: 5` is a region that takes 5 robots, green "
        "clear, white swept now, red unknown, orange lost again; boxes between them are necks and the robots "
        "that block them, orange where a line stands, violet where a way round an island closed. Below: "
        "when the tower last heard of the graph that it has."
    )

    def __init__(self, scenario: Scenario) -> None:
        sensors = scenario.sensors or Sensors()
        self._metrics, self._nodes = ClearMetrics(scenario), scenario.node_ids
        self._detect_m, self._breach_m2 = sensors.detect_m, BREACH_M2[sensors.referee]
        self._row_of = {node: row for row, node in enumerate(self._nodes) if node != scenario.tower.id}
        self._robots = tuple(self._row_of.values())
        cos, sin = math.cos(scenario.field.turned_rad), math.sin(scenario.field.turned_rad)
        turn = np.array([[cos, sin], [-sin, cos]])
        rings_m = [np.array([*ring, ring[0]]) @ turn for ring in scenario.field.rings_m]
        self._lay_out(rings_m)
        self.radius_m = scenario.robots.body_m / 2
        self._facts: Facts | None = None
        self._is_clear = False
        self._outline = self._drawn_outline = b""
        self._drawn_area: dict[str, Strokes | None] = {"contaminated": None, "front": None}
        self._tower, self._tick_s = scenario.tower.id, scenario.tick_s
        self._overheard: Overheard | None = None
        self._drawn_graph: tuple[Delta | None, str] = (None, "")
        self._sketch: Sketch | None = None
        self._news: list[tuple[str, str]] = []
        self._claims: set[str] = set()

    def _lay_out(self, rings_m: list[np.ndarray]) -> None:
        low, high = rings_m[0].min(axis=0) - AROUND_M, rings_m[0].max(axis=0) + AROUND_M
        self.bounds_m = (*low.tolist(), *high.tolist())
        self._step_m = float(high[1] - low[1]) / LEVELS
        thick = {
            name: self.pens[name]._replace(width_m=1.25 * self._step_m) for name in ("floor", "contaminated")
        }
        self.pens = self.pens | thick
        self.fixed = {
            "floor": Strokes(filled(rings_m, self._step_m), [CLEAR_FLOOR]),
            "walls": Strokes(rings_m, [WALL]),
        }
        self.plots = _plots(area_m2(rings_m[0]) - sum(map(area_m2, rings_m[1:])))

    def take(self, facts: Facts, links: np.ndarray) -> None:
        """Fold one tick."""
        before = dict(self._metrics.lost_m2)
        self._metrics.feed(facts)
        self._facts, self._news = facts, []
        for node, report in facts.reports:
            if node in self._metrics.standing:
                self._listen(node, self._metrics.standing[node])
            elif node == self._tower:
                self._listen_to_tower(report)
        for cause, lost_m2 in self._metrics.lost_m2.items():
            if lost_m2 - before[cause] > (self._breach_m2 if cause == "breach" else TOLD_M2):
                level, words = LOST[cause]
                self._news.append((level, f"{lost_m2 - before[cause]:.2f} m² contaminated again: {words}"))
        if facts.clearing is not None:
            self._outline = facts.clearing.outline or self._outline
            if not self._is_clear and facts.clearing.contaminated_m2 < NOTHING_M2:
                self._is_clear = True
                self._news.append(("INFO", "the referee sees that all is clear"))

    def _listen(self, node: str, standing: Standing) -> None:
        for event in standing.events:
            level, words = HAPPENINGS.get(event, ("INFO", event))
            self._news.append((level, f"{node} {words}"))
        if standing.claim and standing.claim not in self._claims:
            self._claims.add(standing.claim)
            level, words = CLAIMS[standing.claim]
            self._news.append((level, f"{node} {words}"))

    def _listen_to_tower(self, report: bytes) -> None:
        with suppress(codec.Malformed):  # a tower with other words for observers
            self._overheard = codec.decode(Overheard, report)

    def news(self) -> list[tuple[str, str]]:
        """Decisions and claims of robots, losses, and that all is clear."""
        return self._news

    def doing(self, row: int) -> str:
        """The role that the robot last reported."""
        standing = self._metrics.standing.get(self._nodes[row])
        return standing.role if standing is not None and standing.role in self.states else "free"

    def curves(self) -> dict[str, tuple[float, ...]]:
        """What is contaminated, what was lost for which cause, and where robots are."""
        standing = self._metrics.standing.values()
        main = sum(one.main for one in standing if one.role in BARRIER)
        on_lines = sum(one.role in BARRIER for one in standing)
        gone = sum(self._facts.modes[row] > 0 for row in self._robots)
        beside = len(self._robots) - on_lines - gone
        return {
            "contaminated": (self._metrics.instant.contaminated_m2,),
            "lost": tuple(self._metrics.lost_m2.values()),
            "lines": (main, on_lines - main, beside, gone),
        }

    def strokes(self) -> dict[str, Strokes | None]:
        """The contaminated area and its front, how far robots see, and lines."""
        places_m = np.frombuffer(self._facts.poses).reshape(-1, 3)
        seeing = [row for row in self._robots if not self._facts.modes[row]]
        return self._area() | {
            "sight": Strokes(circles(places_m[seeing, :2], self._detect_m), [SIGHT]) if seeing else None,
            "lines": self._lines(places_m),
        }

    def _area(self) -> dict[str, Strokes | None]:
        """Drawn anew only when the referee has drawn it anew."""
        if self._outline is not self._drawn_outline:
            self._drawn_outline = self._outline
            rings_m = rings_of(self._outline)
            self._drawn_area = {
                "contaminated": Strokes(filled(rings_m, self._step_m), [DIRTY_FLOOR]) if rings_m else None,
                "front": Strokes(rings_m, [FRONT]) if rings_m else None,
            }
        return self._drawn_area

    def _lines(self, places_m: np.ndarray) -> Strokes | None:
        """Links of robots to their neighbours, and of leaders to their walls."""
        standing, links, walls = self._metrics.standing, {}, []
        for row in self._robots:
            one = standing.get(self._nodes[row])
            if one is None or one.role not in BARRIER:
                continue
            colour = MAIN if one.main else STANDING
            for beside in (one.left, one.right):
                other = self._row_of.get(beside)
                if other is not None and beside in standing and standing[beside].role in HELD:
                    links[frozenset((row, other))] = colour
            if 0 < math.hypot(*one.wall_m) < 2 * self._detect_m:
                walls.append((np.array([places_m[row, :2], seen_from(places_m[row], one.wall_m)]), colour))
        drawn = [(places_m[sorted(ends), :2], colour) for ends, colour in links.items()] + walls
        return Strokes(*zip(*drawn, strict=True)) if drawn else None

    def sketch(self) -> Sketch | None:
        """The newest graph that any robot told, and how old the one is that the tower heard."""
        graph, words = self._metrics.graph, self._of_tower()
        if graph is not None and (graph is not self._drawn_graph[0] or words != self._drawn_graph[1]):
            self._drawn_graph = graph, words
            self._sketch = sketched(graph, words)
        return self._sketch

    def _of_tower(self) -> str:
        if self._overheard is None:
            return ""
        heard_tick = self._overheard.heard_tick
        age_s = (self._facts.tick - heard_tick) * self._tick_s
        return f"tower: graph of tick {heard_tick}, {age_s:.1f} s old"


def _plots(all_m2: float) -> tuple[Plot, ...]:
    causes = (("kill", RED), ("release", YELLOW), ("retreat", BLUE), ("breach", VIOLET))
    robots = (("main line", WHITE), ("standing lines", ORANGE), ("beside", BLUE), ("out of action", RED))
    return (
        Plot(
            "contaminated",
            f"Contaminated area in m², of {all_m2:.0f}",
            (("contaminated", RED),),
            (0.0, all_m2),
        ),
        Plot("lost", "Contaminated again in m², in all, by cause", causes),
        Plot("lines", "Robots on lines and beside them", robots),
    )
