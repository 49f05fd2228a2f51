"""Percepts of one node of any behaviour of ours, and frames it hears: sound, damaged and strange ones."""

import tempfile
from functools import cache
from pathlib import Path

import msgspec
import numpy as np
from hypothesis import strategies as st

from swarm_agent.behaviour import find_behaviour, settled_parameters
from swarm_agent.behaviours.dtag import Arrival
from swarm_agent.behaviours.dtap import Request
from swarm_agent.behaviours.expected_reactive import Decision
from swarm_agent.knowledge import Bulletin
from swarm_agent.node import Mind, percepts_of
from tests.builders import configuration, course, from_robot, from_tower, percept, table
from tests.clear_builders import sweeping
from tests.line_builders import report, straight
from wire import codec
from wire.fields import Grid
from wire.messages import Frame, Percept, Sighting
from world_server.journal import memories

ON_A_LINE = ("line_patrol", "overlap_patrol", "line_keeper")
IN_A_PLAN = ("sweep_line",)
SENDERS = (1, 3, 4, 5, 6, 7, 8)
SWEPT_TICKS = 160


class Notebook:
    """A ledger in memory."""

    def __init__(self) -> None:
        self.grants = {}

    def read(self, before_grant):
        """All entries of the grants before."""
        self.grants = {grant: kept for grant, kept in self.grants.items() if grant < before_grant}
        return [one for kept in self.grants.values() for one in kept]

    def write(self, grant, tick, entries) -> None:
        """Keep the entries of one grant."""
        self.grants[grant] = [msgspec.structs.replace(one, tick=tick) for one in entries]


def a_mind(package: str) -> Mind:
    """A mind with a ledger, which a tower may need."""
    return Mind(package, Notebook())


def answers(package: str, life: list[Percept]) -> list[bytes]:
    """What a new mind answers to all percepts of a life."""
    mind = a_mind(package)
    return [mind.answer(codec.encode(one)) for one in life]


def first(package: str, name: str, generator_key: tuple[int, ...] = (1, 2)) -> Percept:
    """The first percept of a node with this behaviour, on a small field, in the paper's team of ten."""
    if name in IN_A_PLAN:
        return swept()[0]
    parameters = settled_parameters(find_behaviour(name, package), {}, 10)
    node = "r1" if package == "tower" else "r2"
    place = {"field": straight(), "tower_m": (30.0, 0.0)} if name in ON_A_LINE else {"field": Grid(6, 6)}
    told = configuration(node, name, msgspec.to_builtins(parameters), generator_key=generator_key, **place)
    return percept(0, 2.0, 3.0, why="start", configuration=told)


@cache
def sound_frames() -> list[bytes]:
    """Frames that our behaviours really say: without own words, with a duty, a decision, a request."""
    news = table(s1=4, s30=2)
    return [
        codec.encode(from_tower(3, news).message),
        codec.encode(from_robot("r3", 3, 5.0, 1, 2, 3, news).message),
        *(codec.encode(report("r3", tick, "patrol", 1 + tick % 6).message) for tick in (3, 7)),
        codec.encode(Bulletin(news, (), 3, Decision(1, 8, 20.0))),
        codec.encode(Bulletin(news, (), 3, (Request(8, 500.0), Arrival(bytes(4 * 36), 8)))),
        next(frame.payload for frame in swept()[-1].inbox),
    ]


@cache
def swept(seed: int = 1) -> list[Percept]:
    """What a robot really perceived that began to clear a corridor with three others."""
    given = sweeping(4, seed=seed)
    with tempfile.TemporaryDirectory() as folder:
        run = course(given, Path(folder), SWEPT_TICKS)
        return [codec.decode(Percept, one) for one in percepts_of(memories(run.journal, "r2"))]


def a_life(package: str, name: str, ticks: int = 25, seed: int = 0) -> list[Percept]:
    """Percepts of a node that drives about, sees others, hears sense and garbage."""
    draw = np.random.Generator(np.random.Philox(seed))
    if name in IN_A_PLAN:
        start, *rest = swept(1 + seed)
        return [start, *(_louder(one, draw) for one in rest)]
    life = [first(package, name)]
    for tick in range(1, ticks):
        x_m, y_m = (draw.random(2) * 180).tolist()
        heard = [
            Frame(f"r{number}", tick - 1, payload)
            for number, payload in zip(
                SENDERS, [*sound_frames()[:6], draw.bytes(int(draw.integers(40)))], strict=True
            )
            if draw.random() < 0.7
        ]
        seen = [Sighting("r3", x_m + 1, y_m)] if draw.random() < 0.5 else []
        life.append(percept(tick, x_m, y_m, inbox=heard, in_sight=seen))
    return life


def hearing(name: str, tick: int, payloads: list[bytes]) -> Percept:
    """A percept in which a node with this behaviour hears these frames of r1, r2, ..."""
    inbox = [Frame(f"r{number}", tick - 1, payload) for number, payload in enumerate(payloads, start=1)]
    if name not in IN_A_PLAN:
        return percept(tick, 45.0, 45.0, inbox=inbox)
    return with_frames(swept()[tick], inbox, [(0.9, 0.1 * tick)] * len(inbox))


def with_frames(given: Percept, more: list[Frame], bearings: list[tuple[float, float]]) -> Percept:
    """A percept with more frames in its inbox, that come from these ranges and bearings."""
    measured = given.senses.bearings + np.array(bearings, dtype="<f4").tobytes()
    senses = msgspec.structs.replace(given.senses, bearings=measured)
    return msgspec.structs.replace(given, senses=senses, inbox=(*given.inbox, *more))


def _louder(given: Percept, draw: np.random.Generator) -> Percept:
    """A percept with a frame that nobody understands, now and then, and one of somebody far away."""
    strange = draw.bytes(int(draw.integers(40))), sound_frames()[-1]
    more = [
        Frame(f"r{7 + at}", given.tick - 1, payload)
        for at, payload in enumerate(strange)
        if draw.random() < 0.3
    ]
    return with_frames(given, more, [(1.5, 0.3 * given.tick % 3)] * len(more))


@st.composite
def damaged(draw) -> bytes:
    """A sound frame in which one byte is another."""
    payload = bytearray(draw(st.sampled_from(sound_frames())))
    payload[draw(st.integers(0, len(payload) - 1))] = draw(st.integers(0, 255))
    return bytes(payload)


@st.composite
def strange(draw) -> bytes:
    """A frame that has the form of a bulletin and says impossible things."""
    whole = st.integers(-(2**63), 2**63 - 1)
    number = st.floats() | whole
    acknowledged = st.lists(st.tuples(st.text(max_size=3), whole), max_size=2)
    columns = st.tuples(st.binary(max_size=12), st.binary(max_size=6))
    own = st.none() | st.tuples(number, whole, whole, whole)
    return codec.encode(draw(st.tuples(columns, acknowledged, whole, own)))
