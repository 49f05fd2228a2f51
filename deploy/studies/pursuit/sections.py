"""Sections of the report: teams from every place, all runs by team, the referees, the letter, checks."""

from collections import Counter
from collections.abc import Iterable, Iterator

from deploy.markdown import spread, table
from deploy.metrics.clear import CAUSES
from deploy.studies.pursuit.literal import Letter, leaks, longest_line_m
from deploy.studies.pursuit.plan import Ground, places, polygon
from deploy.studies.pursuit.runs import Run, Runs

LEGEND = """Fewest: the smallest team with which the referee finds nothing left and the team says DONE, in
every run. Then what became of that team and of larger ones, for more robots are not always better: what the
team claimed (`done`, `failed`, `none` when time was up), when all was clear, or how much was left."""

AREAS = """Contaminated area that the raster referee (cells of 5 cm) sees above what the exact one sees, at
its most and least over all ticks of a run and on average, in square metres; of several runs the median, and
[smallest..largest]."""

LETTER = """As printed, a line asks for a search when its length exceeds r_all r_follow. Robots abreast have
one gap fewer than they are, so by then they stand r_all / (r_all - 1) r_follow apart; where this is more than
2 r_detect, the line is none. Ours: (r_all - 1) r_follow. Here a team goes abreast, evenly spaced, through a
room that widens, under the exact referee, until its line is as long as the letter allows."""


def of_place(runs: Runs, ground: Ground, follows: int = 3) -> str:
    """A row for each place: the fewest that clear, and what became of them and of the next larger teams."""
    rows = []
    for place, robots in enumerate(runs.fewest_of(ground), start=1):
        teams = runs.teams(ground, place)
        first = min(teams, default=0) if robots is None else robots
        shown = {size: each for size, each in teams.items() if size >= first}
        if robots is not None:
            shown = {size: each for size, each in shown.items() if size <= robots + follows}
        x_m, y_m = places(ground)[place - 1]
        outcomes = "; ".join(f"{size}: {_outcomes(each)}" for size, each in shown.items())
        told = "**none**" if robots is None else f"**{robots}**"
        rows.append((str(place), f"{x_m:.2f}, {y_m:.2f}", told, outcomes))
    return table(("place", "at, m", "fewest", "what became of teams"), rows)


def of_plans(runs: Runs, grounds: Iterable[Ground]) -> str:
    """A row for each plan: its size, and the fewest from place to place."""
    rows = []
    for ground in grounds:
        fewest = runs.fewest_of(ground)
        known = [one for one in fewest if one is not None]
        told = " ".join("-" if one is None else str(one) for one in fewest)
        best, worst = (str(each(known)) if known else "-" for each in (min, max))
        none = str(len(fewest) - len(known))
        rows.append((ground.name, f"{polygon(ground).area:.1f}", told, best, worst, none))
    headings = ("plan", "area, m2", "fewest by place", "best place", "worst", "places from where none clears")
    return table(headings, rows)


def by_team(runs: Runs, grounds: Iterable[Ground]) -> str:
    """A row for each number of robots: how runs ended, and what they took."""
    grounds = list(grounds)
    rows = []
    for robots in sorted({run.trial.robots for run in runs.all if run.trial.ground in grounds}):
        of_team = runs.of(grounds, robots)
        clearing = [run for run in of_team if run.clears]
        rows.append(
            (
                str(robots),
                f"{len(clearing)}/{len(of_team)} ({len(clearing) / len(of_team):.0%})",
                str(sum(run.metrics["claim"] == "failed" for run in of_team)),
                str(sum(run.metrics["claim"] == "none" for run in of_team)),
                spread([run.metrics["clear_time_s"] for run in clearing], 0),
                *(_count(clearing, name) for name in ("splits", "searches", "searches_failed")),
                _count(of_team, "robots_on_lines_peak"),
            )
        )
    ended = ("robots", "clear", "claim failed", "no claim")
    took = ("time to clear, s", "splits", "searches", "of them failed", "most on lines")
    return table((*ended, *took), rows)


def losses(runs: Runs, grounds: Iterable[Ground]) -> str:
    """Ground contaminated again, by class, and breaches."""
    grounds = list(grounds)
    rows = []
    for robots in sorted({run.trial.robots for run in runs.all if run.trial.ground in grounds}):
        of_team = runs.of(grounds, robots)
        lost = (spread([run.metrics["recontaminated_m2"][cause] for run in of_team], 2) for cause in CAUSES)
        breaches = sum(run.metrics["breaches"] for run in of_team)
        rows.append((str(robots), *lost, f"**{breaches}**" if breaches else "0"))
    return table(("robots", *(f"{cause}, m2" for cause in CAUSES), "breaches, all runs"), rows)


def referees(runs: Runs) -> Iterator[str]:
    """How far raster and exact differ."""
    yield AREAS
    rows = []
    for kind in dict.fromkeys(ground.kind for ground in runs.grounds):
        found = [run for run in runs.all if run.trial.ground.kind == kind]
        areas = zip(*((run.between.most_m2, run.between.least_m2, run.between.mean_m2) for run in found))
        rows.append((kind, str(len(found)), *(spread(each, 3) for each in areas)))
    yield table(("plan", "runs", "most, m2", "least", "mean"), rows)
    differ = [run.trial.name for run in runs.all if run.disagree]
    told = f"**They differ in {len(differ)}: {', '.join(differ)}.**" if differ else "They differ in none."
    yield f"Whether all is clear in the end, they were asked in {len(runs.all)} runs. {told}"


def letter(found: Letter) -> Iterator[str]:
    """Algorithm 1 as printed, beside our reading."""
    yield LETTER
    rows = []
    for one in found.teams:
        ours, printed = (
            one.at(longest_line_m(one.robots, found.follow_m, literal)) for literal in (False, True)
        )
        opened = one.lost_m2[: printed + 1].nonzero()[0]
        rows.append(
            (
                str(one.robots),
                f"{one.gap_m[ours]:.2f}",
                f"{one.contaminated_m2[ours]:.2f}",
                f"{one.lost_m2[: ours + 1].sum():.2f}",
                f"{one.gap_m[printed]:.2f}",
                f"{one.contaminated_m2[printed]:.2f}",
                f"**{one.lost_m2[: printed + 1].sum():.2f}**" if len(opened) else "0.00",
                f"{one.gap_m[opened[0]]:.2f}" if len(opened) else "holds",
                "leaks" if leaks(one.robots, found.follow_m, found.detect_m, literal=True) else "holds",
            )
        )
    ours = ("gap, m, ours", "contaminated, m2", "lost, m2")
    printed = ("gap, m, as printed", "contaminated, m2", "lost, m2", "first lost at gap, m")
    yield table(("robots", *ours, *printed, "by its formula"), rows)


def checks(runs: Runs) -> Iterator[str]:
    """What must never be: claims that are not true, breaches, deaths."""
    false = [run.trial.name for run in runs.all if run.is_false]
    yield f"**False claims (DONE while an intruder could be there): {len(false)} of {len(runs.all)} runs.**"
    breached = [run.trial.name for run in runs.all if run.metrics["breaches"]]
    yield f"**Runs with a breach: {len(breached)} of {len(runs.all)}.**"
    died = [run.trial.name for run in runs.all if run.deaths]
    yield f"**Runs in which a robot died by an error of its own: {len(died)} of {len(runs.all)}.**"
    words = Counter(words for run in runs.all for words in run.deaths)
    yield from (f"- {words} ({count} times)" for words, count in words.most_common(10))
    silent = [run.trial.name for run in runs.all if run.metrics["cleared"] and not run.clears]
    yield f"Clear in the end, but not claimed, or claimed too early: {len(silent)}."
    for words, names in (("False", false), ("Breached", breached), ("Died", died), ("Unclaimed", silent)):
        if names:
            yield f"{words}: {', '.join(names[:40])}{', ...' if len(names) > 40 else ''}"


def _count(runs: list[Run], name: str) -> str:
    return spread([run.metrics[name] for run in runs], 0)


def _outcomes(runs: list[Run]) -> str:
    if len(runs) == 1:
        return _outcome(runs[0])
    clear = sum(run.clears for run in runs)
    return f"{clear}/{len(runs)} clear ({', '.join(map(_outcome, runs))})"


def _outcome(run: Run) -> str:
    """What a team claimed, and what was true."""
    found = run.metrics
    left = f"{found['contaminated_area_m2'] or 0:.1f} m2 left"
    if run.is_false:
        said = f"**done, but {'too early' if found['cleared'] else left}**"
    elif run.clears:
        said = f"done {found['clear_time_s']:.0f} s"
    else:
        said = f"{found['claim']}, {'all clear' if found['cleared'] else left}"
    breaches = f", **breaches: {found['breaches']}**" if found["breaches"] else ""
    return said + breaches + (f", **died: {len(run.deaths)}**" if run.deaths else "")
