"""What bodies sense: their own pose, and the other bodies within sensor range, dead or alive."""

from collections.abc import Sequence

import numpy as np

from wire.messages import Sighting


def sightings(
    nodes: Sequence[str], positions_m: np.ndarray, apart_m: np.ndarray, ranges_m: np.ndarray
) -> list[tuple[Sighting, ...]]:
    """For every node the bodies that it sees, in order of their numbers; range 0 sees nothing.

    `positions_m`: (nodes, 2); `apart_m`: (nodes, nodes); `ranges_m`: (nodes,).
    """
    bodies = [Sighting(node, *place) for node, place in zip(nodes, positions_m.tolist(), strict=True)]
    sees = (apart_m <= ranges_m[:, None]) & (ranges_m[:, None] > 0)
    np.fill_diagonal(sees, False)
    seen: list[list[Sighting]] = [[] for _ in nodes]
    for row, other in np.argwhere(sees).tolist():
        seen[row].append(bodies[other])
    return [tuple(one) for one in seen]
