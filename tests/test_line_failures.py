"""Robots of the line that die, run out of charge or freeze, and batteries that run low together."""

import msgspec
import pytest

from tests.line_courses import FLAT, NOISE, Run, line_run, rehearsed_line, run_of, times
from tests.live_runs import launched, run_hash
from wire.scenario import PlannedFault, Scenario

OUTER, INNER = 1, 2


def planned(given: Scenario, *faults: tuple) -> Scenario:
    """The scenario with faults: (tick, verb, node) and further fields."""
    plan = [PlannedFault(float(tick), verb, (node,), **(dict(*rest))) for tick, verb, node, *rest in faults]
    return msgspec.structs.replace(given, faults=tuple(plan))


def on(run: Run, tick: int, segment: int) -> list[str]:
    """Who says at a tick that it patrols a segment."""
    doing = dict(run.states())[tick]
    return [node for node, what in doing.items() if what == ("patrol", segment)]


def deployed(folder, given: Scenario) -> tuple[Scenario, dict[int, str]]:
    """Who patrols which segment at tick 120, when all are deployed."""
    run = rehearsed_line(folder / "deployed", msgspec.structs.replace(given, duration_s=120.0))
    return given, {segment: on(run, 120, segment)[0] for segment in range(1, 5)}


def lost(run: Run, node: str) -> int:
    """When the tower first counted a robot as lost."""
    return next(tick for tick, desk in run.desks() if node in desk.lost)


def visited_by(run: Run, segment: int, since: int) -> dict[int, set[str]]:
    """For each site of a segment who visited it from a tick on."""
    sites = range(3 * segment - 3, 3 * segment)
    return {
        site: {node for one in run.facts if one.tick >= since for node, at in one.visits if at == site}
        for site in sites
    }


def assert_replaced(run: Run, node: str, segment: int, silent_tick: int) -> None:
    """Its silence is noticed, its segment refilled, and its body passed."""
    allowed, told = times(run.scenario), run.scenario.tower.parameters
    noticed = lost(run, node)
    assert 0 < noticed - silent_tick <= told["silence_s"] + told["round_s"]
    assert run.covered_after(noticed)[segment] <= allowed.recovery
    new = [one for one in on(run, noticed + int(allowed.recovery), segment) if one != node]
    assert len(new) == 1
    for site, visitors in visited_by(run, segment, noticed).items():
        assert set(new) & visitors, f"site {site} is not visited past the body"
    assert not [pair for one in run.facts for pair in one.incidents]


def assert_waits_in_queue(run: Run, node: str) -> None:
    """In the end it is there, and the tower knows, which misses nobody."""
    *_, (_, desk) = run.desks()
    assert node in desk.queue and desk.lost == ()


@pytest.mark.parametrize("segment", [OUTER, INNER])
@pytest.mark.parametrize("rule", ["base", "leapfrog"])
def test_a_robot_killed_on_the_line_is_noticed_replaced_and_passed_and_comes_back(rule, segment, tmp_path):
    given, patrols = deployed(tmp_path, line_run("6r4s", 900, 1.0, f"tower.parameters.rule={rule}"))
    node = patrols[segment]
    back = (700, "restart", node, {"place": "queue"})
    run = rehearsed_line(tmp_path / "run", planned(given, (150, "kill", node), back))
    assert_replaced(run, node, segment, 150)
    assert_waits_in_queue(run, node)


def test_a_robot_killed_on_the_line_as_a_real_process(tmp_path):
    given, patrols = deployed(tmp_path, line_run("6r4s", 700, 1.0, "tower.parameters.rule=base"))
    back = (600, "restart", patrols[INNER], {"place": "queue"})
    given = planned(given, (150, "kill", patrols[INNER]), back)
    live = run_of(given, launched(tmp_path, given))
    assert run_hash(live.folder) == run_hash(rehearsed_line(tmp_path / "run", given).folder)
    assert_replaced(live, patrols[INNER], INNER, 150)
    assert_waits_in_queue(live, patrols[INNER])


def test_a_robot_that_runs_flat_on_its_segment_is_replaced_and_passed_and_comes_back(tmp_path):
    """Robots that never go home for their batteries, and one of them began with less than the others."""
    given = line_run("6r4s", 2640, 4.0, "tower.parameters.rule=base", "battery.start_sd_v=0.2", seed=153)
    stubborn = msgspec.structs.replace(given.robots, parameters=given.robots.parameters | {"home_v": 0.0})
    given = msgspec.structs.replace(given, robots=stubborn)
    given = planned(given, (2600, "kill", "r3"), (2600, "restart", "r3", {"place": "queue"}))
    run = rehearsed_line(tmp_path / "run", given)
    row = given.node_ids.index("r3")
    flat_tick = next(one.tick for one in run.facts if one.modes[row] == FLAT)
    segment = dict(run.states())[flat_tick]["r3"][1]
    assert run.flat() == {"r3"}
    assert_replaced(run, "r3", segment, flat_tick)
    assert_waits_in_queue(run, "r3")


def frozen_and_replaced(folder, tower_dies: bool) -> tuple[Run, str, int, int]:
    """A robot is frozen for ten minutes, replaced, and thawed: run, robot, segment, tick of the thaw."""
    given, patrols = deployed(folder, line_run("6r4s", 900, 1.0, "tower.parameters.rule=leapfrog"))
    faults = [(150, "freeze", patrols[OUTER]), (750, "thaw", patrols[OUTER])]
    faults += [(740, "kill", "r1"), (840, "restart", "r1")] if tower_dies else []
    return rehearsed_line(folder / "run", planned(given, *faults)), patrols[OUTER], OUTER, 750


@pytest.mark.parametrize("tower_dies", [False, True], ids=["with the tower", "by themselves"])
def test_of_two_that_believe_they_own_one_segment_one_leaves_within_a_lap(tower_dies, tmp_path):
    run, node, segment, thaw = frozen_and_replaced(tmp_path, tower_dies)
    both = [tick for tick in range(thaw, 901) if len(on(run, tick, segment)) > 1]
    assert len(on(run, thaw, segment)) == 2, "both believe it"
    assert both[-1] - thaw <= NOISE * times(run.scenario).lap
    assert node not in on(run, 900, segment) and len(on(run, 900, segment)) == 1
    assert run.longest_double(frozen={node}) == 0
    assert not [pair for one in run.facts for pair in one.incidents]


def test_the_older_claim_yields_when_the_tower_starts_again_among_two_owners(tmp_path):
    run, node, segment, _ = frozen_and_replaced(tmp_path, tower_dies=True)
    orders = {name: word.order for _, name, word in run.words() if word.segment == segment}
    (stays,) = on(run, 900, segment)
    assert orders[stays] > orders[node]


def away_most(folder, rule: str) -> int:
    """All batteries alike, four times the drain; so reports and rounds come four times as often."""
    settings = "battery.start_sd_v=0", "robots.parameters.report_laps=2", "tower.parameters.round_s=50"
    given = line_run("8r6s", 1760, 4.0, f"tower.parameters.rule={rule}", *settings)
    return rehearsed_line(folder / rule, given).metrics()["away_most"]


def test_proactive_recall_keeps_robots_from_going_home_together(tmp_path):
    """Source: papers/line-patrol.txt, Algorithm 3: what it is for."""
    assert away_most(tmp_path, "base") >= 4
    assert away_most(tmp_path, "proactive") <= 2


def test_robots_idle_for_the_share_of_them_that_is_not_needed(tmp_path):
    """Source: papers/line-patrol.txt, section III: (r - s) / r, over whole rotations, noise off."""
    given = line_run("6r4s", 7000, 2.0, "robots.noise_sd=0", "tower.parameters.rule=base")
    metrics = rehearsed_line(tmp_path / "run", given).metrics()
    assert metrics["idle_share"] == pytest.approx((6 - 4) / 6, rel=0.02)
