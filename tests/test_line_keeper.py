"""The line's tower as a behaviour: deployment, orders, recall. A tick is a second."""

import msgspec
import pytest

from swarm_agent.line_radio import Order
from tests.line_builders import LISTENED, Watch, deployed, report
from tower.line_keeper import LineKeeperParameters
from wire.messages import WAKE_ON_FRAME

HOME = {"state": "home", "low": True, "battery_v": 8.4}


def awaiting(robots: int = 8, **parameters) -> Watch:
    """A tower that has heard its robots from the queue and still listens."""
    watch = Watch(**parameters)
    watch.step(0)
    watch.step(1, *[report(f"r{number}", 0) for number in range(2, robots + 2)])
    return watch


def answering(watch: Watch, last_tick: int) -> list[tuple[int, str, int]]:
    """Every order until a tick, each carried out at once."""
    given = []
    while watch.move.wake_tick <= last_tick:
        tick = watch.move.wake_tick
        sent = watch.step(tick) and watch.sent()
        given += [(tick, *one) for one in sent]
        watch.step(tick + 1, *[watch.obey(node, tick) for node, _ in sent])
    return given


@pytest.mark.parametrize("rule", ["base", "proactive", "leapfrog", "leapfrog+proactive"])
def test_robots_are_deployed_one_by_one_the_outermost_segments_first(rule):
    """Source: papers/line-patrol.txt, Algorithm 2, line 1"""
    given = answering(awaiting(rule=rule), 150)
    assert given == [
        (LISTENED + 10 * place, f"r{place + 2}", segment) for place, segment in enumerate([1, 6, 2, 5, 3, 4])
    ]


def test_while_it_deploys_it_sends_directly_under_shifting_rules_too():
    """Source: none; the paper deploys every robot to its own segment."""
    watch = awaiting(rule="base")
    watch.step(20, report("r20", 19, "patrol", 4), report("r21", 19, "patrol", 5))
    assert answering(watch, LISTENED + 20) == [(30, "r2", 1), (40, "r3", 6), (50, "r4", 2)]


def test_later_a_robot_from_the_queue_is_sent_at_once():
    """Source: papers/line-patrol.txt, Algorithm 2, line 18"""
    watch = deployed(rule="leapfrog")
    watch.step(101, watch.obey("r2", 100, **HOME), watch.obey("r3", 100, **HOME))
    assert watch.sent() == [("r8", 1), ("r9", 6)]


def test_a_robot_that_leaves_is_replaced_by_a_chain_of_shifts():
    """Source: papers/line-patrol.txt, Algorithm 2, lines 11-18"""
    watch = deployed(rule="base")
    watch.step(101, watch.obey("r2", 100, **HOME))
    assert watch.sent() == [("r4", 1)]
    watch.step(110, watch.obey("r4", 109, state="out"))
    assert watch.sent() == [("r6", 2)]
    watch.step(120, watch.obey("r6", 119, state="out"))
    assert watch.sent() == [("r8", 3)]
    assert watch.step(121, watch.obey("r6", 120), watch.obey("r8", 120)).report.vacant == ()


def test_who_is_not_charged_waits():
    watch = awaiting(robots=0)
    watch.step(40, report("r2", 39, battery_v=8.6), report("r3", 39, battery_v=8.8))
    assert watch.sent() == [("r3", 1)]


def test_an_order_is_repeated_until_it_is_acknowledged():
    watch = awaiting(robots=1)
    watch.until(LISTENED)
    first = watch.orders["r2"]
    assert [one.relay for one in watch.move.say] == [False]
    repeats = []
    while watch.move.wake_tick <= 100:
        watch.grant(watch.move.wake_tick)
        repeats += [(watch.keeper._promised_tick, one) for one in watch.move.say]
    assert [one.message for _, one in repeats] == [first, first]
    assert [one.said_tick for _, one in repeats] == [LISTENED + 30, LISTENED + 60]
    assert all(one.relay for _, one in repeats)
    watch.step(101, watch.obey("r2", 100, state="out"))
    watch.until(190)
    assert watch.said(Order) == []


def test_an_order_is_said_again_to_a_robot_that_has_forgotten_it():
    watch = awaiting(robots=1)
    watch.until(LISTENED)
    first = watch.orders["r2"]
    watch.step(LISTENED + 2, watch.obey("r2", LISTENED + 1, state="queue"))
    watch.until(190)
    assert watch.said(Order) == []
    watch.step(191, report("r2", 190, "queue", order=0))
    assert watch.said(Order) == [first], "reborn, it has forgotten what it acknowledged"


def test_who_waits_in_the_queue_long_after_an_order_that_it_has_heard_has_been_out_and_is_back():
    watch = awaiting(robots=1)
    watch.until(LISTENED)
    first = watch.orders["r2"]
    watch.step(200, watch.obey("r2", 199, state="queue"))
    assert [node for node, _ in watch.sent()] == ["r2"]
    assert watch.orders["r2"].number > first.number


def test_an_order_to_somebody_heard_by_relay_is_passed_on():
    watch = awaiting(robots=0)
    watch.step(40, report("r2", 38, hops=2))
    assert [(one.message.to, one.relay) for one in watch.move.say] == [("r2", True)]
    watch.until(200)
    assert watch.rolls() == [(False, False)], "a roll that asks for nothing only tells who hears it directly"


def test_a_roll_call_is_answered_once_and_the_roll_is_called_every_round():
    watch = Watch()
    watch.step(0)
    assert watch.rolls() == [(True, True)]
    watch.step(1, report("r2", 0))
    assert watch.rolls() == []
    watch.until(200)
    assert watch.rolls() == [(False, False)]
    watch.until(400)
    assert watch.rolls() == [(False, False)]


def test_who_does_not_know_that_the_tower_hears_it_is_shown():
    watch = deployed()
    watch.step(110, watch.obey("r2", 109, relay=True))
    assert watch.rolls() == [(False, False)]
    watch.step(112, watch.obey("r2", 111))
    assert watch.rolls() == []
    watch.until(200)
    assert watch.rolls() == [(False, False)], "the next round comes as it would have come"


def test_order_numbers_grow_for_ever():
    watch = deployed(rule="leapfrog")
    watch.step(101, watch.obey("r2", 100, **HOME), watch.obey("r3", 100, **HOME))
    numbers = [one.number for one in watch.entries if one.kind == "order"]
    assert numbers == sorted(set(numbers))
    again = Watch(remembered=watch.entries, rule="leapfrog")
    again.step(102)
    again.step(103, report("r4", 102, **HOME), report("r10", 102))
    again.until(140)
    assert again.orders["r10"].segment == 2
    assert again.orders["r10"].number > max(numbers)


def tired(watch: Watch, tick: int, **battery_v: float) -> list:
    """Reports of all six patrolling robots, 9 V unless told."""
    nodes = ("r2", "r3", "r4", "r5", "r6", "r7")
    return [watch.obey(node, tick, battery_v=battery_v.get(node, 9.0)) for node in nodes]


@pytest.mark.parametrize("rule", ["proactive", "leapfrog+proactive"])
def test_once_a_round_one_robot_at_most_is_recalled(rule):
    """Source: papers/line-patrol.txt, Algorithm 3"""
    watch = deployed(rule=rule)
    watch.step(150, *tired(watch, 149, r4=8.4, r6=8.45))
    assert watch.sent() == []
    watch.until(200)
    assert watch.sent() == [("r4", 0)]
    assert watch.move.report.recalled == ("r4",)
    watch.step(380, *tired(watch, 379, r4=8.4, r6=8.45)[3:])
    watch.until(399)
    assert watch.kinds("recall") == [("recall", "r4", 0)]
    watch.until(400)
    assert ("r6", 0) in watch.sent()


@pytest.mark.parametrize("rule", ["base", "leapfrog", "overlap"])
def test_other_rules_recall_nobody(rule):
    """Source: papers/line-patrol.txt, Algorithm 2: robots leave by themselves."""
    watch = deployed(rule=rule)
    assert watch.kinds("recall") == []
    if rule != "overlap":
        watch.step(150, *tired(watch, 149, r4=8.4))
    watch.until(700)
    assert watch.kinds("recall") == []


def test_a_recalled_robot_is_out_of_the_list_until_it_was_in_the_queue():
    watch = deployed(rule="leapfrog+proactive")
    watch.step(150, *tired(watch, 149, r4=8.4))
    watch.until(200)
    number = watch.orders["r4"].number
    lap = report("r4", 249, "patrol", 2, order=number, battery_v=8.39)
    watch.step(250, lap, report("r8", 249), report("r9", 249))
    watch.until(400)
    assert watch.kinds("recall") == [("recall", "r4", 0)]
    assert watch.step(401, report("r4", 400, "home", order=number)).report.recalled == ("r4",)
    assert watch.sent() == [("r8", 2)], "its segment falls vacant as it leaves"
    assert watch.step(420, report("r4", 419, order=number)).report.recalled == ()


def test_a_report_from_before_the_recall_does_not_end_it():
    watch = deployed(rule="proactive")
    watch.step(150, *tired(watch, 149, r4=8.4))
    watch.until(200)
    watch.step(201, report("r4", 199, "queue"))
    assert "r4" in watch.keeper.recalled


def test_it_sleeps_while_nothing_is_due():
    watch = deployed(rule="proactive")
    assert watch.move.wake_on == WAKE_ON_FRAME
    steps = 0
    while watch.move.wake_tick <= 2100:
        steps += 1
        watch.grant(watch.move.wake_tick)
    assert steps <= 2 * 2100 / 200 + 8


def test_nothing_is_told_or_written_when_nothing_happens():
    watch = deployed()
    before = len(watch.entries)
    assert watch.step(150).report is None
    watch.step(151, *[watch.obey(node, 150) for node in watch.orders])
    assert len(watch.entries) == before
    assert watch.move.report.hops == (0,) * 6


def test_under_overlap_it_listens_calls_the_roll_and_writes_down():
    watch = awaiting(robots=2, rule="overlap")
    watch.step(40, report("r2", 39, "patrol", 3), report("r3", 39, "patrol", 3))
    watch.until(400)
    assert watch.orders == {}
    assert ("heard", "r2", 3) in watch.kinds("heard")
    assert watch.kinds("lost") == [("lost", "r2", 0), ("lost", "r3", 0)]


def test_what_cannot_be_true_is_not_heard():
    watch = awaiting(robots=0)
    strange = [
        report("r2", 50, "patrol", 1),
        report("r2", 39, "patrol", 7),
        report("nobody", 39, "patrol", 1),
        report("r3", 39, battery_v=float("nan")),
    ]
    watch.step(40, *strange)
    assert watch.kinds("heard") == []


@pytest.mark.parametrize(
    "wrong", [{"round_s": 0}, {"margin_v": -1}, {"rule": "best"}, {"partition_s": 10.0}, {"speed": 1}]
)
def test_wrong_parameters_are_refused(wrong):
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(wrong, LineKeeperParameters)
