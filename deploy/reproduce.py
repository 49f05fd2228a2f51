"""`picket reproduce`: the studies and their options. Each runs what a paper ran, to be read beside it."""

import argparse
from collections.abc import Callable
from pathlib import Path

Reader = Callable[[str], int | float]


def add_parser(commands: argparse._SubParsersAction, some: Reader, maybe: Reader, positive: Reader) -> None:
    """Add the command. `some` reads a whole number >= 1, `maybe` one >= 0, `positive` a number > 0."""
    reproduce = commands.add_parser("reproduce", help="run what a paper ran, its tables beside ours")
    studies = reproduce.add_subparsers(required=True, metavar="STUDY", dest="study")
    line = studies.add_parser("line-patrol", help="a line kept for days by robots whose batteries last hours")
    line.add_argument("--seeds", type=some, help="runs of each kind, with seeds 1, 2, ... (default 3)")
    line.add_argument("--hours", type=positive, help="simulated hours of each run (default 24)")
    line.set_defaults(do=_line_patrol)
    area = studies.add_parser("lr-pt", help="LR-PT beside ER, DTAP and others, with real failures")
    words = "compare this behaviour too: file:Class from here, or a shipped name; may be given again"
    graphs = studies.add_parser("graphs", help="the classic patrol rules on patrol graphs")
    for study in (area, graphs):
        study.add_argument("--trials", type=some, help="trials of each kind, with seeds 1, 2, ...")
        study.add_argument("--quick", action="store_true", help="short and few: to try it out in minutes")
        study.add_argument("--behaviour", action="append", default=[], dest="behaviours", help=words)
    area.add_argument("--processes", action="store_true", help="no rehearsals: real processes, run after run")
    only = "only trials whose name contains this, and no report"
    area.add_argument("--only", metavar="TEXT", default="", help=only)
    area.set_defaults(do=_lr_pt)
    files = "a .graph file of patrolling_sim or a TOML file of ours (default: the 5 x 5 map grid)"
    graphs.add_argument("files", nargs="*", type=Path, metavar="FILE", help=files)
    graphs.set_defaults(do=_graphs)
    pursuit = studies.add_parser("pursuit-evasion", help="unknown floor plans cleared by lines of robots")
    pursuit.add_argument("--trials", type=some, help="runs of each team and place, with seeds 1, 2, ... (1)")
    pursuit.add_argument("--quick", action="store_true", help="short and few: to try it out in minutes")
    pursuit.add_argument("--most", type=some, metavar="N", help="the largest team on the cave (default 13)")
    pursuit.add_argument("--plans", type=maybe, metavar="N", help="random plans beside it (default 32)")
    pursuit.add_argument("--only", metavar="TEXT", default="", help=only)
    pursuit.set_defaults(do=_pursuit)
    for study in (line, area, graphs, pursuit):
        words = "where trials, tables and figures are kept (default: reproductions)"
        study.add_argument("--out", type=Path, metavar="DIR", help=words)


def _line_patrol(given: argparse.Namespace) -> int:
    from deploy.studies.line_patrol_report import reproduce  # matplotlib takes half a second to import

    return reproduce(given)


def _lr_pt(given: argparse.Namespace) -> int:
    from deploy.studies.lr_pt.study import reproduce

    return reproduce(given)


def _pursuit(given: argparse.Namespace) -> int:
    from deploy.studies.pursuit.study import reproduce

    return reproduce(given)


def _graphs(given: argparse.Namespace) -> int:
    from deploy.studies.graphs import reproduce

    return reproduce(given)
