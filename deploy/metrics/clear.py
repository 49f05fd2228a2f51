"""How a floor plan was cleared, folded from facts: what the referee saw, and what robots say of themselves.

Source: specs of mission clear, section 4: contaminated is where an intruder of any speed may be; a plan is
clear when less than 1e-7 m2 is. What becomes contaminated again is counted by its cause. In a tick in which a
process was killed or stopped, and as long as a living robot reports a dead one as its neighbour, all of it is
`kill` if a barrier opened, that is: if more was lost than what was in sight until then; else, in one in which
some living robot last reported that it releases, all is `release`; else what some robot had in sight until
then, or what lay ahead of lines and was held by none, is `retreat`, and the rest is `breach`: more than
rounding of it in a tick is one of `breaches`.

A robot is on a line when it has a neighbour there. Events are counted as robots report them, the graph is the
newest that any of them reported. The exact referee decides, where there is one.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from swarm_agent.graph_copy import Delta
from wire import codec
from wire.clearing import Clearing, Standing
from wire.messages import Facts
from wire.scenario import Scenario, Sensors
from world_server.nodes import DEAD

NOTHING_M2 = 1e-7
BREACH_M2 = {"exact": 1e-6, "both": 1e-6, "raster": 2 * 0.05**2 + 1e-9}
"""More than this in a tick is a breach, not rounding: of polygons, or of two cells of a raster."""
EVENTS = {
    "splits": "split",
    "searches": "search",
    "searches_failed": "search_failed",
    "dissolved": "dissolve",
}
"""Names of metrics, and the events that they count."""
CAUSES = ("kill", "release", "retreat", "breach")


class Instant(NamedTuple):
    """A row of `curve`; `raster_m2` is not a number unless both referees judge."""

    time_s: float
    contaminated_m2: float
    raster_m2: float
    lost_m2: float
    on_lines: int


class ClearMetrics:
    """The fold. Feed it facts in order; ask for the metrics at any time."""

    def __init__(self, scenario: Scenario) -> None:
        self._tick_s, self._nodes = scenario.tick_s, scenario.node_ids
        self._robots = scenario.robot_ids
        self._breach_m2 = BREACH_M2[(scenario.sensors or Sensors()).referee]
        self._standing: dict[str, Standing] = {}
        self._dead: set[str] = set()
        self._claim, self._clear_tick, self._contaminated_m2 = "none", None, None
        self._lost_m2 = dict.fromkeys(CAUSES, 0.0)
        self._breaches, self._on_lines_peak = 0, 0
        self._events = dict.fromkeys(EVENTS, 0)
        self._graph: Delta | None = None
        self._curve: list[Instant] = []

    def feed(self, facts: Facts) -> None:
        """Take in one tick. In ticks between this and the last one nothing happened."""
        for node, report in facts.reports:
            self._listen(node, report)
        for node, mode in zip(self._nodes, facts.modes, strict=False):
            if mode == DEAD:
                self._standing.pop(node, None)
                self._dead.add(node)
            else:
                self._dead.discard(node)
        on_lines = sum(map(self.is_on_line, self._robots))
        self._on_lines_peak = max(self._on_lines_peak, on_lines)
        if (clearing := facts.clearing) is not None:
            self._judge(facts, clearing)
            raster_m2 = np.nan if clearing.raster_m2 is None else clearing.raster_m2
            time_s = facts.tick * self._tick_s
            self._curve.append(
                Instant(time_s, clearing.contaminated_m2, raster_m2, clearing.lost_m2, on_lines)
            )

    def summary(self) -> dict[str, Any]:
        """The run's metrics; None where there was nothing to measure."""
        clear_s = None if self._clear_tick is None else self._clear_tick * self._tick_s
        return {
            "cleared": self._contaminated_m2 is not None and self._contaminated_m2 < NOTHING_M2,
            "claim": self._claim,
            "clear_time_s": clear_s,
            "contaminated_area_m2": self._contaminated_m2,
            "recontaminated_m2": dict(self._lost_m2),
            "breaches": self._breaches,
            "robots_deployed": len(self._robots),
            "robots_on_lines_peak": self._on_lines_peak,
            **self._events,
            "graph": self._graph_sizes(),
        }

    @property
    def instant(self) -> Instant:
        """The state after the last tick."""
        return self._curve[-1]

    @property
    def standing(self) -> Mapping[str, Standing]:
        """What living robots last said of themselves."""
        return self._standing

    @property
    def graph(self) -> Delta | None:
        """The newest surveillance graph that any of them told."""
        return self._graph

    @property
    def lost_m2(self) -> Mapping[str, float]:
        """What became contaminated again, by its cause."""
        return self._lost_m2

    def is_on_line(self, node: str) -> bool:
        """Has a living robot a neighbour on a line, by its own last report?"""
        standing = self._standing.get(node)
        return standing is not None and bool(standing.left or standing.right)

    def tables(self) -> dict[str, np.ndarray]:
        """What `clear.npz` holds: `curve`, an Instant for each tick in which anything happened, as a row."""
        return {"curve": np.array(self._curve).reshape(-1, len(Instant._fields))}

    def _listen(self, node: str, report: bytes) -> None:
        if node not in self._robots:
            return
        try:
            standing = self._standing[node] = codec.decode(Standing, report)
        except codec.Malformed:  # a behaviour with other words for observers
            return
        if standing.claim and self._claim == "none":
            self._claim = standing.claim
        for name, event in EVENTS.items():
            self._events[name] += standing.events.count(event)
        if standing.graph:
            self._see_graph(standing.graph)

    def _see_graph(self, graph: bytes) -> None:
        try:
            seen = codec.decode(Delta, graph)
        except codec.Malformed:
            return
        if self._graph is None or seen.version >= self._graph.version:
            self._graph = seen

    def _is_missed(self) -> bool:
        """Does any robot take a dead one for its neighbour still? It cannot know better so soon."""
        return any({one.left, one.right} & self._dead for one in self._standing.values())

    def _judge(self, facts: Facts, clearing: Clearing) -> None:
        self._contaminated_m2 = clearing.contaminated_m2
        if self._clear_tick is None and clearing.contaminated_m2 < NOTHING_M2:
            self._clear_tick = facts.tick
        if clearing.lost_m2 <= NOTHING_M2:
            return
        opened = clearing.lost_m2 - clearing.given_up_m2 > self._breach_m2
        stopped = any(fault.verb in ("kill", "freeze") for fault in facts.faults)
        if opened and (stopped or self._is_missed()):
            self._lost_m2["kill"] += clearing.lost_m2
        elif any(one.releasing for one in self._standing.values()):
            self._lost_m2["release"] += clearing.lost_m2
        else:
            breach_m2 = max(0.0, clearing.lost_m2 - clearing.given_up_m2 - clearing.ahead_m2)
            self._lost_m2["retreat"] += clearing.lost_m2 - breach_m2
            self._lost_m2["breach"] += breach_m2
            self._breaches += breach_m2 > self._breach_m2

    def _graph_sizes(self) -> dict[str, int]:
        vertices = () if self._graph is None else self._graph.vertices
        edges = () if self._graph is None else self._graph.edges
        cycles = sum(edge.kind == "cycle" for edge in edges)
        return {"vertices": len(vertices), "edges": len(edges), "cycle_edges": cycles}
