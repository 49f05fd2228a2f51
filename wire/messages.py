"""Every message that crosses the wire. Units stand last in names; arrays travel as little-endian bytes."""

import math
from typing import Annotated, Any, Literal

import msgspec

from wire.base import Count, Message, NodeId
from wire.clearing import Clearing
from wire.fields import Told

WAKE_ON_FRAME, WAKE_ON_ARRIVAL, WAKE_ON_SENSOR, WAKE_ON_BLOCKED = 1, 2, 4, 8
FRAMES_PER_ACTION = 1024

Why = Literal["start", "wake", "frame", "arrival", "sensor", "blocked", "end"]
Verb = Literal["kill", "freeze", "thaw", "restart", "slow"]
BEFALLS = {
    "kill": ("alive", "frozen", "flat"),
    "freeze": ("alive",),
    "thaw": ("frozen",),
    "restart": ("dead",),
    "slow": ("alive",),
}
"""The states of a node in which each fault can befall it, for the plan and for the world."""
Memory = Literal["lost", "kept"]
Place = Literal["here", "queue"]
"""Where a restarted robot stands: where its body lay, or carried to the tower's queue, charged."""


class Pose(Message):
    """Position in the field's frame and heading, counter-clockwise from the x axis, in (-pi, pi]."""

    x_m: float
    y_m: float
    heading_rad: float


class Sighting(Message):
    """Another body within sensor range, dead or alive, at its position in the field's frame."""

    node: NodeId
    x_m: float
    y_m: float


class Frame(Message):
    """One radio transmission as its receiver hears it; `payload` is the sender's own vocabulary."""

    sender: NodeId
    sent_tick: Count
    payload: bytes


class Configuration(Message):
    """All that a node is told about itself and its mission, once, in its first percept.

    `parameters` is the behaviour's own Struct, encoded; `generator_key` seeds the node's only chance.
    """

    node: NodeId
    incarnation: Count
    behaviour: str
    parameters: bytes
    generator_key: tuple[int, ...]
    tick_s: float
    tower: NodeId
    field: Told
    max_speed_m_s: float
    tower_m: tuple[float, float] = (0.0, 0.0)
    row: Count = 0
    """This robot's place among the robots, in order of their numbers, from 0: also its place in a queue."""
    body_m: float = 0.0
    """The distance that bodies keep from each other; 0: they pass each other freely."""


class Senses(Message):
    """What a body tells its mind at a grant. `pose` is None where a mission gives no position."""

    pose: Pose | None = None
    in_sight: tuple[Sighting, ...] = ()
    battery_v: float | None = None
    refused_frames: Count = 0
    """Frames of the last action that the radio refused because they passed the byte limit of a tick."""
    arrived: bool = False
    """Has the body reached the end of its motion?"""
    travelled_m: float = 0.0
    """How far the body has come along the path it was last given."""
    blocked_by: NodeId | None = None
    """The body that this one waits behind, which is then in sight."""
    shared_last_visit: bytes = b""
    """uint32: the tick of every site's last visit, this tick's included; empty where it is not granted."""
    scan: bytes = b""
    """float32: the range in metres to the nearest wall along each ray, the first from the front of the body,
    the others counter-clockwise at equal angles; infinite where there is none within range."""
    odometry_m: tuple[float, float] = (0.0, 0.0)
    """How far the body has come since the percept before, forward and to the left."""
    bearings: bytes = b""
    """float32, (frames in the inbox, 2): range_m and bearing_rad in (-pi, pi] of the sender of each frame,
    counter-clockwise from the front of the body, as they were when the frame was sent."""


class Percept(Message):
    """A grant: permission to act at `tick`, and everything the node may know at it."""

    tick: Count
    grant: Count
    why: Why
    senses: Senses
    inbox: tuple[Frame, ...] = ()
    configuration: Configuration | None = None


class Stay(Message, tag="stay"):
    """Stand still."""


class GoTo(Message, tag="go_to"):
    """Drive to a point; `within_m` of it counts as arrival. Holds until another motion replaces it."""

    x_m: float
    y_m: float
    within_m: float = 0.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.x_m) and math.isfinite(self.y_m) and math.isfinite(self.within_m)):
            raise ValueError("a motion needs finite numbers")


class Follow(Message, tag="follow"):
    """Drive along a path through these points, from wherever the body is. Holds until replaced.

    With `backwards` the body may drive either way round, else it turns. It stops short of other bodies in its
    way, outside passing lanes and queue, and goes on when the way is clear.
    """

    path_m: Annotated[tuple[tuple[float, float], ...], msgspec.Meta(min_length=1, max_length=1000)]
    backwards: bool = False

    def __post_init__(self) -> None:
        if not all(math.isfinite(one) for point in self.path_m for one in point):
            raise ValueError("a path needs finite numbers")


class Dock(Message, tag="dock"):
    """Stand in the tower's queue and take a charged battery; anywhere else it is `Stay`."""


class Shift(Message, tag="shift"):
    """Drive straight by this much, forward and to the left of the body's front, which never turns; then rest.

    Holds until replaced. Only the discs of mission clear can; to any other body it is `Stay`.
    """

    x_m: float
    y_m: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.x_m) and math.isfinite(self.y_m)):
            raise ValueError("a motion needs finite numbers")


Motion = Stay | GoTo | Follow | Dock | Shift


class Action(Message):
    """The one answer to a grant. `wake_on` adds up WAKE_ON_ flags; no `wake_tick` means: not by time.

    `report` is for observers only; the world carries it unread.
    """

    tick: Count
    grant: Count
    motion: Motion | None = None
    outbox: Annotated[tuple[bytes, ...], msgspec.Meta(max_length=FRAMES_PER_ACTION)] = ()
    wake_tick: Count | None = None
    wake_on: Annotated[int, msgspec.Meta(ge=0, le=15)] = 0
    report: bytes = b""

    def __post_init__(self) -> None:
        if self.wake_tick is not None and self.wake_tick <= self.tick:
            raise ValueError(f"wake_tick {self.wake_tick} is not after tick {self.tick}")


class Fault(Message):
    """What happens to one node at the boundary before `tick`. `every`: which ticks a slow node is granted."""

    tick: Count
    verb: Verb
    node: NodeId
    memory: Memory = "lost"
    place: Place = "here"
    every: Annotated[int, msgspec.Meta(ge=1, le=10**6)] = 1


class Facts(Message):
    """What was true of one tick: the only thing metrics and pictures are made of.

    `poses`: float64, (nodes, 3): x_m, y_m, heading_rad settled at the end of the tick. `goals`: float64,
    (nodes, 2), NaN for none. `modes`: uint8 per node: 0 alive, 1 frozen, 2 dead, 3 flat. `links`: uint16
    pairs of node rows (sender, receiver) of every delivery decided in the tick. `visits`: (node, site) at the
    tick. `reports`: what nodes said of themselves. `radio`: frames sent, deliveries, out of range, otherwise
    lost, oversize, bytes sent. `battery_v`: float32 per node, NaN for the tower, empty where there are no
    batteries. `incidents`: pairs of robots that have just come closer than bodies may. `clearing`: what the
    referee says, where there is one.
    """

    tick: Count
    poses: bytes
    goals: bytes
    modes: bytes
    links: bytes
    visits: tuple[tuple[NodeId, Count], ...]
    reports: tuple[tuple[NodeId, bytes], ...]
    faults: tuple[Fault, ...]
    radio: tuple[int, int, int, int, int, int]
    battery_v: bytes = b""
    incidents: tuple[tuple[NodeId, NodeId], ...] = ()
    clearing: Clearing | None = None


class TruthBlock(Message):
    """A run of consecutive facts; `number` counts blocks, so that a listener sees what it missed."""

    number: Count
    nodes: tuple[NodeId, ...]
    facts: tuple[Facts, ...]


class Event(Message):
    """Something an observer wants to know: a fault, a death, a refusal, a delay."""

    tick: Count
    kind: str
    node: str
    text: str
    data: dict[str, Any] = {}


class Order(Message):
    """The world asks the launcher to do what only the launcher can: a real signal, a real start."""

    number: Count
    fault: Fault


class Started(Message, tag="started"):
    """The launcher started a process for a node."""

    node: NodeId
    pid: Count
    incarnation: Count


class Done(Message, tag="done"):
    """Order `number` was carried out and seen to have happened, or could not be, for the reason given."""

    number: Count
    confirmed: bool
    reason: str = ""


class Exited(Message, tag="exited"):
    """A node's process ended; `status` is its exit code, or minus the signal that ended it."""

    node: NodeId
    incarnation: Count
    status: int
    last_lines: str = ""


class Finish(Message, tag="finish"):
    """End the run at the next tick boundary."""


Notice = Started | Done | Exited | Finish


class Request(Message):
    """An operator's wish. `value` is ticks for `step` and the rate for `speed`."""

    verb: Literal["status", "pause", "resume", "step", "speed", "kill", "freeze", "thaw", "restart"]
    node: str = ""
    memory: Memory = "lost"
    value: float = 0.0
    place: Place = "here"

    def __post_init__(self) -> None:
        if not (math.isfinite(self.value) and self.value >= 0):
            raise ValueError(f"value must be a finite number >= 0, got {self.value}")


class Reply(Message):
    """The world's answer to a request: accepted or not, in words, and the state of the run as facts."""

    accepted: bool
    text: str
    data: dict[str, Any] = {}
