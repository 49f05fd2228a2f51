"""The figures: success against team size, places, what runs took, random plans, areas, the letter."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from matplotlib import pyplot
from matplotlib.collections import PatchCollection
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from matplotlib.ticker import MaxNLocator

from deploy.metrics.clear import Instant
from deploy.studies.boxes import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, STYLE, VERMILLION, save, title_above
from deploy.studies.pursuit.literal import Letter, longest_line_m
from deploy.studies.pursuit.plan import Ground, places, polygon
from deploy.studies.pursuit.runs import Runs, curve, median

COLOURS = (BLUE, ORANGE, GREEN, VERMILLION, PURPLE, SKY)
PANELS = {
    "clear_time_s": "Time to clear, s",
    "splits": "Splits",
    "searches": "Obstacle searches",
    "robots_on_lines_peak": "Most robots on lines",
}


def draw(runs: Runs, main: Ground, letter: Letter, folder: Path) -> Iterator[Path]:
    """Draw every figure; yields the paths."""
    with pyplot.rc_context(STYLE):
        yield _success(runs, folder / "success.png")
        yield _places(runs, main, folder / "places.png")
        yield _took(runs, folder / "runs.png")
        if any(ground.random for ground in runs.grounds):
            yield _plans(runs, folder / "plans.png")
        if runs.best(main):
            yield _areas(runs, main, folder)
        yield _letter(letter, folder / "letter.png")


def kinds(runs: Runs) -> dict[str, list[Ground]]:
    """The grounds of each kind."""
    found: dict[str, list[Ground]] = {}
    for ground in runs.grounds:
        found.setdefault(ground.kind, []).append(ground)
    return found


def sizes(runs: Runs, grounds: Sequence[Ground]) -> list[int]:
    """Team sizes that were tried from every place, so that shares can be compared."""
    return sorted({robots for ground in grounds for robots in ground.teams if runs.of(grounds, robots)})


def _success(runs: Runs, path: Path) -> Path:
    figure, axes = pyplot.subplots(figsize=(8, 4.2))
    for colour, (kind, grounds) in zip(COLOURS, kinds(runs).items(), strict=False):
        teams = sizes(runs, grounds)
        shares = [100 * np.mean([run.clears for run in runs.of(grounds, robots)]) for robots in teams]
        counts = sum(len(runs.of(grounds, robots)) for robots in teams)
        axes.plot(teams, shares, "o-", color=colour, label=f"{kind} ({counts} runs)")
    axes.set_ylim(-3, 103)
    axes.set_ylabel("runs that clear, %")
    axes.set_xlabel("robots")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(frameon=False)
    title_above(figure, "How often teams clear, over all places and plans")
    return save(figure, path)


def _places(runs: Runs, main: Ground, path: Path) -> Path:
    """The plan, with the fewest robots that clear it from each place; a dash where none do."""
    figure, axes = pyplot.subplots(figsize=(6, 6))
    _outline(axes, polygon(main))
    for (x_m, y_m), robots in zip(places(main), runs.fewest_of(main), strict=True):
        colour = GREY if robots is None else BLUE
        axes.plot(x_m, y_m, "o", ms=22, color=colour)
        told = "-" if robots is None else str(robots)
        axes.text(x_m, y_m, told, color="white", ha="center", va="center", fontsize=10, fontweight="bold")
    axes.set_aspect("equal")
    axes.set_xlabel("m")
    axes.grid(visible=False)
    title_above(figure, f"Fewest robots that clear {main.name}, by place")
    return save(figure, path)


def _outline(axes: Any, plan: shapely.Polygon) -> None:
    rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(plan)]
    path = Outline.make_compound_path(*(Outline(ring, closed=True) for ring in rings))
    axes.add_collection(PatchCollection([PathPatch(path)], facecolor="#F1EFE9", edgecolor="#555555"))
    west_m, south_m, east_m, north_m = plan.bounds
    axes.set_xlim(west_m - 0.5, east_m + 0.5)
    axes.set_ylim(south_m - 0.5, north_m + 0.5)


def _took(runs: Runs, path: Path) -> Path:
    """A dot for each run that clears, a line through the medians."""
    figure, panels = pyplot.subplots(2, 2, figsize=(10, 7))
    grounds_of = kinds(runs)
    for axes, (metric, heading) in zip(panels.flat, PANELS.items(), strict=True):
        for number, (kind, grounds) in enumerate(grounds_of.items()):
            clearing = [run for run in runs.all if run.trial.ground in grounds and run.clears]
            aside = 0.12 * (number - (len(grounds_of) - 1) / 2)
            at = [run.trial.robots + aside for run in clearing]
            colour = COLOURS[number % len(COLOURS)]
            axes.plot(at, [run.metrics[metric] for run in clearing], "o", ms=3, color=colour, alpha=0.5)
            teams = sorted({run.trial.robots for run in clearing})
            middle = [
                median(run.metrics[metric] for run in clearing if run.trial.robots == robots)
                for robots in teams
            ]
            axes.plot([one + aside for one in teams], middle, "-", color=colour, label=kind)
        axes.set_title(heading)
        axes.set_ylim(bottom=0)
        axes.set_xticks(sorted({run.trial.robots for run in runs.all}))
    figure.legend(
        *panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False
    )
    title_above(figure, "Runs that clear, by number of robots; lines go through medians")
    return save(figure, path)


def _plans(runs: Runs, path: Path) -> Path:
    """A row of squares for each random plan, one for each place, by the fewest robots that clear."""
    grounds = [ground for ground in runs.grounds if ground.random]
    fewest = np.array([[one or np.nan for one in runs.fewest_of(ground)] for ground in grounds], dtype=float)
    figure, axes = pyplot.subplots(figsize=(6.5, 1.5 + 0.24 * len(grounds)))
    teams = sorted({robots for ground in grounds for robots in ground.teams})
    shown = axes.imshow(fewest, cmap="viridis_r", vmin=teams[0], vmax=teams[-1] + 1, aspect="auto")
    for row, column in np.ndindex(fewest.shape):
        told = "-" if np.isnan(fewest[row, column]) else f"{fewest[row, column]:.0f}"
        axes.text(column, row, told, ha="center", va="center", fontsize=8)
    axes.set_yticks(range(len(grounds)), [ground.name for ground in grounds], fontsize=7)
    axes.set_xticks(range(fewest.shape[1]), range(1, fewest.shape[1] + 1))
    axes.set_xlabel("place")
    axes.grid(visible=False)
    figure.colorbar(shown, ticks=teams, label="robots")
    title_above(figure, "Fewest robots that clear random plans, by place")
    return save(figure, path)


def _areas(runs: Runs, main: Ground, folder: Path) -> Path:
    """The best run of each place: what is contaminated, and how the referees differ."""
    figure, (upper, lower) = pyplot.subplots(2, 1, figsize=(9, 6.5), sharex=True)
    for number, run in enumerate(runs.best(main)):
        samples = curve(folder, run.trial)
        time_s, exact_m2, raster_m2 = (
            samples[:, Instant._fields.index(name)] for name in ("time_s", "contaminated_m2", "raster_m2")
        )
        colour = (*COLOURS, GREY, "#332288")[number % 8]
        told = f"place {run.trial.place}, {run.trial.robots} robots"
        upper.plot(time_s, exact_m2, color=colour, lw=1.3, label=told)
        lower.plot(time_s, raster_m2 - exact_m2, color=colour, lw=0.8)
    upper.set_ylabel("contaminated, m2")
    lower.set_ylabel("raster - exact, m2")
    lower.set_xlabel("s")
    upper.legend(frameon=False, fontsize=8, ncols=2)
    title_above(figure, f"{main.name}: the smallest team that clears from each place")
    return save(figure, folder / "areas.png")


def _letter(letter: Letter, path: Path) -> Path:
    """Contaminated area against the gap; where ours stops, and where the letter does."""
    figure, axes = pyplot.subplots(figsize=(8, 4.5))
    for colour, one in zip(COLOURS, letter.teams, strict=False):
        axes.plot(one.gap_m, one.contaminated_m2, color=colour, label=f"{one.robots} robots")
        for literal, marker in ((False, "o"), (True, "X")):
            stop = one.at(longest_line_m(one.robots, letter.follow_m, literal))
            axes.plot(one.gap_m[stop], one.contaminated_m2[stop], marker, color=colour, ms=9, mec="white")
    axes.plot([], [], "o", color=GREY, label="our reading stops here")
    axes.plot([], [], "X", color=GREY, label="the letter of Algorithm 1 stops here")
    axes.axvline(2 * letter.detect_m, color=GREY, ls="--", lw=1)
    axes.text(2 * letter.detect_m, 0.02, " 2 r_detect", color=GREY, transform=axes.get_xaxis_transform())
    axes.set_xlabel("between neighbours, m")
    axes.set_ylabel("contaminated, m2")
    axes.set_ylim(bottom=0)
    axes.legend(frameon=False)
    title_above(figure, "Abreast through a widening room: how far lines are stretched")
    return save(figure, path)
