"""The figures: boxes by team size and algorithm, maps of visits, curves through failures.

The same colour for an algorithm everywhere, from the palette of Okabe and Ito, which colour-blind people can
tell apart too.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from deploy.studies.lr_pt.outcomes import METRICS, Outcome, Outcomes
from deploy.studies.lr_pt.plan import MEMORIES
from deploy.studies.lr_pt.stability import COLUMNS, curve

BLUE, ORANGE, VERMILLION, GREEN, PURPLE, SKY = "#0072B2 #E69F00 #D55E00 #009E73 #CC79A7 #56B4E9".split()
DARK = "#222222"
COLOURS = {
    "lr_pt": BLUE,
    "expected_reactive": ORANGE,
    "expected_reactive-relay": VERMILLION,
    "dtap": GREEN,
    "chain_connected": PURPLE,
}
GUESTS = (SKY, "#8C6D1F", "#5B5B5B", "#B0A800")
MEMORY_LINES = {
    "kept": {"color": BLUE, "lw": 1.1, "zorder": 3},
    "lost": {"color": ORANGE, "lw": 2.4},  # broader and below: alike until the first restart
}
MANY_TIMES = 8
"""Where the largest value is so many times the smallest, the axis is logarithmic."""
STYLE = {
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#777777",
    "axes.grid": True,
    "axes.grid.axis": "y",
    "axes.axisbelow": True,
    "grid.color": "#E4E4E4",
    "figure.constrained_layout.use": True,
    "savefig.dpi": 150,
}

Boxes = Mapping[str, tuple[str, Mapping[int, Mapping[str, Sequence[float]]]]]
"""By label: colour, and by team size the values of each metric."""


def draw(outcomes: Outcomes, folder: Path) -> Iterator[Path]:
    """Draw every figure that there are trials for; yields the paths."""
    with pyplot.rc_context(STYLE):
        yield _boxes("Algorithms", _by_algorithm(outcomes), folder / "comparison.png")
        yield _boxes("LR-PT with few items per second", _by_items(outcomes), folder / "bandwidth.png")
        yield _boxes("LR-PT taken literally", _by_breaker(outcomes), folder / "literal.png")
        for nodes in outcomes.sizes():
            if first := outcomes.of("main", nodes=nodes):
                yield _maps(first[0], folder / f"visits-n{nodes}.png")
        struck = [one for memory in MEMORIES for one in outcomes.of(f"failures-{memory}")]
        if struck:
            yield _curves(struck, folder / "failures.png")
        for one in struck:
            if one.trial.kind == "failures-kept":
                yield _phases(one, folder / f"failures-visits-n{one.trial.nodes}.png")


def _values(
    outcomes: Outcomes, algorithm: str = "lr_pt", kind: str = "main"
) -> dict[int, dict[str, list[float]]]:
    return {
        nodes: {name: outcomes.values(f"normalised_{name}", nodes, algorithm, kind) for name in METRICS}
        for nodes in outcomes.sizes()
    }


def _by_algorithm(outcomes: Outcomes) -> Boxes:
    guests = iter(GUESTS * 10)
    return {
        one.label: (COLOURS.get(one.name) or next(guests), _values(outcomes, one.name))
        for one in outcomes.algorithms()
    }


def _by_items(outcomes: Outcomes) -> Boxes:
    return {
        "s = 400": (BLUE, _values(outcomes)),
        "s = 8, unsent": (SKY, _values(outcomes, kind="s8")),
        "s = 8, newest (to the letter)": (VERMILLION, _values(outcomes, kind="s8-newest")),
    }


def _by_breaker(outcomes: Outcomes) -> Boxes:
    return {
        "goals of neighbours are skipped (default)": (BLUE, _values(outcomes)),
        "no lock breaker (to the letter)": (VERMILLION, _values(outcomes, kind="literal")),
    }


def _boxes(title: str, boxes: Boxes, path: Path) -> Path:
    """Four panels, one for each metric: team sizes side by side, boxes of one size beside each other."""
    figure, panels = pyplot.subplots(2, 2, figsize=(10, 7.2))
    for axes, (metric, words) in zip(panels.flat, METRICS.items(), strict=True):
        _panel(axes, metric, boxes)
        axes.set_title(f"Normalised {words}")
        axes.set_ylabel("s")
    handles = [Patch(facecolor=colour, label=label) for label, (colour, _) in boxes.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 6), frameon=False)
    _title(figure, title)
    return _save(figure, path)


def _panel(axes: Any, metric: str, boxes: Boxes) -> None:
    sizes = sorted({nodes for _, by_size in boxes.values() for nodes in by_size})
    width, everything = 0.8 / len(boxes), []
    for place, (colour, by_size) in enumerate(boxes.values()):
        for group, nodes in enumerate(sizes):
            values = by_size.get(nodes, {}).get(metric, [])
            if not values:
                continue
            everything += values
            at = group + (place - (len(boxes) - 1) / 2) * width
            drawn = axes.boxplot(
                [values], positions=[at], widths=width * 0.78, patch_artist=True, whis=(0, 100)
            )
            _paint(drawn, colour)
            axes.plot(np.full(len(values), at), values, "o", ms=3, mfc=colour, mec=DARK, mew=0.5, zorder=4)
    axes.set_xticks(range(len(sizes)), [f"N = {nodes}" for nodes in sizes])
    axes.set_xlim(-0.5, len(sizes) - 0.5)
    for between in range(1, len(sizes)):
        axes.axvline(between - 0.5, color="#E4E4E4", lw=0.8, zorder=0)
    axes.tick_params(axis="x", length=0)
    if everything and max(everything) > MANY_TIMES * max(min(everything), 1e-9):
        _logarithmic(axes)
    elif everything:
        axes.set_ylim(0, 1.08 * max(everything))


def _paint(drawn: dict[str, Any], colour: str) -> None:
    for box in drawn["boxes"]:
        box.set(facecolor=colour, edgecolor=colour, alpha=0.75, linewidth=1)
    for line in (*drawn["whiskers"], *drawn["caps"]):
        line.set(color=colour, linewidth=1.2)
    for line in drawn["medians"]:
        line.set(color=DARK, linewidth=1.4)


def _logarithmic(axes: Any) -> None:
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, place: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _maps(outcome: Outcome, path: Path) -> Path:
    """One map for each robot, all in one scale, and one of their sum in its own."""
    visits = outcome.tables["visits"].sum(axis=0)
    columns = min(len(visits) + 1, 5)
    rows = -(-(len(visits) + 1) // columns)
    size = (2.1 * columns + 1.3, 2.3 * rows + 0.4)
    figure, panels = pyplot.subplots(rows, columns, figsize=size, squeeze=False)
    most = max(1, int(visits.max()))
    for axes, robot, counts in zip(panels.flat, outcome.scenario.robot_ids, visits, strict=False):
        of_one = _map(axes, outcome, counts, most, "viridis", robot)
    last = panels.flat[len(visits)]
    of_all = _map(last, outcome, visits.sum(axis=0), None, "cividis", "all together")
    for unused in list(panels.flat)[len(visits) + 1 :]:
        unused.set_visible(False)
    for picture, words in ((of_all, "visits by all together"), (of_one, "visits by one robot")):
        ticks = MaxNLocator(6, integer=True)
        figure.colorbar(picture, ax=panels, shrink=0.75, label=words, ticks=ticks, aspect=30)
    _title(figure, f"LR-PT, N = {outcome.trial.nodes}, seed {outcome.trial.seed}: visits to each cell")
    return _save(figure, path)


def _map(axes: Any, outcome: Outcome, counts: np.ndarray, most: int | None, colours: str, title: str) -> Any:
    """Cells as the field lies: first axis to the right, second upwards; a ring where the tower stands."""
    field, tower = outcome.scenario.field, outcome.scenario.tower
    side = counts.reshape(field.columns, field.rows).T
    extent = (0, field.columns * field.cell_m, 0, field.rows * field.cell_m)
    picture = axes.imshow(side, origin="lower", extent=extent, cmap=colours, vmin=0, vmax=most)
    axes.plot(tower.x_m, tower.y_m, "o", ms=7, mfc="white", mec="black", mew=1.2, clip_on=False, zorder=5)
    axes.set_title(title, fontsize=10)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(False)
    axes.spines[:].set_visible(False)
    return picture


def _phases(outcome: Outcome, path: Path) -> Path:
    """A row of maps for each phase of a run with failures."""
    names = ("before", "failed", "recovered")
    visits, robots = outcome.tables["visits"], outcome.scenario.robot_ids
    columns = len(robots) + 1
    figure, panels = pyplot.subplots(len(visits), columns, figsize=(1.3 * columns + 0.5, 4.6), squeeze=False)
    most = max(1, int(visits.max()))
    for row, (phase, counts) in enumerate(zip(names, visits, strict=True)):
        for axes, robot, own in zip(panels[row], robots, counts, strict=False):
            _map(axes, outcome, own, most, "viridis", robot if row == 0 else "")
            if not own.any():
                axes.text(0.5, 0.5, "no visits", color="white", ha="center", transform=axes.transAxes)
        _map(panels[row][-1], outcome, counts.sum(axis=0), None, "cividis", "all" if row == 0 else "")
        panels[row][0].set_ylabel(phase, fontsize=10)
    title = f"LR-PT, N = {outcome.trial.nodes}: visits before, during and after failures, memory kept"
    _title(figure, f"{title} (brightest: {most} visits by a robot)")
    return _save(figure, path)


def _curves(struck: Sequence[Outcome], path: Path) -> Path:
    """A row for each team size: graph idleness and mean SA delay over time, both memories."""
    sizes = sorted({one.trial.nodes for one in struck})
    figure, panels = pyplot.subplots(
        len(sizes), 2, figsize=(11, 2.3 * len(sizes) + 0.8), sharex=True, sharey="col", squeeze=False
    )
    for one in struck:
        row, memory = sizes.index(one.trial.nodes), one.trial.kind.removeprefix("failures-")
        for axes, (name, words) in zip(panels[row], COLUMNS.items(), strict=True):
            time_s, value_s = curve(one, name)
            axes.plot(time_s / 3600, value_s, label=f"memory {memory}", **MEMORY_LINES[memory])
            axes.set_title(f"N = {one.trial.nodes}: normalised {words}")
            if memory == MEMORIES[0]:
                axes.axvspan(*(fault.at_s / 3600 for fault in one.scenario.faults), color="#EEEEEE", zorder=0)
    for axes in panels.flat:
        axes.set_ylabel("s")
        axes.margins(x=0)
        axes.set_ylim(bottom=0)
        axes.xaxis.set_major_locator(MaxNLocator(12, steps=[1, 2, 3, 6, 10]))
    for axes in panels[-1]:
        axes.set_xlabel("hours; grey: the 20 % highest numbers are dead")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=2, frameon=False)
    _title(figure, "LR-PT through failures")
    return _save(figure, path)


def _title(figure: Any, words: str) -> None:
    figure.suptitle(words, x=0.01, ha="left", fontsize=12, fontweight="bold")


def _save(figure: Any, path: Path) -> Path:
    figure.savefig(path)
    pyplot.close(figure)
    return path
