"""Exactness on graphs: a rehearsal is, tick for tick, what an event-driven simulation says it must be."""

import os
from fractions import Fraction
from pathlib import Path

import pytest

from deploy.field_file import whole_graph
from deploy.metrics.area import AreaMetrics
from deploy.scenario_file import find_scenario, load_scenario
from tests.builders import STILL, course, scenario
from tests.graph_builders import GRAPHS, STEP_M, chance, data_graph, made_up
from tests.graph_oracle import patrol
from tests.live_runs import launched, run_hash
from tests.test_graph_file import FOLDER_VARIABLE
from wire.fields import Graph
from wire.scenario import Robots, Scenario, TowerSection

RULES = ("conscientious_reactive", "heuristic_conscientious_reactive")
TRIALS = 20
METRICS = (
    "instantaneous_graph_idleness_s",
    "average_graph_idleness_s",
    "instantaneous_worst_idleness_s",
    "worst_idleness_at_events_s",
)


def run(graph: Graph, starts: tuple[int, ...], rule: str, horizon_s: float, tick_s: float) -> Scenario:
    """A scenario on a graph at 1 m/s, without radio."""
    robots = Robots(rule, start=starts, max_speed_m_s=1.0, sensor_range_m=0.0, shared_last_visit=True)
    return scenario(
        robots,
        parameters={"ties": "lowest"},
        field=graph,
        tick_s=tick_s,
        duration_s=horizon_s,
        ends_with_visit=True,
        tower=TowerSection(behaviour=STILL),
    )


def measured(given: Scenario, folder: Path) -> list[float]:
    """End, IGI, AGI, IWI and WI of a rehearsal."""
    facts, metrics = course(given, folder).facts, AreaMetrics(given)
    for one in facts:
        metrics.feed(one)
    told = metrics.summary()
    return [facts[-1].tick * given.tick_s, *(told[name] for name in METRICS)]


def compared(
    graph: Graph, rule: str, tick_m: Fraction, folder: Path, ticks: tuple[int, int], key: int
) -> None:
    """Random starts and horizons on one graph, each rehearsed and worked out."""
    for trial in range(TRIALS):
        draw = chance(key, trial)
        team, horizon = int(draw.integers(1, 7)), int(draw.integers(*ticks))
        starts = tuple(draw.integers(len(graph.nodes_m), size=team).tolist())
        wanted = patrol(graph, starts, rule, horizon * tick_m, tick_m)
        given = run(graph, starts, rule, float(horizon * tick_m), float(tick_m))
        assert measured(given, folder) == pytest.approx(wanted, rel=1e-9), (starts, horizon)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("number", range(4))
def test_a_run_on_a_random_graph_is_what_the_oracle_says(number, rule, tmp_path):
    compared(made_up(number), rule, STEP_M, tmp_path, (40, 160), number)


@pytest.mark.parametrize("rule", RULES)
def test_a_run_on_the_grid_is_what_the_oracle_says(rule, tmp_path):
    grid = whole_graph(Graph(graph=str(GRAPHS / "grid.toml")))
    compared(grid, rule, Fraction(57, 100), tmp_path, (40, 160), 4)


def test_processes_come_to_the_same_hash_as_the_rehearsal(tmp_path):
    given = run(made_up(0), (0, 3, 5), RULES[1], 20.0, float(STEP_M))
    folder = launched(tmp_path, given)
    assert run_hash(folder) == course(given, tmp_path / "rehearsed").run_hash


def test_a_run_that_waits_for_a_visit_ends_without_one_when_it_has_lasted_twice_as_long(tmp_path):
    robots = Robots("stand_still", start=(0, 1))
    given = scenario(robots, field=made_up(0), duration_s=20.0, ends_with_visit=True)
    assert course(given, tmp_path).facts[-1].tick == 40


RESOLUTION_M = {"1r5": 0.05, "DIAG_labs": 0.05, "ctcv": 0.05, "cumberland": 0.075, "example": 0.15}


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("name", RESOLUTION_M)
def test_a_run_on_a_map_of_patrolling_sim_is_what_the_oracle_says(name, rule, tmp_path):
    pixel_m = Fraction(str(RESOLUTION_M[name]))
    compared(data_graph(name), rule, pixel_m, tmp_path, (200, 600), 5)


PUBLISHED = {
    RULES[0]: (501.45, 86.15, 53.87, 219.22, 231.00),
    RULES[1]: (503.475, 52.60, 49.65, 243.90, 298.80),
}


@pytest.mark.parametrize("rule", RULES)
def test_cumberland_is_as_published(rule, tmp_path):
    """Source: M2Bench, arXiv 2605.09633: CR and HCR, six robots, 500 s; end, IGI, AGI, IWI and WI."""
    data_graph("cumberland")
    file = Path(os.environ[FOLDER_VARIABLE]) / "cumberland.graph"
    settings = [f"field.graph={file}", f"behaviour={rule}", "robots.start=[0, 8, 16, 24, 32, 39]"]
    given = load_scenario(find_scenario("graph-exact"), settings)
    assert measured(given, tmp_path) == pytest.approx(PUBLISHED[rule], abs=0.02)
