"""Each claim of the paper beside what was measured, and by which rule it counts as reproduced.

Source: Kobayashi et al. 2025, sections V-B to V-F; it has figures and words but no tables of values, so its
claims are of differences and shapes. Every number here is computed from the trials; medians over trials.
"""

import math
import statistics
from collections.abc import Iterator

from deploy.studies.lr_pt.partition import APART, VARIATION, Partition, partition_of
from deploy.studies.lr_pt.plan import MEMORIES
from deploy.studies.lr_pt.stability import COLUMNS, STABLE, phases
from deploy.studies.outcomes import Outcomes
from deploy.studies.verdict import Verdict, Word
from wire.scenario import Range, Scenario

CONSTANT = 0.10
"""`About constant` in N: largest over smallest at most so much above 1."""
SLIGHT = 0.25
"""A `slight` rise: above 0 and at most so much."""
NEAR = 0.10
"""A published change counts as met within so much of it, in parts of the value at s = 400."""
UNCHANGED = 0.05
"""`About unchanged`: at most so much up or down."""

IDLENESS = ("normalised_graph_idleness_s", "normalised_worst_idleness_s")
AWARENESS = ("normalised_mean_sa_delay_s", "normalised_worst_sa_delay_s")
SYMBOLS = dict(zip((*IDLENESS, *AWARENESS), ("I_G", "I_W", "D_MSA", "D_WSA"), strict=True))


def verdicts(outcomes: Outcomes) -> list[Verdict]:
    """All claims, in the paper's order."""
    return [
        _lower(outcomes, "normalised_graph_idleness_s", "dtap", 0.20, 0.30),
        _lower(outcomes, "normalised_worst_idleness_s", "dtap", 0.15, 0.20),
        _second_best(outcomes),
        _others_know_less(outcomes),
        *_chain(outcomes),
        _constant(outcomes, "normalised_graph_idleness_s"),
        _slight_rise(outcomes, "normalised_worst_idleness_s"),
        *(_slight_rise(outcomes, metric) for metric in AWARENESS),
        _bandwidth_idleness(outcomes),
        _bandwidth_small_teams(outcomes),
        _bandwidth_awareness(outcomes, "normalised_mean_sa_delay_s", 0.15),
        _bandwidth_awareness(outcomes, "normalised_worst_sa_delay_s", 0.10),
        *(_stable(outcomes, memory) for memory in MEMORIES),
        *_partition(outcomes),
    ]


def changes(
    outcomes: Outcomes, metric: str, of: tuple[str, str], against: tuple[str, str]
) -> dict[int, float]:
    """By team size, by what part a median lies above (+) or below (-) another; each is (kind, algorithm)."""
    found = {}
    for nodes in outcomes.sizes():
        value = outcomes.median(metric, nodes, of[1], of[0])
        base = outcomes.median(metric, nodes, against[1], against[0])
        if value is not None and base:
            found[nodes] = value / base - 1
    return found


def _lower(outcomes: Outcomes, metric: str, other: str, least: float, most: float) -> Verdict:
    """LR-PT is lower than another by `least` to `most` at every N."""
    found = changes(outcomes, metric, ("main", "lr_pt"), ("main", other))
    word = _word(
        found,
        reproduced=all(least <= -one <= most for one in found.values()),
        direction=all(one < 0 for one in found.values()),
    )
    claim = f"{SYMBOLS[metric]} of LR-PT is {least:.0%} to {most:.0%} lower than DTAP's, at every N"
    rule = "within the range at every N; direction only: lower at every N"
    return Verdict(claim, _told(found), word, rule)


def _second_best(outcomes: Outcomes) -> Verdict:
    found = changes(outcomes, IDLENESS[0], ("main", "dtap"), ("main", "expected_reactive"))
    word = _word(found, reproduced=all(one < 0 for one in found.values()))
    return Verdict(
        "DTAP is second best in I_G, before ER",
        f"DTAP beside ER: {_told(found)}",
        word,
        "I_G of DTAP is lower than ER's at every N",
    )


def _others_know_less(outcomes: Outcomes) -> Verdict:
    parts, ahead, behind = [], [], []
    for other, label in (("expected_reactive", "ER"), ("dtap", "DTAP")):
        for metric in AWARENESS:
            found = changes(outcomes, metric, ("main", other), ("main", "lr_pt"))
            ahead += [one > 0 for one in found.values()]
            behind += [not found]
            parts.append(f"{label} {SYMBOLS[metric]}: {_told(found)}")
    word = "not testable" if any(behind) else "reproduced" if all(ahead) else "not reproduced"
    return Verdict(
        "ER and DTAP have longer SA delays than LR-PT",
        "; ".join(parts),
        word,
        "D_MSA and D_WSA of both are higher than LR-PT's at every N",
    )


def _chain(outcomes: Outcomes) -> Iterator[Verdict]:
    """LPCC is published nowhere, so what is said of it can be set beside our own rule only.

    That a small team cannot reach far while it stays connected follows from lengths alone.
    """
    chains = {one.trial.nodes: _chain_m(one.scenario) for one in outcomes.of("main")}
    short = {nodes for nodes, (reach_m, far_m) in chains.items() if reach_m < far_m}
    told = (f"{reach_m:.0f} m of {far_m:.0f} m (N = {nodes})" for nodes, (reach_m, far_m) in chains.items())
    yield Verdict(
        "patrols that stay connected cannot reach the far cells at N = 5, and larger teams can",
        f"longest chain of links, and the way to the far cell: {', '.join(told) or 'no trials'}",
        "not testable" if not chains else "reproduced" if short == {5} else "not reproduced",
        "(N - 1) x radio range beside the distance of the farthest cell: geometry, no trial",
    )
    claims = {
        "normalised_graph_idleness_s": "I_G of LR-PT is about half of LPCC's",
        "normalised_worst_idleness_s": "I_W of LR-PT is about half of LPCC's",
        "normalised_mean_sa_delay_s": "D_MSA of LR-PT is about 5% lower than LPCC's",
        "normalised_worst_sa_delay_s": "D_WSA of LR-PT is about 30% lower than LPCC's",
    }
    for metric, claim in claims.items():
        found = changes(outcomes, metric, ("main", "lr_pt"), ("main", "chain_connected"))
        measured = f"LR-PT beside our chain_connected: {_told(found)}"
        yield Verdict(claim, measured, "not testable", "LPCC is not published; chain_connected is ours")


def _chain_m(scenario: Scenario) -> tuple[float, float]:
    """How far a chain of all robots reaches from the tower, and how far away the farthest cell is."""
    range_m = min(rule.range_m for rule in scenario.radio.rules if isinstance(rule, Range))
    tower_m = (scenario.tower.x_m, scenario.tower.y_m)
    far_m = max(math.dist(one, tower_m) for one in scenario.field.sites_m())
    return len(scenario.robot_ids) * range_m, far_m


def _by_size(outcomes: Outcomes, metric: str) -> dict[int, float]:
    medians = {nodes: outcomes.median(metric, nodes) for nodes in outcomes.sizes()}
    return {nodes: value for nodes, value in medians.items() if value is not None}


def _constant(outcomes: Outcomes, metric: str) -> Verdict:
    found = _by_size(outcomes, metric)
    ratio = max(found.values()) / min(found.values()) - 1 if len(found) > 1 else None
    word: Word = "not testable" if ratio is None else "reproduced" if ratio <= CONSTANT else "not reproduced"
    return Verdict(
        f"normalised {SYMBOLS[metric]} of LR-PT is about constant in N",
        f"{_seconds(found)}: they differ by {_percent(ratio)}",
        word,
        f"largest over smallest at most {CONSTANT:.0%} above 1",
    )


def _slight_rise(outcomes: Outcomes, metric: str) -> Verdict:
    found = _by_size(outcomes, metric)
    rise = found[max(found)] / found[min(found)] - 1 if len(found) > 1 else None
    word: Word = "not testable"
    if rise is not None:
        word = "reproduced" if 0 < rise <= SLIGHT else "direction only" if rise > 0 else "not reproduced"
    return Verdict(
        f"normalised {SYMBOLS[metric]} of LR-PT rises slightly with N",
        f"{_seconds(found)}: {_percent(rise)} from the smallest to the largest team",
        word,
        f"rises by at most {SLIGHT:.0%}; direction only: rises by more",
    )


def _bandwidth_idleness(outcomes: Outcomes) -> Verdict:
    found = {one: changes(outcomes, one, ("s8", "lr_pt"), ("main", "lr_pt")) for one in IDLENESS}
    every = [one for by_size in found.values() for one in by_size.values()]
    return Verdict(
        "with s = 8 idleness is less than 10% worse at worst",
        _told_each(found),
        "not testable" if not every else "reproduced" if max(every) < 0.10 else "not reproduced",
        "I_G and I_W less than 10% higher than with s = 400, at every N",
    )


def _bandwidth_small_teams(outcomes: Outcomes) -> Verdict:
    found = {one: changes(outcomes, one, ("s8", "lr_pt"), ("main", "lr_pt")) for one in IDLENESS}
    smallest = {metric: dict(list(by_size.items())[:1]) for metric, by_size in found.items()}
    every = [one for by_size in smallest.values() for one in by_size.values()]
    unchanged = all(abs(one) <= UNCHANGED for one in every)
    return Verdict(
        "with s = 8 idleness of the small team is about unchanged",
        _told_each(smallest),
        "not testable" if not every else "reproduced" if unchanged else "not reproduced",
        f"I_G and I_W within {UNCHANGED:.0%} of those with s = 400",
    )


def _bandwidth_awareness(outcomes: Outcomes, metric: str, published: float) -> Verdict:
    found = changes(outcomes, metric, ("s8", "lr_pt"), ("main", "lr_pt"))
    largest = dict(list(found.items())[-1:])
    word = _word(
        largest,
        reproduced=all(abs(one - published) <= NEAR for one in largest.values()),
        direction=all(one > 0 for one in largest.values()),
    )
    newest = changes(outcomes, metric, ("s8-newest", "lr_pt"), ("main", "lr_pt"))
    return Verdict(
        f"with s = 8 {SYMBOLS[metric]} is {published:.0%} higher at N = 15",
        f"{_told(found)}; s = 8 read to the letter (items = newest): {_told(newest)}",
        word,
        f"{published - NEAR:.0%} to {published + NEAR:.0%} higher at the largest N; direction only: higher",
    )


def _stable(outcomes: Outcomes, memory: str) -> Verdict:
    """Curves through failure and recovery."""
    changed, parts = [], []
    for one in outcomes.of(f"failures-{memory}"):
        for name, words in COLUMNS.items():
            change = phases(one, name).change
            changed.append(abs(change))
            parts.append(f"{words} {_percent(change)} (N = {one.trial.nodes})")
    return Verdict(
        f"normalised idleness and SA delay stay stable through failure and recovery (memory {memory})",
        f"largest departure from before: {', '.join(parts) or 'no trials'}",
        "not testable" if not changed else "reproduced" if max(changed) <= STABLE else "not reproduced",
        f"means during and after within {STABLE:.0%} of that before, {memory} memory, every N",
    )


def _partition(outcomes: Outcomes) -> Iterator[Verdict]:
    """Maps that differ from robot to robot, with a sum that is about uniform."""
    found: dict[int, list[Partition]] = {}
    for one in outcomes.of("main"):
        measured = partition_of(one)
        if measured is not None:
            found.setdefault(one.trial.nodes, []).append(measured)
    overlaps, sums, apart, even = [], [], [], []
    for nodes, each in found.items():
        overlap, by_chance, variation, thrown = (
            statistics.median(values) for values in list(zip(*each, strict=True))[:4]
        )
        reach = [statistics.median(one.reach_m[end] for one in each) for end in (0, 1)]
        apart.append(overlap < APART * by_chance)
        even.append(variation <= max(VARIATION, thrown))
        overlaps.append(
            f"overlap {overlap:.2f}, by chance {by_chance:.2f}, "
            f"robots' mean distance from the tower {reach[0]:.0f} to {reach[1]:.0f} m (N = {nodes})"
        )
        sums.append(f"{variation:.2f}, by chance {thrown:.2f} (N = {nodes})")
    yield Verdict(
        "visit maps differ from robot to robot",
        "; ".join(overlaps) or "no trials",
        "not testable" if not apart else "reproduced" if all(apart) else "not reproduced",
        f"mean overlap of two robots below {APART:.0%} of what chance gives, at every N",
    )
    yield Verdict(
        "the visits of all robots together are about uniform over the cells",
        f"coefficient of variation {'; '.join(sums) or '-'}",
        "not testable" if not even else "reproduced" if all(even) else "not reproduced",
        f"coefficient of variation at most {VARIATION}, or what chance gives, at every N",
    )


def _word(found: dict[int, float], reproduced: bool, direction: bool = False) -> Word:
    if not found:
        return "not testable"
    return "reproduced" if reproduced else "direction only" if direction else "not reproduced"


def _told(found: dict[int, float]) -> str:
    return ", ".join(f"{_percent(one)} (N = {nodes})" for nodes, one in found.items()) or "no trials"


def _told_each(found: dict[str, dict[int, float]]) -> str:
    return "; ".join(f"{SYMBOLS[metric]}: {_told(by_size)}" for metric, by_size in found.items())


def _seconds(found: dict[int, float]) -> str:
    return ", ".join(f"{value:.1f} s (N = {nodes})" for nodes, value in found.items()) or "no trials"


def _percent(part: float | None) -> str:
    return "-" if part is None else f"{100 * part:+.1f}%"
