"""`picket tune`: search parameters of a scenario for the best of a metric, in rehearsals side by side."""

import argparse
import math
import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import msgspec
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Table
from rich.text import Text

from deploy.pattern_search import Point, search
from deploy.scenario_file import ScenarioError, find_scenario
from deploy.trials import RECORD, Outcome, Trials
from deploy.tuning import Number, Question, Wish, check_metrics, settings_of, settle

INTERRUPTED = 130
FIRST_SEED = 101
SMALLEST_STEP = 1e-6  # so that points which differ also differ as floating-point numbers


def add_parser(commands: argparse._SubParsersAction, number: Callable[..., Callable[[str], Number]]) -> None:
    """Add the command; `number(kind, words, right)` makes a reader of numbers."""
    tune = commands.add_parser("tune", help="search a scenario's parameters for the best of a metric")
    add = tune.add_argument
    add("scenario", metavar="SCENARIO", help="a file, or the name of a shipped scenario")
    words = "what to tune, its start (default: as in the scenario) and bounds; repeat for more"
    add(
        "--parameter",
        type=_wish,
        action="append",
        required=True,
        metavar="key.path[=START]:LOW..HIGH",
        help=words,
    )
    words = "a metric of summary.json; of several, the sum of each over its value at the start is the score"
    add("--metric", action="append", required=True, metavar="NAME", help=words)
    add("--maximise", action="store_true", help="more is better (default: less is)")
    seed = number(
        int,
        f"a whole number >= {FIRST_SEED}, as `picket reproduce` reports on seeds 1, 2, ... and "
        "what is tuned on the runs it is reported on looks better than it is",
        lambda value: FIRST_SEED <= value < 2**63,
    )
    add(
        "--seeds",
        type=seed,
        nargs="+",
        required=True,
        metavar="N",
        help=f"runs per point, from {FIRST_SEED} on",
    )
    some = number(int, "a whole number >= 1", lambda value: value >= 1)
    add("--evaluations", type=some, default=40, metavar="N", help="try so many points at most (default 40)")
    share = number(float, f"a number from {SMALLEST_STEP} to 1", lambda value: SMALLEST_STEP <= value <= 1)
    add("--step", type=share, default=0.25, help="the first step, as a share of the range (default 0.25)")
    add("--smallest-step", type=share, default=0.01, help="end below this share of the range (default 0.01)")
    add("--set", action="append", default=[], metavar="key.path=value", dest="settings")
    positive = number(float, "a number > 0", lambda value: 0 < value < math.inf)
    add("--until", type=positive, metavar="SECONDS", help="end every run at this simulated time")
    add("--out", type=Path, metavar="DIR", help="where runs are kept (default: tunings/SCENARIO)")
    tune.set_defaults(do=_tune)


def _wish(text: str) -> Wish:
    left, colon, bounds = text.rpartition(":")
    key, equals, start = left.partition("=")
    low, dots, high = bounds.partition("..")
    try:
        if not (key and colon and dots):
            raise ValueError
        wish = Wish(key, _finite(low), _finite(high), _finite(start) if equals else None)
    except ValueError:
        words = "must be key.path[=START]:LOW..HIGH in finite numbers"
        raise argparse.ArgumentTypeError(f"{words}, got {text!r}") from None
    if wish.low >= wish.high:
        raise argparse.ArgumentTypeError(f"the lower bound must be below the upper one, got {text!r}")
    return wish


def _finite(text: str) -> Number:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError
    try:
        return int(text)
    except ValueError:
        return number


def _tune(given: argparse.Namespace) -> int:
    question, smallest = _question(given), Fraction(str(given.smallest_step))
    folder = _folder(given.out or Path("tunings") / Path(given.scenario).stem, question)
    axes, step = [one.axis for one in question.parameters], Fraction(str(question.step))
    try:
        with Shown(given.evaluations) as shown:
            trials = Trials(question, folder, shown.show)

            def ask(points: list[Point]) -> list[float]:
                scores = trials.ask(points)
                trials.save(given.evaluations, given.smallest_step)
                return scores

            search(axes, ask, step, smallest, given.evaluations)
    except KeyboardInterrupt:
        print(f"interrupted; the same command goes on with what is missing in {folder}", file=sys.stderr)
        return INTERRUPTED
    _print(Console(), question, trials.outcomes, trials.best)
    print(f"record {folder / RECORD}\n{' '.join(f'--set {one}' for one in settings_of(trials.best.values))}")
    return 0


def _question(given: argparse.Namespace) -> Question:
    """What the options ask, checked. Raises ScenarioError."""
    if given.smallest_step > given.step:
        raise ScenarioError(f"--smallest-step must be <= --step ({given.step}), got {given.smallest_step}")
    for name in ("metric", "seeds"):
        for one in (values := getattr(given, name)):
            if values.count(one) > 1:
                raise ScenarioError(f"--{name} {one}: is given twice")
    scenario, parameters = settle(given.parameter, find_scenario(given.scenario), given.settings)
    if given.until is not None and given.until > scenario.duration_s:
        raise ScenarioError(f"--until must be <= duration_s ({scenario.duration_s}), got {given.until}")
    question = Question(
        given.scenario,
        tuple(given.settings),
        given.until,
        parameters,
        tuple(given.metric),
        given.maximise,
        tuple(given.seeds),
        given.step,
    )
    check_metrics(given.metric, question.load(question.start, question.seeds[0]))
    return question


def _folder(folder: Path, question: Question) -> Path:
    """Make the folder, or find that it holds the beginning of the same tuning. Raises ScenarioError."""
    record = folder / RECORD
    try:
        folder.mkdir(parents=True, exist_ok=True)
        before = msgspec.json.decode(record.read_bytes(), type=Question) if record.exists() else question
    except OSError as error:
        raise ScenarioError(f"--out {folder}: cannot keep a tuning there: {error.strerror}") from None
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{record}: is damaged: {error}") from None
    if before != question:
        names = [one for one in Question.__struct_fields__ if getattr(before, one) != getattr(question, one)]
        raise ScenarioError(
            f"--out {folder}: holds a tuning with other {' and '.join(names)}; give another folder"
        )
    return folder


class Shown:
    """How far the search is: a bar on a terminal, else a line after every sweep."""

    def __init__(self, evaluations: int) -> None:
        self._console = Console(stderr=True)
        self._bar = Progress(
            TextColumn("{task.description}"), BarColumn(), console=self._console, transient=True
        )
        self._task = self._bar.add_task("the start point", total=evaluations)
        self._evaluations = evaluations
        self._told = 0

    def __enter__(self) -> "Shown":
        if self._console.is_terminal:
            self._bar.start()
        return self

    def __exit__(self, *error: object) -> None:
        if self._console.is_terminal:  # it writes an empty line even where it never started
            self._bar.stop()

    def show(self, tried: float, outcomes: list[Outcome], best: Outcome | None) -> None:
        """Take note of points done and under way; `tried` counts the latter by their share."""
        if best is None:
            return
        words = f"{len(outcomes)} of {self._evaluations} evaluations, best {best.score:.6g}"
        if self._console.is_terminal:
            self._bar.update(self._task, completed=tried, description=words)
        elif len(outcomes) > self._told:
            self._console.print(words, highlight=False)
        self._told = len(outcomes)


def _print(console: Console, question: Question, outcomes: list[Outcome], best: Outcome) -> None:
    """All points in order, the best one marked."""
    several = len(question.metrics) > 1
    score = ["sum of each over its start"] if several else []
    aim = "most" if question.maximise else "least"
    seeds = " ".join(map(str, question.seeds))
    title = (
        f"{Path(question.scenario).stem}: {aim} {' and '.join(question.metrics)}, means over seeds {seeds}"
    )
    table = Table(title=title, title_justify="left")
    for heading in ("point", *_short([one.key for one in question.parameters]), *question.metrics, *score):
        table.add_column(heading.replace("_", " "), justify="right")
    table.add_column("")
    for one in outcomes:
        measured = [*one.metrics.values(), *([one.score] if several else [])] if one.metrics else []
        cells = [f"{value:.6g}" for value in (one.number, *one.values.values(), *measured)]
        blank = [""] * (len(table.columns) - 1 - len(cells))
        remark = f"refused: {one.refused}" if one.refused else "best" if one is best else ""
        table.add_row(*cells, *blank, Text(remark), style="bold" if one is best else None)
    console.print(table)


def _short(keys: list[str]) -> list[str]:
    """The last words of key paths, where they tell them apart."""
    last = [key.rpartition(".")[2] for key in keys]
    return last if len(set(last)) == len(keys) else keys
