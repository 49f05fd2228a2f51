"""The figures: boxes by team size and algorithm, maps of visits, curves through failures."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import pyplot
from matplotlib.ticker import MaxNLocator

from deploy.studies.boxes import (
    BLUE,
    ORANGE,
    SKY,
    STYLE,
    VERMILLION,
    Boxes,
    by_algorithm,
    draw_boxes,
    save,
    title_above,
    values_of,
)
from deploy.studies.lr_pt.plan import MEMORIES
from deploy.studies.lr_pt.stability import COLUMNS, curve
from deploy.studies.outcomes import METRICS, Outcome, Outcomes

PANELS = {f"normalised_{name}": f"Normalised {words}" for name, words in METRICS.items()}
MEMORY_LINES = {
    "kept": {"color": BLUE, "lw": 1.1, "zorder": 3},
    "lost": {"color": ORANGE, "lw": 2.4},  # broader and below: alike until the first restart
}


def draw(outcomes: Outcomes, folder: Path) -> Iterator[Path]:
    """Draw every figure that there are trials for; yields the paths."""
    with pyplot.rc_context(STYLE):
        compared = {
            "comparison": ("Algorithms", by_algorithm(outcomes, "main", PANELS)),
            "bandwidth": ("LR-PT with few items per second", _by_items(outcomes)),
            "literal": ("LR-PT taken literally", _by_breaker(outcomes)),
        }
        for name, (title, boxes) in compared.items():
            yield draw_boxes(title, boxes, PANELS, folder / f"{name}.png", lambda nodes: f"N = {nodes}")
        for nodes in outcomes.sizes():
            if first := outcomes.of("main", nodes=nodes):
                yield _maps(first[0], folder / f"visits-n{nodes}.png")
        struck = [one for memory in MEMORIES for one in outcomes.of(f"failures-{memory}")]
        if struck:
            yield _curves(struck, folder / "failures.png")
        for one in struck:
            if one.trial.kind == "failures-kept":
                yield _phases(one, folder / f"failures-visits-n{one.trial.nodes}.png")


def _by_items(outcomes: Outcomes) -> Boxes:
    return {
        "s = 400": (BLUE, values_of(outcomes, PANELS)),
        "s = 8, unsent": (SKY, values_of(outcomes, PANELS, kind="s8")),
        "s = 8, newest (to the letter)": (VERMILLION, values_of(outcomes, PANELS, kind="s8-newest")),
    }


def _by_breaker(outcomes: Outcomes) -> Boxes:
    return {
        "goals of neighbours are skipped (default)": (BLUE, values_of(outcomes, PANELS)),
        "no lock breaker (to the letter)": (VERMILLION, values_of(outcomes, PANELS, kind="literal")),
    }


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
    title_above(figure, f"LR-PT, N = {outcome.trial.nodes}, seed {outcome.trial.seed}: visits to each cell")
    return save(figure, path)


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
    title_above(figure, f"{title} (brightest: {most} visits by a robot)")
    return save(figure, path)


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
    title_above(figure, "LR-PT through failures")
    return save(figure, path)
