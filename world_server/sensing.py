"""What bodies sense: their own pose, and the other bodies within sensor range, dead or alive."""

from collections.abc import Sequence

import numpy as np

from wire.messages import Sighting


def sightings(
    nodes: Sequence[str],
    positions_m: np.ndarray,
    apart_m: np.ndarray,
    ranges_m: np.ndarray,
    rows: Sequence[int],
) -> dict[int, tuple[Sighting, ...]]:
    """For each of these rows the bodies that it sees, in order of their numbers; range 0 sees nothing.

    `positions_m`: (nodes, 2); `apart_m`: (nodes, nodes); `ranges_m`: (nodes,).
    """
    bodies: dict[int, Sighting] = {}
    reach_m = ranges_m[rows, None]
    sees = (apart_m[rows] <= reach_m) & (reach_m > 0)
    sees[np.arange(len(rows)), rows] = False
    seen: dict[int, list[Sighting]] = {row: [] for row in rows}
    for place, other in zip(*(column.tolist() for column in sees.nonzero()), strict=True):
        if other not in bodies:
            bodies[other] = Sighting(nodes[other], *positions_m[other].tolist())
        seen[rows[place]].append(bodies[other])
    return {row: tuple(one) for row, one in seen.items()}
