"""Each statement of the paper's section V beside what was measured, and by which rule it counts.

Source: papers/pursuit-evasion.txt, section V. Its numbers are of one bitmap that is not public, so they
cannot be tested; ours on the shipped plan of the same size stand beside them. What it says of plans in
general can be.
"""

from collections import Counter
from collections.abc import Iterator

from deploy.studies.pursuit.plan import Ground
from deploy.studies.pursuit.runs import Run, Runs
from deploy.studies.verdict import Verdict, Word

NOT_PUBLIC = "the paper's bitmap is not public: ours is another plan of the same size"
MOSTLY = 0.5
"""`Differs`: in at least this part of what can be compared."""


def verdicts(runs: Runs, main: Ground) -> list[Verdict]:
    """All statements, in the paper's order; `main` stands for the paper's plan."""
    fewest = [one for one in runs.fewest_of(main) if one is not None]
    of_places = f"on {main.name}, by place: {', '.join(_told(runs.fewest_of(main)))} robots"
    best = f"from the best place {min(fewest)}" if fewest else "from no place"
    return [
        Verdict("9 robots clear the plan from the bottom", of_places, "not testable", NOT_PUBLIC),
        Verdict(
            "8 robots from there fail at the first obstacle search",
            _one_fewer(runs, main),
            "not testable",
            NOT_PUBLIC,
        ),
        Verdict("8 robots clear it from the top right", f"{best}", "not testable", NOT_PUBLIC),
        Verdict(
            "7 robots from there clear it in one of three trials",
            _mixed(runs, main),
            "not testable",
            NOT_PUBLIC,
        ),
        Verdict(
            "7 robots are enough with a map, so not knowing it costs two",
            f"{best}; no planner that is given the map is part of this study",
            "not testable",
            NOT_PUBLIC,
        ),
        _place_matters(runs, main),
        _search_fails(runs, main),
        _anywhere(runs, main),
        _other_graph(runs, main),
        _cycles(runs),
    ]


def _told(fewest: list[int | None]) -> Iterator[str]:
    return ("none" if one is None else str(one) for one in fewest)


def _too_few(runs: Runs, main: Ground) -> list[Run]:
    """From each place the runs with one robot fewer than it takes."""
    return [
        run
        for place, robots in enumerate(runs.fewest_of(main), start=1)
        if robots is not None
        for run in runs.teams(main, place).get(robots - 1, [])
    ]


def _one_fewer(runs: Runs, main: Ground) -> str:
    found = _too_few(runs, main)
    claims = Counter(run.metrics["claim"] for run in found if not run.clears)
    ends = ", ".join(f"{count} ended with claim {claim}" for claim, count in sorted(claims.items()))
    return f"{len(found)} runs with one robot fewer than it takes: {ends or 'none that did not clear'}"


def _mixed(runs: Runs, main: Ground) -> str:
    """Places and teams of which some runs clear, and some do not."""
    groups = [
        teams for place in range(1, main.places + 1) for teams in runs.teams(main, place).values() if teams
    ]
    repeated = [group for group in groups if len(group) > 1]
    if not repeated:
        return "one run of each kind: see --trials"
    mixed = [group for group in repeated if 0 < sum(run.clears for run in group) < len(group)]
    return f"some runs clear and some do not, of {len(mixed)} of {len(repeated)} teams and places"


def _place_matters(runs: Runs, main: Ground) -> Verdict:
    """Nine from the bottom, eight from the top right."""
    found = runs.fewest_of(main)
    known = [one for one in found if one is not None]
    word: Word = "not testable"
    if len(found) > 1 and known:
        word = "reproduced" if len(set(found)) > 1 else "not reproduced"
    return Verdict(
        "how many robots it takes depends on where they begin",
        f"by place: {', '.join(_told(found))}",
        word,
        f"the smallest team that clears {main.name} is not the same from every place",
    )


def _search_fails(runs: Runs, main: Ground) -> Verdict:
    found = [run for run in _too_few(runs, main) if not run.clears]
    failed = sum(run.metrics["searches_failed"] > 0 for run in found)
    word: Word = "not testable"
    if found:
        word = "reproduced" if failed == len(found) else "direction only" if failed else "not reproduced"
    return Verdict(
        "with a robot too few an obstacle search fails",
        f"in {failed} of {len(found)} runs with one robot fewer than it takes",
        word,
        "in all of them a search failed; direction only: in some",
    )


def _anywhere(runs: Runs, main: Ground) -> Verdict:
    """`It is hence possible to clear [it] with 7 robots if one resets the starting position`."""
    known = [one for one in runs.fewest_of(main) if one is not None]
    places, enough, word = range(1, main.places + 1), 0, "not testable"
    if known and main.places > 1:
        teams = [runs.teams(main, place).get(min(known), []) for place in places]
        enough = sum(bool(each) and all(run.clears for run in each) for each in teams)
        word = "reproduced" if enough == main.places else "direction only" if enough > 1 else "not reproduced"
    return Verdict(
        "who begins again elsewhere clears from anywhere with as few as from the best place",
        f"with {min(known) if known else '-'} robots from {enough} of {main.places} places",
        word,
        "from all places; direction only: from more than one",
    )


def _other_graph(runs: Runs, main: Ground) -> Verdict:
    """Figures 6 and 7."""
    differ, pairs = 0, 0
    for place in range(1, main.places + 1):
        clearing = [each[0] for each in runs.teams(main, place).values() if each[0].clears]
        for smaller, larger in zip(clearing, clearing[1:], strict=False):
            pairs += 1
            differ += smaller.metrics["graph"] != larger.metrics["graph"]
    word: Word = "not testable"
    if pairs:
        share = differ / pairs
        word = "reproduced" if share >= MOSTLY else "direction only" if differ else "not reproduced"
    return Verdict(
        "with more robots the exploration proceeds differently, and the graph differs",
        f"{differ} of {pairs} pairs of teams from one place, the next larger that clears beside the smaller",
        word,
        f"graphs of other sizes in at least {MOSTLY:.0%} of pairs; direction only: in some",
    )


def _cycles(runs: Runs) -> Verdict:
    grounds = [one for one in runs.grounds if one.random is not None and one.random.islands]
    cleared = 0
    for ground in grounds:
        clearing = [run for run in runs.all if run.trial.ground == ground and run.clears]
        cleared += any(run.metrics["graph"]["cycle_edges"] == ground.random.islands for run in clearing)
    word: Word = "not testable"
    if grounds:
        every = cleared == len(grounds)
        word = "reproduced" if every else "direction only" if cleared else "not reproduced"
    return Verdict(
        "the algorithm can deal with cycles, and the graph receives a cycle for each",
        f"{cleared} of {len(grounds)} plans with islands",
        word,
        "every one cleared by some team, its graph with as many cycle edges as islands; direction only: some",
    )
