"""The cheapest ways between all sites of a field: what they cost, how many hops they have, where they begin.

Source: Dijkstra's algorithm, as patrolling_sim uses it on patrol graphs; hops are those of the cheapest path,
not the fewest there are. On a grid without holes robots drive straight to any cell, so there the cost is the
distance of the centres and a hop is one of the eight steps to a cell beside (our reading of Kobayashi et al.
2025).
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from wire.fields import Field, Grid


class Ways(NamedTuple):
    """By start and goal, (sites, sites) each, and never to be written to.

    `costs_m`: float64, infinite where there is no way. `hops`: int64, the number of sites where there is no
    way, which is more than any way has. `next_site`: int64, the first site on the way; at the goal that is
    the goal itself, and -1 where there is no way.
    """

    costs_m: np.ndarray
    hops: np.ndarray
    next_site: np.ndarray


@lru_cache(maxsize=8)
def ways_of(field: Field) -> Ways:
    """The ways of a field with `sites_m()` and `neighbours(site)`, computed once in a process.

    Of several paths that cost the same there is one, always the same for the same field.
    """
    whole = isinstance(field, Grid) and not field.holes
    ways = _on_cells(field) if whole else _along_edges(field)
    for table in ways:
        table.flags.writeable = False
    return ways


def _on_cells(field: Grid) -> Ways:
    """Each step goes in the direction of the goal, rounded to 45 degrees: as many steps as fit the hops."""
    site = np.arange(field.columns * field.rows)
    column, row = np.divmod(site, field.rows)
    across, along = column - column[:, None], row - row[:, None]
    costs_m = field.cell_m * np.hypot(across, along)
    hops = np.maximum(abs(across), abs(along))
    half_step = math.tan(math.pi / 8)
    step_across = np.sign(across) * (abs(across) > half_step * abs(along))
    step_along = np.sign(along) * (abs(along) > half_step * abs(across))
    return Ways(costs_m, hops, site[:, None] + step_across * field.rows + step_along)


def _along_edges(field: Field) -> Ways:
    import networkx  # a robot on a grid without holes does without it

    count = len(field.sites_m())
    net = networkx.DiGraph()
    net.add_nodes_from(range(count))
    net.add_weighted_edges_from(
        (site, beside, cost_m) for site in range(count) for beside, cost_m in field.neighbours(site)
    )
    ways = Ways(
        np.full((count, count), math.inf), np.full((count, count), count), np.full((count, count), -1)
    )
    for start in range(count):
        costs_m, paths = networkx.single_source_dijkstra(net, start)
        for goal, path in paths.items():
            ways.costs_m[start, goal] = costs_m[goal]
            ways.hops[start, goal] = len(path) - 1
            ways.next_site[start, goal] = path[:2][-1]
    return ways
