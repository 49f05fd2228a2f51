"""The polyline patrol of the paper: teams of 6, 8 and 10 robots under every rule, its tables beside ours.

Source: papers/line-patrol.txt, sections IV and V, Tables I and II, Figures 5 and 6. The paper has no numbers
for its figures, and one run of each kind; ours are means over seeds.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from deploy.metrics.line import LineMetrics
from deploy.scenario_file import find_scenario, load_scenario
from deploy.studies import Bars, Summaries, Table, mean, number, spread
from wire.line import Line
from wire.scenario import Scenario
from world_server.journal import commits

TEAMS = {"6/4": "line-6r4s", "8/6": "line-8r6s", "10/6": "line-10r6s"}
RULES = ("base", "proactive", "leapfrog", "leapfrog+proactive")
LAPS_S = {
    "base": "19.22 ± 1.27 (8/6); 19.60 ± 4.84 (6/4, robots)",
    "proactive": "18.90 ± 3.53",
    "leapfrog": "18.65 ± 1.44",
    "leapfrog+proactive": "19.44 ± 3.05",
}
IDLE = {
    ("6/4", "base"): "24.8 % (robots), 35 % with the failed one",
    ("8/6", "base"): "34.2 %, 12.2 % restructured",
    ("8/6", "proactive"): "11.3 %",
}


def jobs(seeds: int, hours: float) -> dict[str, Scenario]:
    """Every run of the study, by name."""
    return {
        name_of(team, rule, seed): scenario_of(team, rule, seed, hours)
        for team in TEAMS
        for rule in RULES
        for seed in range(1, seeds + 1)
    }


def name_of(team: str, rule: str, seed: int) -> str:
    """The folder of one run."""
    return f"{TEAMS[team]}-{rule}-seed{seed}"


def scenario_of(team: str, rule: str, seed: int, hours: float, *settings: str) -> Scenario:
    """A team under a rule. Where the tower recalls nobody, robots go home at its threshold by themselves."""
    by_tower = rule.endswith("proactive")
    home = [] if by_tower else ["robots.parameters.home_v=8.5"]
    given = [
        f"seed={seed}",
        f"duration_s={hours * 3600}",
        f'tower.parameters.rule="{rule}"',
        *home,
        *settings,
    ]
    return load_scenario(find_scenario(TEAMS[team]), given)


def tables(summaries: Summaries, seeds: int, parent: Path) -> list[Table]:
    """Everything the paper reports, and recovery by the distance of the segment."""
    metrics = _by_run(summaries, seeds)
    return [
        _laps(metrics),
        _idle(metrics),
        _returns(metrics),
        _deployment(metrics),
        _intervals(metrics),
        _criteria(metrics),
        _recovery(seeds, parent),
        _losses(metrics),
    ]


def figures(summaries: Summaries, seeds: int) -> list[Bars]:
    """The paper's Figures 5 and 6."""
    metrics = _by_run(summaries, seeds)
    rules = [one for one in RULES if one != "base"]
    idle = {rule: [_percent(one["idle_share"]) for one in metrics["10/6", rule]] for rule in rules}
    fifth = Bars(
        "figure-5",
        "Time spent idle, 10 robots on 6 segments (Fig. 5)",
        "%",
        ("idle",),
        {rule: (mean(values),) for rule, values in idle.items()},
        {rule: (spread(values),) for rule, values in idle.items()},
    )
    segments = tuple(metrics["10/6", "base"][0]["visit_interval_s"])
    sixth = Bars(
        "figure-6",
        "Longest time between visits to the outer end of each segment, 10 robots on 6 segments (Fig. 6)",
        "s",
        tuple(f"segment {one}" for one in segments),
        {rule: tuple(_outer(metrics, rule, one, "max") for one in segments) for rule in RULES},
        {},
    )
    return [fifth, sixth]


def _by_run(summaries: Summaries, seeds: int) -> dict[tuple[str, str], list[dict[str, Any]]]:
    return {
        (team, rule): [summaries[name_of(team, rule, seed)]["metrics"] for seed in range(1, seeds + 1)]
        for team in TEAMS
        for rule in RULES
    }


Metrics = dict[tuple[str, str], list[dict[str, Any]]]


def _laps(metrics: Metrics) -> Table:
    rows = tuple(
        (rule, *(_mean_and_sd(metrics[team, rule], "lap_time") for team in TEAMS), LAPS_S[rule])
        for rule in RULES
    )
    remark = "Ours: T = 8 s and c = 2 s for half a turn, so a lap takes 20 s, and with noise a little more."
    return Table("Lap time in s, mean ± sd (Tables I and II)", ("rule", *TEAMS, "paper"), rows, remark)


def _idle(metrics: Metrics) -> Table:
    rows = []
    for team in TEAMS:
        robots, segments = (int(one) for one in team.split("/"))
        expected = number(100 * (robots - segments) / robots, 1, " %")
        for rule in RULES:
            share = mean([_percent(one["idle_share"]) for one in metrics[team, rule]])
            paper = IDLE.get((team, rule), "Fig. 5: rules alike" if team == "10/6" else "-")
            rows.append((team, rule, number(share, 1, " %"), expected, paper))
    headings = ("team", "rule", "ours", "(r - s)/r", "paper")
    return Table("Idle share (Table I, section V, Fig. 5)", headings, tuple(rows))


def _returns(metrics: Metrics) -> Table:
    def mean_of(team: str, leap: bool) -> float | None:
        rules = [one for one in RULES if ("leapfrog" in one) == leap]
        return mean([one["return_time_mean_s"] for rule in rules for one in metrics[team, rule]])

    rows = []
    for team in TEAMS:
        shifting, leaping = mean_of(team, leap=False), mean_of(team, leap=True)
        ratio = shifting / leaping if shifting is not None and leaping else None
        paper = "65, 47, 1.38" if team == "10/6" else "-"
        rows.append((team, number(shifting), number(leaping), number(ratio, 2), paper))
    headings = ("team", "with shifting", "leap-frog", "ratio", "paper")
    remark = "Ways, and so times, are ours; the paper's ratio should show."
    return Table("Return time in s (section V-B)", headings, tuple(rows), remark)


def _deployment(metrics: Metrics) -> Table:
    values = {team: mean([one["deployment_s"] for one in metrics[team, "base"]]) for team in TEAMS}
    rows = tuple(
        (team, number(value), "195 (simulated), 210 (robots)" if team == "6/4" else "-")
        for team, value in values.items()
    )
    return Table("Deployment time in s (section V-A)", ("team", "ours", "paper"), rows)


def _intervals(metrics: Metrics) -> Table:
    rows = []
    for segment in metrics["10/6", "base"][0]["visit_interval_s"]:
        cells = [
            f"{number(_outer(metrics, rule, segment, 'mean'), 2)} / "
            + number(_outer(metrics, rule, segment, "max"), 0)
            for rule in RULES
        ]
        rows.append((segment, *cells))
    remark = "The paper says that leap-frog has shorter intervals, and gives no numbers."
    title = "Time between visits to the outer end in s, mean / longest, 10/6 (Fig. 6)"
    return Table(title, ("segment", *RULES), tuple(rows), remark)


def _outer(metrics: Metrics, rule: str, segment: str, what: str) -> float | None:
    runs = metrics["10/6", rule]
    end = "end_left" if int(segment) <= len(runs[0]["visit_interval_s"]) / 2 else "end_right"
    return mean([one["visit_interval_s"][segment][end][what] for one in runs])


def _criteria(metrics: Metrics) -> Table:
    rows = []
    for team in TEAMS:
        for rule in RULES:
            values = [one["visit_frequency_hz"] for one in metrics[team, rule]]
            cells = [mean([one[name] for one in values]) for name in ("variance", "mean", "min")]
            rows.append(
                (team, rule, *(f"{1e3 ** (2 if n == 0 else 1) * one:.3f}" for n, one in enumerate(cells)))
            )
    headings = ("team", "rule", "variance", "mean", "minimum")
    return Table(
        "Frequency of visits in mHz: uniformity, average, minimum (section III-B)", headings, tuple(rows)
    )


def _recovery(seeds: int, parent: Path) -> Table:
    """Minimum, median and maximum from a vacancy to the first traverse, by distance from the tower."""
    rows = []
    for team in TEAMS:
        for rule in RULES:
            found: dict[int, list[float]] = {}
            for seed in range(1, seeds + 1):
                collect_recoveries(parent / name_of(team, rule, seed), found)
            cells = [_range(found.get(one, [])) for one in (1, 2, 3)]
            rows.append((team, rule, *cells))
    headings = ("team", "rule", "nearest the tower", "second", "third")
    remark = (
        "The paper: T to 3 T, here 8 to 24 s, and what it takes to get there. To the first whole traverse."
    )
    title = "Recovery in s, min / median / max (vacancies), by distance from the tower (section III-B)"
    return Table(title, headings, tuple(rows), remark)


def collect_recoveries(folder: Path, found: dict[int, list[float]]) -> None:
    """Add the recovery times of a run, in seconds, by how many segments from the tower, 1 the nearest."""
    scenario = load_scenario(folder / "scenario.toml")
    line = Line(scenario.field, (scenario.tower.x_m, scenario.tower.y_m))
    metrics = LineMetrics(scenario)
    for commit in commits(folder / "journal"):
        metrics.feed(commit.facts)
    for one in metrics.vacancies:
        if one.covered_tick is not None:
            away = len(line.inward(one.segment)) + 1
            found.setdefault(away, []).append((one.covered_tick - one.began_tick) * scenario.tick_s)


def _losses(metrics: Metrics) -> Table:
    names = ("recalls", "away_most", "flat_robots", "incidents")
    fold: dict[str, Callable[[list[Any]], Any]] = {"away_most": max}
    rows = tuple(
        (team, rule, *(str(fold.get(name, sum)([one[name] for one in runs])) for name in names))
        for (team, rule), runs in metrics.items()
    )
    headings = ("team", "rule", "recalls", "away at once", "flat", "incidents")
    return Table("Recalls and losses, all seeds together", headings, rows)


def _mean_and_sd(runs: list[dict[str, Any]], what: str) -> str:
    return f"{number(mean([one[f'{what}_mean_s'] for one in runs]), 2)} ± " + number(
        mean([one[f"{what}_sd_s"] for one in runs]), 2
    )


def _range(values: list[float]) -> str:
    if not values:
        return "-"
    values = sorted(values)
    return f"{values[0]:.0f} / {values[len(values) // 2]:.0f} / {values[-1]:.0f} ({len(values)})"


def _percent(share: float | None) -> float | None:
    return None if share is None else 100 * share
