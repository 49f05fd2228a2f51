"""A synthetic clearing of a box: a line that goes to the right, one that stands, a robot that dies."""

import math

import msgspec
import numpy as np
import shapely

from swarm_agent.graph_copy import Delta, Edge, Moving, Version, Vertex
from tests.builders import facts
from tests.clear_builders import BOX, clearing
from wire import codec
from wire.clearing import Clearing, Standing
from wire.messages import Facts, Fault
from wire.scenario import Scenario
from world_server.judges import outline_of
from world_server.nodes import DEAD

HEADINGS_RAD = (0.0, math.pi / 2, 1.0, 0.0, -2.0, 3.0)
SPLIT_TICK, KILL_TICK, CLAIM_TICK, LAST_TICK = 80, 120, 150, 160
STOPS_TICK = 100
"""From then on the line stands still, and the outline with it."""
WALL_M = 0.4
GRAPH = Delta(
    Version(),
    Version(3, "r2"),
    2,
    Moving(2, 3),
    (Vertex(0, 2, True, True), Vertex(1, 4, True, False), Vertex(2, 3), Vertex(3, 5)),
    (Edge(0, 1, 2, "move"), Edge(0, 2, 3, "split", 1), Edge(0, 3, 1, "cycle")),
)


def box_scenario(**fields: object) -> Scenario:
    """Five robots and a tower in a box of 4 m by 3 m."""
    return clearing(5, (BOX,), **fields)


def front_m(tick: int) -> float:
    """How far to the right the line is."""
    return 0.5 + 0.02 * min(tick, STOPS_TICK)


def places_m(tick: int) -> np.ndarray:
    """The tower, the line of r2, r3 and r4, and r5 and r6 behind it."""
    x_m = front_m(tick)
    return np.array([(0, 0), (x_m, 3 - WALL_M), (x_m, 1.5), (x_m, WALL_M), (0.3, 2.0), (0.3, 1.0)])


def contaminated(tick: int) -> shapely.Polygon:
    """The floor to the right of the line."""
    return shapely.box(front_m(tick), 0, 4, 3)


def standings(tick: int) -> dict[str, Standing]:
    """What every living robot says of itself."""
    split = tick >= SPLIT_TICK
    happened = ("split",) if tick == SPLIT_TICK else ()
    graph = codec.encode(GRAPH) if tick == SPLIT_TICK else b""
    claim = "failed" if tick >= CLAIM_TICK else ""
    said = {
        "r2": Standing("leader", 1, True, "wall", "r3", claim, False, happened, graph, (WALL_M, 0.0)),
        "r3": Standing("centre", 1, True, "r2", "r4", claim),
        "r4": Standing("leader", 1, True, "r3", "wall", wall_m=(0.0, -WALL_M)),
        "r5": Standing("centre", 2, False, "", "r6") if split else Standing("reserve"),
        "r6": Standing("leader", 2, False, "r5") if split else Standing("joining", 1, True, "r3", "r4"),
    }
    if tick >= KILL_TICK:
        del said["r3"]
    return said


def box_facts(last_tick: int = LAST_TICK) -> list[Facts]:
    """All facts of the run; every fourth tick has an outline, if it is new."""
    return [_tick(tick) for tick in range(last_tick + 1)]


def _tick(tick: int) -> Facts:
    outline = outline_of(contaminated(tick)) if tick % 4 == 0 and tick <= STOPS_TICK else b""
    killed = tick == KILL_TICK
    poses = np.column_stack([places_m(tick), HEADINGS_RAD])
    return msgspec.structs.replace(
        facts(tick, reports=[(node, codec.encode(one)) for node, one in standings(tick).items()]),
        poses=poses.tobytes(),
        goals=np.full((6, 2), np.nan).tobytes(),
        modes=bytes(DEAD if row == 2 and tick >= KILL_TICK else 0 for row in range(6)),
        faults=(Fault(tick, "kill", "r3"),) if killed else (),
        links=np.array([(1, 2)], "<u2").tobytes(),
        clearing=Clearing(contaminated(tick).area, 2.0 if killed else 0.0, 0.0, None, outline),
    )
