"""Bodies that drive along paths: a unicycle that turns where it must, and steers as it goes.

Time inside a tick is accounted for: what a turn or a leg leaves of a tick is spent on the next one. A sharp
change of direction is a turn in place, a slight one costs nothing; a body aims at a point ahead of it on its
leg (pure pursuit), so that noise never carries it far off its line.

Source: Gaussian noise on linear and rotational velocity in each step as in the line-patrol paper's
simulation; turning in place beyond a sharp angle is our choice, as the paper gives no motion model.
"""

import math
from typing import NamedTuple

from wire.messages import Follow, GoTo, Motion, Pose
from world_server.motion import Body, wrapped

SHARP_RAD = 0.8
NEAR_M = 1e-9
"""Rounding: a body this near to a point is there."""
INSTANT_S = 1e-12
"""Rounding: less time than this is none."""

Point = tuple[float, float]


class Drive(NamedTuple):
    """How bodies of a team move. `noise_sd`: a fraction of full speed and full turn, over one second.

    `look_ahead_m`: how far ahead on its leg a body aims, at least the step of a tick, else it sways.
    `reach_m`: a path's first point counts as reached this near to it, as a noisy body stands only about where
    it was sent.
    """

    max_speed_m_s: float
    max_turn_rad_s: float
    look_ahead_m: float
    noise_sd: float = 0.0
    reach_m: float = NEAR_M


class Leg(NamedTuple):
    """The way to the next point of a path. `done_m`: the length of the path before it."""

    path_m: tuple[Point, ...]
    place: int
    origin: Point
    way: Point
    length_m: float
    done_m: float
    backwards: bool
    turning: bool


class State(NamedTuple):
    """All that a step changes."""

    x_m: float
    y_m: float
    heading_rad: float
    leg: Leg | None
    gone_m: float


class PathBody(Body):
    """A body that goes where a path leads, noise permitting. Without a path it stands and has arrived."""

    def __init__(self, pose: Pose, drive: Drive) -> None:
        super().__init__(pose, drive.max_speed_m_s, drive.max_turn_rad_s)
        self._drive = drive
        self._leg: Leg | None = None
        self._gone_m = 0.0
        self.passed: list[Point] = []
        """Points of its path that it passed in the last tick."""

    @property
    def at_rest(self) -> bool:
        """Is there nothing left to drive?"""
        return self._leg is None

    @property
    def arrived(self) -> bool:
        """Is the path at its end, or its end within reach of a GoTo?"""
        if self._leg is None:
            return True
        goal = self.goal
        return goal.within_m > 0 and math.hypot(goal.x_m - self.x_m, goal.y_m - self.y_m) <= goal.within_m

    @property
    def travelled_m(self) -> float:
        """How far it has come along the path it was last given."""
        leg = self._leg
        if leg is None:
            return self._gone_m
        return leg.done_m + max(0.0, min(leg.length_m, self._along(leg)))

    @property
    def state(self) -> State:
        """Where it stands on its way, to be put back there if a step is not to be."""
        return State(self.x_m, self.y_m, self.heading_rad, self._leg, self._gone_m)

    def put_back(self, state: State) -> None:
        """Undo a step."""
        self.x_m, self.y_m, self.heading_rad, self._leg, self._gone_m = state
        self.passed = []

    def command(self, motion: Motion | None) -> bool:
        """Take over a motion; None keeps the present one. True when it is already where it is sent."""
        if motion is None:
            return False
        self.halt()
        match motion:
            case Follow(path_m=path_m, backwards=backwards):
                self.goal = GoTo(*path_m[-1])
                self._begin(path_m, backwards)
            case GoTo():
                self.goal = motion
                self._begin(((motion.x_m, motion.y_m),), backwards=False)
        return self.goal is not None and self.arrived

    def halt(self) -> object:
        """Stop where it is. Returns what is left of its errand, for `resume`."""
        errand = (self.goal, self._leg, self._gone_m)
        self.goal, self._leg, self._gone_m = None, None, 0.0
        self.passed = []
        return errand

    def resume(self, errand: object) -> None:
        """Go on with an errand that `halt` interrupted."""
        self.goal, self._leg, self._gone_m = errand

    def advance(self, tick_s: float, draw: Point = (0.0, 0.0)) -> None:
        """One tick. `draw`: two standard normal numbers, for speed and for heading."""
        self.passed = []
        drive = self._drive
        if self._leg is None or drive.max_speed_m_s == 0:
            return
        jitter = drive.noise_sd * math.sqrt(tick_s)
        speed = max(0.0, drive.max_speed_m_s * (1 + jitter * draw[0] / tick_s))
        stray_rad = jitter * drive.max_turn_rad_s * draw[1]
        left_s = tick_s
        while self._leg is not None and left_s > INSTANT_S:
            left_s = self._turn(left_s) if self._leg.turning else self._go(left_s, speed, stray_rad)

    def _turn(self, left_s: float) -> float:
        """Turn in place towards the way ahead. Returns the time that is left."""
        wanted = self._wanted_rad(self._bearing(self._along(self._leg)))
        error = wrapped(wanted - self.heading_rad)
        needed_s = abs(error) / self._drive.max_turn_rad_s
        if needed_s > left_s + INSTANT_S:
            turned = math.copysign(self._drive.max_turn_rad_s * left_s, error)
            self.heading_rad = wrapped(self.heading_rad + turned)
            return 0.0
        self.heading_rad = wanted
        self._leg = self._leg._replace(turning=False)
        return max(0.0, left_s - needed_s)

    def _go(self, left_s: float, speed: float, stray_rad: float) -> float:
        """Drive towards the next point of the path. Returns the time that is left when it is reached."""
        leg = self._leg
        along_m = self._along(leg)
        bearing = self._bearing(along_m)
        towards = bearing + stray_rad / 2  # the chord of a tick in which the heading drifts by all of it
        way_x, way_y = math.cos(towards), math.sin(towards)
        self.heading_rad = wrapped(self._wanted_rad(bearing) + stray_rad)
        gain = speed * (way_x * leg.way[0] + way_y * leg.way[1])
        rest_m = leg.length_m - along_m
        if gain * left_s < rest_m - NEAR_M:
            self.x_m += speed * left_s * way_x
            self.y_m += speed * left_s * way_y
            return 0.0
        used_s = max(0.0, min(left_s, rest_m / gain)) if gain > 0 else 0.0
        self.x_m += speed * used_s * way_x
        self.y_m += speed * used_s * way_y
        self._pass(leg)
        return left_s - used_s

    def _pass(self, leg: Leg) -> None:
        """The next point of the path is reached: exactly, but for what noise has done."""
        x_m, y_m = point = leg.path_m[leg.place]
        if abs(x_m - self.x_m) <= NEAR_M and abs(y_m - self.y_m) <= NEAR_M:
            self.x_m, self.y_m = point
        self.passed.append(point)
        self._enter(leg.path_m, leg.place + 1, point, leg.done_m + leg.length_m, leg.backwards)

    def _begin(self, path_m: tuple[Point, ...], backwards: bool) -> None:
        """The first leg leads from wherever the body is; standing at the path's first point it has none."""
        here = (self.x_m, self.y_m)
        already = math.dist(here, path_m[0]) <= self._drive.reach_m
        if already:
            self._enter(path_m, 1, path_m[0], 0.0, backwards)
        else:
            self._enter(path_m, 0, here, 0.0, backwards)

    def _enter(
        self, path_m: tuple[Point, ...], place: int, origin: Point, done_m: float, backwards: bool
    ) -> None:
        """Begin the leg to the point at `place`, or the next one that is somewhere else."""
        while place < len(path_m) and math.dist(origin, path_m[place]) <= NEAR_M:
            place += 1
        if place == len(path_m):
            self._leg, self._gone_m = None, done_m
            return
        length_m = math.dist(origin, path_m[place])
        way = ((path_m[place][0] - origin[0]) / length_m, (path_m[place][1] - origin[1]) / length_m)
        self._leg = Leg(path_m, place, origin, way, length_m, done_m, backwards, turning=False)
        error = wrapped(self._wanted_rad(self._bearing(self._along(self._leg))) - self.heading_rad)
        if abs(error) > SHARP_RAD:
            self._leg = self._leg._replace(turning=True)

    def _bearing(self, along_m: float) -> float:
        """The direction of the point that it aims at, ahead on its leg or on the leg's continuation."""
        leg, ahead_m = self._leg, along_m + self._drive.look_ahead_m
        away_x = leg.origin[0] + ahead_m * leg.way[0] - self.x_m
        away_y = leg.origin[1] + ahead_m * leg.way[1] - self.y_m
        return math.atan2(away_y, away_x)

    def _wanted_rad(self, bearing: float) -> float:
        """The heading for going in a direction: against it where reversing is allowed and turns less."""
        if self._leg.backwards and abs(wrapped(bearing - self.heading_rad)) > math.pi / 2:
            return wrapped(bearing + math.pi)
        return bearing

    def _along(self, leg: Leg) -> float:
        """How far along its leg it is, judged from where it is."""
        return (self.x_m - leg.origin[0]) * leg.way[0] + (self.y_m - leg.origin[1]) * leg.way[1]
