"""A behaviour to tune: how often it wakes is a parameter, and some values are bad in one way or another."""

from typing import Annotated, Self

import msgspec

from swarm_agent.behaviour import Behaviour, Move, Parameters


class PausingParameters(Parameters, frozen=True):
    """A robot wakes every `pause_ticks`; 13 is refused at once."""

    pause_ticks: Annotated[int, msgspec.Meta(ge=1)] = 8
    mood: str = "calm"

    def settled(self, team_size: int) -> Self:
        """Raises ValueError for 13."""
        if self.pause_ticks == 13:
            raise ValueError("13 brings bad luck")
        return self


class Pausing(Behaviour):
    """Sleeps and wakes. With a pause of 3 it takes its process down, with one of 2 or 1 it raises."""

    Parameters = PausingParameters

    def step(self, percept, heard) -> Move:
        """Wake again after the pause."""
        if self.parameters.pause_ticks == 3:
            raise SystemExit("walked out")
        if self.parameters.pause_ticks < 3:
            raise RuntimeError("no time to breathe")
        return Move(wake_tick=percept.tick + self.parameters.pause_ticks)
