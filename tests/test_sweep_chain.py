"""Where robots in the middle of a line stand, which of them may leave, and how far a searching one comes."""

import numpy as np
import pytest

from swarm_agent.sweep import gait, links
from swarm_agent.sweep.radio import WALL
from swarm_agent.sweep.resting import Slot
from swarm_agent.sweep.robot import Robot
from tests.sweep_builders import a_robot, flow, meets, sees_walls, stands, wall

# Slots


def slot_m(left_m: float, right_m: float, here_m: float) -> float:
    """Where a robot on a straight line goes whose neighbours stand there."""
    robot = in_the_middle(left_m, right_m, here_m)
    left, right = robot.neighbour("left"), robot.neighbour("right")
    return here_m + gait._slot(robot, left, right).real


def in_the_middle(left_m: float, right_m: float, here_m: float) -> Robot:
    robot = a_robot(number=2)
    stands(robot, "centre", 1, 3)
    meets(robot, 1, left_m - here_m + 0j, right=2)
    meets(robot, 3, right_m - here_m + 0j, left=2)
    return robot


def test_slots_are_packed_to_the_left_and_the_last_robot_leaves():
    """Source: specs of mission clear, 3.2 item 2: of length 2.5 slots at 0.4 and 0.8, the next leaves."""
    assert slot_m(0.0, 2.0, 0.7) / 2.5 == pytest.approx(0.4)
    assert slot_m(1.0, 2.5, 1.7) / 2.5 == pytest.approx(0.8)
    assert not links.is_spare(in_the_middle(0.0, 2.0, 1.0))
    assert not links.is_spare(in_the_middle(1.0, 2.5, 2.0))
    assert links.is_spare(in_the_middle(2.0, 2.5, 2.2))


@pytest.mark.parametrize(("gap_m", "leaves"), [(0.88, True), (0.92, False), (1.0, False)])
def test_a_robot_leaves_only_where_its_neighbours_have_some_slack_without_it(gap_m, leaves):
    """Source: specs of mission clear, 3.1, hysteresis: shrink at follow_m - 0.10."""
    assert links.is_spare(in_the_middle(0.0, gap_m, gap_m / 2)) == leaves


@pytest.mark.parametrize("said", [{"pinned": True}, {"close": True}, {"role": "leaving"}, {"right": 9}])
def test_a_robot_stays_where_a_neighbour_needs_it_or_does_not_hold_it(said):
    robot = in_the_middle(0.0, 0.6, 0.3)
    meets(robot, 1, -0.3 + 0j, **({"right": 2} | said))
    assert not links.is_spare(robot)


def test_a_robot_stays_where_a_wall_stands_between_its_neighbours():
    """Source: specs of mission clear, 3.6: a link is a barrier only if both see the same place."""
    robot = a_robot(number=2)
    stands(robot, "centre", 1, 3)
    meets(robot, 1, -0.4 - 0.1j, right=2)
    meets(robot, 3, 0.4 - 0.1j, left=2)
    assert links.is_spare(robot)
    sees_walls(robot, wall(-0.6j, 0.5j))
    assert not links.is_spare(robot)


# The taut chain


def test_a_robot_in_the_middle_pulls_the_chain_straight():
    """Source: specs of mission clear, 3.6: discrete curve shortening."""
    robot = a_robot(number=2)
    stands(robot, "centre", 1, 3)
    left, right = meets(robot, 1, -0.8 - 0.5j, right=2), meets(robot, 3, 0.8 - 0.5j, left=2)
    slot = gait._slot(robot, left, right)
    assert slot == pytest.approx(0.2 - 0.5j)


def test_round_a_corner_behind_the_line_the_chain_is_bent():
    """Source: specs of mission clear, 3.6: the straight chord is blocked by a corner on the cleared side."""
    robot = a_robot(number=2)
    stands(robot, "centre", 1, 3)
    left, right = meets(robot, 1, -0.5 + 0j, right=2), meets(robot, 3, 0.5 + 0j, left=2)
    assert robot.over(left.here, right.here, robot.walls()) is None
    corner = np.concatenate((wall(-0.02j, -0.6 - 0.6j), wall(-0.02j, 0.6 - 0.6j)))
    over = robot.over(left.here, right.here, corner)
    assert over is not None and over.imag > 0, "forward, which is to the left of the way to the right"
    assert robot.margin_m(left.here, right.here, corner) > 0


@pytest.mark.parametrize(("apart_m", "holds"), [(1.0, True), (1.29, True), (1.33, False), (1.5, False)])
def test_a_link_holds_where_both_ends_see_the_middle(apart_m, holds):
    """Source: specs of mission clear, 4.2: gap <= 2 (r_detect - v dt / 2 - margin)."""
    robot = a_robot()
    assert (robot.margin_m(0j, apart_m + 0j, np.empty(0, dtype=complex)) >= 0) == holds


@pytest.mark.parametrize(("ahead_m", "holds"), [(0.1, True), (0.3, True), (0.5, False), (0.9, False)])
def test_a_link_is_bent_round_a_wall_from_behind_as_far_as_both_see(ahead_m, holds):
    robot = a_robot()
    barrier = wall(0.5 - 0.6j, 0.5 + ahead_m * 1j)
    assert (robot.margin_m(0j, 1 + 0j, barrier) >= 0) == holds


def test_a_link_is_never_bent_backward():
    """What is behind the line is clear: a link around the far side of a wall would be ahead of the wall."""
    robot = a_robot()
    assert robot.margin_m(0j, 1 + 0j, wall(0.5 - 0.1j, 0.5 + 0.9j)) < 0


# Between pivots


def test_a_robot_between_two_pivots_whose_walls_it_does_not_reach_comes_to_stand():
    """It went to and fro for ever, and a line can decide nothing before all of it stands still."""
    robot, slot = a_robot(number=2), Slot()
    stands(robot, "centre", 1, 3)
    ways = []
    for _ in range(200):
        robot.tick += 1
        meets(robot, 1, -1 + 0j, right=2, pinned=True, wall_x_m=0.0, wall_y_m=0.25)
        meets(robot, 3, 1 + 0j, left=2, pinned=True, wall_x_m=0.0, wall_y_m=0.25)
        ways.append(gait.keep(robot, slot))
        robot.peers.here += ways[-1]
    assert any(ways) and not any(ways[100:])


# Searching


class Chain:
    """Robots on a line without walls between two leaders that stand still; the others move."""

    def __init__(self, length_m: float, count: int) -> None:
        self.places = {
            number: complex(min(number - 1.0, length_m - 0.3 * (count - number)))
            for number in range(1, count + 1)
        }
        self.places[count] = complex(length_m)
        self.robots = {number: a_robot(number) for number in self.places}
        self.slots = {number: Slot() for number in self.places}
        for number, robot in self.robots.items():
            right = number + 1 if number < count else WALL
            role = "centre" if 1 < number < count else "leader"
            stands(robot, role, number - 1 if number > 1 else WALL, right)
            robot.told = {"left": flow(count=number - 1), "right": flow(count=count - number)}

    def step(self, order: int) -> None:
        """All robots hear where the others are, and those in the middle go."""
        for number, robot in self.robots.items():
            robot.tick += 1
            robot.order = order
            robot.peers.here = self.places[number]
            for other, place in self.places.items():
                one = self.robots[other]
                if other != number:
                    meets(robot, other, place, one.role, **one.beside)
        for number, robot in self.robots.items():
            if robot.role == "centre":
                self.places[number] += gait.keep(robot, self.slots[number])

    def gaps_m(self) -> list[float]:
        """How far neighbours are apart."""
        return [
            abs(self.places[number + 1] - place)
            for number, place in self.places.items()
            if number + 1 in self.places
        ]


@pytest.mark.parametrize(
    ("number", "place"),
    [
        (1, 0.0833 + 0.9965j),
        (2, 1.25 + 1.5612j),
        (3, 2.4167 + 1.7776j),
        (4, 3.5833 + 1.7776j),
        (5, 4.75 + 1.5612j),
        (6, 5.9167 + 0.9965j),
    ],
)
def test_a_search_comes_at_least_as_far_forward_as_links_of_follow_m_reach(number, place):
    """Source: specs of mission clear, 3.10 item 2: places of the obstacle search for L = 6 and 8 robots.

    Links there are never longer than r_follow. Ours may be, as long as they hold: so it comes farther.
    """
    chain = Chain(6.0, 8)
    for _ in range(150):
        chain.step(order=number + 1)
        assert max(chain.gaps_m()) <= 2 * chain.robots[1].reach_m
    assert chain.robots[number + 1].taut == number + 1
    found = chain.places[number + 1]
    assert found.imag >= place.imag - 0.05
    assert abs(found - chain.places[number]) <= 1.05 and abs(found - chain.places[number + 2]) <= 1.05
