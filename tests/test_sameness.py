"""Visits as the world judges them, and what makes two runs the same."""

import msgspec
import pytest

from tests.builders import AWAKE, course, planned, scenario, scripted
from wire.fields import Grid
from wire.scenario import Loss, PlannedFault, RadioSection, Range, Robots, Scenario

# Visits


def test_a_visit_is_the_robots_own_goal_reached(tmp_path):
    """Source: Kobayashi et al. 2025, section III-A. Sites at 15 m and 45 m; the second is only passed."""
    field = Grid(3, 1)
    scripts = {"r2": {"go": {"0": [75, 15, 3]}}, "r3": {"go": {"0": [14, 15, 3]}}}
    run = course(scripted(scripts, [(45, 15), (0, 15)], field=field), tmp_path)
    assert {(node, site) for _, node, site in run.visits()} == {("r2", 2)}
    assert run.visits()[0][0] == 18  # 27 m at 1.5 m/s


def test_a_visit_is_within_reach_of_the_field_whatever_the_robot_calls_arrival(tmp_path):
    scripts = {"r2": {"go": {"0": [45, 15, 30]}}, "r3": {"go": {"0": [45, 15, 0]}}}
    run = course(scripted(scripts, [(15, 15), (15, 15)], field=Grid(2, 1)), tmp_path)
    assert {tick for tick, _, _ in run.visits() if tick < 19} == {18}
    assert {node for tick, node, _ in run.visits() if tick == 18} == {"r2", "r3"}


def test_the_dead_and_the_frozen_visit_nothing(tmp_path):
    go = {"go": {"0": [45, 15, 3]}}
    faults = (
        PlannedFault(17, "kill", ("r2",)),
        PlannedFault(17, "freeze", ("r3",)),
        PlannedFault(30, "thaw", ("r3",)),
    )
    run = course(
        planned(*faults, scripts={"r2": go, "r3": go, "r4": AWAKE}, poses=[(15, 15)] * 3, field=Grid(2, 1)),
        tmp_path,
    )
    assert run.visits()[0][:2] == (30, "r3")
    assert {node for _, node, _ in run.visits()} == {"r3"}


@pytest.mark.parametrize("others", [{}, {"r3": AWAKE}], ids=["alone", "with somebody awake"])
@pytest.mark.parametrize("speed", [1.5, 40.0])
def test_what_others_do_does_not_change_when_a_sleeping_robot_visits(tmp_path, others, speed):
    robots = Robots("tests.scripted:Scripted", 2, max_speed_m_s=speed, max_turn_rad_s=4.0)
    scripts = {"r2": {"go": {"0": [45, 15, 0]}}} | others
    run = course(scripted(scripts, [(15, 15), (0, 0)], field=Grid(2, 1), robots=robots), tmp_path)
    assert run.visits() == [(18 if speed == 1.5 else 1, "r2", 1)]


def test_staying_at_a_site_is_one_visit_and_coming_again_another(tmp_path):
    go = {"0": [45, 15, 3], "22": [75, 15, 3], "23": [45, 15, 3]}
    run = course(scripted({"r2": {"every_tick": True, "go": go}}, [(43, 15)], field=Grid(3, 1)), tmp_path)
    assert run.visits() == [(1, "r2", 1), (24, "r2", 1)]


def test_going_again_to_where_it_stands_is_another_visit(tmp_path):
    """The mind completes its target again, so the world must: the tower would know of more than happened."""
    go = {"0": [45, 15, 3], "20": [45, 15, 3]}
    run = course(scripted({"r2": {"every_tick": True, "go": go}}, [(43, 15)], field=Grid(3, 1)), tmp_path)
    assert run.visits() == [(1, "r2", 1), (21, "r2", 1)]


# Sameness


def test_the_same_scenario_and_seed_give_the_same_hash_and_facts(tmp_path):
    plan = scenario(4, radio=RadioSection((Range(180.0), Loss(0.3))))
    once, again = course(plan, tmp_path / "a"), course(plan, tmp_path / "b")
    assert once.run_hash == again.run_hash
    assert once.facts == again.facts
    assert once.journal.read_bytes() == again.journal.read_bytes()


def test_another_seed_other_faults_or_a_shorter_run_give_another_hash(tmp_path):
    fault = PlannedFault(20, "kill", ("r3",))
    plans = {
        "plain": scenario(3),
        "seed": scenario(3, seed=2),
        "fault": scenario(3, faults=(fault,)),
        "range": scenario(3, range_m=5.0),
        "parameter": scenario(3, parameters={"lock_breaker": "none"}),
    }
    hashes = {name: course(plan, tmp_path / name).run_hash for name, plan in plans.items()}
    hashes["shorter"] = course(plans["plain"], tmp_path / "shorter", 39).run_hash
    assert len(set(hashes.values())) == 6, hashes


def test_the_pace_and_the_port_are_no_part_of_the_hash(tmp_path):
    plain = scenario(2)
    other = msgspec.convert(
        msgspec.to_builtins(plain) | {"clock": {"kind": "paced"}, "wire": {"port": 7}}, Scenario
    )
    assert course(plain, tmp_path / "a").run_hash == course(other, tmp_path / "b").run_hash
