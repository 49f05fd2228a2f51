"""The shapes a field can have, as scenarios describe them and as nodes are told of them."""

import itertools
import math
from functools import cached_property
from typing import Annotated, Literal, NamedTuple

import msgspec

Point = tuple[float, float]
Way = tuple[int, float]
"""A neighbouring site, and what it costs to go there in metres."""
Number = Annotated[int, msgspec.Meta(ge=0)]
Metres = Annotated[float, msgspec.Meta(gt=0)]
Lines = Annotated[int, msgspec.Meta(ge=1, le=1000)]
Rooms = Annotated[int, msgspec.Meta(ge=1, le=10)]
Segments = Annotated[int, msgspec.Meta(ge=1, le=1000)]


class Grid(msgspec.Struct, frozen=True, dict=True, tag_field="kind", tag="grid", forbid_unknown_fields=True):
    """Square cells in the first quadrant, numbered column by column: cell `k` of a grid without holes is
    column `k // rows`, row `k % rows`.

    `holes` are cells (column, row) that do not exist: nobody need visit them, and the others are numbered
    without them. They are no walls: bodies move freely. `centre_offset_m` is the position of the first centre
    on both axes (None: half a cell, so that the origin is the outer corner of the first cell). A visit is
    complete `visit_within_m` from a centre.
    """

    columns: Lines = 20
    rows: Lines = 20
    cell_m: Metres = 30.0
    centre_offset_m: Annotated[float, msgspec.Meta(ge=0)] | None = None
    visit_within_m: Metres = 3.0
    holes: tuple[tuple[Number, Number], ...] = ()

    def sites_m(self) -> list[Point]:
        """Centres of all cells, in order of their number."""
        first = self.cell_m / 2 if self.centre_offset_m is None else self.centre_offset_m
        return [(first + column * self.cell_m, first + row * self.cell_m) for column, row in self.cells]

    def neighbours(self, site: int) -> list[Way]:
        """The up to eight cells around a cell, in order of their number, and how far their centres are."""
        found = self._neighbours.get(site)
        if found is None:
            found = self._neighbours[site] = self._around(*self.cells[site])
        return found

    @cached_property
    def cells(self) -> list[tuple[int, int]]:
        """(column, row) of every cell, in order of their number."""
        holes = set(self.holes)
        everywhere = itertools.product(range(self.columns), range(self.rows))
        return [cell for cell in everywhere if cell not in holes]

    def _around(self, column: int, row: int) -> list[Way]:
        return [
            (
                self._numbers[other_column, other_row],
                self.cell_m * math.hypot(other_column - column, other_row - row),
            )
            for other_column in range(column - 1, column + 2)
            for other_row in range(row - 1, row + 2)
            if (other_column, other_row) in self._numbers and (other_column, other_row) != (column, row)
        ]

    @cached_property
    def _numbers(self) -> dict[tuple[int, int], int]:
        return {cell: number for number, cell in enumerate(self.cells)}

    @cached_property
    def _neighbours(self) -> dict[int, list[Way]]:
        return {}


class Edge(NamedTuple):
    """A way between two nodes of a graph, both ways round, unless the way back is an edge of its own.

    `length_m` None: as long as it is straight. A length need not be the distance of the nodes.
    """

    start: Number
    end: Number
    length_m: Metres | None = None


class Graph(
    msgspec.Struct, frozen=True, dict=True, tag_field="kind", tag="graph", forbid_unknown_fields=True
):
    """Nodes to visit, and the edges along which bodies move between them; docs/fields.md.

    A scenario gives either `graph`, a `.graph` file of patrolling_sim or a TOML file of nodes_m and edges, or
    both of `nodes_m` and `edges`; loaded, it has the latter, with all lengths. `lengths` straight: whatever
    lengths are given, an edge is as long as its nodes are apart. A visit is complete `visit_within_m` from a
    node, which bodies reach exactly.
    """

    graph: str = ""
    nodes_m: tuple[Point, ...] = ()
    edges: tuple[Edge, ...] = ()
    lengths: Literal["cost", "straight"] = "cost"
    visit_within_m: Metres = 1e-6

    def sites_m(self) -> list[Point]:
        """Positions of all nodes, in order of their number."""
        return list(self.nodes_m)

    def neighbours(self, site: int) -> list[Way]:
        """The nodes to which an edge leads, in order of their number, and how long it is."""
        return self._neighbours[site]

    def straight_m(self, edge: Edge) -> float:
        """How far the nodes of an edge are from each other."""
        return math.dist(self.nodes_m[edge.start], self.nodes_m[edge.end])

    @cached_property
    def _neighbours(self) -> list[list[Way]]:
        lengths_m = {
            edge[:2]: self.straight_m(edge) if edge.length_m is None else edge.length_m for edge in self.edges
        }
        found: list[list[Way]] = [[] for _ in self.nodes_m]
        for (start, end), length_m in lengths_m.items():
            found[start].append((end, length_m))
            if (end, start) not in lengths_m:
                found[end].append((start, length_m))
        return [sorted(ways) for ways in found]


class Polyline(msgspec.Struct, frozen=True, tag_field="kind", tag="polyline", forbid_unknown_fields=True):
    """An open polyline that is patrolled in segments, numbered from 1 at its first point.

    `segments`: how many of equal length, `gap_m` apart; or the [start, end] of each in metres along the line.
    `approach_m`: how far from a segment's end a robot begins to change between line and passing lane. The
    passing lane runs `lane_m` to the left of the line, the places of the queue stand `slot_m` apart behind it
    at the tower. `wire.line.Line` has the geometry.
    """

    points_m: tuple[Point, ...]
    segments: Segments | tuple[tuple[float, float], ...]
    gap_m: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    approach_m: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    lane_m: Metres = 0.3
    slot_m: Metres = 0.3


class RandomPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A floor plan of so many columns and rows of rooms with so many islands, drawn by chance."""

    seed: Number = 1
    columns: Rooms = 3
    rows: Rooms = 3
    islands: Number = 0


class FloorPlan(msgspec.Struct, frozen=True, tag_field="kind", tag="plan", forbid_unknown_fields=True):
    """Free space between walls, that no robot is told of.

    A scenario gives one of `plan` (a file of well-known text or GeoJSON, or a picture and `metres_per_px`;
    beside the scenario, or by the name of one that ships), `random`, or `rings_m`: the outer ring, then the
    islands. Loaded, it has `rings_m`. `turned_rad` turns the whole world about the origin, counter-clockwise:
    the plan, starts, and headings.
    """

    plan: str = ""
    metres_per_px: Metres | None = None
    random: RandomPlan | None = None
    rings_m: tuple[tuple[Point, ...], ...] = ()
    turned_rad: float = 0.0


class Unseen(msgspec.Struct, frozen=True, tag_field="kind", tag="unseen", forbid_unknown_fields=True):
    """What a robot is told in place of a floor plan: how far its `rays` and its radio reach."""

    detect_m: Metres
    rays: Number
    comm_m: Metres


Field = Grid | Graph | Polyline | FloorPlan
"""What a scenario may have."""
Told = Grid | Graph | Polyline | Unseen
"""What a node may be told of it: a floor plan cannot even be said."""
