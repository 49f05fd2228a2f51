"""A tower that writes an entry every tick and reports how many it remembered."""

import msgspec

from swarm_agent.behaviour import Behaviour, Move
from tower.desk import Entry


class Diary(msgspec.Struct):
    """How many entries it remembered, and the tick of the last of them."""

    remembered: int
    last_tick: int


class Diarist(Behaviour):
    """Writes until it is killed."""

    diary = Diary(0, -1)

    def remember(self, entries) -> None:
        """Count what was written."""
        self.diary = Diary(len(entries), entries[-1].tick if entries else -1)

    def step(self, percept, heard) -> Move:
        """One entry."""
        return Move(wake_tick=percept.tick + 1, report=self.diary, record=(Entry("born"),))
