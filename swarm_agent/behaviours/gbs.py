"""GBS: greedy Bayesian strategy. What a neighbour gains is idleness per way; robots tell of their visits.

Source: Portugal and Rocha 2011, as patrolling_sim's GBS_Agent decides: P = G1 exp(ln(1 / G1) / G2 gain) for a
gain below G2, else 1.
"""

from collections.abc import Sequence
from typing import Annotated, Any

import msgspec
import numpy as np

from swarm_agent.behaviour import Heard
from swarm_agent.knowledge import Bulletin
from swarm_agent.reactive import Reactive, ReactiveParameters

LEAST = 0.1
"""G1: the probability of a neighbour without gain."""


class GbsParameters(ReactiveParameters, frozen=True):
    """`gain_most` is G2: seconds of idleness per metre of way at which a neighbour is sure to be taken.
    `edge_least_m`: a shorter way counts as this long. Both were tuned for each map; the defaults are those of
    patrolling_sim's SEBS, read in metres.
    """

    gain_most: Annotated[float, msgspec.Meta(gt=0)] = 100.0
    edge_least_m: Annotated[float, msgspec.Meta(gt=0)] = 1.0


class Arrival(msgspec.Struct, frozen=True, array_like=True):
    """What a robot tells the others: the site that it has just visited, and where it goes now."""

    site: int
    next_site: int


class Gbs(Reactive):
    """Gain decides; of others it hears where they were."""

    Parameters = GbsParameters
    Radio = Bulletin[Arrival]

    def worth(self, sites: np.ndarray, idle_s: np.ndarray, costs_m: np.ndarray) -> np.ndarray:
        """The posterior probability of each neighbour, up to what is equal for all."""
        given = self.parameters
        gain = idle_s / np.maximum(costs_m, given.edge_least_m)
        return np.where(gain < given.gain_most, LEAST ** (1 - gain / given.gain_most), 1.0)

    def hear(self, heard: Sequence[Heard]) -> None:
        """Others' visits make sites less idle."""
        for sender, sent_tick, bulletin, *_ in heard:
            arrival = bulletin.message
            if arrival is not None and 0 <= arrival.site < len(self.sites_m):
                known_tick = int(self.knowledge.visited_tick[arrival.site])
                self.knowledge.note_visit(arrival.site, max(known_tick, sent_tick))
                self.intends(sender, arrival.next_site)

    def intends(self, sender: str, site: int) -> None:
        """Another robot goes to a site; GBS does not care."""

    def announce(self, completed: int) -> Any:
        """Where it was and where it goes."""
        return Arrival(completed, self.target)
