"""Builders for tests of sweep robots: beacons, robots that see given walls, and peers at given places."""

from typing import Any

import msgspec
import numpy as np

from swarm_agent.behaviour import Air
from swarm_agent.behaviours.sweep_line import Parameters
from swarm_agent.graph_copy import NOTHING
from swarm_agent.sweep.peers import Peer
from swarm_agent.sweep.radio import NOBODY, Beacon, Flow, Role
from swarm_agent.sweep.robot import UNRANKED, Robot
from tests.builders import configuration
from wire.fields import Unseen

DETECT_M, RAYS = 0.7, 180
SAID = Beacon(
    role="free",
    line=0,
    since=-1,
    left=NOBODY,
    right=NOBODY,
    ahead=NOBODY,
    rank=UNRANKED,
    tail=1,
    ranges=b"\xff" * RAYS,
    measured=(),
    from_left=None,
    from_right=None,
    pinned=False,
    close=False,
    ready=False,
    wall_x_m=0.0,
    wall_y_m=0.0,
    stage="",
    epoch=0,
    anchor=0,
    meets=0,
    couriers=(),
    hand="left",
    dead=(),
    bodies=(),
    gone=(),
    version=NOTHING,
    delta=None,
)
"""What a robot says that sees no wall and is nothing yet."""


def beacon(**fields: Any) -> Beacon:
    """A beacon in which nothing is said but what is given."""
    return msgspec.structs.replace(SAID, **fields)


def flow(**fields: Any) -> Flow:
    """What is told from one end of a line that stands, all well, one robot long."""
    told = {
        "count": 1,
        "since": 0,
        "moved": 0,
        "open": True,
        "halt": False,
        "pinned": False,
        "pivot": False,
        "want": False,
        "spare": 0,
    }
    return Flow(**(told | fields))


def a_robot(number: int = 2, team: int = 8, **parameters: Any) -> Robot:
    """A robot at its origin, that sees no wall, and goes 0.05 m a tick."""
    told = configuration(
        f"r{number}", field=Unseen(DETECT_M, RAYS, 2.0), tick_s=0.25, max_speed_m_s=0.2, body_m=0.2
    )
    settled = Parameters(**({"team": team} | parameters)).settled(team + 1).in_air(Air())
    return Robot(told, settled)


def sees_walls(robot: Robot, *places: np.ndarray) -> None:
    """Let a robot see these places of walls, and nothing behind them."""
    hits = np.concatenate(places)
    robot.hits = hits[np.abs(hits - robot.here) <= DETECT_M]
    robot.ranges_m = np.full(RAYS, np.inf)
    for place in robot.hits:
        ray = robot.eye.ray(complex(place) - robot.here)
        robot.ranges_m[ray] = min(robot.ranges_m[ray], abs(place - robot.here))


def meets(robot: Robot, number: int, place: complex, role: Role = "centre", **said: Any) -> Peer:
    """Let a robot hear another one that stood at a place a tick ago, in a frame that is turned as its own."""
    peer = Peer(number, robot.tick - 1, place, place, 1 + 0j, beacon(role=role, **said), robot.eye)
    robot.peers.known[number] = peer
    return peer


def stands(robot: Robot, role: Role, left: int, right: int) -> None:
    """Put a robot on a line between two others, or a wall: the main line of a team that has just begun."""
    robot.become(role)
    robot.beside = {"left": left, "right": right}
    if robot.graph.main is None:
        robot.graph.begin(2)


def wall(start: complex, end: complex, apart_m: float = 0.02) -> np.ndarray:
    """Places along a straight wall."""
    return np.linspace(start, end, max(2, round(abs(end - start) / apart_m) + 1))
