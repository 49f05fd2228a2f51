"""Whom the line's tower believes lost, and what it does about it. A tick is a second."""

from tests.line_builders import deployed, report


def test_a_silent_robot_is_lost_and_replaced():
    watch = deployed(rule="leapfrog")
    others = ["r3", "r4", "r5", "r6", "r7"]
    watch.step(380, *[watch.obey(node, 379) for node in others], report("r8", 379), report("r9", 379))
    watch.until(399)
    assert watch.kinds("lost") == []
    watch.until(400)
    assert watch.kinds("lost") == [("lost", "r2", 0)]
    assert (watch.sent(), watch.move.report.lost) == ([("r8", 1)], ("r2",))


def test_a_lost_robot_that_comes_back_is_sent_home_when_it_was_replaced():
    watch = deployed(rule="leapfrog")
    others = ["r3", "r4", "r5", "r6", "r7"]
    watch.step(380, *[watch.obey(node, 379) for node in others], report("r8", 379), report("r9", 379))
    watch.until(400)
    watch.step(410, watch.obey("r8", 409, state="out"))
    watch.step(450, watch.obey("r2", 440, hops=3))
    assert watch.kinds("returned") == [("returned", "r2", 0)]
    assert (watch.sent(), watch.move.report.lost, watch.move.report.hops) == ([("r2", 0)], (), (3,))
    watch.step(451, watch.obey("r8", 450))
    assert watch.sent() == [], "once"
    watch.step(460, watch.obey("r2", 459))
    watch.step(480, report("r2", 479, order=watch.orders["r2"].number))
    assert "r2" in watch.move.report.queue


def test_a_lost_robot_that_comes_back_in_time_goes_on():
    watch = deployed(robots=6, rule="base")
    watch.step(380, *[watch.obey(node, 379) for node in ("r4", "r5", "r6", "r7")])
    watch.until(400)
    assert watch.move.report.lost == ("r2", "r3")
    watch.step(401, watch.obey("r2", 400))
    assert watch.sent() == [], "its segment was taken by a shift, which is not undone"


def test_many_that_fall_silent_at_once_are_not_replaced_for_long():
    watch = deployed(rule="leapfrog")
    for tick in range(250, 1900, 150):
        watch.until(tick - 1)
        reports = [watch.obey(node, tick - 1) for node in ("r5", "r6", "r7")]
        watch.step(tick, *reports, report("r8", tick - 1), report("r9", tick - 1))
    assert watch.kinds("lost") == []
    watch.until(1900)
    assert watch.kinds("lost") == [("lost", node, 0) for node in ("r2", "r3", "r4")]


def test_who_does_not_answer_the_call_is_neither_lost_nor_moved_nor_recalled():
    """Source: none; r2, r3 and r4 patrol the left side, r5 the innermost segment of the right one."""
    watch = deployed(robots=6, rule="proactive")
    reachable = ("r3", "r5", "r7")
    watch.until(370)
    assert watch.rolls() == [(True, True)], "r2 and all others were last heard at 100"
    watch.step(372, *[watch.obey(node, 371) for node in reachable])
    watch.until(399)
    watch.step(400, watch.obey("r5", 399, state="home", low=True))
    assert watch.kinds("lost") == []
    assert watch.keeper.roster.cut_off == {"r2", "r4", "r6"}
    watch.step(401, *[watch.obey(node, 400, battery_v=8.55) for node in ("r3", "r7")])
    assert not {node for node, _ in watch.sent()} & {"r2", "r4", "r6"}
