"""What the dashboard draws, with Rerun; the same picture live and in recordings.

Fields have their origin at the bottom left and y upwards; Rerun's 2D views have y downwards. Everything that
is drawn is therefore given at (x, -y), in metres, and images begin with their top row. A snapshot is one row
of each entity at its `sim_time`; changes of state and events stand at their own times.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr

from deploy.layout import TIMELINE, blueprint
from deploy.scene import Scene, Snapshot, describe
from deploy.scenes.mission import BASE, GREY, OWN, WHITE, Mission, Sketch, Strokes
from wire.fields import Grid

LINK, FAINT = (120, 230, 255), (70, 74, 88)
DISC = 1.8
"""How many times as large as a robot a site is drawn."""
HATCHING = [(max(0.0, place - 1), min(1.0, place)) for place in np.linspace(0.2, 1.8, 9)]
"""Parallel strokes across a hole of size 1: each from (start, end) to (end, start)."""
Fixed = Callable[[str, Any], None]
"""Logs to an entity what holds for all times."""


class Picture:
    """One Rerun stream that shows one scene. All calls may block: Rerun waits for its sink."""

    def __init__(self, stream: rr.RecordingStream, scene: Scene) -> None:
        self._stream = stream
        self._nodes = scene.nodes
        self._tower = scene.nodes.index(scene.scenario.tower.id)
        self._robots = [row for row in range(len(scene.nodes)) if row != self._tower]
        self._radius_m = scene.mission.radius_m
        self._names_say_trouble = scene.mission.names_say_trouble
        self._shows_traffic = scene.mission.shows_traffic
        self._drawn: dict[str, Strokes | Sketch | None] = {}
        self._log_fixed(scene)

    def show(self, snapshot: Snapshot) -> None:
        """Log a snapshot: its state as one row per entity, and what happened before it at its own times."""
        stream = self._stream
        for change in snapshot.changes:
            stream.set_time(TIMELINE, duration=change.time_s)
            if change.state != BASE or change.time_s > 0:  # no lane for the tower, unless it is struck
                stream.log(f"states/{change.node}", rr.StateChange(state=change.state))
            if change.node == self._nodes[self._tower]:
                stream.log("map/base", rr.Boxes2D.from_fields(colors=[OWN[change.state]]))
        for line in snapshot.lines:
            stream.set_time(TIMELINE, duration=line.time_s)
            stream.log("events", rr.TextLog(line.text, level=line.level))
        stream.set_time(TIMELINE, duration=snapshot.time_s)
        self._log_map(snapshot)
        self._log_drawn(snapshot)
        for name, values in snapshot.curves.items():
            stream.log(f"plots/{name}", rr.Scalars(values))

    def _log_map(self, snapshot: Snapshot) -> None:
        stream, robots = self._stream, self._robots
        points = _view(snapshot.positions_m)
        stream.log(
            "map/robots",
            rr.Points2D.from_fields(
                positions=points[robots], colors=[snapshot.colours[row] for row in robots]
            ),
        )
        below = points[robots] + (0, 0.7 * self._radius_m)
        labels = self._labels(snapshot) if self._names_say_trouble else None
        stream.log("map/names", rr.Points2D.from_fields(positions=below, labels=labels))
        if self._shows_traffic:
            self._log_traffic(snapshot, points)
        if snapshot.heat_s is not None:
            stream.log("map/idleness", rr.DepthImage.from_fields(buffer=snapshot.heat_s[::-1].tobytes()))
        if snapshot.glow:
            stream.log("map/sites", rr.Points2D.from_fields(colors=snapshot.glow))
        if snapshot.paints:
            colours, labels = zip(*snapshot.paints, strict=True)
            stream.log("map/strips", rr.LineStrips2D.from_fields(colors=colours))
            stream.log("map/numbers", rr.Points2D.from_fields(labels=labels))

    def _log_traffic(self, snapshot: Snapshot, points: np.ndarray) -> None:
        stream = self._stream
        if len(snapshot.links):
            stream.log("map/links", rr.LineStrips2D.from_fields(strips=points[snapshot.links]))
        else:
            stream.log("map/links", rr.Clear(recursive=False))
        going = np.flatnonzero(~np.isnan(snapshot.goals_m[:, 0]))
        if len(going):
            stream.log(
                "map/goals",
                rr.Arrows2D.from_fields(
                    vectors=_view(snapshot.goals_m[going]) - points[going], origins=points[going]
                ),
            )
        else:
            stream.log("map/goals", rr.Clear(recursive=False))

    def _log_drawn(self, snapshot: Snapshot) -> None:
        """Strokes and the graph, where they are not what was drawn last."""
        for name, strokes in snapshot.strokes.items():
            if name not in self._drawn or strokes is not self._drawn[name]:
                self._drawn[name] = strokes
                drawn = rr.Clear(recursive=False) if strokes is None else _strips(strokes)
                self._stream.log(f"map/{name}", drawn)
        sketch = snapshot.sketch
        if sketch is not None and sketch is not self._drawn.get("graph"):
            self._drawn["graph"] = sketch
            boxes = rr.GraphNodes(
                sketch.names, positions=sketch.points, labels=sketch.labels, colors=sketch.colours
            )
            self._stream.log("graph", boxes, rr.GraphEdges(sketch.links))

    def _labels(self, snapshot: Snapshot) -> list[str]:
        """Names of robots; those in trouble with what it is."""
        states = [(self._nodes[row], snapshot.states[row]) for row in self._robots]
        return [f"{node} {state}" if state in OWN else node for node, state in states]

    def _log_fixed(self, scene: Scene) -> None:
        """What does not change: styles, the grid, names, the description of the run."""

        def fixed(entity: str, what: Any) -> None:
            self._stream.log(entity, what, static=True)

        # What is fixed hides what is not: names that say trouble come with every snapshot.
        names = None if self._names_say_trouble else [scene.nodes[row] for row in self._robots]
        fixed("map/robots", rr.Points2D.from_fields(radii=[self._radius_m], draw_order=40))
        fixed(
            "map/names",
            rr.Points2D.from_fields(
                radii=[0.01], colors=[WHITE], labels=names, show_labels=True, draw_order=50
            ),
        )
        fixed("map/links", rr.LineStrips2D.from_fields(radii=[-1.5], colors=[LINK], draw_order=20))
        fixed("map/goals", rr.Arrows2D.from_fields(radii=[-1.5], colors=[WHITE], draw_order=30))
        tower = [(scene.scenario.tower.x_m, -scene.scenario.tower.y_m)]
        fixed(
            "map/base",
            rr.Boxes2D(
                centers=tower,
                half_sizes=[(self._radius_m, self._radius_m)],
                radii=[-2.0],
                labels=[f"base {scene.scenario.tower.id}"],
                show_labels=True,
                draw_order=35,
            ),
        )
        if scene.range_m is not None and self._shows_traffic:
            radii_m = [(scene.range_m, scene.range_m)]
            fixed(
                "map/reach",
                rr.Ellipses2D(centers=tower, half_sizes=radii_m, line_radii=[-0.7], colors=[GREY]),
            )
        _log_grid(scene, fixed)
        _log_sites(scene.mission, fixed)
        _log_strips(scene.mission, fixed)
        _log_pens(scene.mission, fixed)
        for plot in scene.plots:
            series, colours = zip(*plot.series, strict=True)
            fixed(f"plots/{plot.name}", rr.SeriesLines(names=series, colors=colours, widths=[1.5]))
        states, colours = zip(*(OWN | scene.mission.states).items(), strict=True)
        for node in scene.nodes:
            fixed(f"states/{node}", rr.StateConfiguration(values=states, labels=states, colors=colours))
        fixed("about", rr.TextDocument(describe(scene), media_type="text/markdown"))


class FileSink(Picture):
    """A recording on disk, in large chunks: with one chunk for each row it would be eight times larger."""

    def __init__(self, path: Path, run: str, scene: Scene, until_s: float) -> None:
        batches = rr.ChunkBatcherConfig(flush_tick=60.0)
        stream = rr.RecordingStream("picket", recording_id=run, batcher_config=batches)
        stream.save(path, default_blueprint=blueprint(scene, until_s, follow=False))
        super().__init__(stream, scene)

    def close(self) -> None:
        """Write the rest and the footer."""
        self._stream.disconnect()


class LiveSink(Picture):
    """A viewer that listens at `url`."""

    def __init__(self, url: str, run: str, scene: Scene) -> None:
        batches = rr.ChunkBatcherConfig(flush_tick=0.1)
        stream = rr.RecordingStream("picket", recording_id=run, batcher_config=batches)
        stream.connect_grpc(url, default_blueprint=blueprint(scene, scene.scenario.duration_s, follow=True))
        super().__init__(stream, scene)

    def close(self) -> None:
        """Send the rest. The viewer keeps what it has."""
        self._stream.flush()
        self._stream.disconnect()


def _log_grid(scene: Scene, fixed: Fixed) -> None:
    """The lines between cells, and where the heat map's pixels lie: one pixel is one cell."""
    field = scene.scenario.field
    if not isinstance(field, Grid):
        return
    left, bottom, right, top = scene.mission.bounds_m
    x_m, y_m = np.linspace(left, right, field.columns + 1), np.linspace(bottom, top, field.rows + 1)
    lines = [((x, -bottom), (x, -top)) for x in x_m] + [((left, -y), (right, -y)) for y in y_m]
    fixed("map/grid", rr.LineStrips2D(lines, radii=[-0.4], colors=[(30, 30, 38)], draw_order=5))
    fixed("map/idleness", rr.Transform3D(translation=(left, -top, 0), scale=field.cell_m))
    pixels = rr.components.ImageFormat(
        width=field.columns, height=field.rows, channel_datatype=rr.ChannelDatatype.F32
    )
    fixed(
        "map/idleness",
        rr.DepthImage.from_fields(
            format=pixels,
            meter=1.0,
            colormap="inferno",
            depth_range=(0, scene.mission.hottest_s),
            magnification_filter="nearest",
            draw_order=0,
        ),
    )
    strokes = [
        (
            (left + (column + start) * field.cell_m, -bottom - (row + end) * field.cell_m),
            (left + (column + end) * field.cell_m, -bottom - (row + start) * field.cell_m),
        )
        for column, row in field.holes
        for start, end in HATCHING
    ]
    if strokes:
        fixed("map/holes", rr.LineStrips2D(strokes, radii=[-0.7], colors=[FAINT], draw_order=6))


def _log_sites(mission: Mission, fixed: Fixed) -> None:
    """Discs with a rim, so that black ones show too; their colours come with every snapshot."""
    if mission.sites:
        positions = _view(np.array(mission.sites))
        rim = rr.Points2D(positions, radii=[1.15 * DISC * mission.radius_m], colors=[GREY], draw_order=7)
        fixed("map/rims", rim)
        disc = rr.Points2D.from_fields(positions=positions, radii=[DISC * mission.radius_m], draw_order=8)
        fixed("map/sites", disc)


def _log_strips(mission: Mission, fixed: Fixed) -> None:
    """Ways, places where robots wait, and strips; the colours of strips come with every snapshot."""
    if mission.ways:
        ways = [_view(np.array(way)) for way in mission.ways]
        fixed("map/ways", rr.LineStrips2D(ways, radii=[-0.7], colors=[FAINT], draw_order=5))
    if mission.places:
        places, sizes_m = _view(np.array(mission.places)), [(mission.radius_m,) * 2] * len(mission.places)
        fixed(
            "map/places",
            rr.Boxes2D(centers=places, half_sizes=sizes_m, radii=[-0.5], colors=[FAINT], draw_order=5),
        )
    if mission.notes:
        points, words = zip(*mission.notes, strict=True)
        fixed(
            "map/notes",
            rr.Points2D(_view(np.array(points)), radii=[0], colors=[GREY], labels=words, show_labels=True),
        )
    if mission.strips:
        strips = [_view(np.array(strip.points_m)) for strip in mission.strips]
        fixed("map/strips", rr.LineStrips2D.from_fields(strips=strips, radii=[-5.0], draw_order=10))
        fixed(
            "map/numbers",
            rr.Points2D.from_fields(
                positions=_view(np.array([strip.label_m for strip in mission.strips])),
                radii=[0],
                colors=[WHITE],
                show_labels=True,
                draw_order=50,
            ),
        )


def _log_pens(mission: Mission, fixed: Fixed) -> None:
    """How strokes look, and those that are always there."""
    for name, pen in mission.pens.items():
        radius = pen.width_m / 2 if pen.width_m else -pen.width_px / 2
        fixed(f"map/{name}", rr.LineStrips2D.from_fields(radii=[radius], draw_order=pen.order))
    for name, strokes in mission.fixed.items():
        fixed(f"map/{name}", _strips(strokes))


def _strips(strokes: Strokes) -> rr.LineStrips2D:
    lines = [_view(line_m) for line_m in strokes.lines_m]
    return rr.LineStrips2D.from_fields(strips=lines, colors=strokes.colours)


def _view(points_m: np.ndarray) -> np.ndarray:
    """Points of the field as the 2D view has them, y downwards: float32."""
    return (points_m * (1, -1)).astype(np.float32)
