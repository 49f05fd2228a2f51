"""How fast simulated time may go: paused, stepped, held to wall time, or as fast as it goes.

Pure: it is told what the wall clock says.
"""

import math

from wire.messages import Request
from wire.scenario import ClockSection

LATE_AFTER_S = 1.0


class Pace:
    """The operator's hand on time."""

    def __init__(self, section: ClockSection, tick_s: float) -> None:
        self.paused = False
        self.rate = section.rate if section.kind == "paced" else None
        """Simulated seconds per second; None: as fast as it goes."""
        self._tick_s = tick_s
        self._steps = 0
        self._origin: tuple[int, float] | None = None

    def steer(self, request: Request) -> None:
        """Carry out a request to pause, resume, step or change the speed."""
        match request.verb:
            case "pause":
                self.paused = True
            case "resume":
                self.paused, self._origin = False, None
            case "step":
                self.paused, self._steps = True, self._steps + max(1, round(request.value))
            case "speed":
                self.rate, self._origin = request.value or None, None

    def due_s(self, tick: int, now_s: float) -> float:
        """The wall time at which `tick` may begin: minus infinity for at once, infinity while paused."""
        if self.paused:
            return -math.inf if self._steps else math.inf
        if self.rate is None:
            return -math.inf
        if self._origin is None:
            self._origin = (tick, now_s)
        first, began_s = self._origin
        return began_s + (tick - first) * self._tick_s / self.rate

    def begin(self, tick: int, now_s: float) -> float:
        """A tick begins. Returns by how many seconds too late, 0 when in time; time is never skipped."""
        if self._steps:
            self._steps -= 1
        late_s = now_s - self.due_s(tick, now_s)
        return late_s if LATE_AFTER_S < late_s < math.inf else 0.0
