"""How robots come to know where others are, and that a line stands: whatever the moves, delays and losses."""

import cmath
import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from swarm_agent.behaviour import Heard
from swarm_agent.sweep import flows
from swarm_agent.sweep.peers import SEEN_MARGIN_M, Eye, Peers
from swarm_agent.sweep.radio import WALL
from swarm_agent.sweep.robot import Robot
from tests.sweep_builders import DETECT_M, RAYS, a_robot, beacon, meets, stands

ANGLES = st.floats(-math.pi, math.pi)
STEP_M = 0.05


class Body:
    """A robot as it truly is, and what it knows of others."""

    def __init__(self, number: int, place: complex, heading_rad: float) -> None:
        self.number, self.place, self.front = number, place, cmath.exp(1j * heading_rad)
        self.begun, self.moved_m = place, 0j
        self.peers = Peers(number, Eye(RAYS, DETECT_M), 1000)

    def hears(self, other: "Body", sent_tick: int, measured: tuple) -> Heard:
        """A frame of another robot that was sent when both were where they are now."""
        away = (other.place - self.place) / self.front
        return Heard(f"r{other.number}", sent_tick, beacon(measured=measured), abs(away), cmath.phase(away))


class Pair:
    """Two robots that move at random and hear each other some ticks later, or not at all.

    The second one is granted only some ticks: then it hears all that has come, speaks, and moves.
    """

    def __init__(
        self, one: Body, other: Body, latency: int, draw: np.random.Generator, every: int = 1
    ) -> None:
        self.bodies, self.latency, self.draw, self.every = (one, other), latency, draw, every
        self.tick = 0
        self.underway: list[tuple[int, Body, Heard]] = []
        self.truth: dict[int, complex] = {}

    def step(self, loss: float) -> None:
        """One tick: hear, speak, move; frames are measured where all have come to."""
        self.tick += 1
        granted = self.bodies[: 1 if self.tick % self.every else 2]
        for body in granted:
            heard = [one for tick, to, one in self.underway if tick <= self.tick and to is body]
            self.underway = [one for one in self.underway if one[0] > self.tick or one[1] is not body]
            body.peers.take(self.tick, body.moved_m, heard)
        for body in granted:
            body.moved_m = STEP_M * complex(*self.draw.uniform(-0.7, 0.7, 2))
            body.place += body.moved_m * body.front
        for body, other in (self.bodies, self.bodies[::-1]):
            if other in granted and self.draw.random() >= loss:
                heard = body.hears(other, self.tick, other.peers.measured)
                self.underway.append((self.tick + self.latency, body, heard))
            self.truth[body.number, self.tick] = (other.place - body.begun) / body.front


@given(
    headings_rad=st.tuples(ANGLES, ANGLES),
    bearing_rad=ANGLES,
    apart_m=st.floats(0.2, 1.9),
    latency=st.integers(1, 3),
    loss=st.sampled_from((0.0, 0.3, 0.6)),
    every=st.sampled_from((1, 1, 4, 10)),
    seed=st.integers(0, 999),
)
def test_mutual_bearings_give_the_true_angle_between_frames_and_the_true_place(
    headings_rad, bearing_rad, apart_m, latency, loss, every, seed
):
    """Source: specs of mission clear, 3.3: theta_ij = beta_i(j) + pi - beta_j(i)."""
    one = Body(1, 0j, headings_rad[0])
    other = Body(2, cmath.rect(apart_m, bearing_rad), headings_rad[1])
    pair = Pair(one, other, latency, np.random.Generator(np.random.Philox(seed)), every)
    for _ in range(40 * every):
        pair.step(loss)
        for body, far in ((one, other), (other, one)):
            peer = body.peers.known.get(far.number)
            if peer is not None:
                assert abs(peer.turn - far.front / body.front) < 1e-6
                assert abs(peer.here - pair.truth[body.number, peer.tick]) < 1e-6
        if not loss and pair.tick > 2 * latency + 1 + 3 * (every - 1):
            assert len(one.peers.known) == len(other.peers.known) == 1
            assert one.peers.known[2].tick == (pair.tick - latency) // every * every
    assert loss or one.peers.known


def test_who_is_silent_for_too_long_is_lost_where_it_was_and_comes_back():
    one, other = Body(1, 0j, 0.3), Body(2, 1 + 0j, 2.0)
    one.peers._dead_ticks = 6
    pair = Pair(one, other, 1, np.random.Generator(np.random.Philox(1)))
    for _ in range(10):
        pair.step(0.0)
    last = one.peers.known[2]
    silent_from = last.tick
    while 2 in one.peers.known:
        pair.step(1.0)
    assert pair.tick - silent_from == 6 + 2, "the frame of tick 10 was still underway"
    assert one.peers.lost[2].tick == silent_from + 1
    pair.step(0.0)
    pair.step(0.0)
    assert 2 in one.peers.known and 2 not in one.peers.lost


def test_a_late_frame_does_not_take_the_place_of_a_newer_one():
    one, other = Body(1, 0j, 0.3), Body(2, 1 + 0j, 2.0)
    pair = Pair(one, other, 1, np.random.Generator(np.random.Philox(1)))
    for _ in range(6):
        pair.step(0.0)
    newest = one.peers.known[2]
    one.peers.take(7, 0j, [one.hears(other, newest.tick - 3, ())])
    assert one.peers.known[2] is newest


@given(turned_rad=ANGLES, seed=st.integers(0, 99))
def test_what_a_peer_has_seen_is_seen_where_it_was_seen(turned_rad, seed):
    """A scan crosses in a byte a ray: places up to its walls are seen, those behind them are not."""
    draw = np.random.Generator(np.random.Philox(seed))
    eye, turn = Eye(RAYS, DETECT_M), cmath.exp(1j * turned_rad)
    ranges_m = np.where(draw.random(RAYS) < 0.3, np.inf, draw.uniform(0.1, DETECT_M))
    ranges_m = np.repeat(ranges_m[::6], 6)
    told = beacon(ranges=eye.packed(ranges_m))
    robot = a_robot()
    peer = meets(robot, 3, 0.5 + 0.2j)
    peer.turn, peer.beacon, peer._eye = turn, told, eye
    reach_m = np.minimum(ranges_m, DETECT_M)
    middle = np.arange(RAYS) % 6 == 3  # its neighbours see as far
    seen = peer.here + turn * eye.units * (reach_m - SEEN_MARGIN_M - 0.005)
    hidden = peer.here + turn * eye.units * (reach_m + SEEN_MARGIN_M + 0.005)
    assert peer.sees(seen)[middle].all() and not peer.sees(hidden)[middle].any()
    walls = np.isfinite(ranges_m) & (ranges_m < DETECT_M - 2 * SEEN_MARGIN_M)
    assert peer.sees(peer.here + turn * eye.units * reach_m)[middle & walls].all()
    walls = np.isfinite(ranges_m)
    true = peer.here + turn * eye.units[walls] * ranges_m[walls]
    assert np.abs(peer.hits - true).max(initial=0) < DETECT_M / 200


class Line:
    """Robots on a line that tell each other, with frames that come late or never, while some move."""

    def __init__(self, count: int, draw: np.random.Generator) -> None:
        self.draw = draw
        self.robots: list[Robot] = [a_robot(number) for number in range(1, count + 1)]
        for number, robot in enumerate(self.robots, start=1):
            left, right = number - 1 or WALL, number + 1 if number < count else WALL
            stands(robot, "centre" if WALL not in (left, right) else "leader", left, right)
        self.said = [[beacon()] for _ in self.robots]
        self.heard = {}
        self.moves: list[set[int]] = [set() for _ in self.robots]

    def step(self, tick: int, moving: float, lost: float) -> None:
        """All hear what has come by now, move or not, and tell."""
        for row, robot in enumerate(self.robots):
            robot.tick = tick
            for beside in (row - 1, row + 1):
                if 0 <= beside < len(self.robots):
                    self._hear(robot, row, beside, tick, lost)
            flows.hear(robot)
            if self.draw.random() < moving:
                robot.moved = tick
                self.moves[row].add(tick)
            flows.tell(robot)
        for row, robot in enumerate(self.robots):
            said = beacon(
                role=robot.role,
                **robot.beside,
                from_left=robot.flows["left"],
                from_right=robot.flows["right"],
            )
            self.said[row].append(said)

    def _hear(self, robot: Robot, row: int, beside: int, tick: int, lost: float) -> None:
        sent = tick - int(self.draw.integers(1, 5))
        if self.draw.random() < lost or sent <= self.heard.get((row, beside), 0):
            return
        self.heard[row, beside] = sent
        meets(robot, beside + 1, 1j).beacon = self.said[beside][sent]


@given(
    count=st.integers(2, 7),
    moving=st.sampled_from((0.02, 0.1, 0.5)),
    lost=st.sampled_from((0.0, 0.5)),
    seed=st.integers(0, 999),
)
def test_a_line_is_quiet_only_if_nobody_moved_between_the_last_move_it_knows_of_and_its_news(
    count, moving, lost, seed
):
    """Source: specs of mission clear, 3.4: one hop per tick; older values are stale."""
    line = Line(count, np.random.Generator(np.random.Philox(seed)))
    quiet = 0
    for tick in range(1, 160):
        line.step(tick, moving if tick < 60 or tick % 40 < 4 else 0.0, lost)
        for robot in line.robots:
            if robot.is_quiet:
                quiet += 1
                news = min([tick, *(told.since for told in robot.told.values() if told)])
                assert robot.count == count
                for moves in line.moves:
                    assert not any(robot.last_moved() < at <= news for at in moves)
    assert quiet, "else this tests nothing"


def test_a_robot_that_misses_news_from_one_end_is_never_quiet():
    line = Line(4, np.random.Generator(np.random.Philox(1)))
    for tick in range(1, 60):
        line.step(tick, 0.0, 0.0)
    robot = line.robots[1]
    assert robot.is_quiet and robot.is_whole
    robot.told["right"] = None
    assert not robot.is_quiet and not robot.is_whole
