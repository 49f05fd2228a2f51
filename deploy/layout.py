"""How the dashboard is laid out: which views there are, what they show, and what of time they show."""

import rerun as rr
import rerun.blueprint as rrb

from deploy.scene import Scene
from deploy.scenes.mission import Mission, Plot
from wire.scenario import Scenario

TIMELINE = "sim_time"
PAPER = (14, 15, 20)
REPLAY_S = 120.0
WIDE = 1.3
"""A map that is so many times as wide as it is high has room below it, for the mission's first diagram."""


def blueprint(scene: Scene, until_s: float, follow: bool) -> rrb.Blueprint:
    """The map at the left; curves, lanes of states and the event log beside it. The run ends at `until_s`."""
    axis = rrb.TimeAxis(view_range=_window(scene.scenario, until_s, follow))
    infinite = rr.TimeRangeBoundary.infinite()
    all_time = rrb.VisibleTimeRange(TIMELINE, start=infinite, end=infinite)
    plots = [_diagram(plot, axis, all_time) for plot in scene.plots]
    lanes = rrb.StateTimelineView(origin="states", name="Robots", time_ranges=[all_time], time_view=axis)
    columns = rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"])
    events = rrb.TextLogView(origin="events", name="Events", columns=columns)
    about = rrb.TextDocumentView(origin="about", name="About")
    left, bottom, right, top = scene.mission.bounds_m
    if scene.mission.canvas is not None:
        below = rrb.Vertical(_map(scene), rrb.Tabs(events, plots[-1], about), row_shares=[78, 22])
        between = rrb.Vertical(_graph(scene.mission), *plots[:-1], row_shares=[32, 18, 22, 28])
        views = rrb.Horizontal(below, between, lanes, column_shares=[47, 29, 24])
    elif right - left > WIDE * (top - bottom):
        below = rrb.Vertical(_map(scene), plots[0], row_shares=[62, 38])
        others, texts = plots[1:-1], rrb.Tabs(events, plots[-1], about)
        beside = rrb.Vertical(lanes, *others, texts, row_shares=[45, *(18 for _ in others), 19])
        views = rrb.Horizontal(below, beside, column_shares=[11, 9])
    else:
        texts = rrb.Tabs(events, *plots[2:], about)
        beside = rrb.Vertical(*plots[:2], lanes, texts, row_shares=[12, 12, 43, 18])
        views = rrb.Horizontal(_map(scene), beside, column_shares=[11, 9])
    # A person who opens a recording sees the run pass in REPLAY_S.
    speed = None if follow else max(1.0, until_s / REPLAY_S)
    play = "following" if follow else "playing"
    return rrb.Blueprint(
        views,
        rrb.TopPanel(state="hidden"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state=play, playback_speed=speed),
        auto_views=False,
        auto_layout=False,
    )


def _map(scene: Scene) -> rrb.Spatial2DView:
    left, bottom, right, top = scene.mission.bounds_m
    margin = 0.04 * max(right - left, top - bottom)
    bounds = rrb.VisualBounds2D(
        x_range=(left - margin, right + margin), y_range=(-top - margin, margin - bottom)
    )
    return rrb.Spatial2DView(origin="map", name=scene.mission.title, visual_bounds=bounds, background=PAPER)


def _graph(mission: Mission) -> rrb.GraphView:
    width, height = mission.canvas
    bounds = rrb.VisualBounds2D(x_range=(0.0, width), y_range=(0.0, height))
    paper = rrb.archetypes.GraphBackground(color=PAPER)
    return rrb.GraphView(origin="graph", name=mission.graph_title, visual_bounds=bounds, background=paper)


def _diagram(plot: Plot, axis: rrb.TimeAxis, times: rrb.VisibleTimeRange) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=f"plots/{plot.name}",
        name=plot.title,
        time_ranges=[times],
        axis_x=axis,
        axis_y=None if plot.span is None else rrb.ScalarAxis(range=plot.span),
        plot_legend=rrb.PlotLegend("LeftTop", visible=len(plot.series) > 1),
    )


def _window(scenario: Scenario, until_s: float, follow: bool) -> rr.TimeRange:
    """What curves and lanes show: the whole run, or the last twenty minutes of a paced run."""
    if follow and scenario.clock.kind == "paced":
        span_s = min(scenario.duration_s, 1200 * scenario.clock.rate)
        return rr.TimeRange(
            rr.TimeRangeBoundary.cursor_relative(seconds=-span_s),
            rr.TimeRangeBoundary.cursor_relative(seconds=span_s / 20),
        )
    return rr.TimeRange(
        rr.TimeRangeBoundary.absolute(seconds=0.0),
        rr.TimeRangeBoundary.absolute(seconds=max(until_s, scenario.tick_s)),
    )
