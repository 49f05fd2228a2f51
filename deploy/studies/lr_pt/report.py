"""The report of the study, in Markdown: what was run, what came out, and what of the paper that bears out."""

from collections import Counter
from collections.abc import Iterable, Iterator
from datetime import datetime

from deploy.machine import describe
from deploy.markdown import spread, table
from deploy.studies.lr_pt import sections
from deploy.studies.outcomes import METRICS, Outcomes
from deploy.studies.trial import Scale
from deploy.studies.verdict import Verdict, told

QUICK = """> **THIS IS A QUICK RUN.** Trials are {duration_s:.0f} s long instead of 43200 s, and few. It shows
> that everything works. Its numbers and verdicts say nothing about the paper; run it without `--quick` for
> those."""

ORIGIN = """What Kobayashi, Kobayashi, Ueno and Higuchi (2025) ran, run again with Picket: 20 x 20 cells of
30 m, a base station in the corner, radio to 180 m, one second per tick, trials of {duration_s:.0f} s of which
the metrics leave out the first {from_s:.0f} s. N counts the base station. Seconds are normalised by
(N - 1) / 400 unless it says otherwise; of several trials the median stands, and [smallest..largest]. ER, DTAP
and chain connected are our implementations; parameters of every trial are in `trials.parquet`. A worst value
of {never} says that some cell was never visited, or never told of."""

HOW = """{rehearsed} trials were rehearsed (all minds in one process, same codec, same result), {processes}
ran as one operating system process per node. Rehearsed trials leave no journal, which would be large:
`picket run FOLDER/scenario.toml --in-process` gives it, and at the same commit the same `run_hash`."""


def write(outcomes: Outcomes, judged: list[Verdict], scale: Scale, quick: bool, figures: list[str]) -> str:
    """The whole report."""
    parts = ["# LR-PT and others, run again"]
    if quick:
        parts.append(QUICK.format(duration_s=scale.duration_s))
    parts += [
        f"{datetime.now():%Y-%m-%d %H:%M}",
        table(("", ""), [*describe().items(), ("trials by commit", _commits(outcomes))]),
        ORIGIN.format(duration_s=scale.duration_s, from_s=scale.metrics_from_s, never=_never(outcomes)),
        "## The paper's claims",
        told(judged),
        "## All algorithms",
        comparison(outcomes, outcomes.sizes()),
        *_pictures(figures, "comparison"),
        *sections.few_items(outcomes),
        *_pictures(figures, "bandwidth"),
        *sections.literal(outcomes),
        *_pictures(figures, "literal"),
        *sections.failures(outcomes),
        *_pictures(figures, "failures"),
        *sections.maps(outcomes),
        *_pictures(figures, "visits"),
        "## How the trials were run",
        HOW.format(**{"rehearsed": 0, "processes": 0} | Counter(one.how for one in outcomes.all)),
        *sections.checks(outcomes),
        *sections.as_printed(outcomes, scale),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def comparison(outcomes: Outcomes, sizes: Iterable[int]) -> str:
    """One row for each algorithm and size."""
    rows = []
    for nodes in sizes:
        for one in outcomes.algorithms():
            trials = outcomes.of("main", one.name, nodes)
            if trials:
                values = (outcomes.values(f"normalised_{name}", nodes, one.name) for name in METRICS)
                rows.append((str(nodes), one.label, *(spread(each) for each in values), str(len(trials))))
    return table(("N", "algorithm", *METRICS.values(), "trials"), rows)


def _never(outcomes: Outcomes) -> str:
    """The length of the whole run, normalised, by size."""
    lengths_s = {one.trial.nodes: one.scenario.duration_s * one.share for one in outcomes.of("main")}
    return ", ".join(f"{value:.0f} (N = {nodes})" for nodes, value in lengths_s.items()) or "the whole run"


def _commits(outcomes: Outcomes) -> str:
    found = Counter(one.summary.get("commit") or "unknown" for one in outcomes.all)
    return ", ".join(f"{name}: {count}" for name, count in found.most_common())


def _pictures(figures: Iterable[str], beginning: str) -> Iterator[str]:
    """The figures whose name begins so; `failures` has its maps with it."""
    return (f"![{name.removesuffix('.png')}]({name})" for name in figures if name.startswith(beginning))
