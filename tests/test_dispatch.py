"""Algorithm 2, the tower's lines: what is covered, who is sent where. Six segments, tower in the middle."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.line_builders import line, robot
from tower.dispatch import Sending, Situation, covered, deployment_order, next_sending, one_too_many

SIX = line(6)
TEAM = [robot(f"r{segment + 1}", "patrol", segment) for segment in range(1, 7)]
QUEUE = [robot("r8", "queue"), robot("r9", "queue")]


def sending(robots, vacancies, waiting=QUEUE, ordered=None, shift=True, busy=()) -> Sending | None:
    return next_sending(Situation(robots, ordered or {}, vacancies, waiting, busy), SIX, shift)


def without(*segments: int) -> list:
    return [one for one in TEAM if one.segment not in segments]


def chain(vacancy: int, shift: bool = True, waiting=QUEUE, team=None) -> list[tuple[str, int]]:
    """All sendings that one vacancy brings about, as one robot after the other sets out."""
    team, found = list(team or without(vacancy)), []
    vacancies, waiting = [vacancy], list(waiting)
    while one := sending(team, vacancies, waiting, shift=shift):
        found.append((one.node, one.segment))
        waiting = [other for other in waiting if other.node != one.node]
        team = [other for other in team if other.node != one.node] + [robot(one.node, "out", one.segment)]
        vacancies = [number for number in range(1, 7) if number not in covered(team, {})]
    return found


def test_the_outermost_segments_are_deployed_first_alternating_between_the_sides():
    """Source: papers/line-patrol.txt, Algorithm 2, line 1; the order is ours."""
    assert deployment_order(SIX) == [1, 6, 2, 5, 3, 4]
    assert deployment_order(line(1)) == [1]
    assert sorted(deployment_order(line(7))) == list(range(1, 8))


@pytest.mark.parametrize(
    ("one", "segments"),
    [
        (robot("r2", "patrol", 3), {3}),
        (robot("r2", "out", 3), {3}),
        (robot("r2", "home", 3), set()),
        (robot("r2", "queue"), set()),
        (robot("r2", "patrol", 3, low=True), set()),
        (robot("r2", "patrol", 3, lost=True), set()),
    ],
)
def test_a_segment_is_empty_unless_a_robot_is_on_it_or_on_the_way(one, segments):
    """Source: papers/line-patrol.txt, Algorithm 2, line 11"""
    assert covered([one], {}) == segments


def test_an_order_covers_a_segment_and_the_old_one_until_the_robot_has_left():
    """Source: none; the next one of a chain sets out when the segment before it is clear."""
    assert covered([robot("r2", "patrol", 3)], {"r2": 2}) == {2, 3}
    assert covered([robot("r2", "out", 2)], {"r2": 2}) == {2}
    assert covered([robot("r2", "queue")], {"r2": 2}) == {2}


def test_who_is_called_home_covers_its_segment_until_it_leaves():
    """Source: papers/line-patrol.txt, section III-B: the current lap is completed."""
    assert covered([robot("r2", "patrol", 3)], {"r2": 0}) == {3}


@pytest.mark.parametrize(
    ("vacancy", "moves"),
    [(1, [("r3", 1), ("r4", 2)]), (2, [("r4", 2)]), (6, [("r6", 6), ("r5", 5)]), (5, [("r5", 5)])],
)
def test_every_robot_between_the_empty_segment_and_the_tower_moves_out_one(vacancy, moves):
    """Source: papers/line-patrol.txt, Algorithm 2, lines 12-18; the last one comes from the queue."""
    nearest = 3 if vacancy <= 3 else 4
    assert chain(vacancy) == [*moves, ("r8", nearest)]


@pytest.mark.parametrize("nearest", [3, 4])
def test_the_segment_nearest_to_the_tower_is_filled_from_the_queue(nearest):
    """Source: papers/line-patrol.txt, Algorithm 2, line 18"""
    assert chain(nearest) == [("r8", nearest)]


def test_the_one_from_the_queue_waits_until_the_near_segment_is_cleared():
    """Source: papers/line-patrol.txt, section III-B: deployed as soon as the near segment is cleared."""
    leaving, gone = robot("r4", "patrol", 3), robot("r4", "out", 2)
    others = without(2, 3)
    assert covered([*others, leaving], {"r4": 2}) == {1, 2, 3, 4, 5, 6}
    assert sending([*others, gone], [3]) == ("r8", 3, True)


def test_shifts_happen_with_an_empty_queue_too():
    """Source: papers/line-patrol.txt, Algorithm 2, lines 12-17: they do not ask for the queue."""
    assert chain(1, waiting=[]) == [("r3", 1), ("r4", 2)]
    assert chain(3, waiting=[]) == []


def test_where_nobody_is_left_inward_one_comes_from_the_queue_directly():
    """Source: none; the paper has a robot on every segment."""
    assert chain(1, team=without(1, 2, 3))[0] == ("r8", 1)


def test_the_nearest_one_that_can_be_moved_moves():
    """Source: none; who is under way, recalled or low is not interrupted."""
    assert sending(without(1), [1], ordered={"r3": 0}).node == "r4"
    assert sending(without(1), [1], busy={"r3"}).node == "r4"
    low = [robot("r3", "patrol", 2, low=True), robot("r4", "out", 3)]
    assert sending([*without(1, 2, 3), *low], [1]).node == "r8"


def test_leap_frog_sends_one_from_the_queue_directly_and_moves_nobody():
    """Source: papers/line-patrol.txt, section III: the leap-frog algorithm"""
    assert chain(1, shift=False) == [("r8", 1)]


def test_leap_frog_waits_for_the_queue():
    """Source: none; nobody else may move."""
    assert chain(1, shift=False, waiting=[]) == []


def test_vacancies_are_filled_in_their_order():
    assert sending(without(1, 6), [6, 1], shift=False) == ("r8", 6, True)
    assert sending(without(1, 6), [6, 1], shift=True) == ("r6", 6, False)


def test_of_two_on_one_segment_the_one_with_the_older_order_is_too_many():
    """Source: none; the older one was given up when the newer was sent."""
    team = [robot("r2", "patrol", 3, acknowledged=5), robot("r3", "out", 3, acknowledged=9)]
    assert one_too_many(team, {}) == ["r2"]
    assert one_too_many(team, {"r3": 3}) == ["r2"]


def test_of_two_with_equal_orders_the_higher_number_is_too_many():
    team = [robot(node, "patrol", 3) for node in ("r2", "r10", "r9")]
    assert one_too_many(team, {}) == ["r10", "r9"]


@pytest.mark.parametrize("ordered", [{"r2": 2}, {"r2": 0}, {"r3": 4}, {"r3": 0}])
def test_who_is_ordered_away_is_not_too_many(ordered):
    team = [robot("r2", "patrol", 3), robot("r3", "patrol", 3)]
    assert one_too_many(team, ordered) == []


@given(st.sets(st.integers(1, 6)), st.integers(0, 4), st.booleans())
def test_every_chain_ends_and_nobody_is_sent_twice_or_inward(empty, waiting, shift):
    team, ordered = without(*empty), {}
    queue = [robot(f"r{number}", "queue") for number in range(20, 20 + waiting)]
    segment_of = {one.node: one.segment for one in team}
    for _ in range(20):
        vacancies = [n for n in deployment_order(SIX) if n not in covered(team, ordered)]
        one = sending(team, vacancies, queue, ordered, shift)
        if one is None:
            break
        assert one.node not in ordered
        assert one.segment in vacancies
        assert one.from_queue or segment_of[one.node] in SIX.inward(one.segment)
        ordered[one.node] = one.segment
        queue = [other for other in queue if other.node != one.node]
    else:
        raise AssertionError("the chain does not end")
