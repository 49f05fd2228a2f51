"""The smallest behaviour: stand still, say nothing, sleep for good."""

from collections.abc import Sequence

from swarm_agent.behaviour import Behaviour, Heard, Move
from wire.messages import Percept, Stay


class StandStill(Behaviour):
    """Costs nothing after its first grant."""

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Stay, and never wake again."""
        return Move(Stay())
