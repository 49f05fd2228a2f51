"""Bodies and how they move: a unicycle that turns first and then goes.

Source: speeds from Kobayashi et al. 2025, Table I; the turn-then-go step is our choice,
as the paper gives none.
"""

import math

from wire.line import Line
from wire.messages import Dock, Follow, GoTo, Motion, Pose, Shift, Stay
from wire.scenario import Fan, InQueue, Poses, Scenario
from world_server.chance import generator


class Body:
    """A disc on the plane. It holds its last motion until told otherwise; a dead body stays where it fell."""

    travelled_m = 0.0
    """How far it has come along the path it was last given; this kind of body knows no paths."""

    def __init__(self, pose: Pose, max_speed_m_s: float, max_turn_rad_s: float) -> None:
        self.x_m, self.y_m, self.heading_rad = pose.x_m, pose.y_m, pose.heading_rad
        self._max_speed_m_s = max_speed_m_s
        self._max_turn_rad_s = max_turn_rad_s
        self.goal: GoTo | None = None

    @property
    def pose(self) -> Pose:
        """Where the body is now."""
        return Pose(self.x_m, self.y_m, self.heading_rad)

    @property
    def arrived(self) -> bool:
        """Is the body within reach of its goal?"""
        goal = self.goal
        return goal is not None and math.hypot(goal.x_m - self.x_m, goal.y_m - self.y_m) <= goal.within_m

    @property
    def at_rest(self) -> bool:
        """Will the body stay where it is if nobody tells it otherwise?"""
        return self.goal is None or (self.goal.x_m == self.x_m and self.goal.y_m == self.y_m)

    def command(self, motion: Motion | None) -> bool:
        """Take over a motion; None keeps the present one. Of a path only the end counts here.

        Returns whether the body is already where it has just been sent.
        """
        before = self.goal
        if isinstance(motion, (Stay, Dock, Shift)):
            self.goal = None
        elif isinstance(motion, Follow):
            self.goal = GoTo(*motion.path_m[-1])
        elif motion is not None:
            self.goal = motion
        return self.goal != before and self.arrived

    def halt(self) -> object:
        """Stop where it is. Returns what is left of its errand, for `resume`."""
        errand, self.goal = self.goal, None
        return errand

    def resume(self, errand: object) -> None:
        """Go on with an errand that `halt` interrupted."""
        self.goal = errand

    def carry_to(self, pose: Pose) -> None:
        """Put the body somewhere else, by hand; it has no errand any more."""
        self.halt()
        self.x_m, self.y_m, self.heading_rad = pose.x_m, pose.y_m, pose.heading_rad

    def advance(self, tick_s: float) -> None:
        """One tick: turn towards the goal, and go unless the turn takes the whole tick."""
        if self.at_rest or self._max_speed_m_s == 0:
            return
        away_x, away_y = self.goal.x_m - self.x_m, self.goal.y_m - self.y_m
        distance = math.hypot(away_x, away_y)
        error = wrapped(math.atan2(away_y, away_x) - self.heading_rad)
        most = self._max_turn_rad_s * tick_s
        self.heading_rad = wrapped(self.heading_rad + max(-most, min(most, error)))
        if abs(error) > most:
            return
        step = self._max_speed_m_s * tick_s
        if distance <= step:
            self.x_m, self.y_m = self.goal.x_m, self.goal.y_m
        else:
            self.x_m += step * math.cos(self.heading_rad)
            self.y_m += step * math.sin(self.heading_rad)


def wrapped(angle_rad: float) -> float:
    """The same angle in (-pi, pi]."""
    turned = math.remainder(angle_rad, math.tau)
    return math.pi if turned == -math.pi else turned


def first_poses(scenario: Scenario) -> dict[str, Pose]:
    """Where every node begins: the tower where it stands, the robots as the scenario's start says."""
    poses = {scenario.tower.id: Pose(scenario.tower.x_m, scenario.tower.y_m, 0.0)}
    poses |= dict(zip(scenario.robot_ids, _starts(scenario), strict=True))
    return {node: poses[node] for node in scenario.node_ids}


def _starts(scenario: Scenario) -> list[Pose]:
    """The first pose of each robot, in order of their numbers."""
    start, count = scenario.robots.start, len(scenario.robot_ids)
    match start:
        case Fan():
            radius_m = start.radius_m or 2 * math.sqrt(len(scenario.node_ids))
            return [_in_fan(scenario.seed, row, radius_m) for row in range(count)]
        case Poses(poses=poses):
            return [Pose(*pose) for pose in poses]
        case InQueue():
            line = Line(scenario.field, (scenario.tower.x_m, scenario.tower.y_m))
            return [Pose(*line.slot(row), 0.0) for row in range(count)]
        case sites:
            sites_m = scenario.field.sites_m()
            return [Pose(*sites_m[site], 0.0) for site in sites]


def _in_fan(seed: int, row: int, radius_m: float) -> Pose:
    chance = generator(seed, "start", row)
    distance_m = radius_m * math.sqrt(chance.random())
    angle = chance.random() * math.pi / 2
    return Pose(
        distance_m * math.cos(angle), distance_m * math.sin(angle), wrapped(chance.random() * 2 * math.pi)
    )
