"""The line's tower after a kill: what it remembers, what it asks, whose word counts. A tick is a second."""

from pathlib import Path

import pytest

from swarm_agent.line_radio import Order
from swarm_agent.node import Mind
from tests.builders import percept
from tests.line_builders import Watch, deployed, line_configuration, report
from tower.ledger import Ledger
from wire import codec
from wire.messages import Frame

NODES = ("r2", "r3", "r4", "r5", "r6", "r7")


def reborn(watch: Watch, tick: int, **parameters) -> Watch:
    """The same tower killed and started again at a tick, with its ledger."""
    again = Watch(remembered=watch.entries, **parameters)
    again.orders = dict(watch.orders)
    again.step(tick)
    return again


def test_it_calls_the_roll_and_knows_what_it_knew():
    watch = deployed(rule="leapfrog")
    again = reborn(watch, 500, rule="leapfrog")
    assert again.rolls() == [(True, True)]
    assert (again.move.report.queue, again.move.report.vacant, again.move.report.lost) == (
        ("r8", "r9"),
        (),
        (),
    )
    assert again.sent() == []
    assert [one.kind for one in again.entries].count("born") == 2


def test_outstanding_orders_are_repeated_at_once_and_new_ones_wait():
    watch = deployed(rule="leapfrog")
    watch.step(101, watch.obey("r2", 100, state="home", low=True))
    again = reborn(watch, 200, rule="leapfrog")
    assert again.said(Order) == [watch.orders["r8"]]
    assert [one.relay for one in again.move.say] == [True, True]
    again.step(202, watch.obey("r3", 201, state="home", low=True))
    assert again.sent() == []
    again.until(230)
    assert ("r9", 6) in again.sent()


def test_an_acknowledged_order_is_not_repeated_and_still_covers():
    watch = deployed(rule="leapfrog")
    watch.step(101, watch.obey("r2", 100, state="home", low=True))
    watch.step(103, watch.obey("r8", 102, state="queue"))
    again = reborn(watch, 200, rule="leapfrog")
    again.until(260)
    assert again.sent() == []
    assert again.keeper.vacant == {}


def test_everybody_is_given_time_and_the_silent_are_lost_then():
    watch = deployed(rule="leapfrog")
    again = reborn(watch, 5000, rule="leapfrog")
    everybody = [again.obey(node, 5001) for node in NODES[1:]] + [report("r8", 5001), report("r9", 5001)]
    again.step(5002, *everybody)
    again.until(5299)
    assert again.kinds("lost") == []
    again.until(5300)
    assert (again.kinds("lost"), again.sent()) == ([("lost", "r2", 0)], [("r8", 1)])


def test_a_robots_own_word_overrides_the_ledger():
    watch = deployed(rule="leapfrog")
    again = reborn(watch, 500, rule="leapfrog")
    again.step(502, report("r8", 501, "patrol", 1, order=400000), again.obey("r2", 501, state="home"))
    again.until(560)
    assert again.sent() == []
    assert again.keeper.vacant == {}
    assert again.keeper.roster.get("r8").state == "patrol"


def test_who_was_lost_or_recalled_still_is():
    watch = deployed(rule="leapfrog+proactive")
    tired = [watch.obey(node, 149, battery_v=8.4 if node == "r4" else 9.0) for node in NODES if node != "r2"]
    watch.step(150, *tired)
    watch.until(200)
    watch.step(390, *tired_again(watch, 389))
    watch.until(400)
    again = reborn(watch, 420, rule="leapfrog+proactive")
    assert (again.move.report.lost, again.move.report.recalled) == (("r2",), ("r4",))


def tired_again(watch: Watch, tick: int) -> list:
    """The others are heard again, r4 as it finishes its lap."""
    number = watch.orders["r4"].number
    r4 = report("r4", tick, "patrol", 2, order=number, battery_v=8.4)
    others = [watch.obey(node, tick) for node in NODES if node not in ("r2", "r4")]
    return [r4, *others, report("r8", tick), report("r9", tick)]


def test_the_deployment_goes_on_where_it_stopped():
    watch = Watch(rule="base")
    watch.step(0)
    watch.step(1, *[report(f"r{number}", 0) for number in range(2, 10)])
    watch.until(40)
    again = reborn(watch, 45, rule="base")
    again.step(46, *[again.obey(node, 45) for node in ("r2", "r3")])
    again.until(110)
    assert {node: one.segment for node, one in again.orders.items()}.items() >= {
        "r2": 1,
        "r3": 6,
        "r4": 2,
        "r5": 5,
        "r6": 3,
        "r7": 4,
    }.items()


def test_two_on_one_segment_the_older_order_goes_home_after_listening():
    watch = deployed(rule="leapfrog")
    again = reborn(watch, 500, rule="leapfrog")
    again.step(501, report("r8", 500, "patrol", 1, order=400000), *[again.obey(node, 500) for node in NODES])
    assert again.sent() == []
    again.until(530)
    assert again.sent() == [("r2", 0)]
    assert again.orders["r2"].number > 400000


def test_frozen_and_thawed_it_gives_everybody_time():
    watch = deployed(rule="leapfrog")
    assert watch.move.wake_tick < 5000
    watch.grant(5000)
    assert watch.rolls() == [(True, True)]
    assert watch.kinds("lost") == []
    watch.until(5299)
    assert watch.kinds("lost") == []


@pytest.mark.parametrize("cut", [0, 3, 10, 25])
def test_a_life_killed_at_any_grant_goes_on_with_what_was_written(tmp_path: Path, cut: int):
    """A killed tower that is started again knows as much of its robots as one that lived on."""
    percepts = a_life(40)
    whole = Mind("tower", Ledger(tmp_path / "whole.sqlite"))
    for one in percepts:
        whole.answer(codec.encode(one))
    first = Mind("tower", Ledger(tmp_path / "cut.sqlite"))
    for one in percepts[: cut + 1]:
        first.answer(codec.encode(one))
    second = Mind("tower", Ledger(tmp_path / "cut.sqlite"))
    told = line_configuration()
    for place, one in enumerate(percepts[cut:]):
        again = percept(one.tick, grant=one.grant, inbox=one.inbox, configuration=None if place else told)
        second.answer(codec.encode(again))
    here, there = (
        [
            (one.node, one.state, one.segment, one.battery_v, one.acknowledged)
            for one in mind._behaviour.roster
        ]
        for mind in (whole, second)
    )
    assert here == there


def test_a_kept_memory_lived_again_writes_the_same_ledger(tmp_path: Path):
    path = tmp_path / "ledger.sqlite"
    found = []
    for _ in range(2):
        mind = Mind("tower", Ledger(path))
        answers = [mind.answer(codec.encode(one)) for one in a_life(40)]
        found.append((answers, list(Ledger(path).read(1000))))
    assert found[0] == found[1]


def a_life(ticks: int) -> list:
    """Percepts of a tower whose robots report now and then."""
    told, life = line_configuration(), []
    for tick in range(ticks):
        node = f"r{2 + tick % 8}"
        word = report(node, tick - 1, "queue" if tick % 3 else "patrol", 0 if tick % 3 else 1 + tick % 6)
        inbox = [Frame(node, tick - 1, codec.encode(word.message))] if tick else []
        life.append(percept(tick, inbox=inbox, configuration=None if tick else told))
    return life
