"""`picket reproduce graphs`: the classic patrol rules on patrol graphs, by the metrics of patrolling_sim.

Source: Portugal and Rocha's patrolling_sim, whose monitor's metrics are in deploy/metrics/intervals.py, and
whose robots hear each other everywhere: so here. Ours: robots start at nodes drawn by the trial's seed, all
at 1 m/s, turning takes no time, and nobody waits at a node; the first part of a trial is left out.
"""

import argparse
import json
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

import numpy as np
from matplotlib import pyplot
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from deploy.campaign import INTERRUPTED, Campaign, make_folder
from deploy.machine import describe
from deploy.markdown import spread, table
from deploy.scenario_file import SHIPPED, ScenarioError, load_scenario
from deploy.studies.boxes import STYLE, by_algorithm, draw_boxes
from deploy.studies.outcomes import Outcome, Outcomes, collect, save
from deploy.studies.trial import Algorithm, Trial, guest

RULES = (
    Algorithm("random", "random", "random", {}),
    Algorithm("conscientious_reactive", "CR", "conscientious_reactive", {}),
    Algorithm("heuristic_conscientious_reactive", "HCR", "heuristic_conscientious_reactive", {}),
    Algorithm("gbs", "GBS", "gbs", {}),
    Algorithm("sebs", "SEBS", "sebs", {}),
    Algorithm("expected_reactive", "ER", "expected_reactive", {}),
    Algorithm("dtag", "DTAG", "dtag", {}),
    Algorithm("dtap", "DTAP", "dtap", {}),
)
TEAMS = (2, 4, 8)
FULL, QUICK = (1800.0, 300.0, 3), (300.0, 60.0, 2)
"""Duration and beginning of the metrics in seconds, and trials."""
EVERYWHERE = 'radio.rules=[{kind = "range", range_m = 1e6}]'
BASE, OWN_MAP = "graph-grid", "grid"
PANELS = {
    "graph_idleness_s": "Graph idleness, mean over time",
    "node_interval_mean_s": "Interval between visits, mean over nodes",
    "node_interval_worst_mean_s": "Interval between visits, mean of the worst node",
    "node_interval_max_s": "Longest interval between visits",
}
COLUMNS = {
    "graph_idleness_s": "idleness",
    "node_interval_mean_s": "interval",
    "node_interval_worst_mean_s": "worst",
    "node_interval_max_s": "longest",
    "visits": "visits",
}

ORIGIN = """Trials of {duration_s:.0f} s, metrics from {from_s:.0f} s on; robots start at nodes drawn by
the seed, hear each other everywhere, go 1 m/s, need no time to turn and do not wait at nodes. Of several
trials the median stands, and [smallest..largest], in seconds. Idleness: graph idleness, mean over time.
Intervals and visits are those of patrolling_sim's monitor, which counts closed intervals between visits of
a node. Interval: mean over nodes of a node's mean; worst: the largest such mean; longest: of all. Per
visit: interval x robots / nodes, about the time between two visits of one robot; it says how fast robots
drive, idleness how well they share.

Two robots in one tick at one node count as two visits, an interval of 0 between them. On a map with edges
of one length robots stay in step, and those that meet and decide by the same rule on the same news stay
together: a small mean interval beside a large graph idleness is this."""


def reproduce(given: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code. Raises RunError, ScenarioError, SweepError."""
    duration_s, from_s, count = QUICK if given.quick else FULL
    rules = list(RULES)
    for behaviour in given.behaviours:
        rules.append(guest(behaviour, rules))
    found = trials(given.files, rules, given.trials or count, duration_s, from_s)
    folder = make_folder(given.out, "graphs-quick" if given.quick else "graphs")
    summaries = Campaign({one.name: one.scenario() for one in found}, folder).run()
    if summaries is None:
        return INTERRUPTED
    outcomes = collect(found, summaries, folder)
    save(outcomes, folder / "trials.parquet")
    maps = list(dict.fromkeys(one.kind for one in found))
    for name in maps:
        _draw(outcomes, name, folder / f"{name}.png")
        _print(outcomes, name)
    title = "# Patrol rules on graphs" + (
        "\n\n> **THIS IS A QUICK RUN**, short and of few trials." * given.quick
    )
    parts = [title, f"{datetime.now():%Y-%m-%d %H:%M}", table(("", ""), describe().items())]
    parts.append(ORIGIN.format(duration_s=duration_s, from_s=from_s))
    parts += [
        f"## {name}\n\n{table(HEADINGS, rows(outcomes, name))}\n\n![{name}]({name}.png)" for name in maps
    ]
    (folder / "report.md").write_text("\n\n".join(parts) + "\n", "utf-8")
    print(f"report {folder / 'report.md'}\ntrials {folder / 'trials.parquet'}")
    return 0


def trials(
    files: Sequence[Path], rules: Sequence[Algorithm], count: int, duration_s: float, from_s: float
) -> list[Trial]:
    """Every rule, map, team and seed, a whole comparison after each seed. Raises ScenarioError.

    Teams larger than the map has nodes are left out.
    """
    names = [one.stem for one in files] or [OWN_MAP]
    for name in names:
        if names.count(name) > 1:
            raise ScenarioError(f"{name}: there are two maps of this name; rename a file")
    graphs = [f"field.graph={json.dumps(str(one))}" for one in files] or [""]
    nodes = [len(load_scenario(SHIPPED / f"{BASE}.toml", _given(one)).field.nodes_m) for one in graphs]
    return [
        _trial(name, graph, sites, rule, team, seed, (f"duration_s={duration_s}", f"metrics_from_s={from_s}"))
        for seed in range(1, count + 1)
        for name, graph, sites in zip(names, graphs, nodes, strict=True)
        for team in TEAMS
        if team <= sites
        for rule in rules
    ]


def _given(graph: str) -> list[str]:
    """Settings for a map, none for the scenario's own; its start may have nodes that the map has not."""
    return [graph, "robots.start=[0]"] if graph else []


def _trial(
    name: str, graph: str, sites: int, rule: Algorithm, team: int, seed: int, times: tuple[str, ...]
) -> Trial:
    chance = np.random.Generator(np.random.Philox(seed))  # the same start for every rule
    start = chance.choice(sites, team, replace=False).tolist()
    settings = (
        *_given(graph),
        f"seed={seed}",
        f"robots.behaviour={json.dumps(rule.behaviour)}",
        f"robots.start={json.dumps(start)}",
        EVERYWHERE,
        *times,
    )
    return Trial(f"{name}-{rule.name}-r{team}-seed{seed}", name, rule, team + 1, seed, False, BASE, settings)


HEADINGS = ("robots", "rule", *COLUMNS.values(), "per visit", "trials")


def rows(outcomes: Outcomes, name: str) -> list[tuple[str, ...]]:
    """The table of a map: a row for each team and rule."""
    found = []
    for nodes in outcomes.sizes():
        for rule in outcomes.algorithms():
            if each := outcomes.of(name, rule.name, nodes):
                values = [
                    spread(outcomes.values(one, nodes, rule.name, name), 0 if one == "visits" else 1)
                    for one in COLUMNS
                ]
                per_visit = [one for one in map(_per_visit_s, each) if one is not None]
                found.append((str(nodes - 1), rule.label, *values, spread(per_visit), str(len(each))))
    return found


def _per_visit_s(outcome: Outcome) -> float | None:
    interval_s = outcome.summary["metrics"]["node_interval_mean_s"]
    return None if interval_s is None else interval_s * outcome.share


def _draw(outcomes: Outcomes, name: str, path: Path) -> None:
    with pyplot.rc_context(STYLE):
        boxes = by_algorithm(outcomes, name, PANELS)
        draw_boxes(f"Patrol rules on {name}", boxes, PANELS, path, lambda nodes: f"{nodes - 1} robots")


def _print(outcomes: Outcomes, name: str) -> None:
    printed = Table(title=f"{name}: medians and ranges in seconds", title_justify="left")
    for heading in HEADINGS:
        printed.add_column(heading)
    for row in rows(outcomes, name):
        printed.add_row(*map(escape, row))
    Console().print(printed)
