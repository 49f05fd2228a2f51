"""A behaviour that says the same byte every tick, but for one byte at one tick if a test wants it."""

import msgspec

from swarm_agent.behaviour import Behaviour, Move


class Byte(msgspec.Struct, frozen=True, array_like=True):
    """One byte on the air."""

    value: int


class OneByte(Behaviour):
    """Says 1 every tick. `other_at`: the (node, tick) at which a test wants a 2."""

    Radio = Byte
    other_at: tuple[str, int] | None = None

    def step(self, percept, heard) -> Move:
        """Say one byte."""
        now = (self.configuration.node, percept.tick)
        return Move(say=(Byte(2 if now == self.other_at else 1),), wake_tick=percept.tick + 1)
