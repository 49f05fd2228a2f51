"""`picket reproduce line-patrol`: the runs of the study, its tables printed and saved, its figures drawn."""

import argparse
from pathlib import Path

from rich.console import Console
from rich.table import Table as Printed

from deploy.campaign import INTERRUPTED, Campaign, make_folder
from deploy.studies import Bars, Table, line_patrol

DEFAULT_SEEDS, DEFAULT_HOURS = 3, 24.0
WIDTH = 150


def reproduce(given: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code. Raises RunError, SweepError."""
    parent, seeds = make_folder(given.out, "line-patrol"), given.seeds or DEFAULT_SEEDS
    jobs = line_patrol.jobs(seeds, given.hours or DEFAULT_HOURS)
    summaries = Campaign(jobs, parent, lean=False).run()  # recovery times are folded from the journals
    if summaries is None:
        return INTERRUPTED
    tables = line_patrol.tables(summaries, seeds, parent)
    _print(Console(), tables)
    with (parent / "tables.txt").open("w") as stream:
        _print(Console(file=stream, width=WIDTH), tables)
    for figure in line_patrol.figures(summaries, seeds):
        print(f"figure {_draw(figure, parent / f'{figure.name}.png')}")
    print(f"tables {parent / 'tables.txt'}\nruns   {parent}")
    return 0


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
