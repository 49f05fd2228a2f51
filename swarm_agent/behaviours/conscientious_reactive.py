"""CR: go to the neighbour that this robot has not visited for longest.

Source: Machado et al. 2002, as patrolling_sim's Conscientious_Reactive decides.
"""

import numpy as np

from swarm_agent.reactive import Reactive


class ConscientiousReactive(Reactive):
    """Idleness decides."""

    def worth(self, sites: np.ndarray, idle_s: np.ndarray, costs_m: np.ndarray) -> np.ndarray:
        """The longer ago the better."""
        return idle_s
