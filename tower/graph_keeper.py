"""The tower of a clearing: it keeps the newest surveillance graph that it hears of, and tells observers.

Robots tell each other what the other's copy lacks, and whoever hears that can follow. To robots the tower is
nobody: it says nothing but which version it has, and only while it hears of a newer one that it cannot take.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move
from swarm_agent.graph_copy import NOTHING, GraphCopy
from swarm_agent.sweep.radio import Beacon, Lacking, Spoken
from wire import codec
from wire.clearing import Overheard
from wire.messages import WAKE_ON_FRAME, Configuration, Percept, Stay


class GraphKeeper(Behaviour):
    """Sleeps until it hears somebody."""

    Radio = Spoken

    def __init__(self, parameters: Any, configuration: Configuration, generator: np.random.Generator) -> None:
        super().__init__(parameters, configuration, generator)
        self.graph = GraphCopy(configuration.node)
        self.heard_tick = 0
        """When a robot last said the version that is kept."""
        self._told = NOTHING, 0
        """What observers know: the version, and when it was heard."""

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Take what is newer, ask for what is missing."""
        spoken = [(one.sent_tick, one.message) for one in heard if isinstance(one.message, Beacon)]
        for sent_tick, beacon in spoken:
            self._hear(sent_tick, beacon)
        lacks = any(beacon.version > self.graph.version for _, beacon in spoken)
        say = (Lacking(self.graph.version),) if lacks else ()
        return Move(Stay(), say, wake_on=WAKE_ON_FRAME, report=self._overheard())

    def _hear(self, sent_tick: int, beacon: Beacon) -> None:
        if beacon.delta is not None and self.graph.take(beacon.delta):
            self.heard_tick = sent_tick
        elif beacon.version == self.graph.version:
            self.heard_tick = max(self.heard_tick, sent_tick)

    def _overheard(self) -> Overheard | None:
        """What observers do not know yet; of a graph that they have, only when it was heard."""
        version, (told, told_tick) = self.graph.version, self._told
        if version == NOTHING or (version, self.heard_tick) == (told, told_tick):
            return None
        self._told = version, self.heard_tick
        graph = b"" if version == told else codec.encode(self.graph.delta_since(NOTHING))
        return Overheard(self.heard_tick, graph)
