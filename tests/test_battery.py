"""Batteries: what drains them, what fills them, and what an empty one means."""

import math

import numpy as np
import pytest

from tests.builders import AWAKE, STRAIGHT, course, on_line
from wire.scenario import BatterySection, PlannedFault
from world_server.battery import QUEUEING, TRAVELLING, Batteries

FULL = BatterySection(9.0, 8.0, 0.0, patrolling_v_h=3.6, travelling_v_h=7.2, queueing_v_h=1.8)
"""A thousandth of a volt a second on the line, two on the way, half of one in the queue."""
SLOT = (20.0, 0.6)


def volts(run, row=1) -> list[float]:
    return [float(np.frombuffer(one.battery_v, "<f4")[row]) for one in run.facts]


def modes(run, row=1) -> list[int]:
    return [one.modes[row] for one in run.facts]


def test_every_place_has_its_drain(tmp_path):
    """Source: the line-patrol paper gives volts per hour on patrol; queue and passing lane are our choice."""
    poses = [SLOT, (5.0, 0.0), (5.0, 0.3), SLOT]
    run = course(on_line({}, poses, battery=FULL), tmp_path, 9)
    assert [volts(run, row)[-1] for row in (1, 2, 3)] == pytest.approx([8.995, 8.99, 8.98], abs=1e-5)
    assert volts(run, 4)[-1] == pytest.approx(8.98, abs=1e-5)  # in somebody else's place
    assert math.isnan(volts(run, 0)[-1])


def test_the_start_is_full_less_a_spread_and_known_to_the_robot(tmp_path):
    section = BatterySection(start_sd_v=0.1)
    names = [f"r{number}" for number in range(2, 402)]
    missing = 9.0 - np.array(Batteries(section, names, 7, 1.0).volts)
    assert missing.min() >= 0
    assert missing.mean() == pytest.approx(0.1 * math.sqrt(2 / math.pi), rel=0.1)
    few = Batteries(section, names[5:6], 7, 1.0).volts
    assert few[0] == pytest.approx(9.0 - missing[5])  # whoever else is there
    run = course(on_line({"r2": AWAKE}, 2, battery=section), tmp_path, 3)
    told = [log.battery_v for log in run.logs("r2").values()]
    assert told[1:] == pytest.approx(volts(run)[:-1], abs=1e-6)


def test_without_batteries_nobody_hears_of_them(tmp_path):
    run = course(on_line({"r2": AWAKE}, 1), tmp_path, 2)
    assert run.logs("r2")[1].battery_v is None
    assert all(one.battery_v == b"" for one in run.facts)


def test_docking_gives_a_full_battery_at_once_each_time(tmp_path):
    scripts = {"r2": {"every_tick": True, "dock": [50, 80]}}
    run = course(on_line(scripts, 1, battery=FULL), tmp_path, 90)
    charge = volts(run)
    assert charge[49] == pytest.approx(9 - 50 * 0.0005, abs=1e-5)
    assert charge[50] == pytest.approx(9 - 0.0005, abs=1e-5)
    assert charge[79] == pytest.approx(9 - 30 * 0.0005, abs=1e-5)
    assert charge[80] == pytest.approx(9 - 0.0005, abs=1e-5)


@pytest.mark.parametrize("place", [(5.0, 0.0), (20.3, 0.6)])
def test_docking_elsewhere_is_standing_still(tmp_path, place):
    scripts = {"r2": {"every_tick": True, "dock": [5]}}
    run = course(on_line(scripts, [place], battery=FULL), tmp_path, 20)
    assert volts(run) == sorted(volts(run), reverse=True)
    assert volts(run)[-1] < 8.981


def test_charging_takes_its_time_and_then_the_queue_drains(tmp_path):
    slow = BatterySection(9.0, 8.0, 0.0, 3.6, 7.2, 1800.0, charge_s=10.0)
    one = Batteries(slow, ["r2"], 1, 1.0)
    one.volts[0] = 8.55
    one.dock(0)
    course_v = []
    for _ in range(6):
        one.use(0, QUEUEING)
        course_v.append(one.volts[0])
    assert course_v == pytest.approx([8.65, 8.75, 8.85, 8.95, 9.0, 8.5])
    one.dock(0)
    one.use(0, TRAVELLING)
    one.use(0, QUEUEING)
    assert one.volts[0] < 8.5  # who left is not charged when it comes back


def test_charging_ends_with_another_motion(tmp_path):
    slow = BatterySection(9.0, 8.0, 0.0, 3.6, 7.2, 36.0, charge_s=100.0)
    scripts = {"r2": {"every_tick": True, "dock": [10], "go": {"15": []}}}
    run = course(on_line(scripts, 1, battery=slow), tmp_path, 20)
    steps = np.diff(volts(run))
    assert steps[9:14] == pytest.approx([0.01] * 5, abs=1e-5)
    assert steps[14:] == pytest.approx([-0.01] * len(steps[14:]), abs=1e-5)


EMPTYING = BatterySection(9.0, 8.0, 0.0, 36.0, 36.0, 36.0)
"""Empty after a hundred seconds."""


def test_a_flat_robot_stops_falls_silent_and_is_deaf(tmp_path):
    scripts = {
        "r2": {"every_tick": True, "say_always": "x", "go": {"0": [40, 0, 0]}},
        "r3": {"wake_ticks": [1, 150], "dock": [1], "say": {"1": ["y"]}},
    }
    given = on_line(scripts, [(0.0, 0.0), SLOT], battery=EMPTYING, robots={"max_speed_m_s": 0.2})
    run = course(given, tmp_path, 160)
    flat = modes(run).index(3)
    assert flat in (99, 100) and modes(run)[flat:] == [3] * (161 - flat)
    assert volts(run)[flat] <= 8.0 < volts(run)[flat - 2]
    assert len(set(run.positions(1)[flat:])) == 1
    assert max(run.grants("r2")) == flat
    assert all(one.radio[0] == 0 for one in run.facts[flat:] if one.tick < 150)
    goals = np.frombuffer(run.facts[flat].goals).reshape(-1, 2)
    assert np.isnan(goals[1]).all()


def test_nobody_is_heard_by_who_is_flat(tmp_path):
    loud = {"every_tick": True, "say_always": "x", "dock": list(range(1, 200, 20))}
    given = on_line({"r2": AWAKE, "r3": loud}, [(18.0, 0.0), (20.0, 0.9)], battery=EMPTYING)
    run = course(given, tmp_path, 120)
    assert modes(run, 2)[-1] == 0 and modes(run, 1)[-1] == 3
    delivered = [one.radio[1] for one in run.facts]
    assert delivered[50] == 2 and delivered[-1] == 1  # the tower still hears


def test_the_dead_do_not_drain_and_flat_robots_can_be_killed(tmp_path):
    faults = (PlannedFault(30.0, "kill", ("r3",)), PlannedFault(120.0, "kill", ("r2",)))
    run = course(on_line({}, [(5.0, 0.0), (15.0, 0.0)], battery=EMPTYING, faults=faults), tmp_path, 130)
    assert len(set(volts(run, 2)[30:])) == 1
    assert [modes(run)[tick] for tick in (98, 110, 120)] == [0, 3, 2]


@pytest.mark.parametrize("memory", ["lost", "kept"])
def test_a_robot_restarted_in_the_queue_is_charged_and_lives(tmp_path, memory):
    faults = (
        PlannedFault(120.0, "kill", ("r2",)),
        PlannedFault(130.0, "restart", ("r2",), memory=memory, place="queue"),
    )
    script = {"r2": {"every_tick": True, "go": {"0": [10, 0, 0]}}}
    run = course(on_line(script, [(5.0, 0.0)], battery=EMPTYING, faults=faults), tmp_path, 140)
    assert modes(run)[125:] == [2] * 5 + [0] * 11
    assert run.positions(1)[130] == SLOT
    assert volts(run)[130] == pytest.approx(9 - 0.01, abs=1e-5)
    grants = run.grants("r2")
    assert grants[130] == ("start" if memory == "lost" else "wake")
    assert run.logs("r2")[130].arrived


def test_a_robot_restarted_where_it_ran_flat_stays_flat(tmp_path):
    faults = (PlannedFault(120.0, "kill", ("r2",)), PlannedFault(130.0, "restart", ("r2",), memory="kept"))
    run = course(on_line({"r2": AWAKE}, [(5.0, 0.0)], battery=EMPTYING, faults=faults), tmp_path, 140)
    assert modes(run)[130:] == [3] * 11
    assert max(run.grants("r2")) <= 100


def test_a_robot_that_runs_flat_while_it_is_frozen_is_flat_when_it_thaws(tmp_path):
    faults = (PlannedFault(50.0, "freeze", ("r2",)), PlannedFault(120.0, "thaw", ("r2",)))
    run = course(on_line({"r2": AWAKE}, [(5.0, 0.0)], battery=EMPTYING, faults=faults), tmp_path, 130)
    assert [modes(run)[tick] for tick in (49, 50, 119, 120)] == [0, 1, 1, 3]


def test_the_field_of_these_tests_has_its_queue_where_they_say():
    assert STRAIGHT.lane_m * 2 == SLOT[1]
