"""HCR: weigh how long ago a neighbour was visited against how far it is.

Source: Almeida et al. 2004, as patrolling_sim's Heuristic_Conscientious_Reactive decides:
(D_max - D) / D_max + I / I_max, maxima over the neighbours; the second term is 0 where I_max is.
"""

import numpy as np

from swarm_agent.reactive import Reactive


class HeuristicConscientiousReactive(Reactive):
    """Idleness and distance decide, each as a share of the greatest among the neighbours."""

    def worth(self, sites: np.ndarray, idle_s: np.ndarray, costs_m: np.ndarray) -> np.ndarray:
        """The sum of both shares."""
        near = (costs_m.max() - costs_m) / costs_m.max()
        return near + (idle_s / idle_s.max() if idle_s.max() > 0 else 0.0)
