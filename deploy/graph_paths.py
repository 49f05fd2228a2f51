"""The cheapest ways between all nodes of a patrol graph."""

import math

import msgspec
import networkx

from deploy.graph_file import PatrolGraph


class PathTable(msgspec.Struct, frozen=True):
    """By start and goal: the cost of the cheapest path, and its nodes from start to goal, both included.

    There is no way to a node that cannot be reached: its cost is infinite and its path empty. Of several
    paths that cost the same there is one, always the same for the same graph.
    """

    costs_m: tuple[tuple[float, ...], ...]
    paths: tuple[tuple[tuple[int, ...], ...], ...]

    @property
    def diameter_m(self) -> float:
        """The cost between the two nodes that are farthest apart; infinite if some node cannot be reached."""
        return max(map(max, self.costs_m))


def shortest_paths(graph: PatrolGraph) -> PathTable:
    """The cheapest paths along arcs, each counted at its cost in its own direction.

    Costs are compared in whole pixels, so equal ones are equal and not a rounding apart.
    """
    net = networkx.DiGraph()
    net.add_nodes_from(node.id for node in graph.nodes)
    net.add_weighted_edges_from(
        (node.id, arc.neighbour, arc.cost_px) for node in graph.nodes for arc in node.arcs
    )
    costs_m, paths = [], []
    for start in range(len(graph.nodes)):
        costs_px, ways = networkx.single_source_dijkstra(net, start)
        goals = range(len(graph.nodes))
        costs_m.append(tuple(costs_px.get(goal, math.inf) * graph.metres_per_px for goal in goals))
        paths.append(tuple(tuple(ways.get(goal, ())) for goal in goals))
    return PathTable(tuple(costs_m), tuple(paths))
