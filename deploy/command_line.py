"""Every command of `picket` and its options."""

import argparse
from pathlib import Path

from deploy.compare import compare
from deploy.dashboard import open_recording
from deploy.operate import request
from deploy.report import console_for, print_result
from deploy.run import run_scenario
from deploy.run_folder import find_folder, live_runs, summary_of
from deploy.scenario_file import shipped_scenarios
from wire.messages import Request

DASHBOARDS = ("auto", "native", "web", "file", "off")


def parse(arguments: list[str]) -> int:
    """Parse a command line and carry it out; returns the exit code."""
    given = _parser().parse_args(arguments)
    return given.do(given)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="picket", description="Robot swarms as real processes, with real kills.")
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
    dashboard.set_defaults(do=lambda given: open_recording(find_folder(given.run), given.mode))
    bench = commands.add_parser("bench", help="what a lockstep tick costs, beside the bare wire")
    bench.add_argument("--ticks", type=int, default=200, help="ticks of one block (default 200)")
    bench.add_argument("--sizes", type=int, nargs="+", default=[1, 5, 15, 50], metavar="N",
                       help="numbers of nodes, the tower counted (default 1 5 15 50)")
    bench.add_argument("--rounds", type=int, default=5, help="pairs of blocks for each size (default 5)")
    bench.set_defaults(do=_bench)
    scenarios = commands.add_parser("scenarios", help="the scenarios that come with Picket")
    scenarios.set_defaults(do=_scenarios)
    return parser


def _add_run(commands: argparse._SubParsersAction) -> None:
    run = commands.add_parser("run", help="run a scenario")
    run.add_argument("scenario", metavar="SCENARIO", help="a file, or the name of a shipped scenario")
    run.add_argument("--seed", type=int)
    run.add_argument("--until", type=float, metavar="SECONDS", help="end at this simulated time")
    run.add_argument("--set", action="append", default=[], metavar="key.path=value", dest="settings")
    run.add_argument("--clock", choices=("lockstep", "paced"))
    run.add_argument("--rate", type=float, metavar="X", help="simulated seconds per second of the paced clock")
    run.add_argument("--in-process", action="store_true", help="rehearse: all minds in this process, no Zenoh")
    run.add_argument("--faults-from", metavar="RUN", help="repeat all faults of that run, and no others")
    run.add_argument("--dashboard", choices=DASHBOARDS, default="auto")
    run.add_argument("--out", type=Path, metavar="DIR", help="where the run folder is made (default: runs)")
    run.add_argument("--json", action="store_true", help="print summary.json and nothing else on standard output")
    run.set_defaults(do=run_scenario)


def _add_request(commands: argparse._SubParsersAction, verb: str, words: str) -> None:
    command = commands.add_parser(verb, help=words)
    command.add_argument("run", metavar="RUN")
    if verb in ("kill", "freeze", "thaw", "restart"):
        command.add_argument("node", metavar="NODE")
    if verb == "restart":
        command.add_argument("--memory", choices=("lost", "kept"), default="lost")
    if verb in ("step", "speed"):
        command.add_argument("value", type=float, metavar="TICKS" if verb == "step" else "X")
    command.set_defaults(do=lambda given: _request(verb, given))


def _request(verb: str, given: argparse.Namespace) -> int:
    node, memory = getattr(given, "node", ""), getattr(given, "memory", "lost")
    reply = request(given.run, Request(verb, node, memory, getattr(given, "value", 0.0)))
    print(reply.text if reply.accepted else f"picket: {reply.text}")
    return 0 if reply.accepted else 2


def _status(given: argparse.Namespace) -> int:
    if given.run is None:
        for live in live_runs():
            print(live.folder)
        return 0
    folder = find_folder(given.run)
    if any(Path(live.folder) == folder.resolve() for live in live_runs()):
        state = request(given.run, Request("status")).data
        waiting = f", waiting for {', '.join(state['waiting_for'])}" if state["waiting_for"] else ""
        print(f"running: {state['sim_s']:.0f} of {state['duration_s']:.0f} s, {len(state['alive'])} nodes alive "
              f"({', '.join(state['alive'])}){', paused' if state['paused'] else ''}{waiting}")
        return 0
    summary = summary_of(folder)
    if summary is None:
        print(f"{folder}: ended without a summary: its launcher was killed")
    else:
        print_result(console_for(json_only=False), summary, str(folder))
    return 0


def _compare(given: argparse.Namespace) -> int:
    equal, text = compare(find_folder(given.first), find_folder(given.second))
    print(text)
    return 0 if equal else 1


def _bench(given: argparse.Namespace) -> int:
    from deploy.bench import bench

    return bench(given.sizes, given.ticks, given.rounds)


def _scenarios(given: argparse.Namespace) -> int:
    for name, path in shipped_scenarios().items():
        first_line = path.read_text("utf-8").splitlines()[0]
        print(f"{name:24} {first_line.lstrip('# ')}")
    return 0


