"""What a mission adds to the world: bodies, how they settle, what they sense, and what counts as a visit."""

from collections.abc import Sequence

from wire.clearing import Clearing
from wire.fields import Told
from wire.messages import Action, Pose, Senses
from wire.scenario import Scenario
from world_server.motion import Body, first_poses
from world_server.nodes import Letter, Node

Visits = tuple[tuple[str, int], ...]
Pairs = tuple[tuple[str, str], ...]


class Mission:
    """Base of all missions. What one does not say is as here: no batteries, no visits, no referee."""

    ends_tick: int | None = None
    """The tick at which the mission ends, where it ends before its time."""
    cleared_share = 0.0
    """How much of a floor plan is clear, in the eyes of the referee."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._nodes: Sequence[Node] = ()

    @property
    def told(self) -> Told:
        """What nodes are told of the field."""
        return self._scenario.field

    @property
    def tower_m(self) -> tuple[float, float]:
        """Where nodes are told that the tower stands."""
        return self._scenario.tower.x_m, self._scenario.tower.y_m

    @property
    def sensor_range_m(self) -> float:
        """How far robots see each other."""
        return self._scenario.robots.sensor_range_m

    def first_poses(self) -> dict[str, Pose]:
        """Where every node begins, in order of their numbers."""
        return first_poses(self._scenario)

    def body(self, name: str, pose: Pose) -> Body:
        """The body of a node."""
        raise NotImplementedError

    def begin(self, nodes: Sequence[Node]) -> None:
        """All nodes stand where they begin."""
        self._nodes = nodes

    @property
    def restless(self) -> bool:
        """Is the next tick to be settled even though nobody moves or is due?"""
        return False

    def battery_v(self, row: int) -> float | None:
        """What a node's battery says."""
        return None

    def volts(self) -> bytes:
        """The charge of all nodes, as Facts keep it."""
        return b""

    def last_visits(self, tick: int) -> bytes:
        """What robots sense of visits as a tick begins, as Senses have it."""
        return b""

    def sensed(self, tick: int, row: int, senses: Senses, letters: Sequence[Letter]) -> Senses:
        """What a node's body tells its mind. `senses`: what it would without this; `letters`: its inbox."""
        return senses

    def addressed(self, letter: Letter, receiver: int) -> Letter:
        """A letter of this tick as the node in row `receiver` gets it."""
        return letter

    def visits(self, tick: int) -> Visits:
        """The visits that are complete as the tick begins; each counts once."""
        return ()

    def acted(self, row: int, action: Action) -> None:
        """Take note of what a node does, beside the motion of its body."""

    def restarted(self, row: int, in_queue: bool) -> None:
        """A new process finds the body where it lay, or carried to its place in the queue."""

    def settle(self, tick: int) -> tuple[Visits, Pairs]:
        """One tick of all bodies. Returns further visits of the tick, and who has come too close to whom."""
        raise NotImplementedError

    def judged(self, tick: int) -> Clearing | None:
        """What the referee says of the tick that has just been settled."""
        return None

    def in_role(self, role: str) -> tuple[str, ...]:
        """Living robots on the main line that last reported this role, in order of their numbers."""
        return ()
