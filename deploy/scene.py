"""What a picture of a run shows, folded from facts and events. Pure: no viewer, no clock.

Positions are metres in the field's frame: origin at the bottom left, y upwards. Times are seconds of
simulated time. What only one mission has (its curves, heat map, words for what robots do) is in one class.
"""

from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from deploy.metrics.area import AreaMetrics
from wire.fields import Grid
from wire.messages import Event, Facts
from wire.scenario import Range, Scenario

BASE, DEAD, FROZEN = "base station", "dead", "frozen"
CONTACT_S = 30.0
ORANGE, VIOLET = (255, 170, 60), (214, 110, 255)
GREEN, BLUE, ICE, RED = (64, 214, 150), (80, 170, 255), (190, 235, 255), (255, 70, 70)


class Plot(NamedTuple):
    """One diagram over time; `series` are names and colours of its curves."""

    name: str
    title: str
    series: tuple[tuple[str, tuple[int, int, int]], ...]


class Line(NamedTuple):
    """One line of the event log; `level` is INFO, WARN or ERROR."""

    time_s: float
    level: str
    text: str


class Change(NamedTuple):
    """From `time_s` on, `node` is in `state`."""

    time_s: float
    node: str
    state: str


class Snapshot(NamedTuple):
    """A scene at one time, and what happened since the snapshot before it.

    `positions_m`: (nodes, 2). `links`: rows of nodes, (links, 2), each pair once. `goals_m`: (nodes, 2), NaN
    for none. `heat_s`: (rows, columns), row 0 at the bottom, or None. `curves`: values by name of the plot.
    """

    time_s: float
    positions_m: np.ndarray
    states: tuple[str, ...]
    links: np.ndarray
    goals_m: np.ndarray
    heat_s: np.ndarray | None
    curves: dict[str, tuple[float, ...]]
    lines: tuple[Line, ...]
    changes: tuple[Change, ...]

    def after(self, older: "Snapshot") -> "Snapshot":
        """This snapshot in place of itself and an older one: nothing that happened is lost."""
        return self._replace(lines=older.lines + self.lines, changes=older.changes + self.changes)


class Mission(Protocol):
    """What a mission adds to the picture of bodies and radio."""

    plots: tuple[Plot, ...]
    states: dict[str, tuple[int, int, int]]
    bounds_m: tuple[float, float, float, float]
    """Left, bottom, right, top of the field."""
    hottest_s: float
    """The value at the end of the heat map's colour scale."""
    legend: str
    """One sentence about what is drawn of this mission."""

    def take(self, facts: Facts, links: np.ndarray) -> None:
        """Fold one tick."""

    def doing(self, row: int) -> str:
        """What the living robot in `row` does, one of `states`."""

    def heat_s(self) -> np.ndarray | None:
        """The heat map as in Snapshot."""

    def curves(self) -> dict[str, tuple[float, ...]]:
        """Present values of all series, by plot."""


class AreaMission:
    """Idleness of cells, what the base station knows of it, and who is in contact with the base station."""

    plots = (
        Plot("idleness", "Idleness in s: true, by cell", (("mean", GREEN), ("worst", ORANGE))),
        Plot("sa_delay", "SA delay in s: age of what the base knows", (("mean", BLUE), ("worst", VIOLET))),
    )
    states: ClassVar = {"patrol": BLUE, "contact": GREEN}

    def __init__(self, scenario: Scenario) -> None:
        self._metrics = AreaMetrics(scenario)
        self._field, self._tick_s = scenario.field, scenario.tick_s
        self._sites_m = np.array(scenario.field.sites_m())
        self._row_of = {node: row for row, node in enumerate(scenario.node_ids)}
        self._tower = self._row_of[scenario.tower.id]
        self._instant = None
        self._contact_tick: dict[int, int] = {}
        self._tick = 0
        margin_m = scenario.field.cell_m / 2
        low, high = self._sites_m.min(axis=0) - margin_m, self._sites_m.max(axis=0) + margin_m
        self.bounds_m = (*low.tolist(), *high.tolist())
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


MISSIONS: dict[str, type[Mission]] = {"area": AreaMission}


class Scene:
    """The fold. Feed it every fact and event; ask for snapshots as often as there is somebody to look."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.nodes = scenario.node_ids
        self.mission = MISSIONS[scenario.mission](scenario)
        self.time_s = -1.0
        self._facts: Facts | None = None
        self._links = np.zeros((0, 2), int)
        self._states = [""] * len(self.nodes)
        self._tower = self.nodes.index(scenario.tower.id)
        self._lines: list[Line] = []
        self._changes: list[Change] = []
        self._delivered = self._ticks = 0

    @property
    def range_m(self) -> float | None:
        """The radio's range, if a rule limits it."""
        ranges = [rule.range_m for rule in self.scenario.radio.rules if isinstance(rule, Range)]
        return min(ranges, default=None)

    def take(self, facts: Facts) -> None:
        """Fold one tick. A tick that was already seen (a world that replays its journal) is ignored."""
        if self._facts is not None and facts.tick <= self._facts.tick:
            return
        self._facts, self.time_s = facts, facts.tick * self.scenario.tick_s
        self._links = np.frombuffer(facts.links, "<u2").reshape(-1, 2)
        self.mission.take(facts, self._links)
        self._delivered, self._ticks = self._delivered + len(self._links), self._ticks + 1
        for row, mode in enumerate(facts.modes):
            state = (FROZEN, DEAD)[mode - 1] if mode else self._doing(row)
            if state != self._states[row]:
                self._states[row] = state
                self._changes.append(Change(self.time_s, self.nodes[row], state))

    def note(self, event: Event) -> None:
        """Take in an event."""
        text = f"end of the run: {event.text}" if event.kind == "end" else event.text
        self._lines.append(Line(event.tick * self.scenario.tick_s, _level(event), text))

    def warn(self, text: str) -> None:
        """Say something of our own in the event log."""
        self._lines.append(Line(max(0.0, self.time_s), "WARN", text))

    def snapshot(self) -> Snapshot:
        """The scene as it is now. There must have been facts."""
        facts = self._facts
        assert facts is not None, "a snapshot of nothing"
        goals_m = np.frombuffer(facts.goals, "<f8").reshape(-1, 2).copy()
        goals_m[np.frombuffer(facts.modes, "u1") > 0] = np.nan
        curves = self.mission.curves() | {"radio": (self._delivered / max(1, self._ticks),)}
        snapshot = Snapshot(
            self.time_s,
            np.frombuffer(facts.poses, "<f8").reshape(-1, 3)[:, :2],
            tuple(self._states),
            np.unique(np.sort(self._links, axis=1), axis=0),
            goals_m,
            self.mission.heat_s(),
            curves,
            tuple(self._lines),
            tuple(self._changes),
        )
        self._lines, self._changes = [], []
        self._delivered = self._ticks = 0
        return snapshot

    def _doing(self, row: int) -> str:
        return BASE if row == self._tower else self.mission.doing(row)


def _level(event: Event) -> str:
    """How bad an event is. A kill somebody ordered warns; what nobody ordered is an error."""
    if event.kind in ("death", "watchdog", "stranger") or event.data.get("confirmed") is False:
        return "ERROR"
    harmless = event.kind == "end" or event.data.get("verb") in ("restart", "thaw")
    return "INFO" if harmless else "WARN"


def describe(scene: Scene) -> str:
    """What the run is and how to read its picture, as Markdown."""
    given = scene.scenario
    rows = {
        "mission": given.mission,
        "robots": f"{len(given.robot_ids)}, behaviour `{given.robots.behaviour}`",
        "base station": f"{given.tower.id} at ({given.tower.x_m:g}, {given.tower.y_m:g}) m",
        "radio range": "unlimited" if scene.range_m is None else f"{scene.range_m:g} m",
        "duration": f"{given.duration_s:g} s in ticks of {given.tick_s:g} s",
        "seed": str(given.seed),
    }
    table = "\n".join(f"| {name} | {value} |" for name, value in rows.items())
    legend = "Links: frames delivered in the tick shown. Arrows: to the goal. Red: dead; pale: frozen."
    return f"| run | |\n|---|---|\n{table}\n\n{scene.mission.legend}\n\n{legend}"
