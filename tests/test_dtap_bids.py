"""DTAP: bids and partition by hand. Source: Farinelli, Iocchi and Nardi 2017, their released code."""

from typing import Any

import pytest

from swarm_agent.behaviours.dtap import Bid, DtapParameters, Partition
from swarm_agent.ways import ways_of
from wire.fields import Grid

NOWHERE = (-1, -1)
LINE = Grid(1, 11, 10.0)
"""Eleven cells in a line: site k is 10 k metres from site 0."""


def partition(robot: int, current: int = 0, field: Grid = LINE, **parameters: Any) -> Partition:
    """What a robot that has heard of no bids knows of them."""
    return Partition(robot, ways_of(field).costs_m, DtapParameters(**parameters), current)


def with_tasks(*sites: int, current: int = 0, centre: int | None = None, **parameters: Any) -> Partition:
    """A robot that holds the best bids for some sites; `centre`: where their middle was before."""
    one = partition(2, current, Grid(1, 3, 10.0), **parameters)
    for site in sites:
        one.claim(site, 1.0, 0)
    one.centre = current if centre is None else centre
    one.settle()
    return one


def asked(responder: Partition, bid_m: float, going: tuple[int, int] = NOWHERE) -> tuple[int, int]:
    """r2 asks for site 10 with this bid at tick 5. Who owns it then, at r2 and at the responder r3?"""
    requester = partition(2)
    requester.claim(10, bid_m, 5)
    responder.hear(10, bid_m, 2, 5)
    bid = responder.answer(10, going, 6)
    if bid is not None:
        requester.hear(bid.site, bid.bid_m, 3, 6)
    return int(requester.owner[10]), int(responder.owner[10])


def test_a_responder_whose_bid_is_as_low_wins():
    """Source: an equal bid replaces; 100 m each, then 100 against 101."""
    assert asked(partition(3), 100.0) == (3, 3)
    assert asked(partition(3), 99.0) == (2, 2), "and the responder says nothing"


def test_who_goes_there_anyway_bids_nothing_and_always_wins():
    """Source: 0 for the next site and the one after; against a requester's 0 it is equal, so it wins too."""
    for going in ((10, -1), (4, 10)):
        assert asked(partition(3), 0.1, going) == (3, 3)
        assert asked(partition(3), 0.0, going) == (3, 3)


def test_a_bid_grows_with_the_number_of_tasks():
    """Source: way from the centre times (1 + tasks): for 50 m 50, 100, 150."""
    one = partition(2, current=5)
    assert one.own_bid_m(0, NOWHERE) == 50.0
    for number, site in enumerate((5, 4, 6), start=2):
        one.claim(site, 1.0, 0)
        one.settle()
        assert one.centre in (4, 5) and one.own_bid_m(0, NOWHERE) == 10.0 * one.centre * number


def test_a_bid_must_be_lower_by_the_share_of_history():
    """Source: replaced if known >= (1 + hist) * bid."""
    for bid_m, owner in ((81.0, 2), (80.0, 3), (79.0, 3)):
        one = partition(2, history=0.25)
        one.claim(10, 100.0, 5)
        one.hear(10, bid_m, 3, 6)
        assert one.owner[10] == owner


def test_bids_never_end_and_a_dead_owner_blocks_nothing():
    """Source: a requester overwrites what is known of the site."""
    one = partition(2)
    one.hear(10, 0.0, 3, 5)
    one.settle()
    assert one.owner[10] == 3 and one.answer(10, NOWHERE, 5000) is None
    one.claim(10, 100.0, 5001)
    assert one.owns(10)


@pytest.mark.parametrize("tasks", [(), (0,)])
def test_what_is_said_in_one_tick_counts_as_said_in_order_of_numbers(tasks):
    """Our choice: three robots at one place ask for one site at once. The last of them has it, for all.

    Who has no other task bids 0 for what it thinks it has, as the site itself is then its centre.
    """
    team = {number: partition(number) for number in (2, 3, 4)}
    said: list[tuple[int, Bid]] = []
    for one in team.values():
        for site in tasks:
            one.claim(site, 0.0, 0)
        one.claim(10, 100.0, 0)
    for number, one in team.items():
        for other in sorted(team.keys() - {number}):
            one.hear(10, 100.0, other, 0)
            bid = one.answer(10, NOWHERE, 1)
            said += [] if bid is None else [(number, bid)]
    assert {bid.bid_m for _, bid in said[1:]} == ({100.0} if tasks else {0.0})
    for number, bid in said:
        for other in team.keys() - {number}:
            team[other].hear(bid.site, bid.bid_m, number, 1)
    assert [int(one.owner[10]) for one in team.values()] == [4, 4, 4]


# Tasks and their centre


def test_the_centre_is_the_task_nearest_to_all_tasks():
    """Source: sites a, b, c in a line; whatever the centre was."""
    assert with_tasks(0, 1, 2).centre == 1
    assert with_tasks(0, 1, 2, centre=1).centre == 1


def test_as_released_the_old_centre_is_no_candidate():
    """Source: `i != old center`; the robot stands at a, so a is the first of two that are equal."""
    assert with_tasks(0, 1, 2, exact_center_quirk=True).centre == 1
    assert with_tasks(0, 1, 2, centre=1, exact_center_quirk=True).centre in (0, 2)
    assert with_tasks(0, 1, 2, current=1, centre=1, exact_center_quirk=True).centre == 1


def test_without_tasks_the_centre_is_where_the_robot_is():
    """Source: all sums are zero and the first is kept. It is found anew when tasks change, not before."""
    one = with_tasks(2)
    assert one.centre == 2
    one.current = 1
    one.hear(2, 0.0, 3, 1)
    assert (one.task_count, one.centre) == (0, 1)
