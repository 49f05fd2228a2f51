"""A behaviour that does a little of everything at random, so that an oracle has much to check."""

from collections.abc import Sequence

import msgspec

from swarm_agent.behaviour import Behaviour, Heard, Move
from wire.channels import number_of
from wire.messages import WAKE_ON_FRAME, GoTo, Motion, Percept, Stay


class Chatter(msgspec.Struct, frozen=True, array_like=True):
    """What wanderers say to each other: nothing that matters, in frames of different lengths."""

    words: bytes


class Wanderer(Behaviour):
    """Goes to sites, to places between them, or nowhere; says up to three frames.

    Even numbers wake every tick; odd ones sleep for some ticks, and half of the time a frame wakes them.
    """

    Radio = Chatter

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Throw the dice."""
        chance = self.generator
        say = tuple(Chatter(bytes(int(chance.integers(1, 40)))) for _ in range(int(chance.integers(0, 4))))
        motion = self._motion() if chance.random() < 0.1 or percept.configuration else None
        if number_of(self.configuration.node) % 2 == 0:
            return Move(motion, say, percept.tick + 1)
        wake_on = WAKE_ON_FRAME if chance.random() < 0.5 else 0
        return Move(motion, say, percept.tick + int(chance.integers(1, 7)), wake_on)

    def _motion(self) -> Motion:
        chance, sites = self.generator, self.configuration.field.sites_m()
        x_m, y_m = sites[int(chance.integers(len(sites)))]
        kind = chance.random()
        if kind < 0.1:
            return Stay()
        if kind < 0.3:
            return GoTo(x_m + chance.random(), y_m - chance.random())
        return GoTo(x_m, y_m, 3.0)
