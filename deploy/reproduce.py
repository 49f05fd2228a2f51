"""`picket reproduce`: run what a paper ran, print its tables beside ours, and save the figures."""

import argparse
import sys
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table as Printed

from deploy.run_folder import RunError
from deploy.studies import Bars, Table, line_patrol
from deploy.sweep import sweep

STUDIES = {"line-patrol": line_patrol}
INTERRUPTED = 130
WIDTH = 150


def reproduce(given: argparse.Namespace) -> int:
    """Carry out `picket reproduce`; returns the exit code. Raises RunError, SweepError."""
    study, parent = STUDIES[given.study], (given.out or Path("reproductions")) / given.study
    try:
        parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"--out {given.out}: cannot make a folder there: {error.strerror}") from None
    seeds = given.seeds or study.DEFAULT_SEEDS
    jobs = study.jobs(seeds, given.hours or study.DEFAULT_HOURS)
    try:
        summaries = _run(jobs, parent)
    except KeyboardInterrupt:
        print(f"interrupted; the same command goes on with what is missing in {parent}", file=sys.stderr)
        return INTERRUPTED
    tables = study.tables(summaries, seeds, parent)
    _print(Console(), tables)
    with (parent / "tables.txt").open("w") as stream:
        _print(Console(file=stream, width=WIDTH), tables)
    for figure in study.figures(summaries, seeds):
        print(f"figure {_draw(figure, parent / f'{figure.name}.png')}")
    print(f"tables {parent / 'tables.txt'}\nruns   {parent}")
    return 0


def _run(jobs: dict[str, Any], parent: Path) -> dict[str, dict[str, Any]]:
    console = Console(stderr=True)
    columns = (TextColumn("rehearsing"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=len(jobs))
        return sweep(jobs, parent, lambda done, all_of_them: bar.update(task, completed=done))


def _print(console: Console, tables: list[Table]) -> None:
    for table in tables:
        printed = Printed(
            title=table.title, title_justify="left", caption=table.remark, caption_justify="left"
        )
        for heading in table.headings:
            printed.add_column(heading)
        for row in table.rows:
            printed.add_row(*row)
        console.print(printed)
        console.print()


def _draw(figure: Bars, path: Path) -> Path:
    """Grouped bars as a PNG."""
    import matplotlib  # half a second to import, and only needed here

    matplotlib.use("Agg")
    from matplotlib import pyplot

    canvas, axes = pyplot.subplots(figsize=(9, 4.5), layout="constrained")
    width = 0.8 / len(figure.groups)
    for place, (group, values) in enumerate(figure.groups.items()):
        at = [label + (place - (len(figure.groups) - 1) / 2) * width for label in range(len(figure.labels))]
        errors = [one or 0.0 for one in figure.errors[group]] if group in figure.errors else None
        axes.bar(at, [one or 0.0 for one in values], width, yerr=errors, label=group, capsize=3)
    axes.set_xticks(range(len(figure.labels)), figure.labels)
    axes.set_ylabel(figure.unit)
    axes.set_title(figure.title, fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=9)
    canvas.savefig(path, dpi=130)
    pyplot.close(canvas)
    return path
