"""Mission "clear" as the world plays it: discs among walls, senses without a position, and a referee."""

from collections.abc import Sequence

import numpy as np
import shapely

from wire import codec
from wire.clearing import Clearing, Standing
from wire.fields import Point, Unseen
from wire.messages import Action, Pose, Senses
from wire.scenario import Range, Scenario, Sensors
from world_server.deployment import deployed, plan_of, turned, turned_point
from world_server.discs import Disc
from world_server.frontline import Line, whole_lines
from world_server.judges import Judges
from world_server.mission import Mission, Pairs, Visits
from world_server.motion import Body
from world_server.nodes import ALIVE, Letter, Node
from world_server.perception import Perception
from world_server.walls import Walls

CLAIMED_S = 10.0  # how long a run goes on when a robot has claimed that it is over
ANSWER = codec.decoder(Standing)


class Clear(Mission):
    """Robots see walls, hear bearings, and are not told where they are. The tower is a mast, no obstacle."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario)
        self._sensors = scenario.sensors or Sensors()
        plan = turned(plan_of(scenario.field), scenario.field.turned_rad)
        rings_m = [shapely.get_coordinates(ring) for ring in shapely.get_rings(plan)]
        step_m = scenario.robots.max_speed_m_s * scenario.tick_s
        self._walls = Walls(rings_m, scenario.robots.body_m / 2 + step_m + 1e-6)
        self._perception = Perception(self._sensors, Walls(rings_m, self._sensors.detect_m), scenario.seed)
        self._robots: dict[int, Node] = {}
        self._felt_m: dict[int, Point] = {}
        """Where each robot was at its percept before."""
        self._standing: dict[int, Standing] = {}

    @property
    def told(self) -> Unseen:
        """How far rays and radio reach, and nothing of the plan."""
        ranges_m = [rule.range_m for rule in self._scenario.radio.rules if isinstance(rule, Range)]
        return Unseen(self._sensors.detect_m, self._sensors.rays, min(ranges_m))

    @property
    def tower_m(self) -> Point:
        """Nobody is told where anything is."""
        return (0.0, 0.0)

    @property
    def sensor_range_m(self) -> float:
        """Robots do not see each other."""
        return 0.0

    @property
    def cleared_share(self) -> float:
        """How much of the plan is clear."""
        return self._judges.cleared_share

    def first_poses(self) -> dict[str, Pose]:
        """Where every node begins, in order of their numbers."""
        return deployed(self._scenario)

    def body(self, name: str, pose: Pose) -> Body:
        """The body of a node."""
        return Disc(pose, 0.0 if name == self._scenario.tower.id else self._scenario.robots.max_speed_m_s)

    def begin(self, nodes: Sequence[Node]) -> None:
        """All nodes stand where they begin, and the referee takes a first look."""
        super().begin(nodes)
        tower = self._scenario.tower.id
        self._robots = {row: node for row, node in enumerate(nodes) if node.name != tower}
        self._judges = Judges(self._scenario, self._places_m(), self._alive())
        self._felt_m = dict(zip(self._robots, self._places_m(), strict=True))

    def sensed(self, tick: int, row: int, senses: Senses, letters: Sequence[Letter]) -> Senses:
        """A scan, what the body has come since, and bearings of what is heard, in place of a pose."""
        bearings = np.array([letter.bearing for letter in letters], dtype="<f4").tobytes()
        node = self._robots.get(row)
        scan, odometry_m = b"", (0.0, 0.0)
        if node is not None:
            scan = self._perception.scan(tick, node)
            odometry_m = self._perception.odometry_m(tick, node, self._felt_m[row])
            self._felt_m[row] = (node.body.x_m, node.body.y_m)
        return Senses(
            refused_frames=senses.refused_frames,
            arrived=senses.arrived,
            scan=scan,
            odometry_m=odometry_m,
            bearings=bearings,
        )

    def addressed(self, letter: Letter, receiver: int) -> Letter:
        """A letter with its bearing, as the receiver measures it now."""
        node, sender = self._nodes[receiver], self._nodes[letter.sender]
        return letter._replace(bearing=self._perception.bearing(letter.sent_tick, node, sender))

    def acted(self, row: int, action: Action) -> None:
        """Take note of what a robot reports of itself; what is no Standing is not for the world."""
        if row not in self._robots or not action.report:
            return
        try:
            standing = self._standing[row] = ANSWER(action.report)
        except codec.Malformed:
            return
        if standing.claim and self.ends_tick is None:
            self.ends_tick = action.tick + self._scenario.tick_of(CLAIMED_S)

    def restarted(self, row: int, in_queue: bool) -> None:
        """A new process finds the body where it lay; what the one before it said counts no more."""
        self._standing.pop(row, None)
        if row in self._robots:
            self._felt_m[row] = (self._nodes[row].body.x_m, self._nodes[row].body.y_m)

    def settle(self, tick: int) -> tuple[Visits, Pairs]:
        """One tick of all bodies, in order of their numbers; each finds the others where they are by then."""
        corners_m = []
        for row, node in self._robots.items():
            others_m = [(one.body.x_m, one.body.y_m) for other, one in self._robots.items() if other != row]
            arrived = node.body.arrived
            way = node.body.drive(self._scenario.tick_s, self._walls, others_m, self._scenario.robots.body_m)
            corners_m.append(tuple(way[:-1]))
            if node.body.arrived and not arrived:
                node.arrival_pending = True
        self._judges.step(self._places_m(), corners_m, self._alive())
        return (), ()

    def judged(self, tick: int) -> Clearing:
        """What the referee says of the tick that has just been settled."""
        return self._judges.said(tick, self._lines)

    def _lines(self) -> list[Line]:
        """Lines from wall to wall that living robots last said they form, where they really stand.

        Lines of robots that have not heard yet that the team began again hold nothing.
        """
        robots, newest = {}, max((standing.epoch for standing in self._standing.values()), default=0)
        for row, node in self._robots.items():
            standing = self._standing.get(row)
            if standing is not None and node.mode == ALIVE and standing.epoch == newest:
                wall_m = seen_from(node.body.pose, standing.wall_m)
                place_m = (node.body.x_m, node.body.y_m)
                robots[node.name] = (standing.left, standing.right, place_m, wall_m)
        return whole_lines(robots)

    def in_role(self, role: str) -> tuple[str, ...]:
        """Living robots on the main line that last reported this role, in order of their numbers."""
        return tuple(
            node.name
            for row, node in self._robots.items()
            if node.mode == ALIVE
            and (standing := self._standing.get(row)) is not None
            and standing.main
            and standing.role == role
        )

    def _places_m(self) -> list[Point]:
        return [(node.body.x_m, node.body.y_m) for node in self._robots.values()]

    def _alive(self) -> list[bool]:
        """Who sees: a process that is stopped or gone notices no intruder."""
        return [node.mode == ALIVE for node in self._robots.values()]


def seen_from(pose: Pose, way_m: Point) -> Point:
    """Where a way of a body ends that is told forward and to the left of it."""
    x_m, y_m = turned_point(way_m, pose.heading_rad)
    return (pose.x_m + x_m, pose.y_m + y_m)
