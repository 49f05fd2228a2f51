"""Which leader of a line goes, and which way."""

import cmath
import math

import numpy as np
import pytest

from swarm_agent.sweep import flows, gait, resting
from swarm_agent.sweep.events import decide
from swarm_agent.sweep.outlook import Outlook
from swarm_agent.sweep.radio import GO_BACK, GO_HOME, OTHER, WALL, Side
from swarm_agent.sweep.robot import BARRED_TICKS, Robot
from tests.sweep_builders import a_robot, flow, meets, sees_walls, stands, wall


def a_leader(side: Side, other_deg: float = 90.0, **parameters) -> Robot:
    """A leader of the main line at a straight wall below it, told of the other leader's angle."""
    robot = a_robot(**parameters)
    neighbours = (WALL, 3) if side == "left" else (3, WALL)
    stands(robot, "leader", *neighbours)
    sees_walls(robot, wall(-2 - 0.25j, 2 - 0.25j))
    robot.contact = -0.25j
    robot.told[OTHER[side]] = flow(angle_rad=math.radians(other_deg))
    return robot


def nothing_ahead(ways: dict[Side, complex]) -> Outlook:
    """An outlook without any ray."""
    none = np.zeros(0, dtype=bool)
    return Outlook(np.zeros(0, dtype=complex), none, none, none, ways)


def led(robot: Robot, degrees: float) -> complex:
    """The way of a leader whose neighbour stands at that angle from the way along its wall.

    The angle is measured from the neighbour through the contaminated side, so the left leader, whose way
    along the wall is -1 here, has its neighbour clockwise from there.
    """
    side = robot.wall_side()
    turn = cmath.exp(1j * math.radians(degrees))
    ways = {side: robot.contact, OTHER[side]: -1 / turn if side == "left" else turn}
    return gait.lead(robot, nothing_ahead(ways), resting.Strides())


@pytest.mark.parametrize(
    ("left_deg", "right_deg", "left_moves", "right_moves"),
    [
        (90, 90, True, True),
        (60, 120, True, False),
        (120, 60, False, True),
        (100, 140, True, False),
        (140, 100, False, True),
        (120, 120, True, True),
        (225, 200, False, True),
    ],
)
def test_the_leader_goes_whose_angle_is_less_than_a_right_one_or_the_smaller(
    left_deg, right_deg, left_moves, right_moves
):
    """Source: specs of mission clear, 3.7 item 1; Kolling and Carpin 2010, algorithm 1, by signed angles."""
    left, right = a_leader("left", right_deg), a_leader("right", left_deg)
    assert bool(led(left, left_deg)) == left_moves
    assert bool(led(right, right_deg)) == right_moves
    assert math.degrees(left.angle_rad) == pytest.approx(left_deg, abs=3)
    assert math.degrees(right.angle_rad) == pytest.approx(right_deg, abs=3)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(("degrees", "read_deg"), [(45, 45), (135, 135), (225, 225), (300, 300), (350, 0)])
def test_angles_of_leaders_are_signed_and_noise_around_zero_is_zero(side, degrees, read_deg):
    """Source: specs of mission clear, 3.2 item 4: 225 degrees are not 135; more than 1.8 pi is none."""
    robot = a_leader(side)
    led(robot, degrees)
    assert math.degrees(robot.angle_rad) == pytest.approx(read_deg, abs=3)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("degrees", [10, 60, 90, 120, 170])
def test_a_leader_changes_the_length_of_the_line_by_the_cosine_of_its_angle(side, degrees):
    """Source: specs of mission clear, 3.2 item 4: d(length)/dt = -v1 cos a1 - v2 cos a2."""
    robot = a_leader(side, 179.0)
    way = led(robot, degrees)
    turn = cmath.exp(1j * math.radians(degrees))
    neighbour = 5 * (-1 / turn if side == "left" else turn)
    longer_m = abs(neighbour - way) - abs(neighbour)
    assert longer_m == pytest.approx(-abs(way) * math.cos(robot.angle_rad), abs=0.002)


def held(robot: Robot) -> None:
    robot.halt = True


def told_to_halt(robot: Robot) -> None:
    robot.told["right"] = flow(halt=True)


def told_nothing(robot: Robot) -> None:
    robot.told["right"] = None


def searching(robot: Robot) -> None:
    robot.order = 3


@pytest.mark.parametrize("why", [held, told_to_halt, told_nothing, searching])
def test_no_leader_moves_while_the_line_is_to_stand_or_its_news_is_missing(why):
    """Source: specs of mission clear, 3.7 item 2: gate."""
    robot = a_leader("left")
    assert led(robot, 60)
    why(robot)
    assert not led(robot, 60)


def pinned_line(robot: Robot) -> None:
    robot.told["right"] = flow(pinned=True, angle_rad=math.pi / 2)


def standing_line(robot: Robot) -> None:
    robot.line = 7


@pytest.mark.parametrize("why", [pinned_line, standing_line])
def test_a_line_that_stands_or_has_a_pivot_only_becomes_shorter(why):
    """Source: specs of mission clear, 3.9: stationary lines tighten, only by shortening moves."""
    robot = a_leader("left")
    why(robot)
    assert led(robot, 60) and not led(robot, 100) and not led(robot, 90)


def test_a_leader_stops_where_its_link_would_be_wider_than_both_see():
    """Source: specs of mission clear, 3.4: the gap gate."""
    robot = a_leader("left", 179.0)
    for apart_m, widens in ((1.0, True), (1.15, True), (1.25, False), (1.35, False)):
        peer = meets(robot, 3, cmath.rect(apart_m, math.radians(10)))
        way = led(robot, 170)
        assert (abs(peer.here - way) > apart_m + 1e-6) == widens


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("order", [GO_BACK, GO_HOME])
def test_a_leader_goes_back_along_its_wall_where_that_shortens_the_line(side, order):
    robot = a_leader(side, 120.0)
    robot.order = order
    ahead = -1 if side == "left" else 1
    assert led(robot, 120).real * ahead < -0.02
    assert led(robot, 80) == 0


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(
    ("apart_m", "role", "goes"), [(0.45, "leader", False), (0.55, "leader", True), (0.45, "centre", True)]
)
def test_two_leaders_at_one_place_of_a_wall_go_back_no_farther(side, apart_m, role, goes):
    """Who went on would turn the line over, front to back."""
    robot = a_leader(side, 120.0)
    robot.order = GO_BACK
    behind = 1 if side == "left" else -1
    meets(robot, 3, behind * apart_m + 0.3j, role, wall_y_m=-0.55)
    assert bool(led(robot, 120)) == goes


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(("apart_m", "line", "goes"), [(0.45, 0, False), (0.55, 0, True), (0.45, 7, True)])
def test_nor_do_they_with_a_robot_between_them(side, apart_m, line, goes):
    """A line of three that went home turned over so, and claimed that all was clear."""
    robot = a_leader(side, 120.0)
    robot.order = GO_BACK
    behind = 1 if side == "left" else -1
    meets(robot, 3, behind * apart_m / 2 + 0.3j)
    meets(robot, 4, behind * apart_m + 0.3j, "leader", wall_y_m=-0.55, line=line, **{OTHER[side]: WALL})
    assert bool(led(robot, 120)) == goes


def strides(robot: Robot, ways: list[complex], taken: resting.Strides) -> list[complex]:
    """What a leader takes of some ways, one a tick."""
    gone = []
    for way in ways:
        gone.append(taken.taken(robot, way))
        robot.peers.here += gone[-1]
    return gone


TO_AND_FRO = [0.03 + 0j, -0.03 + 0j] * 10


def neighbour_moves(robot: Robot) -> None:
    meets(robot, 3, 1j + resting.RESTED_M)


def neighbour_trembles(robot: Robot) -> None:
    meets(robot, 3, 1j + resting.RESTED_M / 2)


def order_changes(robot: Robot) -> None:
    robot.order = GO_BACK


def comes_close(robot: Robot) -> None:
    robot.close = True


@pytest.mark.parametrize(
    ("what", "goes"),
    [(neighbour_moves, True), (order_changes, True), (comes_close, True), (neighbour_trembles, False)],
)
def test_a_leader_that_goes_to_and_fro_rests_until_its_neighbour_or_its_order_is_another(what, goes):
    """A line can decide nothing before all of it stands still."""
    robot, taken = a_leader("left"), resting.Strides()
    meets(robot, 3, 1j)
    gone = strides(robot, TO_AND_FRO, taken)
    assert all(gone[: resting.TRY_TICKS]) and not any(gone[resting.TRY_TICKS :])
    what(robot)
    assert bool(taken.taken(robot, 0.03 + 0j)) == goes


def test_a_leader_that_comes_on_however_slowly_does_not_rest():
    robot, taken = a_leader("left"), resting.Strides()
    meets(robot, 3, 1j)
    assert all(strides(robot, [0.01 + 0j] * 60, taken))
    assert all(strides(robot, [0.05 + 0j, -0.03 + 0j] * 30, taken))


def test_a_leader_that_stood_for_a_while_has_not_gone_to_and_fro():
    robot, taken = a_leader("left"), resting.Strides()
    strides(robot, [0j] * 50, taken)
    assert all(strides(robot, [0.03 + 0j] * 5, taken))


@pytest.mark.parametrize(
    ("count", "left_deg", "right_deg", "dissolves"),
    [(1, 100, 100, True), (1, 200, 100, False), (1, 0, 269, True), (1, 0, 275, False), (2, 200, 100, True)],
)
def test_a_line_of_two_that_has_turned_over_does_not_claim_to_be_closed(
    count, left_deg, right_deg, dissolves
):
    """Its back is where it takes its front to be, and so is nothing ahead that it does not see."""
    robot = a_leader("right")
    robot.tick, robot.open, robot.angle_rad = 50, False, math.radians(right_deg)
    robot.told["left"] = flow(count=count, since=48, open=False, angle_rad=math.radians(left_deg))
    decide(robot, nothing_ahead({"left": 1j, "right": robot.contact}))
    assert robot.halt == dissolves or robot.role == "reserve"
    assert (robot.events == ["dissolve"]) == dissolves


def test_a_leader_that_cannot_go_tells_it_after_a_while_and_the_other_one_goes_on():
    """A dead body lay in the way of the leader whose turn it was, and both stood for ever."""
    robot, strides = a_leader("left", other_deg=180), resting.Strides()
    robot.told["right"] = flow(angle_rad=math.pi)
    ways = {"left": robot.contact, "right": 1j}
    for number in range(8):
        meets(robot, 11 + number, 0.2 * cmath.exp(2j * math.pi * number / 8))
    for tick in range(1, BARRED_TICKS + 2):
        robot.tick = tick
        assert gait.lead(robot, nothing_ahead(ways), strides) == 0
        flows.tell(robot)
        assert robot.is_barred == robot.flows["left"].barred == (tick > BARRED_TICKS)


@pytest.mark.parametrize("barred", [False, True])
def test_a_leader_lengthens_the_line_by_the_larger_angle_only_if_the_other_one_is_barred(barred):
    robot = a_leader("left")
    robot.angle_rad = 2.0
    assert gait.may_grow(robot, flow(angle_rad=1.0, barred=barred)) == barred


@pytest.mark.parametrize(("spacing", "tries"), [("plain", False), ("robust", True)])
def test_a_leader_of_a_robust_line_that_rests_tries_again_when_who_barred_its_way_may_have_gone(
    spacing, tries
):
    """Its shadow stands still until it moves itself, so it would wait for that for ever."""
    robot, taken = a_leader("left", spacing=spacing), resting.Strides()
    meets(robot, 3, 1j)
    assert not strides(robot, TO_AND_FRO, taken)[-1]
    robot.tick += resting.LEADER_REST_TICKS
    assert bool(taken.taken(robot, 0.03 + 0j)) == tries
