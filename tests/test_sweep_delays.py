"""Late frames, lost frames and slow robots cost a sweep team time, and nothing else."""

from typing import Any

import pytest

from deploy.metrics.clear import ClearMetrics
from deploy.scenario_file import SHIPPED, ScenarioError, load_scenario
from swarm_agent.behaviour import Air
from swarm_agent.behaviours.sweep_line import Parameters
from tests.sweep_play import Play, play
from wire.scenario import Scenario

RANGE = '{kind="range",range_m=2.0}'
LOSS = '{kind="loss",probability=0.05}'
SLOW = 'faults=[{at_s=0,verb="slow",nodes=["r3"],every=10}]'
LATE = {ticks: f'{{kind="latency",ticks={ticks}}}' for ticks in (1, 2)}
NO_MORE_S = {"late": 170, "later": 200, "lost": 170, "slow": 1200, "all": 1500}
SETTINGS = {
    "late": [f"radio.rules=[{RANGE},{LATE[1]}]"],
    "later": [f"radio.rules=[{RANGE},{LATE[2]}]"],
    "lost": [f"radio.rules=[{RANGE},{LOSS}]"],
    "slow": [SLOW],
    "all": [f"radio.rules=[{RANGE},{LOSS},{LATE[2]}]", SLOW],
}


def shipped(name: str, *settings: str) -> Scenario:
    return load_scenario(SHIPPED / f"{name}.toml", ["duration_s=2000", *settings])


def cleared(given: Scenario) -> tuple[Play, dict[str, Any]]:
    """Run it to its end; all that the referee counts."""
    counted, dead = ClearMetrics(given), set()

    def watch(course: Play) -> bool:
        counted.feed(course.facts[-1])
        dead.update(*(robot.dead for robot in course.robots.values()))
        return False

    course = play(given, given.last_tick, watch)
    return course, counted.summary() | {"dead": dead}


@pytest.mark.parametrize(
    ("name", "trouble"), [*(("clear-corridor", trouble) for trouble in SETTINGS), ("clear-rooms", "all")]
)
def test_a_floor_is_cleared_whatever_is_late_lost_or_slow(name, trouble):
    """No breach, nobody taken for dead, only more time."""
    given = shipped(name, *SETTINGS[trouble])
    course, found = cleared(given)
    assert found["cleared"] and found["claim"] == "done"
    assert found["breaches"] == 0
    assert found["dead"] == set()
    assert course.tick * given.tick_s < NO_MORE_S[trouble]


@pytest.mark.parametrize("tick_s", [0.1, 0.25, 1.0])
@pytest.mark.parametrize("loss", [1e-4, 0.05, 0.3, 0.9])
@pytest.mark.parametrize(("latency_ticks", "grant_ticks"), [(1, 1), (2, 1), (1, 10), (3, 7)])
def test_who_lives_is_taken_for_dead_less_than_once_in_a_million_hours(
    tick_s, loss, latency_ticks, grant_ticks
):
    """By loss alone: all frames of that silence are lost, in whatever tick the hearer is granted."""
    settled = Parameters().in_air(Air(tick_s, latency_ticks, loss, grant_ticks))
    oldest_ticks = latency_ticks + grant_ticks - 1  # of the newest news, where no frame is lost
    lost = 0
    while oldest_ticks + lost * grant_ticks <= settled.dead_ticks:
        lost += 1
    assert loss**lost * 3600 / tick_s <= 1e-6
    assert settled.hop_ticks == oldest_ticks


def test_parameters_follow_from_the_radio_and_the_slowest_robot():
    found = {name: shipped("clear-corridor", *given).robots.parameters for name, given in SETTINGS.items()}
    ticks = {name: (one["hop_ticks"], one["dead_ticks"]) for name, one in found.items()}
    assert ticks == {"late": (1, 6), "later": (2, 7), "lost": (1, 13), "slow": (10, 15), "all": (11, 86)}


def test_parameters_that_are_given_are_kept():
    given = ["robots.parameters.dead_ticks=30", "robots.parameters.hop_ticks=3", *SETTINGS["all"]]
    found = shipped("clear-corridor", *given).robots.parameters
    assert (found["dead_ticks"], found["hop_ticks"]) == (30, 3)


def test_a_radio_that_loses_everything_is_refused():
    rules = f'radio.rules=[{RANGE},{{kind="loss",probability=1.0}}]'
    with pytest.raises(ScenarioError, match=r"robots\.parameters: .* loses every frame"):
        shipped("clear-corridor", rules)
