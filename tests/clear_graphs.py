"""Graphs to clear: small ones with known answers, and random ones."""

from itertools import combinations

import networkx
import numpy as np

from swarm_agent.graph_clear import extra_sweepers, one_line

CONVENTIONS = (extra_sweepers, one_line)


def graph(weights, edges) -> networkx.Graph:
    """Vertices 0, 1, ... of these weights, and edges as (vertex, vertex, weight)."""
    net = networkx.Graph()
    net.add_nodes_from((number, {"robots": weight}) for number, weight in enumerate(weights))
    net.add_edges_from((low, high, {"robots": weight}) for low, high, weight in edges)
    return net


PATH = graph([1, 1, 1], [(0, 1, 1), (1, 2, 1)])
STAR = graph([2, 1, 1, 1], [(0, 1, 1), (0, 2, 1), (0, 3, 1)])
RING = graph([1] * 4, [(0, 1, 1), (1, 2, 1), (2, 3, 1), (0, 3, 1)])
COMPLETE = graph([1] * 4, [(*pair, 1) for pair in combinations(range(4), 2)])
TREE = graph([2, 3, 1, 4, 2, 3], [(0, 1, 2), (1, 2, 1), (1, 3, 3), (3, 4, 1), (3, 5, 2)])
SPIDER = graph([1] * 7, [(0, 1, 1), (1, 2, 1), (0, 3, 1), (3, 4, 1), (0, 5, 1), (5, 6, 1)])
HEAVY_SPIDER = graph(
    [1, 1, 4, 1, 4, 1, 4], [(0, 1, 2), (1, 2, 1), (0, 3, 2), (3, 4, 1), (0, 5, 2), (5, 6, 1)]
)
HUB = graph([3, 1, 4, 4, 3], [(0, 1, 1), (1, 2, 1), (1, 3, 1), (1, 4, 1)])


def any_tree(chance: np.random.Generator, most: int, weight: int = 6) -> networkx.Graph:
    """Of 1 to `most` vertices: each is joined to a random one before it."""
    count = int(chance.integers(1, most + 1))
    edges = [(int(chance.integers(far)), far, int(chance.integers(1, 5))) for far in range(1, count)]
    return graph(chance.integers(1, weight + 1, count).tolist(), edges)


def any_graph(chance: np.random.Generator, fewest: int, most: int) -> networkx.Graph:
    """A random tree and some of the other edges."""
    net = any_tree(chance, most)
    while len(net) < fewest:
        net = any_tree(chance, most)
    for pair in combinations(net, 2):
        if not net.has_edge(*pair) and chance.random() < 0.4:
            net.add_edge(*pair, robots=int(chance.integers(1, 5)))
    return net
