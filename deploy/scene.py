"""What a picture of a run shows, folded from facts and events. Pure: no viewer, no clock.

Positions are metres in the field's frame: origin at the bottom left, y upwards. Times are seconds of
simulated time. What only one mission has (its curves, heat map or strips, words for what robots do) is in
deploy/scenes.
"""

from typing import NamedTuple

import numpy as np

from deploy.scenes.area import AreaMission
from deploy.scenes.clear import ClearMission
from deploy.scenes.line import LineMission
from deploy.scenes.mission import BASE, DEAD, FLAT, FROZEN, OWN, Colour, Mission, Paint, Plot, Sketch, Strokes
from wire.messages import Event, Facts
from wire.scenario import Range, Scenario


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

    `positions_m`: (nodes, 2). `colours`: of all nodes. `links`: rows of nodes, (links, 2), each pair once.
    `goals_m`: (nodes, 2), NaN for none. `heat_s`: (rows, columns), row 0 at the bottom, or None. `glow`: of
    the mission's sites. `paints`: of its strips. `strokes`: by name, None for none. `sketch`: of its graph.
    `curves`: values by name of the plot.
    """

    time_s: float
    positions_m: np.ndarray
    states: tuple[str, ...]
    colours: tuple[Colour, ...]
    links: np.ndarray
    goals_m: np.ndarray
    heat_s: np.ndarray | None
    glow: tuple[Colour, ...]
    paints: tuple[Paint, ...]
    strokes: dict[str, Strokes | None]
    sketch: Sketch | None
    curves: dict[str, tuple[float, ...]]
    lines: tuple[Line, ...]
    changes: tuple[Change, ...]

    def after(self, older: "Snapshot") -> "Snapshot":
        """This snapshot in place of itself and an older one: nothing that happened is lost."""
        return self._replace(lines=older.lines + self.lines, changes=older.changes + self.changes)


MISSIONS: dict[str, type[Mission]] = {"area": AreaMission, "line": LineMission, "clear": ClearMission}
RADIO = Plot("radio", "Radio: frames delivered per tick", (("delivered", (110, 200, 220)),))


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
    def plots(self) -> tuple[Plot, ...]:
        """All diagrams, the mission's first."""
        return (*self.mission.plots, RADIO)

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
        self._lines += [Line(self.time_s, level, text) for level, text in self.mission.news()]
        self._delivered, self._ticks = self._delivered + len(self._links), self._ticks + 1
        for row, mode in enumerate(facts.modes):
            state = (FROZEN, DEAD, FLAT)[mode - 1] if mode else self._doing(row)
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
            tuple(map(self._colour, range(len(self.nodes)))),
            np.unique(np.sort(self._links, axis=1), axis=0),
            goals_m,
            self.mission.heat_s(),
            self.mission.glow(),
            self.mission.paints(),
            self.mission.strokes(),
            self.mission.sketch(),
            curves,
            tuple(self._lines),
            tuple(self._changes),
        )
        self._lines, self._changes = [], []
        self._delivered = self._ticks = 0
        return snapshot

    def _doing(self, row: int) -> str:
        return BASE if row == self._tower else self.mission.doing(row)

    def _colour(self, row: int) -> Colour:
        return OWN.get(self._states[row]) or self.mission.colour(row)


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
    traffic = "Links: frames delivered in the tick shown. Arrows: to the goal. "
    legend = f"{traffic if scene.mission.shows_traffic else ''}Red: dead; pale: frozen."
    return f"| run | |\n|---|---|\n{table}\n\n{scene.mission.legend}\n\n{legend}"
