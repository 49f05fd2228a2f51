"""Which trials the study has: their names, settings and order.

Source: Kobayashi et al. 2025, Tables I and II, sections V-B to V-E. Ten trials of each kind per size, as its
Table II has them with three sizes and two kinds of idleness; seeds are ours.
"""

import json
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from deploy.scenario_file import ScenarioError
from deploy.studies.trial import Algorithm, Scale, Trial, contains, settings_of

SIZES = (5, 10, 15)
"""Nodes, the tower counted."""


LR_PT = Algorithm("lr_pt", "LR-PT", "lr_pt", {})
ALGORITHMS = (
    LR_PT,
    Algorithm("expected_reactive", "ER", "expected_reactive", {}),
    Algorithm("expected_reactive-relay", "ER+relay", "expected_reactive", {"relay": True}),
    Algorithm("dtap", "DTAP", "dtap", {}),
    Algorithm("chain_connected", "chain connected", "chain_connected", {}),
)

TUNED: dict[tuple[str, int], dict[str, Any]] = {
    ("expected_reactive", 15): {"distance_min_m": 36.05},
    ("dtap", 5): {"hop_weight": -2.25},
    ("dtap", 10): {"hop_weight": -1.75},
    ("dtap", 15): {"timeout_s": 1.5},
}
"""Parameters by the algorithm's name and N, where `picket tune` found better ones than the defaults:
how, and the tables, in docs/lr-pt.md.
"""

FULL = Scale(43200, 10000, 129600, 10)
QUICK = Scale(3000, 1000, 6000, 2)
FEW = 3
"""Trials of kinds that only show what the paper's letter leads to."""


class Variant(NamedTuple):
    """LR-PT in another setting; `most`: no more trials than this, 0 for as many as of the others."""

    name: str
    parameters: dict[str, Any]
    tower: dict[str, Any]
    most: int

    def settings(self) -> tuple[str, ...]:
        """As `--set` takes them."""
        return (*settings_of("robots", self.parameters), *settings_of("tower", self.tower))


VARIANTS = (
    Variant("s8", {"items_per_tick": 8, "items": "unsent"}, {"items_per_tick": 8}, 0),
    Variant("s8-newest", {"items_per_tick": 8, "items": "newest"}, {"items_per_tick": 8}, FEW),
    Variant("literal", {"lock_breaker": "none"}, {}, FEW),
)
MEMORIES = ("kept", "lost")


def trials(
    scale: Scale, count: int, guests: Sequence[Algorithm] = (), all_processes: bool = False, only: str = ""
) -> list[Trial]:
    """All trials in the order in which they are to run: a whole comparison after each seed.

    `only`: those whose name contains this text, in which a number stands for itself and not for the beginning
    of a longer one. Raises ScenarioError where there is none.
    """
    everybody = (*ALGORITHMS, *guests)
    found = [
        trial
        for seed in range(1, count + 1)
        for trial in _of_seed(scale, seed, everybody, all_processes)
        if contains(trial.name, only)
    ]
    if not found:
        raise ScenarioError(f"--only {only}: no trial has this in its name; one is called lr_pt-n5-seed1")
    return found


def _of_seed(
    scale: Scale, seed: int, algorithms: Sequence[Algorithm], all_processes: bool
) -> Iterator[Trial]:
    def plain(algorithm: Algorithm, nodes: int, kind: str = "main", *settings: str) -> Trial:
        parts = (algorithm.name, *([kind] if kind != "main" else []), f"n{nodes}", f"seed{seed}")
        given = _settings(algorithm, nodes, seed) + settings
        given += (f"duration_s={scale.duration_s}", f"metrics_from_s={scale.metrics_from_s}")
        base = "area-patrol-n10"
        return Trial("-".join(parts), kind, algorithm, nodes, seed, all_processes, base, given)

    for nodes in SIZES:
        yield from (plain(algorithm, nodes) for algorithm in algorithms)
    for variant in VARIANTS:
        if not variant.most or seed <= variant.most:
            yield from (plain(LR_PT, nodes, variant.name, *variant.settings()) for nodes in SIZES)
    if seed > 1:
        return
    if not all_processes:
        for algorithm in algorithms:
            sample = plain(algorithm, min(SIZES))
            yield sample._replace(name=f"{sample.name}-processes", kind="processes", as_processes=True)
    for nodes in SIZES:
        yield from (_failures(scale, nodes, memory) for memory in MEMORIES)


def _failures(scale: Scale, nodes: int, memory: str) -> Trial:
    """The 20 % highest numbers die at a third of the run and come back at two thirds: always real kills."""
    settings = (
        *_settings(LR_PT, nodes, 1),
        f"duration_s={scale.failures_s}",
        f"metrics_from_s={scale.metrics_from_s}",
        f"faults.0.at_s={scale.failures_s / 3}",
        f"faults.1.at_s={scale.failures_s * 2 / 3}",
        f"faults.1.memory={memory}",
    )
    kind = f"failures-{memory}"
    return Trial(
        f"lr_pt-{kind}-n{nodes}-seed1", kind, LR_PT, nodes, 1, True, "area-patrol-failures", settings
    )


def _settings(algorithm: Algorithm, nodes: int, seed: int) -> tuple[str, ...]:
    parameters = TUNED.get((algorithm.name, nodes), {}) | algorithm.parameters
    return (
        f"seed={seed}",
        f"robots.count={nodes - 1}",
        f"robots.behaviour={json.dumps(algorithm.behaviour)}",
        *settings_of("robots", parameters),
    )
