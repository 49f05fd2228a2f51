"""The robot of the line patrol, line by line of Algorithm 2 as far as a robot carries it out."""

import pytest

from swarm_agent.line_radio import Order, Report, Roll
from tests.line_robot import BODY_M, LINE, LineRobot
from wire.messages import Dock, Follow


def test_a_robot_in_the_queue_says_so_and_waits():
    robot = LineRobot()
    move = robot.wake(robot.hears(Roll()))
    assert robot.said == [Report("queue", 0, 9.0)]
    assert move.motion is None
    assert move.wake_tick > robot.tick + 100, "a robot in the queue is not asked every tick"


def test_line_1_and_18_ordered_from_the_queue_it_drives_out_by_the_passing_lane():
    """Source: papers/line-patrol.txt, Algorithm 2, lines 1 and 18."""
    robot = LineRobot()
    robot.wake()
    robot.wake(robot.order(1))
    assert robot.said[0].state == "out" and robot.said[0].segment == 1
    own = LINE.segment(1)
    assert robot.path[0] == (LINE.tower_arc_m, LINE.lane_m)
    assert robot.path[-2] == (pytest.approx(own.near_m + LINE.approach_m), pytest.approx(LINE.lane_m))
    assert robot.path[-1] == (pytest.approx(own.near_m), 0.0)


def test_arrived_it_reports_and_begins_a_lap_there_and_back():
    robot = LineRobot().on_patrol(1)
    assert robot.said[0].state == "patrol"
    own = LINE.segment(1)
    assert [arc for arc, _ in robot.path] == [pytest.approx(own.far_m), pytest.approx(own.near_m)]


def test_lines_3_and_4_above_the_threshold_it_completes_another_lap():
    """Source: papers/line-patrol.txt, Algorithm 2, lines 3 and 4."""
    robot = LineRobot(home_v=8.5).on_patrol(2)
    robot.battery_v = 8.51
    robot.lap()
    assert robot.mind.state == "patrol" and robot.mind.laps == 1
    assert robot.path[-1][0] == pytest.approx(LINE.segment(2).near_m)


def test_lines_5_to_8_low_it_says_so_leaves_the_segment_and_returns_to_the_tower():
    """Source: papers/line-patrol.txt, Algorithm 2, lines 5 to 8."""
    robot = LineRobot(home_v=8.5).on_patrol(2)
    robot.battery_v = 8.5
    robot.wake(after=5)
    assert robot.move.motion is None, "a lap is not interrupted for a battery"
    robot.lap()
    assert robot.said == [Report("home", 0, 8.5, robot.mind.order, 1, low=True)]
    assert robot.move.motion.path_m[-1] == LINE.slot(0)
    assert robot.path[-2] == (LINE.tower_arc_m, LINE.lane_m)


def test_a_robot_called_home_completes_its_lap_first():
    robot = LineRobot().on_patrol(2)
    robot.wake(robot.order(0), travelled_m=0.5)
    assert robot.move.motion is None and robot.mind.state == "patrol"
    assert robot.said[0].order == robot.mind.order, "the order is acknowledged at once"
    robot.lap()
    assert robot.mind.state == "home" and not robot.said[0].low


def test_lines_13_to_15_moving_out_it_leaves_at_the_far_end():
    """Source: papers/line-patrol.txt, Algorithm 2, lines 13 to 15, and section III-B."""
    robot = LineRobot().on_patrol(2)
    inner, outer = LINE.segment(2), LINE.segment(1)
    robot.at(inner.near_m - 0.5).wake(robot.order(1), travelled_m=0.5)
    assert [arc for arc, _ in robot.path] == [pytest.approx(inner.far_m)], "outward: only to the far end"
    robot.at(inner.far_m).wake(arrived=True, travelled_m=0.7)
    assert robot.said[0].state == "out" and robot.said[0].segment == 1
    assert robot.path == [(pytest.approx(outer.near_m), 0.0)], "it just crosses the gap"


def test_moving_out_on_the_way_back_it_first_completes_the_lap():
    """The worst case of section III-B: the neighbour has just turned back."""
    robot = LineRobot().on_patrol(2)
    own = LINE.segment(2)
    robot.at(own.far_m + 0.1).wake(robot.order(1), travelled_m=1.3)
    assert [arc for arc, _ in robot.path] == [pytest.approx(own.near_m), pytest.approx(own.far_m)]


def test_moving_out_at_the_far_end_it_goes_at_once():
    """The best case of section III-B: the neighbour just arrives at the border."""
    robot = LineRobot().on_patrol(2)
    own = LINE.segment(2)
    robot.at(own.far_m).wake(robot.order(1), travelled_m=1.2)
    assert robot.path == [] or [arc for arc, _ in robot.path] == [pytest.approx(own.far_m)]


def test_an_order_past_a_patrolled_segment_goes_by_the_passing_lane():
    robot = LineRobot().on_patrol(3)
    robot.wake(robot.order(4), travelled_m=0.1)
    robot.wake(robot.order(2))
    robot.at(LINE.segment(3).far_m).wake(arrived=True)
    assert robot.mind.segment == 2
    assert any(aside == pytest.approx(LINE.lane_m) for _, aside in robot.path)


def test_batteries_are_reported_every_ten_laps():
    """Source: papers/line-patrol.txt, section III-A."""
    robot = LineRobot(report_laps=10).on_patrol(2)
    told = []
    for lap in range(1, 31):
        robot.lap()
        told += [lap] * len(robot.said)
    assert told == [10, 20, 30]


def test_a_robot_that_is_held_up_reports_by_time():
    robot = LineRobot(report_laps=10).on_patrol(2)
    due = robot.move.wake_tick
    assert robot.tick + 200 < due <= robot.tick + 310
    robot.wake(after=due - robot.tick)
    assert len(robot.said) == 1


def test_home_again_it_takes_a_battery_and_then_says_what_it_has():
    robot = LineRobot(home_v=8.5).on_patrol(2)
    robot.battery_v = 8.4
    robot.lap()
    robot.place = LINE.slot(0)
    robot.wake(arrived=True)
    assert isinstance(robot.move.motion, Dock)
    robot.battery_v = 9.0
    robot.wake()
    assert robot.said == [Report("queue", 0, 9.0, robot.mind.order)]


def test_in_the_queue_it_changes_a_battery_that_has_run_down():
    robot = LineRobot(swap_below_v=8.7)
    robot.wake(robot.hears(Roll()))
    robot.battery_v = 8.69
    robot.wake()
    assert robot.move.motion is None, "at the next report, not at once"
    robot.wake(after=robot.move.wake_tick - robot.tick)
    assert isinstance(robot.move.motion, Dock)


def test_an_order_holds_over_older_ones():
    robot = LineRobot().on_patrol(2)
    robot.wake(robot.hears(Order(5_000_000, "r2", 1)))
    robot.wake(robot.hears(Order(4_000_000, "r2", 0)))
    assert robot.mind.pending == 1 and robot.said[0].order == 5_000_000


def test_an_order_to_somebody_else_is_no_order():
    robot = LineRobot().on_patrol(2)
    robot.wake(robot.hears(Order(5_000_000, "r3", 0)))
    assert robot.mind.pending is None and robot.said == []


@pytest.mark.parametrize(("other", "goes"), [(-1, False), (1, True)])
def test_of_two_robots_with_one_segment_the_older_order_goes_home(other, goes):
    robot = LineRobot().on_patrol(2)
    claim = Report("patrol", 2, 9.0, robot.mind.order + other)
    robot.wake(robot.hears(claim, origin="r9"))
    if goes:
        assert robot.said[0].state == "home", "at once: the segment is the other's to cover"
        assert robot.path[0][1] == pytest.approx(LINE.lane_m)
    else:
        assert robot.said[0].segment == 2, "it answers, so that the other knows"


def test_a_newer_claim_holds_whatever_older_claims_are_heard_with_it():
    robot = LineRobot().on_patrol(2)
    newer, older = (Report("patrol", 2, 9.0, robot.mind.order + by) for by in (1, -1))
    robot.wake(robot.hears(newer, origin="r9"), robot.hears(older, origin="r8"))
    assert robot.said[0].state == "home"


def test_of_two_robots_with_equal_orders_the_lower_number_stays():
    robot = LineRobot().on_patrol(2)
    robot.wake(robot.hears(Report("patrol", 2, 9.0, robot.mind.order), origin="r9"))
    assert robot.mind.pending is None


def test_a_roll_call_is_answered_only_when_it_asks():
    robot = LineRobot().on_patrol(2)
    robot.wake(robot.hears(Roll()))
    assert robot.said == []
    robot.wake(robot.hears(Roll(answer=True)))
    assert robot.said[0].state == "patrol"


def test_blocked_on_its_segment_it_claims_it_and_passes_by_the_lane():
    robot = LineRobot().on_patrol(2)
    own = LINE.segment(2)
    obstacle = own.near_m - 0.6
    robot.at(own.near_m - 0.38).wake(blocked_by=("r7", obstacle), travelled_m=0.38)
    assert len(robot.said) == 1
    beside = [aside for arc, aside in robot.path if abs(arc - obstacle) <= 1.3 * BODY_M]
    assert beside and all(aside == pytest.approx(LINE.lane_m) for aside in beside)
    assert robot.path[-1] == (pytest.approx(own.near_m), 0.0), "and completes its lap"
    robot.lap()
    assert any(aside > 0 for _, aside in robot.path), "it remembers for some laps"


def test_blocked_at_the_end_it_was_going_to_it_patrols_from_the_lane():
    robot = LineRobot()
    robot.wake()
    robot.wake(robot.order(2))
    near_m = LINE.segment(2).near_m
    robot.at(near_m + 0.15, 0.15).wake(blocked_by=("r7", near_m))
    assert robot.mind.state == "patrol"
    assert robot.path[0][1] == pytest.approx(LINE.lane_m)


def test_a_mind_that_wakes_on_the_line_goes_home():
    robot = LineRobot().at(LINE.segment(1).mid_m)
    robot.wake()
    assert robot.said[0].state == "home"
    assert isinstance(robot.move.motion, Follow) and robot.move.motion.path_m[-1] == LINE.slot(0)


def test_backwards_it_turns_nowhere_but_on_patrol():
    robot = LineRobot(backwards=True).on_patrol(2)
    assert robot.move.motion.backwards
    robot.battery_v = 8.0
    robot.lap()
    assert not robot.move.motion.backwards
