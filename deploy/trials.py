"""Trying points: a rehearsal for every seed, folded into one score, and the record of a tuning.

The score is the mean of the metric over the seeds; of several metrics the sum of each mean over its mean at
the start point, so that each counts the same there. Less is better, unless the question says to maximise.
"""

import math
from collections.abc import Callable
from pathlib import Path
from statistics import fmean
from typing import Any

import msgspec

from deploy.pattern_search import Point
from deploy.recorder import deaths
from deploy.scenario_file import ScenarioError
from deploy.sweep import SweepError, sweep
from deploy.tuning import Number, Question, settings_of, value_at
from wire.scenario import Scenario

RECORD = "tuning.json"


class Outcome(msgspec.Struct, frozen=True):
    """What came of one point: means over the seeds and the score, or why it was refused."""

    number: int
    values: dict[str, Number]
    metrics: dict[str, float] = {}
    score: float | None = None
    refused: str = ""


Show = Callable[[float, list[Outcome], Outcome | None], None]


class Trials:
    """Tries points in a folder; what is there already is not run again. `outcomes` are in order of trial.

    `show` is told how many points are tried, those under way by their share, and the outcomes and their best.
    """

    def __init__(self, question: Question, folder: Path, show: Show) -> None:
        self.outcomes: list[Outcome] = []
        self._question = question
        self._folder = folder
        self._show = show
        self._sign = -1 if question.maximise else 1

    @property
    def best(self) -> Outcome | None:
        """The first of the best outcomes so far; None before there is any."""
        measured = [one for one in self.outcomes if one.score is not None]
        return min(measured, key=lambda one: self._sign * one.score, default=None)

    def ask(self, points: list[Point]) -> list[float]:
        """The scores of new points, all their rehearsals side by side; negative what is to be maximised.

        Infinity for a point that is refused: by the scenario, by an error of a node or of the rehearsal, or
        because something was not measured. Raises ScenarioError where that is the start point, SweepError
        where a rehearsal was killed.
        """
        numbered = dict(enumerate(points, len(self.outcomes) + 1))
        summaries, refused = self._rehearse(numbered)
        asked = [
            self._outcome(number, point, summaries.get(number, []), refused.get(number, ""))
            for number, point in numbered.items()
        ]
        self.outcomes += asked
        if self.outcomes[0].refused:
            raise ScenarioError(f"the start point is refused: {self.outcomes[0].refused}")
        self._show(len(self.outcomes), self.outcomes, self.best)
        return [math.inf if one.score is None else self._sign * one.score for one in asked]

    def save(self, evaluations: int, smallest_step: float) -> None:
        """Write the record: the question, when the search was to end, every point, and the best."""
        best = self.best
        record = msgspec.to_builtins(self._question) | {
            "evaluations": evaluations,
            "smallest_step": smallest_step,
            "best": msgspec.to_builtins(best),
            "best_settings": settings_of(best.values) if best else [],
            "points": msgspec.to_builtins(self.outcomes),
        }
        fresh = self._folder / f"{RECORD}.new"
        fresh.write_bytes(msgspec.json.format(msgspec.json.encode(record), indent=2) + b"\n")
        fresh.replace(self._folder / RECORD)

    def _rehearse(self, points: dict[int, Point]) -> tuple[dict[int, list[dict[str, Any]]], dict[int, str]]:
        """The summaries of all seeds by number of the point, and why a point is refused."""
        jobs: dict[str, Scenario] = {}
        points_of: dict[str, int] = {}
        refused: dict[int, str] = {}
        for number, point in points.items():
            try:
                scenarios = {seed: self._question.load(point, seed) for seed in self._question.seeds}
            except ScenarioError as error:
                refused[number] = str(error)
                continue
            for seed, scenario in scenarios.items():
                name = f"point{number:03}-seed{seed}"
                jobs[name], points_of[name] = scenario, number
        before = len(self.outcomes)

        def show(done: int, total: int) -> None:
            self._show(before + len(points) * done / max(total, 1), self.outcomes, self.best)

        failed: dict[str, SweepError] = {}
        finished = sweep(jobs, self._folder, show, lean=True, failed=failed)
        summaries: dict[int, list[dict[str, Any]]] = {}
        for name, number in points_of.items():  # in order, so that of several reasons always the same is told
            if name in failed:
                refused.setdefault(number, f"{name}: {_last_line(str(failed[name]))}")
                continue
            summaries.setdefault(number, []).append(finished[name])
            for death in deaths(self._folder / name):  # nobody kills in a rehearsal but the plan
                why = f"{name}: {death['text']}: {_last_line(death['data']['last_lines'])}"
                refused.setdefault(number, why)
        return summaries, refused

    def _outcome(self, number: int, point: Point, summaries: list[dict[str, Any]], refused: str) -> Outcome:
        values = self._question.values(point)
        if refused:
            return Outcome(number, values, refused=refused)
        measured = {
            metric: [value_at(summary["metrics"], metric) for summary in summaries]
            for metric in self._question.metrics
        }
        for metric, found in measured.items():
            if None in found:
                return Outcome(number, values, refused=f"{metric} was not measured")
        means = {metric: fmean(found) for metric, found in measured.items()}
        at_start = self.outcomes[0].metrics if self.outcomes else means
        if len(means) == 1:
            return Outcome(number, values, means, sum(means.values()))
        for metric, start in at_start.items():
            if start <= 0:
                return Outcome(number, values, refused=f"{metric} is {start}, no score can be relative to it")
        return Outcome(number, values, means, sum(mean / at_start[name] for name, mean in means.items()))


def _last_line(text: str) -> str:
    return text.rstrip().rpartition("\n")[2]
