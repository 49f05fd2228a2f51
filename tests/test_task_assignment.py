"""DTAG and DTAP in rehearsed runs: whole fields, deaths, new minds, and the same again."""

import numpy as np
import pytest
from msgspec.structs import replace as changed

from deploy.metrics.area import AreaMetrics
from swarm_agent.behaviours.dtag import Plan
from tests.builders import course, scenario
from wire import codec
from wire.fields import Grid
from wire.scenario import PlannedFault

both = pytest.mark.parametrize("name", ["dtag", "dtap"])
PLACES = ((15.0, 15.0, 0.0), (75.0, 75.0, 0.0), (15.0, 75.0, 0.0))
WEIGHTS = {"dtag": {"start_weight": 0.0}, "dtap": {}}
"""Three robots that start apart would, as published, hardly leave their corners."""


def small(name: str, duration_s: float = 900.0, **fields):
    """Three robots on nine cells, all in range of each other and of the tower."""
    return scenario(3, name, WEIGHTS[name], poses=PLACES, field=Grid(3, 3), duration_s=duration_s, **fields)


def plans(run, node: str) -> dict[int, Plan]:
    """What a robot reported, by tick."""
    told = ((one.tick, name, report) for one in run.facts for name, report in one.reports)
    return {tick: codec.decode(Plan, report) for tick, name, report in told if name == node}


@both
@pytest.mark.parametrize("robots", [4, 9, 14])
def test_the_field_of_the_paper_is_patrolled_more_and_more(name, robots, tmp_path):
    run = course(scenario(robots, name, field=Grid(), duration_s=3000.0), tmp_path)
    visits = run.visits()
    assert {node for _, node, _ in visits} == {f"r{number}" for number in range(2, robots + 2)}
    by_thirds = np.histogram([tick for tick, _, _ in visits], 3, (0, 3000))[0]
    assert by_thirds.min() > 1000 / 100 * robots * (0.5 if name == "dtag" else 2.5)
    known = [len({site for tick, _, site in visits if tick <= until}) for until in (200, 600, 3000)]
    assert known[0] < known[1] < known[2]


@both
def test_a_small_field_is_visited_everywhere_and_the_tower_knows(name, tmp_path):
    given = small(name)
    run, metrics = course(given, tmp_path), AreaMetrics(given)
    for one in run.facts:
        metrics.feed(one)
    assert {site for _, _, site in run.visits()} == set(range(9))
    assert {node for _, node, _ in run.visits()} == {"r2", "r3", "r4"}
    assert (metrics.visited_tick - metrics.known_tick).max() <= 3 and metrics.known_tick.min() > 0


@both
def test_what_a_robot_that_is_killed_had_taken_is_visited_by_others(name, tmp_path):
    """Two seconds after it set out and told so; what it holds then it holds for ever, or only seems to."""
    before = course(small(name), tmp_path / "unharmed")
    told = plans(before, "r4")
    set_out = next(tick for tick, node, _ in before.visits() if node == "r4" and tick > 100)
    reserved = next(plan.next_site for tick, plan in told.items() if tick >= set_out)
    kill = PlannedFault(set_out + 2.0, "kill", ("r4",))
    run = course(small(name, faults=(kill,)), tmp_path / "killed")
    after = [(tick, node, site) for tick, node, site in run.visits() if tick > set_out + 2]
    assert {node for _, node, _ in after} == {"r2", "r3"}
    visits = [tick for tick, _, site in after if site == reserved]
    assert visits[0] < set_out + 9 * 30
    assert max(np.diff([*visits, 900])) < 9 * 30


@both
@pytest.mark.parametrize("memory", ["lost", "kept"])
def test_a_robot_that_is_restarted_patrols_again(name, memory, tmp_path):
    faults = (PlannedFault(200.0, "kill", ("r3",)), PlannedFault(400.0, "restart", ("r3",), memory=memory))
    visits = course(small(name, faults=faults), tmp_path).visits()
    theirs = [tick for tick, node, _ in visits if node == "r3"]
    assert not [tick for tick in theirs if 200 < tick < 400]
    assert len([tick for tick in theirs if tick >= 400]) > 8


@both
def test_the_same_seed_gives_the_same_run_and_another_seed_another(name, tmp_path):
    given = scenario(5, name, field=Grid(8, 8), duration_s=400.0)
    once = course(given, tmp_path / "once").run_hash
    assert course(given, tmp_path / "again").run_hash == once
    assert course(changed(given, seed=2), tmp_path / "other").run_hash != once


@both
def test_a_robot_alone_patrols_a_field_of_two_cells(name, tmp_path):
    run = course(scenario(1, name, field=Grid(1, 2), duration_s=300.0), tmp_path)
    sites = [site for _, _, site in run.visits()]
    assert len(sites) > 8 and set(sites) == {0, 1}


@both
def test_a_field_of_one_cell_is_visited_again_and_again(name, tmp_path):
    run = course(scenario(1, name, field=Grid(1, 1), duration_s=100.0), tmp_path)
    assert len(run.visits()) > 8


def test_robots_that_begin_at_one_place_part(tmp_path):
    """Equal bids at equal times: without an order between them nobody would ever win."""
    run = course(scenario(9, "dtap", field=Grid(), duration_s=40.0), tmp_path)
    goals = {list(plans(run, f"r{number}").values())[-1].next_site for number in range(2, 11)}
    assert len(goals) == 9 and -1 not in goals


def test_a_robot_that_waits_for_its_auction_has_visited_once(tmp_path):
    """Cells so near that every arrival comes before the auction ends."""
    field = Grid(1, 6, 4.0)
    visits = course(scenario(1, "dtap", field=field, duration_s=200.0), tmp_path).visits()
    ticks, sites = [tick for tick, _, _ in visits], [site for _, _, site in visits]
    assert len(visits) > 50 and np.diff(ticks).min() >= 2
    assert all(np.diff(sites))
