"""One robot of the line on its own, told by a test where its body is and what it hears."""

from typing import Any

import numpy as np

from swarm_agent.behaviour import Heard, Move
from swarm_agent.behaviours.line_patrol import LinePatrol, LinePatrolParameters
from swarm_agent.line_radio import Envelope, Order, Report
from tests.builders import configuration
from wire.fields import Polyline
from wire.line import Line
from wire.messages import Follow, Percept, Pose, Senses, Sighting

FIELD = Polyline(((-3.0, 0.0), (3.0, 0.0)), 4, gap_m=0.4, approach_m=0.2)
LINE = Line(FIELD, (0.0, 0.0))
BODY_M = 0.2


class LineRobot:
    """A robot r2 (row 0) of a line of four segments of 1.2 m, two on each side of the tower at the origin."""

    def __init__(self, **parameters: Any) -> None:
        told = configuration(
            "r2", "line_patrol", field=FIELD, max_speed_m_s=0.12, tower_m=(0.0, 0.0), row=0, body_m=BODY_M
        )
        chance = np.random.Generator(np.random.Philox(1))
        self.mind = LinePatrol(LinePatrolParameters(**parameters), told, chance)
        self.tick = 0
        self.battery_v = 9.0
        self.place = LINE.slot(0)
        self.move = Move()
        self._numbers = 0

    def at(self, arc_m: float, aside_m: float = 0.0) -> "LineRobot":
        """Put the body somewhere."""
        self.place = LINE.point(arc_m, aside_m)
        return self

    def wake(
        self,
        *heard: Heard,
        arrived: bool = False,
        travelled_m: float = 0.0,
        blocked_by: tuple[str, float] | None = None,
        after: int = 1,
    ) -> Move:
        """Let the mind take a step. `blocked_by`: a body and its arc."""
        self.tick += after
        seen, name = (), None
        if blocked_by is not None:
            name = blocked_by[0]
            seen = (Sighting(name, *LINE.point(blocked_by[1])),)
        pose = Pose(*self.place, 0.0)
        senses = Senses(pose, seen, self.battery_v, 0, arrived, travelled_m, name)
        self.move = self.mind.step(Percept(self.tick, self.tick, "wake", senses), list(heard))
        return self.move

    def hears(self, message: Any, origin: str = "r1", relay: bool = False, distance_m: float = 0.0) -> Heard:
        """A message as this robot hears it now, straight from its origin."""
        self._numbers += 1
        return Heard(
            origin, self.tick, Envelope(origin, self.tick, self._numbers, message, distance_m, relay)
        )

    def order(self, segment: int, number: int | None = None) -> Heard:
        """The tower's order to this robot."""
        return self.hears(Order(number or 1000 * (self.tick + 1), "r2", segment))

    @property
    def said(self) -> list[Report]:
        """The reports of its own in the last move."""
        return [one.message for one in self.move.say if one.origin == "r2"]

    @property
    def path(self) -> list[tuple[float, float]]:
        """Arc and aside of every point of the path in the last move."""
        assert isinstance(self.move.motion, Follow), f"{self.move.motion} is not a path"
        return [tuple(round(one, 6) for one in LINE.locate(point)) for point in self.move.motion.path_m]

    def on_patrol(self, segment: int) -> "LineRobot":
        """Bring it onto a segment, at the beginning of its first lap."""
        self.wake()
        self.wake(self.order(segment))
        self.at(LINE.segment(segment).near_m).wake(arrived=True)
        assert self.mind.state == "patrol"
        return self

    def lap(self) -> Move:
        """Come to the end of a lap."""
        self.at(LINE.segment(self.mind.segment).near_m)
        return self.wake(arrived=True, travelled_m=2.4, after=20)
