"""The instantaneous metrics over time, sampled, and how many robots were active then.

Source: Kobayashi et al. 2025, Figures 19 and 20, which plot them through failures and normalise them by the
robots that are active.
"""

from typing import NamedTuple

import numpy as np

from wire.scenario import Scenario
from world_server.nodes import ALIVE

EVERY_S = 60.0


class Instant(NamedTuple):
    """The four instantaneous metrics of one tick, in seconds."""

    tick: int
    graph_idleness_s: float
    worst_idleness_s: float
    mean_sa_delay_s: float
    worst_sa_delay_s: float


class Curves:
    """The fold. Let it `see` the states of nodes when they may have changed, and feed it every tick."""

    def __init__(self, scenario: Scenario) -> None:
        self._every_ticks = max(1, scenario.tick_of(EVERY_S))
        self._is_robot = [node != scenario.tower.id for node in scenario.node_ids]
        self._modes = b""
        self._active = len(scenario.robot_ids)
        self._samples: list[tuple[float, ...]] = []

    def see(self, modes: bytes) -> None:
        """Take in the states of all nodes, in the order of their rows."""
        if modes != self._modes:
            pairs = zip(modes, self._is_robot, strict=False)
            self._modes, self._active = modes, sum(is_robot and mode == ALIVE for mode, is_robot in pairs)

    def feed(self, instant: Instant) -> None:
        """Take in one tick."""
        if instant.tick % self._every_ticks == 0:
            self._samples.append((*instant, self._active))

    def tables(self) -> dict[str, np.ndarray]:
        """`curves`: one row for each sample; columns are the fields of Instant, and active robots."""
        return {"curves": np.array(self._samples).reshape(-1, len(Instant._fields) + 1)}
