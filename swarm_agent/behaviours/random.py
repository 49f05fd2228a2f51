"""RAND: go to any neighbour, all equally likely. The floor under every comparison.

Source: patrolling_sim, Random_Agent.
"""

import numpy as np

from swarm_agent.reactive import Reactive


class Random(Reactive):
    """Draws the next site."""

    def worth(self, sites: np.ndarray, idle_s: np.ndarray, costs_m: np.ndarray) -> np.ndarray:
        """All are equal."""
        return np.ones(len(idle_s))
