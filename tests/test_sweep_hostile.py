"""Whatever valid beacons say, in whatever a robot of a sweep team is doing: it goes on, and is understood."""

import cmath
import copy
import math
from functools import cache
from typing import NamedTuple

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_agent.behaviour import Heard
from swarm_agent.behaviours.sweep_line import SweepLine
from swarm_agent.sweep.radio import Beacon, Measured
from tests.hostile_beacons import absurd
from tests.sweep_play import Play, column, in_line, lined_up, play
from wire import codec
from wire.fields import Point
from wire.messages import Percept, Senses
from wire.scenario import PlannedFault

BEACON = codec.decoder(Beacon)
TICKS = 3
NOSE: tuple[Point, ...] = ((0, 0), (3, 0), (3, 1.6), (1.5, 1.6), (1.5, 2), (3, 2), (3, 3.6), (0, 3.6))
HALL: tuple[Point, ...] = ((0, 0), (4, 0), (4, 2.4), (0, 2.4))


class Moment(NamedTuple):
    """A robot in the midst of a run, after a tick, and what its body sensed in it."""

    robot: SweepLine
    tick: int
    senses: Senses


@cache
def moments() -> list[Moment]:
    """Robots in every role and state of three short runs: a split, a search, a kill and a new beginning."""
    found: dict[tuple, Moment] = {}

    def watch(course: Play) -> None:
        lined_up(course, line)
        if searched and course.tick == 20:
            course.robots[line + 1].order = 2
        for number, mind in course.minds.items():
            one = mind.robot
            state = (one.role, one.stage, one.pinned, one.ready, one.is_main, one.order > 0, one.order < 0)
            if state not in found and one.peers.known:
                found[state] = Moment(copy.deepcopy(mind), course.tick, course.senses[number])

    for line, searched, rings_m, faults, last_tick in (
        (5, False, (NOSE,), (), 180),
        (6, False, (NOSE,), (), 40),
        (3, True, (HALL,), (), 60),
        (3, False, (HALL,), (PlannedFault(5.0, "kill", ("r3",)),), 60),
    ):
        width_m = rings_m[0][-1][1]
        given_run = in_line(rings_m, column(0.35, width_m, line), [(0.12, 1.0), (0.12, 1.6)], faults=faults)
        play(given_run, last_tick, watch)
    return list(found.values())


def test_there_are_robots_in_every_role():
    roles = {moment.robot.robot.role for moment in moments()}
    assert roles == {"free", "anchor", "reserve", "joining", "centre", "leader", "leaving"}


@settings(max_examples=200)
@given(data=st.data())
def test_no_beacon_crashes_a_robot_or_makes_it_mute(data):
    """A neighbour may be itself, or nobody; walls may be nowhere, scans too short, graphs of nothing."""
    moment = data.draw(st.sampled_from(moments()))
    mind = copy.deepcopy(moment.robot)
    peers = dict(mind.robot.peers.known)
    here = mind.robot.here
    still = msgspec.structs.replace(moment.senses, odometry_m=(0.0, 0.0))
    for tick in range(moment.tick + 1, moment.tick + 1 + TICKS):
        heard = []
        for number, peer in sorted(peers.items()):
            try:
                beacon = BEACON(codec.encode(data.draw(absurd(peer.beacon))))
            except codec.Malformed:
                continue
            away = peer.here - here
            heard.append(Heard(f"r{number}", tick - 1, beacon, abs(away), cmath.phase(away)))
        move = mind.step(Percept(tick, tick, "wake", still), heard)
        assert math.hypot(move.motion.x_m, move.motion.y_m) <= mind.robot.step_m + 1e-9
        told = codec.encode(move.say[0])
        if mind.robot.graph.version.events <= 2**53:
            assert codec.encode(BEACON(told)) == told


@pytest.mark.parametrize("field", ["wall_x_m", "wall_y_m"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e300])
def test_a_wall_that_is_nowhere_is_not_understood(field, value):
    sound = next(iter(moments()[-1].robot.robot.peers.known.values())).beacon
    assert BEACON(codec.encode(sound)) == sound
    with pytest.raises(codec.Malformed, match="float"):
        BEACON(codec.encode(msgspec.structs.replace(sound, **{field: value})))


@pytest.mark.parametrize("bearing_rad", [math.nan, math.inf, 100.0])
def test_a_bearing_that_is_none_is_not_understood(bearing_rad):
    sound = next(iter(moments()[-1].robot.robot.peers.known.values())).beacon
    measured = (Measured(3, 7, bearing_rad),)
    with pytest.raises(codec.Malformed, match="float"):
        BEACON(codec.encode(msgspec.structs.replace(sound, measured=measured)))


@pytest.mark.parametrize("ranges", [b"", b"\7" * 179, b"\7" * 4000])
def test_of_a_scan_with_other_rays_nothing_is_believed(ranges):
    """It sees nothing: no place is covered by it."""
    moment = moments()[-1]
    mind = copy.deepcopy(moment.robot)
    number, peer = next(iter(mind.robot.peers.known.items()))
    beacon = msgspec.structs.replace(peer.beacon, ranges=ranges)
    away = peer.here - mind.robot.here
    tick = moment.tick + 1
    still = msgspec.structs.replace(moment.senses, odometry_m=(0.0, 0.0))
    heard = [Heard(f"r{number}", tick - 1, beacon, abs(away), cmath.phase(away))]
    mind.step(Percept(tick, tick, "wake", still), heard)
    spots = peer.here + 0.2 * np.exp(1j * np.arange(6))
    assert not mind.robot.peer(number).sees(spots).any()
