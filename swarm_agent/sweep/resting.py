"""Who goes to and fro, or pushes against what bars its way, rests: a line decides nothing while it moves."""

from swarm_agent.sweep.moves import best
from swarm_agent.sweep.radio import OTHER
from swarm_agent.sweep.robot import Robot

REST_M, NEARER_M, TRY_TICKS = 0.025, 0.08, 12
RESTED_M = 0.08
REST_TICKS, LEADER_REST_TICKS = 10, 60


class Strides:
    """Whether a leader comes any farther; else it rests until its neighbour or its order changes.

    On a robust line also for a while only, each time a longer one: those who barred its way may have gone.
    """

    def __init__(self) -> None:
        self._trail: list[complex] = []
        self._rested: tuple[complex, int] | None = None
        self._rest_tick, self._rest_ticks = 0, LEADER_REST_TICKS

    def taken(self, robot: Robot, way: complex) -> complex:
        """The way, or nothing while it rests."""
        beside = robot.neighbour(OTHER[robot.wall_side()])
        place = robot.here if beside is None else beside.here
        if self._rested is not None:
            moved = abs(place - self._rested[0]) >= RESTED_M
            over = robot.is_robust and robot.tick - self._rest_tick >= self._rest_ticks
            if not moved and robot.order == self._rested[1] and not robot.close and not over:
                return 0j
            self._rest_ticks = LEADER_REST_TICKS if moved else 2 * self._rest_ticks
            self._rested, self._trail = None, []
        if way:
            self._trail = [*self._trail[-TRY_TICKS:], robot.here]
        if len(self._trail) > TRY_TICKS and abs(self._trail[0] - robot.here) < NEARER_M:
            self._rested, self._rest_tick = (place, robot.order), robot.tick
            return 0j
        return way


class Slot:
    """Whether one in the middle comes nearer to its slot; else it rests until a neighbour has moved on."""

    def __init__(self) -> None:
        self._trail: list[complex] = []
        self._rested: tuple[complex, complex] | None = None
        self._rest_tick, self._rest_ticks = 0, REST_TICKS

    def way(self, robot: Robot, aims: list[complex], neighbours: tuple[complex, complex]) -> complex:
        """The way to the first of some places to which there is one; nothing when it is there, or rests."""
        if self._rested is not None:
            moved = max(abs(now - then) for now, then in zip(neighbours, self._rested, strict=True))
            if moved < RESTED_M and not self._tries_again(robot, aims[-1]):
                return 0j
            self._rested, self._trail = None, []
        if abs(aims[0] - robot.here) < REST_M:
            return 0j
        self._trail = [*self._trail[-TRY_TICKS:], robot.here]
        if len(self._trail) > TRY_TICKS and abs(self._trail[0] - robot.here) < NEARER_M:
            self._rested, self._rest_tick = neighbours, robot.tick
            return 0j
        return next((way for aim in aims if (way := best(robot, aim - robot.here))), 0j)

    def _tries_again(self, robot: Robot, aim: complex) -> bool:
        """On a robust line one who is far from its slot waits for others beyond its neighbours, too."""
        if not robot.is_robust or abs(aim - robot.here) < NEARER_M:
            self._rest_ticks = REST_TICKS
            return False
        if robot.tick - self._rest_tick < self._rest_ticks:
            return False
        self._rest_ticks *= 2
        return True
