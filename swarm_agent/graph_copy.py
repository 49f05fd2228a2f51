"""A surveillance graph that every robot has a copy of: vertices, edges, lines, and how copies agree.

Source: what is recorded is that of Kolling and Carpin, "Multi-robot pursuit-evasion without maps", 2010,
section IV, who leave open how robots share it; versions and deltas are ours.
"""

from typing import Annotated, Literal

import msgspec
import networkx

Robots = Annotated[int, msgspec.Meta(ge=1, le=10**6)]
Number = Annotated[int, msgspec.Meta(ge=0, le=10**6)]
Kind = Literal["move", "split", "cycle"]
"""A line moved from one vertex to the other; was split off; or met another from the front."""
NO_LINE = 0


class Version(msgspec.Struct, frozen=True, array_like=True, order=True):
    """Which of two graphs is newer: the one after more events; of equally many, the later name's."""

    events: Annotated[int, msgspec.Meta(ge=0, le=2**53)] = 0
    writer: str = ""


class Vertex(msgspec.Struct, frozen=True, array_like=True):
    """A region. `robots`: the most it took, or is known to take.

    `explored`: the line that went in has made other vertices, or dissolved there.
    """

    number: Number
    robots: Robots
    explored: bool = False
    clear: bool = False


class Edge(msgspec.Struct, frozen=True, array_like=True):
    """A neck between two vertices, the lower number first. `robots` block it; `line`: the one that does."""

    low: Number
    high: Number
    robots: Robots
    kind: Kind
    line: Number = NO_LINE

    def __post_init__(self) -> None:
        if self.low >= self.high:
            raise ValueError("an edge whose first vertex is not the lower one")


class Moving(msgspec.Struct, frozen=True, array_like=True):
    """The main line. `vertex`: the one it sweeps; `widest`: the most robots since its blocking position.

    `line`: the number it had while it stood, NO_LINE for the first.
    """

    vertex: Number
    widest: Robots
    line: Number = NO_LINE


class Delta(msgspec.Struct, frozen=True, array_like=True):
    """What has changed from one version to another; since version 0 it is the whole graph.

    `lines`: how many lines there have been, whose numbers are used up.
    """

    since: Version
    version: Version
    lines: Number
    main: Moving | None
    vertices: tuple[Vertex, ...]
    edges: tuple[Edge, ...]


NOTHING = Version()


class GraphCopy:
    """One robot's copy: what it reads there, tells others, and takes from them."""

    def __init__(self, writer: str) -> None:
        self.version = NOTHING
        self.main: Moving | None = None
        self.net = networkx.Graph()
        """`robots` on vertices and edges is what `graph_clear` plans with."""
        self._writer = writer
        self._lines = 0
        self._passed = {NOTHING}

    def vertex(self, number: int) -> Vertex:
        """One vertex; KeyError if there is none."""
        return self.net.nodes[number]["record"]

    def edge(self, one: int, other: int) -> Edge:
        """The edge between two vertices; KeyError if there is none."""
        return self.net.edges[one, other]["record"]

    def vertices(self) -> tuple[Vertex, ...]:
        """All, by number."""
        return tuple(self.vertex(number) for number in sorted(self.net))

    def edges(self) -> tuple[Edge, ...]:
        """All, by lower and then higher number."""
        ends = sorted((min(pair), max(pair)) for pair in self.net.edges)
        return tuple(self.edge(*pair) for pair in ends)

    def cleared(self) -> frozenset[int]:
        """The numbers of all clear vertices."""
        return frozenset(vertex.number for vertex in self.vertices() if vertex.clear)

    def lines(self) -> dict[int, Edge]:
        """The edge that each stationary line blocks, by the line's number."""
        return {edge.line: edge for edge in self.edges() if edge.line}

    def ahead_of(self, line: int) -> int:
        """The vertex a stationary line stands before; KeyError if there is no such line."""
        edge = self.lines()[line]
        return edge.high if self.vertex(edge.low).clear else edge.low

    def delta_since(self, version: Version) -> Delta:
        """What a copy of that version lacks; the whole graph if we know no such version."""
        since = version if version in self._passed else NOTHING
        nodes, edges = self.net.nodes, self.net.edges
        return Delta(
            since,
            self.version,
            self._lines,
            self.main,
            tuple(one for one in self.vertices() if nodes[one.number]["changed"] > since.events),
            tuple(one for one in self.edges() if edges[one.low, one.high]["changed"] > since.events),
        )

    def take(self, delta: Delta) -> bool:
        """Become the newer version, if the delta tells of one and fits to ours. Answers whether that was so.

        Copies that tell each other what the other's version lacks all come to the newest there is. When two
        robots have written on from the same copy, what one of them wrote is forgotten.
        """
        if delta.version <= self.version or delta.since not in (NOTHING, self.version):
            return False
        known = {vertex.number for vertex in delta.vertices}
        if delta.since != NOTHING:
            known |= set(self.net)
        ends = {end for edge in delta.edges for end in (edge.low, edge.high)}
        ends |= {delta.main.vertex} if delta.main else set()
        if known != set(range(len(known))) or not known >= ends:
            return False
        if delta.since == NOTHING:
            self.net.clear()
            self._passed = {NOTHING}
        self.version, self.main, self._lines = delta.version, delta.main, delta.lines
        self._passed.add(self.version)
        for vertex in delta.vertices:
            self._put_vertex(vertex)
        for edge in delta.edges:
            self._put_edge(edge)
        return True

    def _event(self) -> None:
        self.version = Version(self.version.events + 1, self._writer)
        self._passed.add(self.version)

    def _put_vertex(self, vertex: Vertex) -> None:
        changed = self.version.events
        self.net.add_node(vertex.number, record=vertex, robots=vertex.robots, changed=changed)

    def _put_edge(self, edge: Edge) -> None:
        changed = self.version.events
        self.net.add_edge(edge.low, edge.high, record=edge, robots=edge.robots, changed=changed)
