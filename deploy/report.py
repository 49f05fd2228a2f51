"""What a person reads in the terminal: progress while a run lasts, and its result as a table."""

import sys
import time
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from wire.messages import Facts
from wire.scenario import Scenario
from world_server.nodes import DEAD, FLAT

PLAIN_EVERY_S = 5.0
LABELS = {
    "graph_idleness_s": "graph idleness",
    "worst_idleness_s": "worst idleness",
    "mean_sa_delay_s": "mean SA delay",
    "worst_sa_delay_s": "worst SA delay",
}


class ProgressLine:
    """Simulated time, speed and robots alive: a bar on a terminal, else a plain line now and then."""

    def __init__(self, console: Console, scenario: Scenario, last_tick: int) -> None:
        self._console = console
        self._scenario = scenario
        self._last_tick = last_tick
        self._robots = len(scenario.robot_ids)
        self._began = self._shown = time.monotonic()
        columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[words]}"))
        self._bar = Progress(*columns, TimeRemainingColumn(), console=console, transient=True)
        self._task = self._bar.add_task("patrol", total=last_tick, words="starting")

    def __enter__(self) -> "ProgressLine":
        if self._console.is_terminal:
            self._bar.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._bar.stop()

    def show(self, facts: Facts) -> None:
        """Take note of the facts of a tick; draws at most a few times a second."""
        now = time.monotonic()
        if now - self._shown < (0.1 if self._console.is_terminal else PLAIN_EVERY_S):
            return
        self._shown = now
        words = self._words(facts, now)
        if self._console.is_terminal:
            self._bar.update(self._task, completed=facts.tick, words=words)
        else:
            self._console.print(words, highlight=False)

    def _words(self, facts: Facts, now: float) -> str:
        tick_s = self._scenario.tick_s
        gone = sum(mode in (DEAD, FLAT) for mode in self._robot_modes(facts))
        speed = facts.tick * tick_s / (now - self._began)
        of = self._last_tick * tick_s
        alive = self._robots - gone
        return f"{facts.tick * tick_s:.0f} of {of:.0f} s, {speed:.0f} x real time, {alive} robots alive"

    def _robot_modes(self, facts: Facts) -> list[int]:
        tower = self._scenario.tower.id
        return [
            mode for node, mode in zip(self._scenario.node_ids, facts.modes, strict=False) if node != tower
        ]


def metrics_table(summary: dict[str, Any]) -> Table:
    """The result of a run as a table, as its mission measures it."""
    title = f"{summary['scenario']}, seed {summary['seed']}, {summary['sim_s']:.0f} s"
    table = Table(title=title, title_justify="left")
    TABLES[summary["mission"]](table, summary["metrics"])
    return table


def _area_rows(table: Table, metrics: dict[str, Any]) -> None:
    for heading, justify in (("metric", "left"), ("seconds", "right"), ("x (N - 1) / K", "right")):
        table.add_column(heading, justify=justify)
    for name, label in LABELS.items():
        table.add_row(label, _number(metrics[name], 1), _number(metrics[f"normalised_{name}"], 2))
    table.add_row("graph idleness, at events", _number(metrics["average_graph_idleness_s"], 2), "")
    table.add_row("worst idleness, at events", _number(metrics["worst_idleness_at_events_s"], 2), "")
    last = [_number(metrics[f"instantaneous_{name}_idleness_s"], 2) for name in ("graph", "worst")]
    table.add_row("idleness at the end, graph / worst", " / ".join(last), "")
    intervals = [_number(metrics[f"node_interval_{name}_s"], 1) for name in ("mean", "max")]
    table.add_row("node interval, mean / max", " / ".join(intervals), "")


def _line_rows(table: Table, metrics: dict[str, Any]) -> None:
    for heading, justify in (("metric", "left"), ("value", "right"), ("unit", "left")):
        table.add_column(heading, justify=justify)
    recovery, frequency = metrics["recovery_s"], metrics["visit_frequency_hz"]
    covered = f"s, min / median / max of {recovery['count']}"
    asked = metrics["grants"] / metrics["robot_ticks"] if metrics["robot_ticks"] else None
    orders = metrics["orders"]
    hops = [_number(orders["hops_mean"], 1), _number(orders["hops_max"], 0)]
    lap = [_number(metrics[name], 2) for name in ("lap_time_mean_s", "lap_time_sd_s")]
    uniformity = [_scaled(frequency[name], 1e3, 2) for name in ("mean", "min")]
    for row in (
        ("lap time", " ± ".join(lap), "s, mean ± sd"),
        ("idle in the queue", _scaled(metrics["idle_share"], 100, 1), "% of robot time"),
        ("return time", _number(metrics["return_time_mean_s"], 1), "s, mean"),
        ("deployment", _number(metrics["deployment_s"], 0), "s"),
        ("longest gap", _number(metrics["longest_gap_s"], 0), "s"),
        ("recovery", " / ".join(_number(recovery[name], 0) for name in ("min", "median", "max")), covered),
        ("recalls", str(metrics["recalls"]), f"at most {metrics['away_most']} on their way home at once"),
        ("robots gone flat", str(metrics["flat_robots"]), ""),
        ("incidents", str(metrics["incidents"]), "closer than bodies may come"),
        ("orders", f"{orders['delivered']} / {orders['given']}", "reached their robots / given"),
        ("their hops", " / ".join(hops), "mean / most"),
        ("visit frequency", " / ".join(uniformity), "per 1000 s, mean / min of all sites"),
        ("its variance", _scaled(frequency["variance"], 1e6, 2), "(per 1000 s)²"),
        ("asked", _scaled(asked, 100, 1), "% of robot-ticks"),
    ):
        table.add_row(*row)


def _clear_rows(table: Table, metrics: dict[str, Any]) -> None:
    for heading, justify in (("metric", "left"), ("value", "right"), ("unit", "left")):
        table.add_column(heading, justify=justify)
    lost, graph = metrics["recontaminated_m2"], metrics["graph"]
    again = " / ".join(_number(area_m2, 2) for area_m2 in lost.values())
    peak = f"{metrics['robots_on_lines_peak']} / {metrics['robots_deployed']}"
    searches = f"{metrics['searches']} / {metrics['searches_failed']}"
    for row in (
        ("cleared", "yes" if metrics["cleared"] else "no", "as the referee sees it"),
        ("claim", metrics["claim"], "as the team says"),
        ("clear after", _number(metrics["clear_time_s"], 0), "s"),
        ("contaminated at the end", _number(metrics["contaminated_area_m2"], 2), "m²"),
        ("lost again", again, f"m², {' / '.join(lost)}"),
        ("breaches", str(metrics["breaches"]), "ticks"),
        ("robots", peak, "most on lines / deployed"),
        ("splits", str(metrics["splits"]), ""),
        ("searches", searches, "all / failed"),
        ("lines dissolved", str(metrics["dissolved"]), ""),
        ("graph", " / ".join(map(str, graph.values())), "vertices / edges / of cycles"),
    ):
        table.add_row(*row)


TABLES = {"area": _area_rows, "line": _line_rows, "clear": _clear_rows}


def print_result(
    console: Console, summary: dict[str, Any], folder: str, deaths: list[dict[str, Any]]
) -> None:
    """The table, what befell the team, and where everything is. `deaths`: events of deaths nobody ordered."""
    console.print(metrics_table(summary))
    for death in deaths:
        console.print(f"tick {death['tick']:>6}: {death['text']}", style="red", highlight=False, markup=False)
        for line in death["data"]["last_lines"].splitlines():
            console.print(f"    {line}", highlight=False, markup=False)
    for fault in summary["faults"]:
        done = "" if fault["confirmed"] else " (not done)"
        console.print(f"tick {fault['tick']:>6}: {fault['verb']} {fault['node']}{done}", highlight=False)
    radio = summary["radio"]
    console.print(
        f"radio: {radio['sent']} frames, {radio['delivered']} deliveries, {radio['bytes']} bytes "
        f"({summary['wall_s']:.1f} s of wall time)",
        highlight=False,
    )
    if not summary["completed"]:
        console.print(f"ended early, at tick {summary['ticks']}", style="yellow")
    console.print(f"run hash {summary['run_hash']}", highlight=False)
    console.print(f"run folder {folder}", highlight=False, soft_wrap=True)


def console_for(json_only: bool) -> Console:
    """Standard output, or standard error where standard output is for JSON only."""
    return Console(file=sys.stderr if json_only else sys.stdout)


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _scaled(value: float | None, factor: float, digits: int) -> str:
    return _number(None if value is None else value * factor, digits)
