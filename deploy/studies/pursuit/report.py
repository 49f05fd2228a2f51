"""The report of the study, in Markdown: statements, the main plan, random plans, referees, the letter."""

from collections import Counter
from collections.abc import Iterable, Iterator
from datetime import datetime

from deploy.machine import describe
from deploy.markdown import table
from deploy.studies.pursuit import sections
from deploy.studies.pursuit.figures import kinds
from deploy.studies.pursuit.literal import Letter
from deploy.studies.pursuit.plan import Ground, polygon
from deploy.studies.pursuit.runs import Runs
from deploy.studies.verdict import Verdict, told
from wire.scenario import Scenario

QUICK = """> **THIS IS A QUICK RUN**, short, of few places and teams. It shows that everything works. Its
> numbers and verdicts say nothing about the paper; run it without `--quick` for those."""

ORIGIN = """What Kolling and Carpin (2010) ran, run again with Picket on other plans: theirs is not public.
`{main}` is {area_m2:.0f} m2 in {width_m:.1f} x {height_m:.1f} m. Robots see {detect_m:g} m far, stand at most
{follow_m:g} m apart, hear each other within {range_m:g} m, go {speed_m_s:g} m/s, and know neither map nor
position. They begin close together at one of {places} places, equally far apart along the wall and 0.4 m off
it, the first at the lower left, the others anticlockwise. Runs end with a claim or after {main_s:.0f} s
({main}) and {random_s} (random plans). Of several runs the median stands, and [smallest..largest]."""

MIXED = """**These runs are of several commits, so perhaps of several versions of the behaviour: begin afresh
in another folder (`--out`) to compare like with like.**"""

RANDOM = """Rooms in a grid, joined by corridors to a tree, and by one more for each island. Every team size
from every place; `-`: none of them clears."""

LOST = """Ground that became contaminated again, by its cause: a robot that died, ground given up on purpose
(`release`), a line that moved back (`retreat`), and the rest, which is always a defect (`breach`)."""

HOW = """{runs} runs, rehearsed (all minds in one process, same codec, same result), {hours:.1f} hours of
work. A row for each is in `runs.parquet`. They leave no journal, which would be large:
`picket run FOLDER/scenario.toml --in-process` gives it, and at the same commit the same `run_hash`."""


def write(
    runs: Runs,
    main: Ground,
    scenario: Scenario,
    judged: list[Verdict],
    letter: Letter,
    quick: bool,
    figures: Iterable[str],
) -> str:
    """The whole report; `scenario` is one of the main plan's."""
    shown = {name.removesuffix(".png"): f"![{name.removesuffix('.png')}]({name})" for name in figures}
    parts = [
        "# Pursuit-evasion without maps, run again",
        QUICK if quick else "",
        f"{datetime.now():%Y-%m-%d %H:%M}",
        table(("", ""), [*describe().items(), ("runs by commit", _commits(runs))]),
        MIXED if len({run.summary.get("commit") for run in runs.all}) > 1 else "",
        _origin(runs, main, scenario),
        "## What must never be",
        *sections.checks(runs),
        "## The paper's statements",
        told(judged),
        shown.get("success", ""),
        *_main(runs, main, shown),
        *_random(runs, shown),
        "## The two referees",
        *sections.referees(runs),
        shown.get("areas", ""),
        "## Algorithm 1 to the letter",
        *sections.letter(letter),
        shown.get("letter", ""),
        "## How this was run",
        HOW.format(runs=len(runs.all), hours=sum(run.summary["wall_s"] for run in runs.all) / 3600),
        *_every_plan(runs, main),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _origin(runs: Runs, main: Ground, scenario: Scenario) -> str:
    west_m, south_m, east_m, north_m = polygon(main).bounds
    random_s = sorted({f"{ground.duration_s:.0f} s" for ground in runs.grounds if ground.random})
    return ORIGIN.format(
        main=main.name,
        area_m2=polygon(main).area,
        width_m=east_m - west_m,
        height_m=north_m - south_m,
        detect_m=scenario.sensors.detect_m,
        follow_m=scenario.robots.parameters["follow_m"],
        range_m=min(rule.range_m for rule in scenario.radio.rules),
        speed_m_s=scenario.robots.max_speed_m_s,
        places=main.places,
        main_s=main.duration_s,
        random_s=", ".join(random_s) or "none",
    )


def _main(runs: Runs, main: Ground, shown: dict[str, str]) -> Iterator[str]:
    yield f"## {main.name}"
    known = [one for one in runs.fewest_of(main) if one is not None]
    if known:
        none = main.places - len(known)
        spread = f"It takes {min(known)} from the best place and {max(known)} from the worst"
        yield f"{spread}; from {none} of {main.places} places no team clears." if none else f"{spread}."
    yield sections.LEGEND
    yield sections.of_place(runs, main)
    yield shown.get("places", "")
    yield sections.by_team(runs, [main])
    yield LOST
    yield sections.losses(runs, [main])


def _random(runs: Runs, shown: dict[str, str]) -> Iterator[str]:
    of_kind = {kind: each for kind, each in kinds(runs).items() if each[0].random}
    if not of_kind:
        return
    yield "## Random plans"
    yield RANDOM
    yield sections.of_plans(runs, [ground for each in of_kind.values() for ground in each])
    yield shown.get("plans", "")
    for kind, grounds in of_kind.items():
        yield f"### {kind}: {len(grounds)} plans"
        yield sections.by_team(runs, grounds)
        yield sections.losses(runs, grounds)
    yield shown.get("runs", "")


def _every_plan(runs: Runs, main: Ground) -> Iterator[str]:
    """At the end, for it is long."""
    others = [ground for ground in runs.grounds if ground != main]
    if others:
        yield "## Every random plan, every place"
        yield sections.LEGEND
    for ground in others:
        yield f"### {ground.name}"
        yield sections.of_place(runs, ground)


def _commits(runs: Runs) -> str:
    found = Counter(run.summary.get("commit") or "unknown" for run in runs.all)
    return ", ".join(f"{name}: {count}" for name, count in found.most_common())
