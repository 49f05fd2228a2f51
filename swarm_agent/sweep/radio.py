"""What robots of a sweep team say to each other: one beacon a tick, with what passes along their line.

Robots are named by their numbers. Lines are seen with the contaminated side ahead: so each robot on one has
a left and a right neighbour, and the leaders have a wall there.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import msgspec

from swarm_agent.graph_copy import Delta, Version

Role = Literal["free", "anchor", "reserve", "joining", "centre", "leader", "leaving"]
"""`free`: not yet in a team; `anchor`: the others gather around it; `reserve`: follows a line, or looks for
one; `joining` and `leaving`: on the way into a line or out of it; `leader`: at the end of a line.
"""
Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")
OTHER: dict[Side, Side] = {"left": "right", "right": "left"}
NOBODY, WALL = 0, -1
GO_ON, GO_BACK, GO_HOME = 0, -1, -2
"""Orders of a captain. Any other is the place of the robot that is to push forward."""
BARRIER = ("centre", "leader", "leaving")
"""The roles of those who are part of a line."""

Number = Annotated[int, msgspec.Meta(ge=-1, le=9999)]
MOST = 10_000
Count = Annotated[int, msgspec.Meta(ge=0, le=MOST)]
Tick = Annotated[int, msgspec.Meta(ge=-1, le=2**53)]
Order = Annotated[int, msgspec.Meta(ge=-2, le=10_000)]
Angle = Annotated[float, msgspec.Meta(ge=-10, le=10)]
Way = Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)]
"""Numbers that are finite: bounds refuse what is no number, too."""
Stage = Literal["", "forming", "cut", "closed", "gone", "homing", "gathering"]


class Flow(msgspec.Struct, frozen=True, array_like=True):
    """What a line tells from one of its ends up to a robot, that robot included.

    `count` robots; news of all of them is from tick `since` or later, and none has moved after `moved`.
    `open`: has any something ahead that nobody sees; `halt`: does any want the line to stand; `pinned`: is
    any held by an obstacle, `pivot`: in the middle; `want`: is there a gap that needs one more robot;
    `spare`: robots that follow them.
    `angle_rad`: of the leader at that end. `order`: what the right leader orders; `taut`: the place of the
    robot that has pushed as far as it can. `meets`: does the leader at that end become one with another line;
    `barred`: can it not go along its wall.
    """

    count: Count
    since: Tick
    moved: Tick
    open: bool
    halt: bool
    pinned: bool
    pivot: bool
    want: bool
    spare: Count
    angle_rad: Angle = 0.0
    order: Order = 0
    taut: Count = 0
    meets: bool = False
    barred: bool = False


class Measured(msgspec.Struct, frozen=True, array_like=True):
    """The bearing at which the frame that robot `number` sent at `tick` came in."""

    number: Number
    tick: Tick
    bearing_rad: Angle


class Body(msgspec.Struct, frozen=True, array_like=True):
    """The way to the body of a dead robot that somebody last heard at `tick`."""

    number: Number
    tick: Tick
    x_m: Way
    y_m: Way


class Beacon(msgspec.Struct, frozen=True, array_like=True):
    """All that a robot says in a tick.

    `line` since tick `since`; `ahead`: whom a reserve robot follows, in `rank`-th place behind the line, with
    `tail` robots in its file from it on. `ranges`: its scan (`sweep.peers.Eye`). `wall_x_m`, `wall_y_m`: the
    way to the wall that it holds, or would hold where it is `pinned`; `ready`: does it see the wall of its
    pinned neighbour; `close`: its neighbour must come near, for it has an obstacle ahead and is a leader.
    `meets`: a leader of another line, with whom it would become one line. `epoch`: how often the team began
    again, at `anchor`, with `couriers` underway to tell the others; `hand`: where it keeps walls when it
    travels. `dead` robots and `gone` lines: all that it knows of, and the ways to `bodies` of the dead.
    """

    role: Role
    line: Number
    since: Tick
    left: Number
    right: Number
    ahead: Number
    rank: Count
    tail: Count
    ranges: bytes
    measured: tuple[Measured, ...]
    from_left: Flow | None
    from_right: Flow | None
    pinned: bool
    close: bool
    ready: bool
    wall_x_m: Way
    wall_y_m: Way
    stage: Stage
    meets: Number
    epoch: Count
    anchor: Number
    couriers: tuple[Number, ...]
    hand: Side
    dead: tuple[Number, ...]
    bodies: tuple[Body, ...]
    gone: tuple[Number, ...]
    version: Version
    delta: Delta | None

    @property
    def wall(self) -> complex:
        """The way to its wall, in its own frame."""
        return complex(self.wall_x_m, self.wall_y_m)

    def beside(self, side: Side) -> int:
        """Its neighbour on that side of the line."""
        return self.left if side == "left" else self.right

    @property
    def follows_nobody(self) -> bool:
        """Is it no part of a line?"""
        return self.role not in BARRIER


@dataclass(frozen=True)
class Lacking:
    """Said by who is no robot of the team: I have this version of the graph, and heard of a newer one.

    A map on the wire, so that no beacon, which is a list, needs a tag to be told from it.
    """

    version: Version


Spoken = Beacon | Lacking
