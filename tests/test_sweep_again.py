"""How a team begins again: who is the anchor when it has died, and where two leaders stand."""

import pytest

from swarm_agent.sweep.beginning import SECOND_TICKS, Beginning
from swarm_agent.sweep.radio import NOBODY, WALL
from swarm_agent.sweep.reserve import Reserve
from swarm_agent.sweep.robot import Robot
from tests.sweep_builders import a_robot, meets, sees_walls, stands, wall

ANCHOR, EPOCH, LAST_TICK = 7, 2, 100


def gathers(number: int = 4, anchor: complex = 0.8j) -> Robot:
    """A robot of a team that had begun to gather around an anchor, which was last heard at that place."""
    robot = a_robot(number)
    robot.become("reserve")
    robot.epoch, robot.anchor = EPOCH, ANCHOR
    robot.peers.lost[ANCHOR] = meets(robot, ANCHOR, anchor, "anchor", epoch=EPOCH, anchor=ANCHOR)
    robot.peers.lost[ANCHOR].tick = LAST_TICK
    del robot.peers.known[ANCHOR]
    return robot


def next_anchor_after(robot: Robot, ticks: int = 3 * SECOND_TICKS) -> int:
    """For so many ticks it hears of no anchor before it is one itself; 0 if it never is."""
    beginning, reserve = Beginning(), Reserve()
    for after in range(1, ticks):
        robot.tick = LAST_TICK + robot.parameters.dead_ticks + after
        beginning.hear(robot, reserve)
        if robot.role == "anchor":
            return after
    return 0


def beside(robot: Robot, number: int, epoch: int = EPOCH) -> None:
    meets(robot, number, 0.5 + 0j, "reserve", epoch=epoch, anchor=ANCHOR if epoch == EPOCH else 0)


def test_an_anchor_that_falls_silent_near_by_has_a_successor():
    robot = gathers()
    beside(robot, 6)
    assert next_anchor_after(robot) == 1
    assert robot.anchor == robot.number and robot.epoch == EPOCH + 1
    assert robot.dead == {ANCHOR} and robot.trouble == f"r{ANCHOR} is silent"
    assert robot.events == ["restart"] and robot.stage == "gathering"


@pytest.mark.parametrize(("epoch", "after"), [(EPOCH, SECOND_TICKS + 1), (EPOCH - 1, 1)])
def test_of_those_who_gather_the_one_with_the_least_number_is_the_next_anchor(epoch, after):
    """The others wait for a while, for it may not have been near."""
    robot = gathers(4)
    beside(robot, 3, epoch)
    assert next_anchor_after(robot) == after


def test_whoever_hears_of_the_next_anchor_comes_to_it():
    robot = gathers(4)
    meets(robot, 3, 0.5 + 0j, "anchor", epoch=EPOCH + 1, anchor=3, dead=(ANCHOR,))
    assert next_anchor_after(robot) == 0
    assert (robot.anchor, robot.epoch, robot.dead) == (3, EPOCH + 1, {ANCHOR})


def far_away(robot: Robot) -> None:
    robot.peers.lost[ANCHOR].here = 1.3j


def has_a_main_line(robot: Robot) -> None:
    robot.graph.begin(2)


def has_a_line_that_stands(robot: Robot) -> None:
    robot.graph.begin(4)
    robot.graph.split(2, 2)


def still_heard(robot: Robot) -> None:
    del robot.peers.lost[ANCHOR]


def is_on_a_line(robot: Robot) -> None:
    robot.role = "centre"


@pytest.mark.parametrize(
    "why", [far_away, has_a_main_line, has_a_line_that_stands, still_heard, is_on_a_line]
)
def test_an_anchor_that_is_out_of_reach_or_not_needed_any_more_is_not_missed(why):
    robot = gathers()
    why(robot)
    assert next_anchor_after(robot) == 0
    assert robot.epoch == EPOCH and robot.events == []


def test_who_was_far_when_the_anchor_was_lost_does_not_miss_it_when_it_comes_near():
    robot = gathers(anchor=1.3j)
    assert next_anchor_after(robot, 10) == 0
    robot.peers.here = 1j
    beginning = Beginning()
    robot.tick += 20
    beginning.hear(robot, Reserve())
    assert robot.role == "reserve"


def is_asked(first: complex, first_wall_y_m: float = -0.25) -> Robot:
    """A robot that is asked to stand beside the first leader of a line."""
    robot = a_robot()
    robot.tick = 9
    robot.become("reserve")
    stage = {"stage": "forming", "left": WALL, "right": 2, "since": 5}
    meets(robot, 3, first, "leader", wall_y_m=first_wall_y_m, **stage)
    return robot


def test_the_second_leader_stands_beside_the_first_at_the_same_wall():
    robot = is_asked(-0.3 + 0j)
    sees_walls(robot, wall(-1 - 0.25j, 1 - 0.25j))
    assert Beginning().second(robot) == 0
    assert robot.role == "leader" and robot.beside == {"left": 3, "right": WALL}
    assert robot.contact == pytest.approx(-0.25j) and robot.since == 5
    assert robot.graph.main is not None


def test_the_second_leader_of_a_first_line_never_takes_a_wall_opposite():
    """However near it is: between the two walls would be a gap that neither of them sees."""
    robot = is_asked(-0.3 - 0.15j)
    sees_walls(robot, wall(-1 - 0.4j, 1 - 0.4j), wall(-1 + 0.2j, 1 + 0.2j))
    way = Beginning().second(robot)
    assert robot.role == "reserve" and way.imag < 0, "it is still too far from that wall"
    robot.peers.here = -0.1j
    assert Beginning().second(robot) == 0
    assert robot.role == "leader" and robot.contact.imag == pytest.approx(-0.4)


def test_who_stands_on_the_left_of_the_first_leader_goes_to_its_right():
    robot = is_asked(0.3 + 0j)
    sees_walls(robot, wall(-1 - 0.25j, 1 - 0.25j))
    way = Beginning().second(robot)
    assert robot.role == "reserve" and way


def already_has_a_line(robot: Robot) -> None:
    robot.graph.begin(2)


def asks_another(robot: Robot) -> None:
    meets(robot, 3, -0.3 + 0j, "leader", stage="forming", left=WALL, right=5)


def of_another_beginning(robot: Robot) -> None:
    robot.epoch = 1


@pytest.mark.parametrize("why", [already_has_a_line, asks_another, of_another_beginning])
def test_nobody_is_the_second_leader_of_a_line_that_does_not_ask_it(why):
    robot = is_asked(-0.3 + 0j)
    sees_walls(robot, wall(-1 - 0.25j, 1 - 0.25j))
    why(robot)
    assert Beginning().second(robot) is None and robot.role == "reserve"


def test_the_first_leader_asks_another_one_after_a_while():
    robot, beginning = a_robot(), Beginning()
    stands(robot, "leader", WALL, 3)
    robot.stage, robot.contact = "forming", -0.25j
    meets(robot, 3, 0.4 + 0j, "reserve")
    meets(robot, 4, 0.5 + 0j, "reserve")
    for robot.tick in range(SECOND_TICKS + 1):
        beginning.await_second(robot)
    assert robot.beside["right"] == 3
    robot.tick += 1
    beginning.await_second(robot)
    assert robot.beside["right"] == 4 and robot.stage == "forming"
    meets(robot, 4, 0.3 + 0j, "leader", left=2, right=WALL)
    beginning.await_second(robot)
    assert robot.stage == "" and NOBODY not in robot.beside.values()


def test_the_first_leader_that_has_asked_everybody_in_vain_goes_elsewhere():
    """There is no room beside it."""
    robot, beginning = a_robot(), Beginning()
    stands(robot, "leader", WALL, 3)
    robot.stage, robot.contact = "forming", -0.25j
    for number in (3, 4):
        meets(robot, number, number / 10 + 0j, "reserve")
    for robot.tick in range(2 * SECOND_TICKS + 2):
        beginning.await_second(robot)
    assert robot.role == "leader"
    robot.tick += 1
    beginning.await_second(robot)
    assert (robot.role, robot.stage) == ("anchor", "gathering")
