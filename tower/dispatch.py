"""Dispatch: which segments nobody covers, and which robot is sent where.

Source: papers/line-patrol.txt, Algorithm 2, lines 1 and 11-19, and the leap-frog algorithm of section III.
"""

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import chain, zip_longest
from typing import NamedTuple

from tower.roster import Robot
from wire.line import Line


class Sending(NamedTuple):
    """One robot is to take one segment."""

    node: str
    segment: int
    from_queue: bool


class Situation(NamedTuple):
    """All that a decision rests on. `ordered`: the segment each robot with an open order is to take, 0: home.

    `vacancies`: uncovered segments in the order in which they are to be filled. `waiting`: robots that can be
    sent from the queue, the first one first; `busy`: robots that are not to be moved, being recalled.
    """

    robots: Sequence[Robot]
    ordered: Mapping[str, int]
    vacancies: Sequence[int]
    waiting: Sequence[Robot]
    busy: Collection[str] = ()


def deployment_order(line: Line) -> list[int]:
    """All segments, the outermost first, alternating between the sides of the tower, the left one first."""
    numbers = [one.number for one in line.segments]
    left = [one for one in numbers if line.side(one) < 0]
    right = [one for one in reversed(numbers) if line.side(one) > 0]
    return [one for one in chain.from_iterable(zip_longest(left, right)) if one is not None]


def covered(robots: Iterable[Robot], ordered: Mapping[str, int]) -> set[int]:
    """Segments that a robot patrols, is on the way to, or is ordered to take.

    Who is ordered elsewhere covers its segment until it has left, so that the next robot of a chain sets out
    for a segment that is clear.
    """
    return {segment for segment in ordered.values() if segment} | {one.claims for one in robots if one.claims}


def one_too_many(robots: Iterable[Robot], ordered: Mapping[str, int]) -> list[str]:
    """Who is to come home, as another robot claims the same segment by a later order.

    Of equal orders the lower node number stays. Robots under an order to go elsewhere claim nothing.
    """
    claims = defaultdict(list)
    for robot in robots:
        if robot.claims and ordered.get(robot.node, robot.claims) == robot.claims:
            claims[robot.claims].append(robot)
    leave = []
    for claimants in claims.values():
        stays = max(claimants, key=lambda one: (one.acknowledged, -one.number))
        leave += [one.node for one in claimants if one is not stays]
    return leave


def next_sending(situation: Situation, line: Line, shift: bool) -> Sending | None:
    """The first robot to be sent, or None when nobody can be.

    With `shift` the nearest robot that patrols further inward on the same side moves out, and only where
    there is none comes one from the queue; else robots come from the queue directly.
    """
    patrolling = {
        one.segment: one.node
        for one in reversed(situation.robots)
        if one.state == "patrol" and one.claims and one.node not in situation.ordered
        if one.node not in situation.busy
    }
    for vacancy in situation.vacancies:
        movers = [patrolling[one] for one in line.inward(vacancy) if one in patrolling] if shift else []
        if movers:
            return Sending(movers[0], vacancy, False)
        if situation.waiting:
            return Sending(situation.waiting[0].node, vacancy, True)
    return None
