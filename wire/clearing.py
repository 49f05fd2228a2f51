"""What is said of a floor plan that is being cleared: by robots and tower to observers, by the referee."""

from typing import Literal

from wire.base import Count, Message

Claim = Literal["", "done", "failed"]


class Standing(Message):
    """What a robot says of itself to observers: its action's report. Other robots never hear it.

    `line`: the number of the line it belongs to, `main`: is that the one that moves? `left`, `right`: its
    neighbours on the line. `releasing`: it gives up cleared ground on purpose. `events`: what it has decided
    since its last report, each told by one robot only: "split", "search", "search_failed", "dissolve",
    "merge", "restart". `graph`: its surveillance graph, whole, as swarm_agent.graph_copy.Delta. `wall_m`: the
    way to the wall that it holds as an end of its line, forward and to the left of its body. `epoch`: how
    often its team has begun again, as far as it knows.
    """

    role: str = ""
    line: Count = 0
    main: bool = False
    left: str = ""
    right: str = ""
    claim: Claim = ""
    releasing: bool = False
    events: tuple[str, ...] = ()
    graph: bytes = b""
    wall_m: tuple[float, float] = (0.0, 0.0)
    epoch: Count = 0


class Overheard(Message):
    """What the tower says to observers of the graph that robots draw: its action's report.

    `heard_tick`: the last tick in which a robot said that this is the newest that it knows. `graph`: whole,
    as swarm_agent.graph_copy.Delta; empty where it is the one that was told last.
    """

    heard_tick: Count
    graph: bytes = b""


class Clearing(Message):
    """What the referee says of one tick, in square metres.

    `lost_m2`: clear before the tick and contaminated now; of this `given_up_m2` was in sight of some robot
    until this tick. `raster_m2`: contaminated in the eyes of the raster referee, where both judge.
    `outline`: for pictures, float32 (points, 2): the rings around what is contaminated, x_m and y_m, each
    ring closed and followed by a row of NaN; where nothing is, that row alone. It comes at most once per
    simulated second, when it has changed. `ahead_m2`: of what was lost out of sight, the part that lay ahead
    of lines and was held by none.
    """

    contaminated_m2: float
    lost_m2: float = 0.0
    given_up_m2: float = 0.0
    raster_m2: float | None = None
    outline: bytes = b""
    ahead_m2: float = 0.0
