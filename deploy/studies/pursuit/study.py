"""`picket reproduce pursuit-evasion`: from the runs that are missing to the report."""

import argparse
from pathlib import Path

from deploy.campaign import INTERRUPTED, Campaign, make_folder
from deploy.studies.pursuit import plan, report
from deploy.studies.pursuit.claims import verdicts
from deploy.studies.pursuit.figures import draw
from deploy.studies.pursuit.literal import read_literally
from deploy.studies.pursuit.runs import Runs, collect, save
from deploy.studies.verdict import show


def reproduce(given: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code. Raises RunError, ScenarioError, SweepError."""
    extent = plan.QUICK if given.quick else plan.FULL
    study = plan.study(extent, given.most, given.plans)._replace(seeds=given.trials or 1, only=given.only)
    folder = make_folder(given.out, "pursuit-evasion-quick" if given.quick else "pursuit-evasion")
    runs = _run(study, folder)
    if runs is None:
        return INTERRUPTED
    if given.only:
        print(f"runs {folder}\nno report: --only leaves runs out")
        return 0
    save(runs, folder / "runs.parquet")
    main = study.grounds[0]
    scenario = runs.all[0].trial.scenario()
    letter = read_literally(scenario.robots.parameters["follow_m"], scenario.sensors.detect_m)
    judged = verdicts(runs, main)
    figures = [path.name for path in draw(runs, main, letter, folder)]
    text = report.write(runs, main, scenario, judged, letter, given.quick, figures)
    (folder / "report.md").write_text(text, "utf-8")
    show(judged, given.quick)
    print(f"report {folder / 'report.md'}\nruns   {folder / 'runs.parquet'}")
    return 0


def _run(study: plan.Study, folder: Path) -> Runs | None:
    """Every team, and then the larger ones where it has been seen which are; None after Ctrl-C."""
    trials = study.every_team()
    runs = _carry_out(trials, folder)
    if runs is None or not (larger := study.larger_teams(runs.fewest())):
        return runs
    return _carry_out([*trials, *larger], folder)


def _carry_out(trials: list[plan.Trial], folder: Path) -> Runs | None:
    summaries = Campaign({one.name: one.scenario() for one in trials}, folder).run()
    return None if summaries is None else collect(trials, summaries, folder)
