"""The base station r_1: it cannot move, runs Algorithm 1, keeps what it knows and tells observers.

Source: Kobayashi et al. 2025, section IV-A: its table gives the SA delay.
"""

from collections.abc import Sequence
from typing import Annotated

import msgspec
import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from swarm_agent.knowledge import AnyBulletin, AssumedIdleness, Bulletin, NeighbourMemory, News
from wire.messages import Configuration, Percept, Stay


class Awareness(msgspec.Struct, frozen=True, array_like=True):
    """What the base station tells observers: entries that changed, or all of them when `whole`."""

    news: News
    whole: bool


class BaseStationParameters(Parameters, frozen=True):
    """`items_per_tick`: how many entries a frame carries; None: all."""

    items_per_tick: Annotated[int, msgspec.Meta(ge=1)] | None = None


class BaseStation(Behaviour):
    """Listens, merges, and says its own table back every tick."""

    Parameters = BaseStationParameters
    Radio = AnyBulletin

    def __init__(
        self, parameters: BaseStationParameters, configuration: Configuration, generator: np.random.Generator
    ) -> None:
        super().__init__(parameters, configuration, generator)
        sites = len(configuration.field.sites_m())
        self.knowledge = AssumedIdleness(sites)
        self.memory = NeighbourMemory(configuration.node, sites)
        self.items = parameters.items_per_tick or sites
        self.since_tick = -1

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Algorithm 1 without a target: say the table, then merge what was heard."""
        whole = self.since_tick < 0
        self.since_tick = percept.tick if whole else self.since_tick
        say = self._bulletin(percept.tick, heard)
        before = self.knowledge.visited_tick.copy()
        self.knowledge.merge(*[one.message.news for one in heard])
        report = self._awareness(before, whole)
        return Move(Stay(), (say,), percept.tick + 1, report=report)

    def _bulletin(self, tick: int, heard: Sequence[Heard]) -> Bulletin:
        if self.items >= len(self.knowledge.visited_tick):
            return Bulletin(self.knowledge.newest(self.items), _acknowledged(heard), self.since_tick)
        self.memory.listen(heard)
        scarce = self.memory.unknown_to([one.sender for one in heard], self.knowledge.visited_tick)
        news = self.knowledge.newest(self.items, scarce)
        self.memory.remember_sent(tick, news)
        return Bulletin(news, _acknowledged(heard), self.since_tick)

    def _awareness(self, before: np.ndarray, whole: bool) -> Awareness | None:
        if whole:
            return Awareness(News(self.knowledge.visited_tick.tobytes()), True)
        changed = np.flatnonzero(self.knowledge.visited_tick != before).astype("<u2")
        if len(changed) == 0:
            return None
        return Awareness(News(self.knowledge.visited_tick[changed].tobytes(), changed.tobytes()), False)


def _acknowledged(heard: Sequence[Heard]) -> tuple[tuple[str, int], ...]:
    return tuple((one.sender, one.sent_tick) for one in heard)
