"""Sections of the report beside the comparison: few items, the paper's letter, failures, maps, checks."""

from collections.abc import Iterator

from deploy.markdown import spread, table
from deploy.studies.lr_pt.partition import partition_of
from deploy.studies.lr_pt.plan import MEMORIES
from deploy.studies.lr_pt.stability import COLUMNS, phases
from deploy.studies.outcomes import METRICS, Outcome, Outcomes
from deploy.studies.trial import Scale

KILLED = -9

READINGS = """`unsent`: the newest entries that some neighbour is not known to have. `newest`: the newest of
all, as printed; an entry that has dropped out of the newest eight is never said again."""

TOLD = """Does the tower hear of every visit in the end? The time from a visit until the tower knows of it,
or of a later one to the same cell, in seconds (not normalised; the worst counts visits still untold with
the time they have waited). Never told: cells with a visit that the tower does not know of at the end
although it is older than twice the worst SA delay of all trials with s = 400 of that N."""

LOCK = """As printed, two robots that meet at a cell hold the same table, choose alike and stay together.
Our default skips the goals that neighbours announce, which is a deviation from the paper; `none` is the
paper's letter."""

STRUCK = """The 20 % highest numbers are killed at a third of the run and started again at two thirds, with
the memory they had or with none. Always real processes and SIGKILL. Normalised by the robots that are
active; the beginning of each phase, as long as that left out of the metrics, is left out."""

SHARED = """LR-PT, seed 1. Overlap of two robots: the sum over cells of the smaller of their shares of
visits, mean over pairs. Variation of the sum over robots: standard deviation over mean. Reach: mean
distance of a robot's visits from the tower, lowest to highest of the team. In brackets: by chance, had
every visit been made by a robot, or at a cell, drawn at random."""

PRINTED = """The paper prints means as a sum over the ticks from t0 on, divided by T. We divide by the number
of terms. Read as printed, means are {factor:.4f} of ours:"""


def few_items(outcomes: Outcomes) -> Iterator[str]:
    """s = 8 in both readings beside s = 400, and whether the tower ever hears of every visit."""
    yield "## Eight items per second"
    yield READINGS
    yield _variants(outcomes, {"s = 400": "main", "s = 8, unsent": "s8", "s = 8, newest": "s8-newest"})
    rows = []
    for nodes in outcomes.sizes():
        longest_s = max(outcomes.values("worst_sa_delay_s", nodes), default=None)
        for words, kind in (("s = 400", "main"), ("s = 8, unsent", "s8"), ("s = 8, newest", "s8-newest")):
            trials = outcomes.of(kind, nodes=nodes)
            if trials and longest_s is not None:
                lost = [float(_untold(one, 2 * longest_s)) for one in trials]
                waits = (outcomes.values(name, nodes, kind=kind) for name in ("word_mean_s", "word_worst_s"))
                rows.append((str(nodes), words, *(spread(each, 0) for each in waits), spread(lost, 0)))
    yield TOLD
    yield table(("N", "items", "mean time to be told", "worst", "cells never told of"), rows)


def _untold(outcome: Outcome, older_than_s: float) -> int:
    """Cells with a visit so old that the tower has no word of at the end."""
    untold_tick = outcome.tables["untold_tick"]
    age_s = (outcome.summary["ticks"] - untold_tick) * outcome.scenario.tick_s
    return int(((untold_tick >= 0) & (age_s > older_than_s)).sum())


def literal(outcomes: Outcomes) -> Iterator[str]:
    """Without a lock breaker."""
    yield "## Taken literally"
    yield LOCK
    yield _variants(outcomes, {"default": "main", "lock_breaker = none": "literal"})


def _variants(outcomes: Outcomes, kinds: dict[str, str]) -> str:
    rows = []
    for nodes in outcomes.sizes():
        for words, kind in kinds.items():
            if trials := outcomes.of(kind, nodes=nodes):
                values = (outcomes.values(f"normalised_{name}", nodes, kind=kind) for name in METRICS)
                rows.append((str(nodes), words, *(spread(each) for each in values), str(len(trials))))
    return table(("N", "LR-PT", *METRICS.values(), "trials"), rows)


def failures(outcomes: Outcomes) -> Iterator[str]:
    """Means of the phases, and which processes were killed."""
    struck = [one for memory in MEMORIES for one in outcomes.of(f"failures-{memory}")]
    if not struck:
        return
    yield "## Failures"
    yield STRUCK
    rows, killed = [], []
    for one in struck:
        memory = one.trial.kind.removeprefix("failures-")
        for name, words in COLUMNS.items():
            found = phases(one, name)
            means = (f"{value:.1f}" for value in found)
            rows.append((str(one.trial.nodes), memory, words, *means, f"{100 * found.change:+.1f} %"))
        pids = [f"{it['node']} ({it['pid']})" for it in one.summary["processes"] if it["exit"] == KILLED]
        killed.append((str(one.trial.nodes), memory, ", ".join(pids) or "none"))
    headings = ("N", "memory", "normalised", "before, s", "during", "after", "largest change")
    yield table(headings, rows)
    yield table(("N", "memory", "processes that ended by SIGKILL (pid)"), killed)


def maps(outcomes: Outcomes) -> Iterator[str]:
    """Overlap, variation and reach of every first trial's maps."""
    rows = []
    for nodes in outcomes.sizes():
        for one in outcomes.of("main", nodes=nodes)[:1]:
            if (found := partition_of(one)) is not None:
                rows.append(
                    (
                        str(nodes),
                        f"{found.overlap:.2f} ({found.overlap_by_chance:.2f})",
                        f"{found.variation:.2f} ({found.variation_by_chance:.2f})",
                        f"{found.reach_m[0]:.0f} to {found.reach_m[1]:.0f} "
                        f"({found.reach_by_chance_m[0]:.0f} to {found.reach_by_chance_m[1]:.0f})",
                    )
                )
    yield "## Who visits what"
    yield SHARED
    yield table(("N", "overlap", "variation of the sum", "reach, m"), rows)


def checks(outcomes: Outcomes) -> Iterator[str]:
    """Equal hashes of rehearsals and processes, delays no shorter than idleness, deaths by nobody's plan."""
    rows = []
    mains = {_identity(one): one for one in outcomes.all if one.trial.kind == "main"}
    for one in (one for one in outcomes.all if one.trial.kind == "processes"):
        other = mains[_identity(one)]
        mine, theirs = one.summary["run_hash"], other.summary["run_hash"]
        rows.append((other.trial.name, theirs, mine, "yes" if mine == theirs else "**NO**"))
    if rows:
        yield "One trial of each algorithm was run a second time, as processes:"
        yield table(("trial", "run hash, rehearsed", "run hash, processes", "equal"), rows)
    wrong = [one.trial.name for one in outcomes.all if not _delays_follow_idleness(one)]
    right = f"{len(outcomes.all) - len(wrong)} of {len(outcomes.all)} trials"
    but = f"; not: {', '.join(wrong)}" if wrong else ""
    yield f"SA delay is never shorter than idleness (D_MSA >= I_G, D_WSA >= I_W): {right}{but}."
    died = [(one.trial.name, death) for one in outcomes.all for death in one.deaths]
    if died:
        yield f"**{len(died)} nodes died that nobody had planned to kill:**"
        rows = [(name, str(it["tick"]), it["node"], _last_line(it)) for name, it in died[:20]]
        yield table(("trial", "tick", "node", "last words"), rows)


def _identity(outcome: Outcome) -> tuple[str, int, int]:
    return outcome.trial.algorithm.name, outcome.trial.nodes, outcome.trial.seed


def _delays_follow_idleness(outcome: Outcome) -> bool:
    found = outcome.summary["metrics"]
    pairs = (("mean_sa_delay_s", "graph_idleness_s"), ("worst_sa_delay_s", "worst_idleness_s"))
    return all(found[delay] is None or found[delay] >= found[idleness] for delay, idleness in pairs)


def _last_line(death: dict) -> str:
    lines = death["data"].get("last_lines", "").strip().splitlines()
    return lines[-1] if lines else death["text"]


def as_printed(outcomes: Outcomes, scale: Scale) -> Iterator[str]:
    """The paper's formula divides by another number than it sums terms."""
    factor = (scale.duration_s - scale.metrics_from_s + 1) / scale.duration_s
    rows = [
        (str(nodes), label, *(f"{factor * value:.1f}" for value in values))
        for nodes in outcomes.sizes()
        for label, name in ((one.label, one.name) for one in outcomes.algorithms())
        if None
        not in (
            values := [
                outcomes.median(f"normalised_{metric}_s", nodes, name)
                for metric in ("graph_idleness", "mean_sa_delay")
            ]
        )
    ]
    yield "## For those who read values off the paper's figures"
    yield PRINTED.format(factor=factor)
    yield table(("N", "algorithm", "graph idleness, as printed", "mean SA delay, as printed"), rows)
