"""`picket reproduce lr-pt`: the whole comparison, from the trials that are missing to the report."""

import argparse

from deploy.campaign import INTERRUPTED, Campaign, make_folder
from deploy.studies.lr_pt import plan, report
from deploy.studies.lr_pt.claims import verdicts
from deploy.studies.lr_pt.figures import draw
from deploy.studies.outcomes import collect, save
from deploy.studies.trial import Algorithm, guest
from deploy.studies.verdict import show


def reproduce(given: argparse.Namespace) -> int:
    """Carry out `picket reproduce lr-pt`; returns the exit code.

    Raises RunError, ScenarioError, SweepError.
    """
    scale = plan.QUICK if given.quick else plan.FULL
    guests: list[Algorithm] = []
    for behaviour in given.behaviours:
        guests.append(guest(behaviour, (*plan.ALGORITHMS, *guests)))
    count = given.trials or scale.trials
    trials = plan.trials(scale, count, guests, given.processes, given.only)
    folder = make_folder(given.out, "lr-pt-quick" if given.quick else "lr-pt")
    jobs = {trial.name: trial.scenario() for trial in trials}
    as_processes = {trial.name for trial in trials if trial.as_processes}
    summaries = Campaign(jobs, folder, as_processes).run()
    if summaries is None:
        return INTERRUPTED
    if given.only:
        print(f"trials {folder}\nno report: --only leaves trials out")
        return 0
    outcomes = collect(trials, summaries, folder)
    save(outcomes, folder / "trials.parquet")
    judged = verdicts(outcomes)
    figures = [path.name for path in draw(outcomes, folder)]
    (folder / "report.md").write_text(report.write(outcomes, judged, scale, given.quick, figures), "utf-8")
    show(judged, given.quick)
    print(f"report {folder / 'report.md'}\ntrials {folder / 'trials.parquet'}")
    return 0
