"""The roster: the latest word of each robot, losses, and the suspicion that the radio is split."""

from swarm_agent.line_radio import Report
from tower.roster import Roster, Silence

AFTER, SPLIT, ANSWER = 300, 1800, 30


def roster(**heard_tick: int) -> Roster:
    """A roster of patrolling robots that were heard at these ticks."""
    one = Roster(Silence(AFTER, 3, SPLIT, ANSWER))
    for node, tick in heard_tick.items():
        one.hear(tick, node, tick, Report("patrol", int(node[1:]), 9.0), 0)
    return one


def lost(one: Roster, tick: int) -> list[str]:
    found = one.newly_lost(tick)
    for node in found:
        one.lose(node)
    return found


def test_a_later_word_holds_even_when_an_earlier_one_arrives_after_it():
    one = roster(r2=10)
    assert one.hear(12, "r2", 11, Report("home", 0, 8.4, 7, low=True), 3)
    assert not one.hear(13, "r2", 9, Report("out", 5, 9.0), 0)
    known = one.get("r2")
    assert (known.state, known.battery_v, known.acknowledged, known.low, known.hops) == (
        "home",
        8.4,
        7,
        True,
        3,
    )
    assert (known.heard_tick, known.said_tick) == (13, 11)


def test_a_word_that_says_nothing_new_is_heard_all_the_same():
    one = roster(r2=10)
    assert not one.hear(20, "r2", 20, Report("patrol", 2, 9.0), 0)
    assert one.hear(30, "r2", 30, Report("patrol", 2, 8.9), 0)
    assert one.get("r2").heard_tick == 30


def test_a_state_is_as_old_as_its_first_report():
    one = roster(r2=10)
    one.hear(20, "r2", 20, Report("queue", 0, 8.4), 0)
    one.hear(30, "r2", 30, Report("queue", 0, 9.0), 0)
    assert one.get("r2").since_tick == 20


def test_who_is_silent_for_long_enough_is_lost_once():
    one = roster(r2=0, r3=10)
    assert (lost(one, AFTER - 1), one.next_loss_tick()) == ([], AFTER)
    assert (lost(one, AFTER), one.next_loss_tick()) == (["r2"], AFTER + 10)
    assert lost(one, AFTER + 9) == []
    assert [robot.node for robot in one.present()] == ["r3"]


def test_many_that_fall_silent_together_are_suspected_to_be_cut_off():
    one = roster(r2=0, r3=0, r4=0, r5=290)
    assert (lost(one, AFTER), one.next_loss_tick()) == ([], 290 + AFTER)
    assert lost(one, 290 + AFTER) == []
    assert one.next_loss_tick() == SPLIT
    assert lost(one, SPLIT) == ["r2", "r3", "r4"]
    assert lost(one, SPLIT + 290) == ["r5"]


def test_many_that_fall_silent_one_after_another_are_lost():
    one = roster(r2=0, r3=301, r4=602)
    assert (lost(one, 300), lost(one, 601), lost(one, 902)) == (["r2"], ["r3"], ["r4"])


def test_before_somebody_is_lost_everybody_is_called_once():
    one = roster(r2=0, r3=100)
    assert one.next_call_tick() == AFTER - ANSWER
    one.call(AFTER - ANSWER)
    assert one.next_call_tick() is None, "r3 was called too"
    one.hear(272, "r3", 271, Report("patrol", 3, 9.0), 0)
    assert one.next_call_tick() == 272 + AFTER - ANSWER
    assert lost(one, AFTER) == ["r2"]


def test_of_many_who_do_not_answer_the_call_nobody_is_lost():
    one = roster(r2=0, r3=100, r4=200, r5=200)
    one.call(AFTER - ANSWER)
    one.hear(AFTER - ANSWER + 2, "r5", 271, Report("patrol", 5, 9.0), 0)
    assert (lost(one, AFTER), one.cut_off) == ([], {"r2", "r3", "r4"})
    assert one.next_call_tick() == 272 + AFTER - ANSWER, "who is cut off is not called"
    one.hear(1000, "r3", 1000, Report("patrol", 3, 9.0), 0)
    assert one.cut_off == {"r2", "r4"}
    assert lost(one, 1300) == ["r3"]
    assert lost(one, SPLIT) == ["r2"]


def test_who_was_lost_just_before_makes_a_split_likelier():
    one = roster(r2=0, r3=100, r4=200)
    assert (lost(one, 300), lost(one, 400), lost(one, 500)) == (["r2"], ["r3"], [])
    assert lost(one, 200 + SPLIT) == ["r4"]


def test_a_suspicion_holds_when_others_are_heard_again():
    one = roster(r2=0, r3=0, r4=0)
    assert lost(one, 300) == []
    one.hear(400, "r2", 399, Report("patrol", 2, 9.0), 0)
    assert (lost(one, 700), lost(one, SPLIT)) == (["r2"], ["r3", "r4"])


def test_when_nobody_could_be_heard_all_silences_begin_anew():
    one = roster(r2=0, r3=0)
    one.forgive(1000)
    assert (lost(one, 1299), lost(one, 1300)) == ([], ["r2", "r3"])


def test_what_a_robot_claims():
    one = roster(r2=0, r3=0)
    assert one.get("r2").claims == 2
    one.lose("r2")
    assert one.get("r2").claims == 0
    one.hear(1, "r3", 1, Report("patrol", 3, 8.4, low=True), 0)
    assert one.get("r3").claims == 0
