"""Every command of `picket` and its options."""

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from deploy import reproduce, tune
from deploy.compare import compare
from deploy.operate import request
from deploy.recorder import deaths
from deploy.report import console_for, print_result
from deploy.run import run_scenario
from deploy.run_folder import RunError, find_folder, live_runs, summary_of
from deploy.scenario_file import shipped_scenarios
from deploy.viewer import choose_mode, open_recording
from wire.messages import Request

Number = int | float
Reader = Callable[[str], Number]
DASHBOARDS = ("auto", "native", "web", "file", "off")


class OneLineParser(argparse.ArgumentParser):
    """Complains in one line, like all of Picket."""

    def error(self, message: str) -> NoReturn:
        """Raises RunError."""
        raise RunError(f"{message.removeprefix('argument ')}; see {self.prog} --help")


def parse(arguments: list[str]) -> int:
    """Parse a command line and carry it out; returns the exit code. Raises RunError among others."""
    given = _parser().parse_args(arguments)
    return given.do(given)


def _parser() -> argparse.ArgumentParser:
    parser = OneLineParser(prog="picket", description="Robot swarms as real processes, with real kills.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_run(commands)
    for verb, words in {
        "kill": "kill a node's process (SIGKILL)",
        "freeze": "stop a node's process (SIGSTOP)",
        "thaw": "let a frozen node go on (SIGCONT)",
        "restart": "start a new process for a dead node",
        "pause": "let simulated time stand still",
        "resume": "let simulated time go on",
        "step": "go on for some ticks, then pause",
        "speed": "simulated seconds per second; 0: as fast as it goes",
    }.items():
        _add_request(commands, verb, words)
    status = commands.add_parser("status", help="how a run stands, or all live runs")
    status.add_argument("run", nargs="?", metavar="RUN")
    status.set_defaults(do=_status)
    comparing = commands.add_parser("compare", help="are two runs the same, and where do they part?")
    comparing.add_argument("first", metavar="RUN_A")
    comparing.add_argument("second", metavar="RUN_B")
    comparing.set_defaults(do=_compare)
    dashboard = commands.add_parser("dashboard", help="look at a run in Rerun")
    dashboard.add_argument("run", metavar="RUN")
    dashboard.add_argument("--mode", choices=("auto", "native", "web", "file"), default="auto")
    dashboard.set_defaults(do=_dashboard)
    bench = commands.add_parser("bench", help="what a lockstep tick costs, beside the bare wire")
    some = _number(int, "a whole number >= 1", lambda value: value >= 1)
    bench.add_argument("--ticks", type=some, default=200, help="ticks of one block (default 200)")
    sizes = "numbers of nodes, the tower counted (default 1 5 15 50)"
    bench.add_argument("--sizes", type=some, nargs="+", default=[1, 5, 15, 50], metavar="N", help=sizes)
    bench.add_argument("--rounds", type=some, default=5, help="pairs of blocks for each size (default 5)")
    bench.set_defaults(do=_bench)
    positive = _number(float, "a number > 0", lambda value: 0 < value < math.inf)
    maybe = _number(int, "a whole number >= 0", lambda value: value >= 0)
    reproduce.add_parser(commands, some, maybe, positive)
    tune.add_parser(commands, _number)
    scenarios = commands.add_parser("scenarios", help="the scenarios that come with Picket")
    scenarios.set_defaults(do=_scenarios)
    return parser


def _add_run(commands: argparse._SubParsersAction) -> None:
    run = commands.add_parser("run", help="run a scenario")
    words = "a file, or the name of a shipped scenario (default: area-patrol)"
    run.add_argument("scenario", metavar="SCENARIO", nargs="?", default="area-patrol", help=words)
    positive = _number(float, "a number > 0", lambda value: 0 < value < math.inf)
    run.add_argument("--seed", type=_number(int, "a whole number >= 0", lambda value: value >= 0))
    run.add_argument("--until", type=positive, metavar="SECONDS", help="end at this simulated time")
    words = "change the scenario; behaviour=NAME is short for robots.behaviour=NAME (repeatable)"
    run.add_argument(
        "--set", action="append", default=[], metavar="key.path=value", dest="settings", help=words
    )
    run.add_argument("--clock", choices=("lockstep", "paced"))
    run.add_argument("--rate", type=positive, metavar="X", help="simulated seconds per second when paced")
    run.add_argument("--in-process", action="store_true", help="rehearse: all minds in this process")
    run.add_argument("--faults-from", metavar="RUN", help="repeat all faults of that run, and no others")
    run.add_argument("--dashboard", choices=DASHBOARDS, default="auto")
    run.add_argument("--out", type=Path, metavar="DIR", help="where the run folder is made (default: runs)")
    run.add_argument("--json", action="store_true", help="print summary.json and nothing else")
    run.set_defaults(do=run_scenario)


def _add_request(commands: argparse._SubParsersAction, verb: str, words: str) -> None:
    command = commands.add_parser(verb, help=words)
    command.add_argument("run", metavar="RUN")
    if verb in ("kill", "freeze", "thaw", "restart"):
        command.add_argument("node", metavar="NODE")
    if verb == "restart":
        command.add_argument("--memory", choices=("lost", "kept"), default="lost")
        words = "where its body lay, or in the tower's queue with a full battery (default: here)"
        command.add_argument("--place", choices=("here", "queue"), default="here", help=words)
    if verb == "step":
        ticks = _number(int, "a whole number >= 1", lambda value: 1 <= value < 2**53)
        command.add_argument("value", type=ticks, metavar="TICKS")
    elif verb == "speed":
        rate = _number(float, "a number >= 0", lambda value: 0 <= value < math.inf)
        command.add_argument("value", type=rate, metavar="X")
    command.set_defaults(do=lambda given: _request(verb, given))


def _number(kind: type[Number], words: str, right: Callable[[Number], bool]) -> Reader:
    """How to read an option that is a number; `words` say what is right."""

    def read(text: str) -> Number:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not right(value):
            raise argparse.ArgumentTypeError(f"must be {words}, got {text!r}")
        return value

    return read


def _request(verb: str, given: argparse.Namespace) -> int:
    node, memory = getattr(given, "node", ""), getattr(given, "memory", "lost")
    value, place = getattr(given, "value", 0.0), getattr(given, "place", "here")
    reply = request(given.run, Request(verb, node, memory, value, place))
    if not reply.accepted:
        raise RunError(reply.text)
    print(reply.text)
    return 0


def _status(given: argparse.Namespace) -> int:
    if given.run is None:
        for live in live_runs():
            print(live.folder)
        return 0
    folder = find_folder(given.run)
    if any(Path(live.folder) == folder.resolve() for live in live_runs()):
        state = request(given.run, Request("status")).data
        waiting = f", waiting for {', '.join(state['waiting_for'])}" if state["waiting_for"] else ""
        alive = ", ".join(f"{node} (pid {state['pids'].get(node)})" for node in state["alive"])
        paused = ", paused" if state["paused"] else ""
        print(
            f"running: {state['sim_s']:.0f} of {state['duration_s']:.0f} s{paused}{waiting}\nalive: {alive}"
        )
        return 0
    summary = summary_of(folder)
    if summary is None:
        print(
            f"{folder}: ended without a summary; its journal can still be read by "
            "`picket dashboard` and `picket compare`"
        )
    else:
        print_result(console_for(json_only=False), summary, str(folder), deaths(folder))
    return 0


def _compare(given: argparse.Namespace) -> int:
    equal, text = compare(find_folder(given.first), find_folder(given.second))
    print(text)
    return 0 if equal else 1


def _dashboard(given: argparse.Namespace) -> int:
    from deploy.dashboard import record  # rerun takes most of a second to import

    recording = record(find_folder(given.run))
    mode = choose_mode(given.mode)
    if mode == "file":
        print(recording)
        return 0
    return open_recording(recording, mode)


def _bench(given: argparse.Namespace) -> int:
    from deploy.bench import bench

    return bench(given.sizes, given.ticks, given.rounds)


def _scenarios(given: argparse.Namespace) -> int:
    for name, path in shipped_scenarios().items():
        first_line = path.read_text("utf-8").splitlines()[0]
        print(f"{name:24} {first_line.lstrip('# ')}")
    return 0
