"""Graph-Clear on trees: what each branch takes, alone or interleaved with the others.

A tree is a `networkx.Graph` with whole numbers as vertices and `robots` on every vertex (to sweep it) and
every edge (to block it). All counts here are robots.

Source: labels and cut sets are ideas of Kolling and Carpin, "Pursuit-evasion on trees by robot teams", T-RO
2010; how segments are glued and merged is ours, tested against all orders.
"""

from collections.abc import Callable, Iterable, Iterator
from heapq import merge
from typing import NamedTuple

import networkx

Convention = Callable[[int, int, int], int]
"""What sweeping a vertex takes, by its weight and the robots on its edges to cleared and other vertices."""
CLEARED = -1
"""Stands for all cleared vertices in a graph where they are one."""


class Segment(NamedTuple):
    """Sweeping `vertices` in this order brings the robots that block from `start` to `end`.

    `peak` is the most that are needed on the way, those who block at the start included.
    """

    start: int
    peak: int
    end: int
    vertices: tuple[int, ...]

    @property
    def rise(self) -> int:
        """How many robots it takes beyond those who already block."""
        return self.peak - self.start


def sequential_label(tree: networkx.Graph, convention: Convention, source: int, target: int) -> int:
    """Robots that clear the side of `target`, coming from `source`, one branch after the other."""
    beyond = {child: tree.edges[target, child]["robots"] for child in sorted(tree[target]) if child != source}
    behind = tree.edges[source, target]["robots"]
    label = convention(tree.nodes[target]["robots"], behind, sum(beyond.values()))
    costs = {child: sequential_label(tree, convention, target, child) for child in beyond}
    waiting = sum(beyond.values())
    for child in sorted(beyond, key=lambda child: costs[child] - beyond[child]):
        waiting -= beyond[child]
        label = max(label, costs[child] + waiting)
    return label


class CutSets:
    """Contiguous strategies on a tree that interleave its branches: the optimum among the contiguous ones."""

    def __init__(self, tree: networkx.Graph, convention: Convention) -> None:
        self._tree = tree
        self._convention = convention
        self._branches: dict[tuple[int, int], tuple[Segment, ...]] = {}

    def branch(self, source: int, target: int) -> tuple[Segment, ...]:
        """The side of `target`, coming over the edge from `source`, in segments.

        Each begins where the one before ends, ends lower than it begins, and rises more than the one before.
        """
        if (source, target) not in self._branches:
            self._branches[source, target] = _glued(
                [self._sweep(target, source), *self._beyond(target, source)]
            )
        return self._branches[source, target]

    def label(self, source: int, target: int) -> int:
        """Robots that clear the side of `target`, coming over the edge from `source`."""
        return peak(self.branch(source, target))

    def start(self, vertex: int) -> tuple[Segment, ...]:
        """The whole tree, beginning with `vertex`; its segments are as they come."""
        return (self._sweep(vertex, None), *self._beyond(vertex, None))

    def onward(self) -> tuple[Segment, ...]:
        """All but `CLEARED`, which is one vertex of the tree."""
        return tuple(self._beyond(CLEARED, None))

    def _sweep(self, vertex: int, source: int | None) -> Segment:
        edges = self._tree[vertex]
        behind = 0 if source is None else edges[source]["robots"]
        ahead = sum(edge["robots"] for edge in edges.values()) - behind
        peak = self._convention(self._tree.nodes[vertex]["robots"], behind, ahead)
        return Segment(behind, peak, ahead, (vertex,))

    def _beyond(self, vertex: int, source: int | None) -> Iterator[Segment]:
        """The branches of a swept vertex, interleaved: what rises least comes first."""
        children = [child for child in sorted(self._tree[vertex]) if child != source]
        blocking = sum(self._tree.edges[vertex, child]["robots"] for child in children)
        branches = [self.branch(vertex, child) for child in children]
        for start, peak, end, vertices in merge(*branches, key=lambda segment: segment.rise):
            others = blocking - start
            yield Segment(blocking, others + peak, others + end, vertices)
            blocking = others + end


def _glued(segments: Iterable[Segment]) -> tuple[Segment, ...]:
    """Segments nobody would stop between become one: the first does not fall, or the next rises no more."""
    kept: list[Segment] = []
    for segment in segments:
        if kept and (kept[-1].end >= kept[-1].start or segment.rise <= kept[-1].rise):
            start, peak, _, vertices = kept.pop()
            segment = Segment(start, max(peak, segment.peak), segment.end, vertices + segment.vertices)
        kept.append(segment)
    return tuple(kept)


def order_of(segments: Iterable[Segment]) -> tuple[int, ...]:
    """The vertices that segments sweep, one after the other."""
    return tuple(vertex for segment in segments for vertex in segment.vertices)


def peak(segments: Iterable[Segment]) -> int:
    """The most robots that any of the segments takes."""
    return max(segment.peak for segment in segments)
