"""What robots of a sweep team say to each other: one beacon a tick, with what passes along their line.

Ways and places are complex numbers in metres, in the sender's own frame. Robots are named by their numbers.
"""

from typing import Annotated, Any, Literal

import msgspec

from swarm_agent.graph_copy import Delta, Version

Role = Literal["anchor", "free", "file", "join", "leader", "centre", "leave"]
NOBODY, WALL = 0, -1
Number = Annotated[int, msgspec.Meta(ge=-1, le=9999)]
Tick = Annotated[int, msgspec.Meta(ge=-1, le=2**53)]


class Flow(msgspec.Struct, frozen=True, array_like=True):
    """What a line tells from one of its ends up to a robot, that robot included.

    `count` robots, none of which has moved since tick `moved`; does any of them have something `open` ahead,
    does any want the line to `halt`, is any `pinned` to an obstacle. `angle_rad` of the leader at that end.
    `spare`: robots behind that leader.
    """

    count: int = 1
    moved: Tick = 0
    open: bool = True
    halt: bool = False
    pinned: bool = False
    angle_rad: float = 0.0
    spare: int = 0
    leader: Number = NOBODY
    want: bool = False
    order: int = 0
    taut: int = 0


class Measured(msgspec.Struct, frozen=True, array_like=True):
    """The bearing at which the frame that robot `number` sent at `tick` came in."""

    number: Number
    tick: Tick
    bearing_rad: float


class Beacon(msgspec.Struct, frozen=True, array_like=True):
    """All that a robot says in a tick.

    `left`, `right`: its neighbours on the line, seen with the contaminated side ahead; WALL where it is a
    leader. `ahead`: whom it follows in file; `tail`: how many there are in the file from it on. `ranges`: its
    scan. `wall`: the way to the place of the wall that it holds or, pinned, would hold.
    """

    role: Role
    line: int
    since: Tick
    left: Number
    right: Number
    ahead: Number
    rank: int
    tail: int
    ranges: bytes
    measured: tuple[Measured, ...]
    from_left: Flow | None
    from_right: Flow | None
    pinned: bool
    close: bool
    ready: bool
    wall_x_m: float
    wall_y_m: float
    version: Version
    delta: Delta | None
    stage: str = ""
    gap: bool = False
    epoch: int = 0
    anchor: int = 0
    courier: int = 0
    dead: tuple[int, ...] = ()

    @property
    def wall(self) -> complex:
        return complex(self.wall_x_m, self.wall_y_m)
