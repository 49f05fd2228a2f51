"""What bodies sense: their own pose, and the other bodies within sensor range, dead or alive."""

from collections.abc import Sequence

import numpy as np

from wire.messages import Sighting


def sightings(
    nodes: Sequence[str], row: int, positions_m: np.ndarray, apart_m: np.ndarray, range_m: float
) -> tuple[Sighting, ...]:
    """The bodies that the node in `row` sees, in order of their numbers; range 0 sees nothing."""
    if range_m == 0:
        return ()
    seen = np.flatnonzero(apart_m[row] <= range_m)
    return tuple(Sighting(nodes[other], *positions_m[other].tolist()) for other in seen.tolist() if other != row)
