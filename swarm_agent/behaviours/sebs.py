"""SEBS: state exchange Bayesian strategy. As GBS, and less inclined to where other robots are going.

Source: Portugal and Rocha 2013, as patrolling_sim's SEBS_Agent decides: with c of R robots on their way to a
neighbour its probability is multiplied by 2^(R - c) / (2^R - 1).
"""

from typing import Annotated, Self

import msgspec
import numpy as np

from swarm_agent.behaviours.gbs import Gbs, GbsParameters
from wire.messages import Configuration


class SebsParameters(GbsParameters, frozen=True):
    """`team`: R, the number of robots; None: all but the tower."""

    team: Annotated[int, msgspec.Meta(ge=1, le=1000)] | None = None

    def settled(self, team_size: int) -> Self:
        """The team is all nodes without the tower."""
        return self if self.team else msgspec.structs.replace(self, team=max(1, team_size - 1))


class Sebs(Gbs):
    """Gain decides, and what others intend."""

    Parameters = SebsParameters

    def __init__(
        self, parameters: SebsParameters, configuration: Configuration, generator: np.random.Generator
    ) -> None:
        super().__init__(parameters, configuration, generator)
        self.intentions: dict[str, int] = {}
        """Where each other robot was last heard to go."""

    def worth(self, sites: np.ndarray, idle_s: np.ndarray, costs_m: np.ndarray) -> np.ndarray:
        """GBS's, reduced where others are going."""
        going = list(self.intentions.values())
        others = np.array([going.count(site) for site in sites.tolist()], dtype=float)
        team = float(self.parameters.team or 1)
        share = 2.0 ** (team - others) / (2.0**team - 1) if team > 1 else np.ones(len(sites))
        return super().worth(sites, idle_s, costs_m) * np.where(others > 0, share, 1.0)

    def intends(self, sender: str, site: int) -> None:
        """Remember it until the next word of that robot."""
        self.intentions[sender] = site
