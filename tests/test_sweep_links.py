"""Whoever comes into a line or leaves it, and whatever frames are lost: the barrier never opens."""

from collections.abc import Iterator

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_agent.sweep.links import ask_in
from swarm_agent.sweep.radio import WALL
from swarm_agent.sweep.robot import Robot
from tests.sweep_play import Play, column, in_line, lined_up, play
from wire.scenario import Latency, Loss, RadioSection, Range

DETECT_M = 0.7
MET_TICK, STIRRED_TICK, SETTLED_TICKS = 30, 80, 100
DETOUR_M = 0.25  # who stands far behind a link has no business in it
DEAD_TICKS = 40
"""So many frames in a row are never lost here."""


def holds(robot: Robot) -> set[int]:
    """All to whom a robot believes itself linked, old links included."""
    return {number for number in robot.beside.values() if number > 0} | set(robot.old)


def links(course: Play) -> Iterator[tuple[int, int, float]]:
    """Two robots that both believe in a link between them, and how far they are apart."""
    robots, places = course.robots, course.places
    for number, robot in robots.items():
        for other in holds(robot):
            if number < other and other in robots and number in holds(robots[other]):
                yield number, other, abs(places[other] - places[number])


def is_joined(course: Play) -> bool:
    """Do links that both ends believe in, none too long to be seen all along, lead from wall to wall?"""
    ends = [
        {number for number, robot in course.robots.items() if robot.beside[side] == WALL}
        for side in ("left", "right")
    ]
    near = [(one, other) for one, other, apart_m in links(course) if apart_m <= 2 * DETECT_M]
    reached, found = set(), set(ends[0])
    while found - reached:
        reached |= found
        found = {end for link in near if set(link) & reached for end in link}
    return bool(ends[0] and ends[1] and ends[1] <= reached)


def is_settled(course: Play, ticks: int) -> bool:
    """Has everybody who has begun to come in or to leave long ago done so, or given it up?"""
    return all(
        robot.on_line == (number in course.line())
        for number, robot in course.robots.items()
        if course.tick - robot.since_role > ticks
    )


def stir(course: Play, draw: np.random.Generator) -> None:
    """Somebody of the reserve asks into a link near by, or somebody in the middle wants to leave."""
    number = int(draw.choice(sorted(course.robots)))
    robot = course.robots[number]
    if robot.role == "centre" and draw.random() < 0.5:
        robot.role, robot.since_role = "leaving", robot.tick
    elif robot.role == "reserve":
        for left in list(robot.peers.known.values()):
            right = robot.peer(left.beacon.right)
            if right is not None and right.beacon.left == left.number:
                ways_m = [abs(one.here - robot.here) for one in (left, right)]
                if sum(ways_m) - abs(left.here - right.here) <= DETOUR_M:
                    ask_in(robot, left, right)
                    break


@settings(max_examples=12)
@given(
    count=st.integers(3, 8),
    gap_m=st.floats(0.6, 0.98),
    loss=st.sampled_from((0.0, 0.1, 0.3)),
    latency=st.integers(1, 2),
    seed=st.integers(0, 999),
)
def test_no_join_and_no_leave_opens_the_barrier_whatever_is_lost(count, gap_m, loss, latency, seed):
    """At every tick links that both ends believe in lead from wall to wall, and the referee agrees."""
    width_m = 0.5 + gap_m * (count - 1)
    corridor = ((0.0, 0.0), (9.0, 0.0), (9.0, width_m), (0.0, width_m))
    draw = np.random.Generator(np.random.Philox(seed))
    rules = (Range(2.0), Loss(loss), Latency(latency))
    scenario = in_line(
        (corridor,),
        column(0.35, width_m, count),
        [(0.12, 0.5), (0.12, width_m - 0.5)],
        radio=RadioSection(rules),
        parameters={"dead_ticks": DEAD_TICKS, "hop_ticks": latency},
        seed=seed,
    )

    def watch(course: Play) -> bool:
        lined_up(course, count, MET_TICK)
        if course.said:  # it has split at the wall behind, which is no business of this test
            return True
        if course.tick > MET_TICK + 2 * latency:
            assert is_joined(course), f"tick {course.tick}: {list(links(course))}"
            if draw.random() < 0.3 and course.tick < STIRRED_TICK:
                stir(course, draw)
        return False

    settled_ticks = SETTLED_TICKS * latency
    course = play(scenario, STIRRED_TICK + settled_ticks + 10, watch)
    assert course.breaches() == []
    if not course.said:
        assert is_settled(course, settled_ticks)
