"""A behaviour with a bug: one robot raises at one tick."""

from swarm_agent.behaviour import Behaviour, Move


class Crashing(Behaviour):
    """r3 raises at tick 20; the others go on."""

    def step(self, percept, heard) -> Move:
        """Wake every tick, until the wheel falls off."""
        if self.configuration.node == "r3" and percept.tick == 20:
            raise RuntimeError("the wheel fell off")
        return Move(wake_tick=percept.tick + 1)
