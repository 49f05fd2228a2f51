"""The way that a robot has come, without its detours, so that it can go back to where it began."""

from swarm_agent.sweep.moves import toward
from swarm_agent.sweep.robot import Robot

APART_M, STALLED_TICKS = 0.3, 80


class Trail:
    """Places by odometry, the first one where the robot began."""

    def __init__(self) -> None:
        self._places: list[complex] = []
        self._tick = 0

    def note(self, here: complex) -> None:
        """Remember where it is; who comes back to where it was has made a detour."""
        if not self._places:
            self._places.append(here)
        elif abs(here - self._places[-1]) > APART_M:
            back = [row for row, place in enumerate(self._places) if abs(place - here) <= APART_M]
            self._places = [*self._places[: back[0] + 1], here] if back else [*self._places, here]

    def begin(self, tick: int) -> None:
        """Go back from now on."""
        self._tick = tick

    def way(self, robot: Robot) -> complex | None:
        """The next step back; None at the end, or where it does not come any farther."""
        while len(self._places) > 1 and abs(self._places[-1] - robot.here) < APART_M:
            self._places.pop()
            self._tick = robot.tick
        stalled = robot.tick - self._tick > STALLED_TICKS * robot.parameters.hop_ticks
        if stalled or abs(self._places[-1] - robot.here) < APART_M:
            return None
        return toward(robot, self._places[-1])
