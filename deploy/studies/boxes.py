"""Boxes of trials by team size and algorithm, and the colours of algorithms.

The same colour for an algorithm everywhere, from the palettes of Okabe and Ito and of Tol, which colour-blind
people can tell apart too.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from deploy.studies.outcomes import Outcomes

BLUE, ORANGE, VERMILLION, GREEN, PURPLE, SKY = "#0072B2 #E69F00 #D55E00 #009E73 #CC79A7 #56B4E9".split()
DARK = "#222222"
GREY, INDIGO, SAND, WINE, TEAL = "#999999 #332288 #DDCC77 #882255 #44AA99".split()
COLOURS = {
    "lr_pt": BLUE,
    "expected_reactive": ORANGE,
    "expected_reactive-relay": VERMILLION,
    "dtap": GREEN,
    "chain_connected": PURPLE,
    "random": GREY,
    "conscientious_reactive": SKY,
    "heuristic_conscientious_reactive": INDIGO,
    "gbs": SAND,
    "sebs": WINE,
    "dtag": TEAL,
}
GUESTS = ("#000000", "#AA4499", "#999933", "#661100")
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


def by_algorithm(outcomes: Outcomes, kind: str, metrics: Iterable[str]) -> Boxes:
    """The trials of one kind, a colour for each algorithm."""
    guests, found = iter(GUESTS * 10), {}
    for one in outcomes.algorithms():
        colour = COLOURS.get(one.name) or COLOURS.get(one.behaviour) or next(guests)
        found[one.label] = (colour, values_of(outcomes, metrics, one.name, kind))
    return found


def values_of(
    outcomes: Outcomes, metrics: Iterable[str], algorithm: str = "lr_pt", kind: str = "main"
) -> dict[int, dict[str, list[float]]]:
    """By team size and metric the values of all trials."""
    names = list(metrics)
    return {
        nodes: {name: outcomes.values(name, nodes, algorithm, kind) for name in names}
        for nodes in outcomes.sizes()
    }


def draw_boxes(
    title: str, boxes: Boxes, panels: Mapping[str, str], path: Path, size: Callable[[int], str]
) -> Path:
    """Four panels, headings by metric: team sizes side by side, boxes of one size beside each other.

    `size` says how a number of nodes is told.
    """
    figure, places = pyplot.subplots(2, 2, figsize=(10, 7.2))
    for axes, (metric, heading) in zip(places.flat, panels.items(), strict=True):
        _panel(axes, metric, boxes, size)
        axes.set_title(heading)
        axes.set_ylabel("s")
    handles = [Patch(facecolor=colour, label=label) for label, (colour, _) in boxes.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 5), frameon=False)
    title_above(figure, title)
    return save(figure, path)


def _panel(axes: Any, metric: str, boxes: Boxes, size: Callable[[int], str]) -> None:
    sizes = sorted({nodes for _, by_size in boxes.values() for nodes in by_size})
    width = 0.84 / len(boxes)
    for place, (colour, by_size) in enumerate(boxes.values()):
        for group, nodes in enumerate(sizes):
            if values := by_size.get(nodes, {}).get(metric, []):
                at = group + (place - (len(boxes) - 1) / 2) * width
                drawn = axes.boxplot(
                    [values], positions=[at], widths=width * 0.78, patch_artist=True, whis=(0, 100)
                )
                _paint(drawn, colour)
                dots = np.full(len(values), at)
                axes.plot(dots, values, "o", ms=3, mfc=colour, mec=DARK, mew=0.5, zorder=4)
    axes.set_xticks(range(len(sizes)), [size(nodes) for nodes in sizes])
    axes.set_xlim(-0.5, len(sizes) - 0.5)
    for between in range(1, len(sizes)):
        axes.axvline(between - 0.5, color="#E4E4E4", lw=0.8, zorder=0)
    axes.tick_params(axis="x", length=0)
    _scale(axes, [one for _, by_size in boxes.values() for each in by_size.values() for one in each[metric]])


def _scale(axes: Any, everything: Sequence[float]) -> None:
    if not everything:
        return
    if max(everything) > MANY_TIMES * max(min(everything), 1e-9):
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, place: f"{value:g}"))
        axes.yaxis.set_minor_formatter(NullFormatter())
    else:
        axes.set_ylim(0, 1.08 * max(everything))


def _paint(drawn: dict[str, Any], colour: str) -> None:
    for box in drawn["boxes"]:
        box.set(facecolor=colour, edgecolor=colour, alpha=0.75, linewidth=1)
    for line in (*drawn["whiskers"], *drawn["caps"]):
        line.set(color=colour, linewidth=1.2)
    for line in drawn["medians"]:
        line.set(color=DARK, linewidth=1.4)


def title_above(figure: Any, words: str) -> None:
    """The figure's title, above its left edge."""
    figure.suptitle(words, x=0.01, ha="left", fontsize=12, fontweight="bold")


def save(figure: Any, path: Path) -> Path:
    """Write a PNG and forget the figure; returns the path."""
    figure.savefig(path)
    pyplot.close(figure)
    return path
