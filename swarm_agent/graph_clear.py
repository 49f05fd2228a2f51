"""Graph-Clear: in which order to clear a surveillance graph, so that as few robots as possible do.

A graph is a `networkx.Graph` with whole numbers as vertices and a positive whole number `robots` on every
vertex (to sweep it) and every edge (to block it). All counts here are robots.

Sources: the problem is that of Kolling and Carpin, "Pursuit-evasion on trees by robot teams", T-RO 2010;
orders, and the contiguous ones among them: Morin et al., Constraints 23, 2018. That lines are their own
sweepers, and the search for what to keep, are ours.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import NamedTuple

import networkx

from swarm_agent.cut_sets import CLEARED, Convention, CutSets, order_of, peak

EXACT_VERTICES = 12
"""A graph with cycles and no more vertices than this is planned exactly."""


def extra_sweepers(weight: int, behind: int, ahead: int) -> int:
    """Graph-Clear as published: the vertex's robots sweep while others block each of its edges."""
    return weight + behind + ahead


def one_line(weight: int, behind: int, ahead: int) -> int:
    """A team in lines: the same robots leave the edges behind, cross it and block those ahead (ours)."""
    return max(weight, behind, ahead)


class Strategy(NamedTuple):
    """An order to sweep all vertices that are not yet cleared, and the most robots that any step takes."""

    robots: int
    order: tuple[int, ...]


class State(NamedTuple):
    """Cleared vertices that `held` robots keep so; to get there, `given_up` one after the other.

    `retreat`: the most robots that giving up takes, which is what sweeping the same vertices would take.
    """

    cleared: frozenset[int]
    held: int
    given_up: tuple[int, ...]
    retreat: int


def held(graph: networkx.Graph, cleared: Collection[int]) -> int:
    """Robots that block all edges between cleared vertices and others."""
    return sum(
        graph.edges[vertex, beside]["robots"]
        for vertex in cleared
        for beside in graph[vertex]
        if beside not in cleared
    )


def step(graph: networkx.Graph, cleared: Collection[int], vertex: int, convention: Convention) -> int:
    """Robots at work while `vertex` is swept and `cleared` is kept clear."""
    edges = graph[vertex]
    behind = sum(edges[beside]["robots"] for beside in edges if beside in cleared)
    ahead = sum(edges[beside]["robots"] for beside in edges if beside not in cleared)
    weight = graph.nodes[vertex]["robots"]
    return convention(weight, behind, ahead) + held(graph, cleared) - behind


def steps(
    graph: networkx.Graph, order: Iterable[int], convention: Convention, cleared: Collection[int] = ()
) -> Iterator[int]:
    """What each step of an order takes, beginning with `cleared`."""
    done = set(cleared)
    for vertex in order:
        yield step(graph, done, vertex, convention)
        done.add(vertex)


def exact(
    graph: networkx.Graph, convention: Convention, contiguous: bool, cleared: Collection[int] = ()
) -> Strategy:
    """The cheapest order of all that go on from `cleared`, by dynamic programming over sets of vertices.

    `contiguous`: every vertex but the first of all lies beside a cleared one. Of equal orders it is always
    the same. Source: the recursion of model CPS in Morin et al. 2018; time and memory grow as 2 to the
    number of vertices.
    """
    names = sorted(graph)
    weights = [graph.nodes[name]["robots"] for name in names]
    beside = [
        [(1 << names.index(far), graph.edges[name, far]["robots"]) for far in graph[name]] for name in names
    ]
    degrees = [sum(robots for _, robots in edges) for edges in beside]
    already = sum(1 << place for place, name in enumerate(names) if name in cleared)
    layer = {
        already: (0, held(graph, cleared), ())
    }  # by set: the cost so far, the robots that block, the order
    for _ in range(len(names) - already.bit_count()):
        following = {}
        for done, (cost, blocking, order) in layer.items():
            for place, edges in enumerate(beside):
                if done >> place & 1:
                    continue
                behind = sum(robots for bit, robots in edges if done & bit)
                if contiguous and done and not behind:
                    continue
                ahead = degrees[place] - behind
                here = convention(weights[place], behind, ahead) + blocking - behind
                target, total = done | 1 << place, max(cost, here)
                if target not in following or total < following[target][0]:
                    following[target] = (total, blocking - behind + ahead, (*order, place))
        layer = following
    if not layer:
        raise ValueError("a graph that is not connected has no contiguous order")
    [(cost, _, order)] = layer.values()
    return Strategy(cost, tuple(names[place] for place in order))


def _contracted(graph: networkx.Graph, cleared: Collection[int]) -> networkx.Graph:
    """The graph with all cleared vertices as one, if there are any, and in an order of its own.

    What reaches a vertex from several of them is one edge: they are passed at the same time anyway.
    """
    small = networkx.Graph()
    name = {vertex: CLEARED if vertex in cleared else vertex for vertex in sorted(graph)}
    for vertex, short in name.items():
        small.add_node(short, robots=graph.nodes[vertex]["robots"])
    for one, other in sorted(tuple(sorted(edge)) for edge in graph.edges):
        low, high = name[one], name[other]
        if low != high:
            known = small.get_edge_data(low, high, {"robots": 0})["robots"]
            small.add_edge(low, high, robots=known + graph.edges[one, other]["robots"])
    return small


def plan(graph: networkx.Graph, cleared: Collection[int] = (), convention: Convention = one_line) -> Strategy:
    """The order in which to go on from the cleared vertices of a connected graph, always beside them.

    The contiguous optimum where what is left is a tree; with cycles and at most EXACT_VERTICES vertices too.
    Else the order is that of a spanning tree, as if the edges that close cycles stayed blocked (Kolling and
    Carpin 2007), which may cost more than it must. The robots are those that the order really takes.
    """
    left = _contracted(graph, cleared)
    if set(left) <= {CLEARED}:
        return Strategy(0, ())
    if networkx.is_tree(left) or len(left) > EXACT_VERTICES:
        cut_sets = CutSets(networkx.maximum_spanning_tree(left, weight="robots"), convention)
        if CLEARED in left:
            order = order_of(cut_sets.onward())
        else:
            order = order_of(min(map(cut_sets.start, left), key=peak))
    else:
        order = exact(graph, convention, contiguous=True, cleared=cleared).order
    return Strategy(max(steps(graph, order, convention, cleared)), order)


def next_vertex(
    graph: networkx.Graph, cleared: Collection[int], robots: int, convention: Convention = one_line
) -> int | None:
    """The first vertex of the plan, among those beside cleared ones, that so many robots can sweep now.

    None if there is no such vertex: all are cleared, or `fallback` must give something up. Before anything is
    cleared any vertex may be the first.
    """
    for vertex in plan(graph, cleared, convention).order:
        beside = not cleared or any(near in cleared for near in graph[vertex])
        if beside and step(graph, cleared, vertex, convention) <= robots:
            return vertex
    return None


def fallback(
    graph: networkx.Graph,
    cleared: Collection[int],
    vertex: int,
    robots: int,
    convention: Convention = one_line,
    area_m2: Mapping[int, float] | None = None,
) -> State | None:
    """What to keep of `cleared` so that so many robots can sweep `vertex`: the largest area among the states.

    The states are those that the cut sets of the known tree go through, from every start, less what is not
    cleared. One counts if sweeping `vertex` while it is held, and the retreat to it, take no more than
    `robots`. Nothing cleared at all counts too: then lines are abandoned, which takes nobody. Of equal areas
    (without `area_m2`: of equally many vertices) the one held by fewest. None: nothing suffices.
    """
    tree = networkx.maximum_spanning_tree(_contracted(graph, ()), weight="robots")
    cut_sets = CutSets(tree, convention)
    best, best_rank = None, ()
    for start in sorted(cleared) or [vertex]:
        order = [one for one in order_of(cut_sets.start(start)) if one in cleared]
        for state in _states(graph, order, convention):
            if step(graph, state.cleared, vertex, convention) > robots:
                continue
            if state.cleared and state.retreat > robots:
                continue
            area = sum(area_m2[one] if area_m2 else 1 for one in sorted(state.cleared))
            rank = (area, -state.held, -start)
            if best is None or rank > best_rank:
                best, best_rank = state, rank
    return best


def _states(graph: networkx.Graph, order: list[int], convention: Convention) -> Iterator[State]:
    """All that an order goes through, the last first."""
    costs = list(steps(graph, order, convention))
    for kept in range(len(order), -1, -1):
        cleared = frozenset(order[:kept])
        given_up = tuple(reversed(order[kept:]))
        yield State(cleared, held(graph, cleared), given_up, max(costs[kept:], default=0))
