"""The queue at the tower: first come, first sent."""

from tests.line_builders import robot
from tower.queue import in_line, ready


def names(robots) -> list[str]:
    return [one.node for one in robots]


def test_first_come_first_sent_and_ties_by_number():
    """Source: papers/line-patrol.txt, section III: an idle queue; the order is ours."""
    team = [
        robot("r10", "queue", since_tick=5),
        robot("r9", "queue", since_tick=5),
        robot("r2", "queue", since_tick=7),
    ]
    assert names(in_line(team)) == ["r9", "r10", "r2"]


def test_only_who_is_there_and_not_sent_stands_in_line():
    states = ("queue", "out", "patrol", "home")
    team = [robot(f"r{number}", state) for number, state in enumerate(states, 2)]
    team += [robot("r6", "queue", lost=True), robot("r7", "queue")]
    assert names(in_line(team)) == ["r2", "r7"]
    assert names(in_line(team, {"r2": 4})) == ["r7"]


def test_who_is_not_charged_is_passed_over_and_keeps_his_place():
    team = [
        robot("r2", "queue", battery_v=8.69, since_tick=1),
        robot("r3", "queue", battery_v=8.7, since_tick=2),
    ]
    assert names(ready(team, (), 8.7)) == ["r3"]
    assert names(in_line(team)) == ["r2", "r3"]
    team[0].battery_v = 9.0
    assert names(ready(team, (), 8.7)) == ["r2", "r3"]
