"""What a team knows of an unknown floor plan: the surveillance graph that its lines draw as they move.

Vertices weigh the most robots that a line took there, edges the fewest that block between two vertices. Until
something is lost or given up, a line has exactly one unexplored vertex ahead, which takes up what the line
meets: it becomes the vertex of a split, or of a region between two necks. So a split adds two vertices, and
passing a widest place adds one.

Source: Kolling and Carpin, "Multi-robot pursuit-evasion without maps", 2010, section IV. The paper makes
the vertex ahead only when it is met; to make it before, what copies carry, and how they agree, are ours.
"""

from collections.abc import Collection

import msgspec

from swarm_agent.graph_copy import NO_LINE, Edge, GraphCopy, Kind, Moving, Vertex

EVENTS_OF_AN_EPOCH = 1_000_000


class SurveillanceGraph(GraphCopy):
    """One robot's copy. A robot of the main line tells it what happens; others take what that one says."""

    def begin(self, robots: int, vertex: int | None = None) -> int:
        """A first line forms: on new ground, or in a known contaminated vertex. Returns the vertex."""
        self._only_if(self.main is None, "there is a main line already")
        known = len(self.net) if vertex is None else vertex
        self._only_if(vertex is None or not self.vertex(known).clear, "a first line on clear ground")
        self._event()
        if vertex is None:
            self._put_vertex(Vertex(known, robots))
        self._raise(known, robots)
        self.main = Moving(known, robots)
        return known

    def activate(self, line: int) -> None:
        """A stationary line becomes the main line."""
        self._only_if(self.main is None, "there is a main line already")
        vertex, edge = self.ahead_of(line), self.lines()[line]
        self._event()
        self._put_edge(msgspec.structs.replace(edge, line=NO_LINE))
        self.main = Moving(vertex, edge.robots, line)

    def measure(self, robots: int) -> None:
        """The main line has so many robots now.

        On unexplored ground, fewer than ever become the blocking position. Fewer after more were needed mean
        that the widest place is passed: its vertex is explored, and another one lies ahead.
        """
        main = self._moving()
        entries = self._entries(main.vertex)
        blocking = self.held(main.vertex)
        if robots == main.widest or (self.vertex(main.vertex).explored and robots < main.widest):
            return
        self._event()
        if robots > main.widest:
            self.main = Moving(main.vertex, robots, main.line)
            self._raise(main.vertex, robots)
        elif main.widest > blocking or len(entries) > 1:
            ahead = self._new_vertex(main.vertex, robots, "move")
            self.main = Moving(ahead, robots, main.line)
            self._close(main.vertex)
        else:
            self._put_edge(msgspec.structs.replace(entries[0], robots=robots))
            self.main = Moving(main.vertex, robots, main.line)

    def split(self, left: int, right: int) -> tuple[int, int]:
        """The main line has become two stationary ones with so many robots. Returns the lines' numbers."""
        vertex = self._leave(left + right)
        ahead = [self._new_vertex(vertex, robots, "split") for robots in (left, right)]
        self._close(vertex)
        return self.edge(vertex, ahead[0]).line, self.edge(vertex, ahead[1]).line

    def park(self, available: int) -> tuple[int, ...]:
        """The main line went back to its blocking position: `available` robots did not suffice.

        So the vertex ahead takes at least one more, which is what plans need to know. Returns the lines'
        numbers; the first line of all leaves none, since nothing is clear behind it.
        """
        self._leave(available + 1)
        return self._stand()

    def tighten(self, line: int, robots: int) -> None:
        """A stationary line has moved on to where it needs fewer robots."""
        edge = self.lines()[line]
        self._only_if(robots <= edge.robots, "a stationary line never gives ground back")
        if robots < edge.robots:
            self._event()
            self._put_edge(msgspec.structs.replace(edge, robots=robots))

    def meet(self, line: int, robots: int) -> None:
        """The main line met a stationary one from the front, and they are one line of so many robots now."""
        main = self._moving()
        other, edge = self.ahead_of(line), self.lines()[line]
        self._event()
        self._put_edge(msgspec.structs.replace(edge, line=NO_LINE))
        self.main = Moving(main.vertex, max(main.widest, robots), main.line)
        self._raise(main.vertex, robots)
        if other != main.vertex:  # else it stood before the same vertex, and an edge leads there already
            low, high = sorted((main.vertex, other))
            if not self.net.has_edge(low, high):
                self._put_edge(Edge(low, high, edge.robots, "cycle"))
            self._close(other)

    def dissolve(self) -> tuple[int, ...]:
        """The main line has nothing ahead any more, or stands on known edges: its vertex is clear.

        Returns the numbers of the lines that now stand on edges to vertices known from before.
        """
        return self._close(self._leave(1))

    def vanish(self, line: int) -> None:
        """A stationary line has dissolved where it stood, because nothing was left ahead of it."""
        ahead = self.ahead_of(line)
        self._event()
        self._close(ahead)

    def release(self, line: int | None) -> None:
        """A line is lost or abandoned, None: the main line. What it kept clear is contaminated.

        Lines with contamination on both sides hold nothing: they are lines no more, their robots are free.
        """
        if line is None:
            self._leave(1)
        else:
            edge = self.lines()[line]
            self._event()
            self._put_edge(msgspec.structs.replace(edge, line=NO_LINE))
        self._flood()

    def renew(self, epoch: int) -> None:
        """The team begins again, for the `epoch`-th time: what others still write of before is older now."""
        events = max(self.version.events, epoch * EVENTS_OF_AN_EPOCH)
        self.version = msgspec.structs.replace(self.version, events=events)
        self._event()

    def retreat(self, cleared: Collection[int]) -> tuple[int, ...]:
        """The lines went back, or were abandoned, until only `cleared` is clear. Returns their numbers."""
        self._only_if(self.main is None, "the main line must have stopped")
        self._only_if(self.cleared() >= set(cleared), "a retreat clears nothing")
        self._event()
        for vertex in sorted(self.cleared() - set(cleared)):
            self._put_vertex(msgspec.structs.replace(self.vertex(vertex), clear=False))
        for edge in self.lines().values():
            self._put_edge(msgspec.structs.replace(edge, line=NO_LINE))
        return self._stand()

    def held(self, vertex: int) -> int:
        """How many robots block the edges over which the main line came into a vertex."""
        return sum(edge.robots for edge in self._entries(vertex))

    def _raise(self, number: int, robots: int) -> None:
        """A vertex weighs at least so much."""
        vertex = self.vertex(number)
        if robots > vertex.robots:
            self._put_vertex(msgspec.structs.replace(vertex, robots=robots))

    def _new_vertex(self, beside: int, robots: int, kind: Kind) -> int:
        number = len(self.net)
        self._put_vertex(Vertex(number, robots))
        self._put_edge(Edge(beside, number, robots, kind))
        return number

    def _moving(self) -> Moving:
        self._only_if(self.main is not None, "there is no main line")
        return self.main

    def _leave(self, robots: int) -> int:
        """An event ends the main line, in a vertex that weighs at least so much: which one."""
        vertex = self._moving().vertex
        self._event()
        self._raise(vertex, robots)
        self.main = None
        return vertex

    def _entries(self, vertex: int) -> list[Edge]:
        """The edges that the main line blocks in that vertex: to clear ones, where no other line stands."""
        edges = (
            self.edge(vertex, beside) for beside in sorted(self.net[vertex]) if self.vertex(beside).clear
        )
        return [edge for edge in edges if edge.line == NO_LINE]

    def _close(self, number: int) -> tuple[int, ...]:
        """A vertex is explored and clear: its lines have nothing to hold towards it, others have."""
        self._put_vertex(msgspec.structs.replace(self.vertex(number), explored=True, clear=True))
        for edge in self.lines().values():
            if self.vertex(edge.low).clear and self.vertex(edge.high).clear:
                self._put_edge(msgspec.structs.replace(edge, line=NO_LINE))
        return self._stand()

    def _stand(self) -> tuple[int, ...]:
        """New lines on all edges between clear and other vertices that nobody blocks: their numbers."""
        numbers = []
        for edge in self._open_edges():
            self._lines += 1
            numbers.append(self._lines)
            self._put_edge(msgspec.structs.replace(edge, line=self._lines))
        return tuple(numbers)

    def _open_edges(self) -> list[Edge]:
        """Edges between clear and other vertices that neither a stationary nor the main line blocks."""
        swept = self.main.vertex if self.main else None
        return [
            edge
            for edge in self.edges()
            if self.vertex(edge.low).clear != self.vertex(edge.high).clear
            and edge.line == NO_LINE
            and swept not in (edge.low, edge.high)
        ]

    def _flood(self) -> None:
        """Contamination goes through every edge that nobody blocks."""
        while edges := self._open_edges():
            for end in (edges[0].low, edges[0].high):
                self._put_vertex(msgspec.structs.replace(self.vertex(end), clear=False))
        for edge in self.lines().values():
            if not self.vertex(edge.low).clear and not self.vertex(edge.high).clear:
                self._put_edge(msgspec.structs.replace(edge, line=NO_LINE))
        if self.main and not self._entries(self.main.vertex):
            self.main = None

    @staticmethod
    def _only_if(holds: bool, complaint: str) -> None:
        if not holds:
            raise ValueError(complaint)
