"""What the dashboard draws: the only user of Rerun; the same picture live and in recordings.

Fields have their origin at the bottom left and y upwards; Rerun's 2D views have y downwards. Everything that
is drawn is therefore given at (x, -y), in metres, and images begin with their top row. A snapshot is one row
of each entity at its `sim_time`; changes of state and events stand at their own times.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from deploy.scene import BASE, DEAD, FROZEN, ICE, RED, Plot, Scene, Snapshot, describe
from wire.fields import Grid
from wire.scenario import Scenario

TIMELINE = "sim_time"
REPLAY_S = 120.0
WHITE, GREY, LINK = (240, 240, 245), (120, 124, 140), (120, 230, 255)
RADIO = Plot("radio", "Radio: frames delivered per tick", (("delivered", (110, 200, 220)),))


class Picture:
    """One Rerun stream that shows one scene. All calls may block: Rerun waits for its sink."""

    def __init__(self, stream: rr.RecordingStream, scene: Scene) -> None:
        self._stream = stream
        self._nodes = scene.nodes
        self._tower = scene.nodes.index(scene.scenario.tower.id)
        self._robots = [row for row in range(len(scene.nodes)) if row != self._tower]
        self._bounds_m = scene.mission.bounds_m
        self._radius_m = (self._bounds_m[2] - self._bounds_m[0]) / 85
        self._colours = {BASE: WHITE, FROZEN: ICE, DEAD: RED} | scene.mission.states
        self._hottest_s = scene.mission.hottest_s
        self._log_fixed(scene)

    def show(self, snapshot: Snapshot) -> None:
        """Log a snapshot: its state as one row per entity, and what happened before it at its own times."""
        stream = self._stream
        for change in snapshot.changes:
            stream.set_time(TIMELINE, duration=change.time_s)
            if change.state != BASE or change.time_s > 0:  # no lane for the tower, unless it is struck
                stream.log(f"states/{change.node}", rr.StateChange(state=change.state))
            if change.node == self._nodes[self._tower]:
                stream.log("map/base", rr.Boxes2D.from_fields(colors=[self._colours[change.state]]))
        for line in snapshot.lines:
            stream.set_time(TIMELINE, duration=line.time_s)
            stream.log("events", rr.TextLog(line.text, level=line.level))
        stream.set_time(TIMELINE, duration=snapshot.time_s)
        self._log_map(snapshot)
        for name, values in snapshot.curves.items():
            stream.log(f"plots/{name}", rr.Scalars(values))

    def _log_map(self, snapshot: Snapshot) -> None:
        stream, robots = self._stream, self._robots
        points = _view(snapshot.positions_m)
        stream.log(
            "map/robots",
            rr.Points2D.from_fields(
                positions=points[robots], colors=[self._colours[snapshot.states[row]] for row in robots]
            ),
        )
        below = points[robots] + (0, 0.7 * self._radius_m)
        stream.log("map/names", rr.Points2D.from_fields(positions=below))
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
        if snapshot.heat_s is not None:
            stream.log("map/idleness", rr.DepthImage.from_fields(buffer=snapshot.heat_s[::-1].tobytes()))

    def _log_fixed(self, scene: Scene) -> None:
        """What does not change: styles, the grid, names, the description of the run."""

        def fixed(entity: str, what: Any) -> None:
            self._stream.log(entity, what, static=True)

        names = [scene.nodes[row] for row in self._robots]
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
        if scene.range_m is not None:
            radii_m = [(scene.range_m, scene.range_m)]
            fixed(
                "map/reach",
                rr.Ellipses2D(centers=tower, half_sizes=radii_m, line_radii=[-0.7], colors=[GREY]),
            )
        self._log_grid(scene.scenario.field, fixed)
        for plot in (*scene.mission.plots, RADIO):
            series, colours = zip(*plot.series, strict=True)
            fixed(f"plots/{plot.name}", rr.SeriesLines(names=series, colors=colours, widths=[1.5]))
        states, colours = zip(*self._colours.items(), strict=True)
        for node in scene.nodes:
            fixed(f"states/{node}", rr.StateConfiguration(values=states, labels=states, colors=colours))
        fixed("about", rr.TextDocument(describe(scene), media_type="text/markdown"))

    def _log_grid(self, field: Any, fixed: Callable[[str, Any], None]) -> None:
        """The lines between cells, and where the heat map's pixels lie: one pixel is one cell."""
        if not isinstance(field, Grid):
            return
        left, bottom, right, top = self._bounds_m
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
                depth_range=(0, self._hottest_s),
                magnification_filter="nearest",
                draw_order=0,
            ),
        )


class FileSink(Picture):
    """A recording on disk, in large chunks: with one chunk for each row it would be eight times larger."""

    def __init__(self, path: Path, run: str, scene: Scene) -> None:
        batches = rr.ChunkBatcherConfig(flush_tick=60.0)
        stream = rr.RecordingStream("picket", recording_id=run, batcher_config=batches)
        stream.save(path, default_blueprint=blueprint(scene, follow=False))
        super().__init__(stream, scene)

    def close(self) -> None:
        """Write the rest and the footer."""
        self._stream.disconnect()


class LiveSink(Picture):
    """A viewer that listens at `url`."""

    def __init__(self, url: str, run: str, scene: Scene) -> None:
        batches = rr.ChunkBatcherConfig(flush_tick=0.1)
        stream = rr.RecordingStream("picket", recording_id=run, batcher_config=batches)
        stream.connect_grpc(url, default_blueprint=blueprint(scene, follow=True))
        super().__init__(stream, scene)

    def close(self) -> None:
        """Send the rest. The viewer keeps what it has."""
        self._stream.flush()
        self._stream.disconnect()


def blueprint(scene: Scene, follow: bool) -> rrb.Blueprint:
    """The layout: the map at the left; curves, lanes of states and the event log at the right."""
    left, bottom, right, top = scene.mission.bounds_m
    margin = 0.04 * max(right - left, top - bottom)
    bounds = rrb.VisualBounds2D(
        x_range=(left - margin, right + margin), y_range=(-top - margin, margin - bottom)
    )
    world = rrb.Spatial2DView(origin="map", name="Map", visual_bounds=bounds, background=(14, 15, 20))
    infinite = rr.TimeRangeBoundary.infinite()
    all_time = rrb.VisibleTimeRange(TIMELINE, start=infinite, end=infinite)
    axis = rrb.TimeAxis(view_range=_window(scene.scenario, follow))
    plots = [
        rrb.TimeSeriesView(
            origin=f"plots/{plot.name}",
            name=plot.title,
            time_ranges=[all_time],
            axis_x=axis,
            plot_legend=rrb.PlotLegend("LeftTop"),
        )
        for plot in (*scene.mission.plots, RADIO)
    ]
    lanes = rrb.StateTimelineView(origin="states", name="Robots", time_ranges=[all_time], time_view=axis)
    columns = rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"])
    events = rrb.TextLogView(origin="events", name="Events", columns=columns)
    about = rrb.TextDocumentView(origin="about", name="About")
    side = rrb.Vertical(*plots[:2], lanes, rrb.Tabs(events, *plots[2:], about), row_shares=[12, 12, 43, 18])
    # A person who opens a recording sees the run pass in REPLAY_S.
    speed = None if follow else scene.scenario.duration_s / REPLAY_S
    play = "following" if follow else "playing"
    return rrb.Blueprint(
        rrb.Horizontal(world, side, column_shares=[11, 9]),
        rrb.TopPanel(state="hidden"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state=play, playback_speed=speed),
        auto_views=False,
        auto_layout=False,
    )


def _window(scenario: Scenario, follow: bool) -> rr.TimeRange:
    """What curves and lanes show: the whole run, or the last twenty minutes of a paced run."""
    if follow and scenario.clock.kind == "paced":
        span_s = min(scenario.duration_s, 1200 * scenario.clock.rate)
        return rr.TimeRange(
            rr.TimeRangeBoundary.cursor_relative(seconds=-span_s),
            rr.TimeRangeBoundary.cursor_relative(seconds=span_s / 20),
        )
    return rr.TimeRange(
        rr.TimeRangeBoundary.absolute(seconds=0.0), rr.TimeRangeBoundary.absolute(seconds=scenario.duration_s)
    )


def _view(points_m: np.ndarray) -> np.ndarray:
    """Points of the field as the 2D view has them, y downwards: float32."""
    return (points_m * (1, -1)).astype(np.float32)
