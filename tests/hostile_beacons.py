"""Valid beacons that say what cannot be, for who must not crash on any of them."""

import math
from typing import Any

import msgspec
from hypothesis import strategies as st

from swarm_agent.graph_copy import Delta, Edge, Moving, Version, Vertex
from swarm_agent.sweep.radio import SIDES, Beacon, Body, Flow, Measured

NUMBERS = st.sampled_from((-1, 0, 1, 2, 3, 4, 5, 6, 7, 9999))
COUNTS = st.sampled_from((0, 1, 2, 3, 7, 9_999, 10_000))
TICKS = st.sampled_from((-1, 0, 1, 50, 200, 1000, 2**53))
FLOATS = st.sampled_from((0.0, -0.0, 1e-12, 0.3, -2.0, 7.0, 1e6, -1e300, math.inf, -math.inf, math.nan))
FLAGS = st.booleans()
ROLES = st.sampled_from(("free", "anchor", "reserve", "joining", "centre", "leader", "leaving"))
STAGES = st.sampled_from(("", "forming", "cut", "closed", "gone", "homing", "gathering"))
RANGES = st.sampled_from(
    (b"", b"\0", b"\0" * 180, b"\xff" * 180, b"\x80" * 180, b"\x40\xff" * 90, b"\7" * 4000)
)
FEW = {"max_size": 4}
FLOWS = st.none() | st.builds(
    Flow, COUNTS, TICKS, TICKS, FLAGS, FLAGS, FLAGS, FLAGS, FLAGS, COUNTS, FLOATS, TICKS, COUNTS, FLAGS
)
MEASURED = st.lists(st.builds(Measured, NUMBERS, TICKS, FLOATS), **FEW).map(tuple)
VERSIONS = st.builds(Version, st.sampled_from((0, 1, 2, 500, 2**53)), st.sampled_from(("", "r3", "z" * 40)))
ROBOTS = st.sampled_from((1, 2, 3, 9, 10**6))
VERTEX_NUMBERS = st.sampled_from((0, 1, 2, 3, 4, 10**6))
LINES = st.sampled_from((0, 1, 2, 3, 9999, 10**6))
EDGES = st.builds(
    lambda ends, *rest: Edge(*sorted(ends), *rest),
    st.lists(VERTEX_NUMBERS, min_size=2, max_size=2, unique=True),
    ROBOTS,
    st.sampled_from(("move", "split", "cycle")),
    LINES,
)
VERTICES = st.lists(st.builds(Vertex, VERTEX_NUMBERS, ROBOTS, FLAGS, FLAGS), max_size=7).map(tuple)
DELTAS = st.none() | st.builds(
    Delta,
    st.just(Version()) | VERSIONS,
    VERSIONS,
    LINES,
    st.none() | st.builds(Moving, VERTEX_NUMBERS, ROBOTS, LINES),
    VERTICES,
    st.lists(EDGES, max_size=6).map(tuple),
)
FIELDS: dict[str, st.SearchStrategy[Any]] = {
    "role": ROLES,
    "line": NUMBERS,
    "since": TICKS,
    "left": NUMBERS,
    "right": NUMBERS,
    "ahead": NUMBERS,
    "rank": COUNTS,
    "tail": COUNTS,
    "ranges": RANGES,
    "measured": MEASURED,
    "from_left": FLOWS,
    "from_right": FLOWS,
    "pinned": FLAGS,
    "close": FLAGS,
    "ready": FLAGS,
    "wall_x_m": FLOATS,
    "wall_y_m": FLOATS,
    "stage": STAGES,
    "meets": NUMBERS,
    "epoch": COUNTS,
    "anchor": NUMBERS,
    "couriers": st.lists(NUMBERS, **FEW).map(tuple),
    "hand": st.sampled_from(SIDES),
    "dead": st.lists(NUMBERS, **FEW).map(tuple),
    "bodies": st.lists(st.builds(Body, NUMBERS, TICKS, FLOATS, FLOATS), **FEW).map(tuple),
    "gone": st.lists(NUMBERS, **FEW).map(tuple),
    "version": VERSIONS,
    "delta": DELTAS,
}


@st.composite
def absurd(draw, sound: Beacon) -> Beacon:
    """A beacon that differs from a sound one in some fields, or in all."""
    assert set(FIELDS) == set(Beacon.__struct_fields__), "a field of which nothing absurd is said"
    names = draw(st.lists(st.sampled_from(sorted(FIELDS)), min_size=1, max_size=len(FIELDS), unique=True))
    return msgspec.structs.replace(sound, **{name: draw(FIELDS[name]) for name in names})
