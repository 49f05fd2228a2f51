"""Where the bodies of the dead lie, who tells of them, and how robots pass them."""

import cmath

import pytest

from swarm_agent.sweep import fallen, gait
from swarm_agent.sweep.beginning import BODY_ROOM_M, Beginning
from swarm_agent.sweep.radio import WALL, Body
from swarm_agent.sweep.robot import Robot
from tests.sweep_builders import a_robot, meets, sees_walls, stands, wall

QUARTER = 1j
"""A frame that is turned by a right angle."""
WALL_BELOW = wall(-2 - 0.25j, 3 - 0.25j, 0.01)


def dies(robot: Robot, number: int, tick: int, place: complex) -> None:
    """Let a robot know that another one is dead, which it last heard at that tick and place."""
    robot.dead.add(number)
    robot.peers.lost[number] = meets(robot, number, place)
    robot.peers.lost[number].tick = tick
    del robot.peers.known[number]


def test_the_body_of_a_dead_robot_lies_where_it_was_last_heard():
    robot = a_robot()
    dies(robot, 3, 7, 1 + 2j)
    fallen.see(robot)
    assert robot.bodies == {3: (7, 1 + 2j)} and robot.fallen == [1 + 2j]


def test_who_is_out_of_reach_and_not_dead_has_no_body():
    robot = a_robot()
    dies(robot, 3, 7, 1 + 2j)
    robot.dead.clear()
    meets(robot, 4, 1j, bodies=(Body(3, 9, 1.0, 0.0),))
    fallen.see(robot)
    assert robot.fallen == []


@pytest.mark.parametrize(("tick", "place"), [(9, 1j - 0.5), (8, 1 + 2j), (5, 1 + 2j)])
def test_the_latest_word_on_where_a_body_lies_counts_whoever_heard_it(tick, place):
    """The way to it is told in the frame of who tells."""
    robot = a_robot()
    dies(robot, 3, 8, 1 + 2j)
    meets(robot, 4, 1j, bodies=(Body(3, tick, 0.0, 0.5),)).turn = QUARTER
    fallen.see(robot)
    assert robot.fallen == [pytest.approx(place)]


def test_what_a_robot_tells_of_bodies_is_what_others_take_over():
    teller, listener = a_robot(4), a_robot(2)
    teller.peers.here = 0.3 + 0.1j
    teller.bodies = {5: (3, 1 + 1j), 3: (8, -1j)}
    told = fallen.told(teller)
    assert [body.number for body in told] == [3, 5]
    listener.dead = {3, 5}
    meets(listener, 4, 2 + 0j, bodies=told).turn = QUARTER
    fallen.see(listener)
    for number, (tick, place) in teller.bodies.items():
        expected = 2 + QUARTER * (place - teller.here)
        assert listener.bodies[number] == (tick, pytest.approx(expected))


def test_who_is_heard_again_is_no_body_any_more():
    robot = a_robot()
    robot.bodies = {3: (7, 1j), 4: (7, 2j)}
    meets(robot, 3, 1j)
    fallen.see(robot)
    assert robot.bodies == {4: (7, 2j)}


def test_who_is_held_up_where_it_knows_of_nothing_has_met_a_body():
    robot = a_robot()
    robot.tick = 5
    fallen.bump(robot, 0.05j, 0.01j)
    assert robot.bumps == [(5, pytest.approx(0.2j))] and robot.fallen == [pytest.approx(0.2j)]


def comes_on(robot: Robot) -> complex:
    return 0.04j


def stands_before_a_wall(robot: Robot) -> complex:
    sees_walls(robot, wall(-1 + 0.25j, 1 + 0.25j))
    return 0j


def stands_before_a_robot(robot: Robot) -> complex:
    meets(robot, 3, 0.3j)
    return 0j


def knows_of_the_body(robot: Robot) -> complex:
    robot.bodies[3] = (1, 0.3j)
    return 0j


def has_bumped_into_it_before(robot: Robot) -> complex:
    fallen.bump(robot, 0.05j, 0j)
    return 0j


@pytest.mark.parametrize(
    ("how", "bumps"),
    [
        (comes_on, 0),
        (stands_before_a_wall, 0),
        (stands_before_a_robot, 0),
        (knows_of_the_body, 0),
        (has_bumped_into_it_before, 1),
    ],
)
def test_who_comes_on_or_knows_what_is_in_its_way_has_met_nothing_new(how, bumps):
    robot = a_robot()
    moved = how(robot)
    fallen.bump(robot, 0.05j, moved)
    assert len(robot.bumps) == bumps


def test_who_did_not_want_to_go_has_met_nothing():
    robot = a_robot()
    fallen.bump(robot, 0.01j, 0j)
    assert robot.bumps == []


def test_who_was_pushed_aside_on_its_way_has_met_a_body():
    robot = a_robot()
    fallen.bump(robot, 0.05j, 0.05 + 0j)
    assert robot.fallen == [pytest.approx(0.2j)]


def test_bodies_that_were_only_bumped_into_are_forgotten_after_a_while():
    """It may have been somebody else that was out of hearing."""
    robot = a_robot()
    fallen.bump(robot, 0.05j, 0j)
    robot.tick = fallen.REMEMBERED_TICKS
    fallen.bump(robot, 0j, 0j)
    assert len(robot.bumps) == 1
    robot.tick += 1
    fallen.bump(robot, 0j, 0j)
    assert robot.bumps == []


def gone_along(body: complex, steps: int = 44) -> list[complex]:
    """The places of a leader that goes along a wall below it past a dead body."""
    robot = a_robot()
    stands(robot, "leader", 3, WALL)
    robot.bodies[5] = (0, body)
    robot.contact, places = -0.25j, []
    for _ in range(steps):
        sees_walls(robot, WALL_BELOW)
        gait.touch(robot)
        robot.peers.here += gait.along_wall(robot, "right")
        places.append(robot.here)
    return places


def beside(places: list[complex], body: complex) -> complex:
    """The one of some places that is beside a body."""
    return min(places, key=lambda place: abs(place.real - body.real))


@pytest.mark.parametrize("gap_m", [0.05, 0.15, 0.25, 0.3, 0.35])
def test_a_leader_passes_a_dead_body_outside_where_it_is_near_to_the_wall(gap_m):
    body = 0.8 + (gap_m - 0.25) * 1j
    places = gone_along(body, 60)
    assert places[-1].real > body.real + 0.3
    assert beside(places, body).imag > body.imag + 0.2
    assert min(abs(place - body) for place in places) > 0.26


@pytest.mark.parametrize("gap_m", [0.39, 0.45, 0.5])
def test_a_leader_passes_a_dead_body_inside_where_there_is_room_at_the_wall(gap_m):
    body = 0.8 + (gap_m - 0.25) * 1j
    places = gone_along(body)
    assert places[-1].real > body.real + 0.3
    assert -0.25 + 0.09 < beside(places, body).imag < body.imag - 0.2
    assert min(abs(place - body) for place in places) > 0.25


def test_a_leader_that_has_passed_a_body_is_as_far_from_the_wall_as_before():
    for gap_m in (0.15, 0.45):
        places = gone_along(0.4 + (gap_m - 0.25) * 1j, 50)
        assert places[-1].imag == pytest.approx(0.0, abs=0.02)


def test_an_anchor_goes_to_a_place_of_a_wall_where_no_body_lies():
    """The second leader is to stand beside the first one."""
    body = -0.3 - 0.1j
    robot = a_robot()
    robot.become("anchor", "gathering")
    sees_walls(robot, WALL_BELOW)
    robot.bodies[3] = (0, body)
    way = Beginning().gather(robot)
    assert abs(robot.contact - body) > BODY_ROOM_M and robot.contact.imag == pytest.approx(-0.25)
    assert way.real > 0.02


def test_an_anchor_that_sees_no_other_wall_stays_beside_the_body():
    robot = a_robot()
    robot.become("anchor", "gathering")
    sees_walls(robot, wall(-0.2 - 0.25j, 0.2 - 0.25j))
    robot.bodies[3] = (0, cmath.rect(0.2, -0.5))
    Beginning().gather(robot)
    assert robot.contact == pytest.approx(-0.25j)
