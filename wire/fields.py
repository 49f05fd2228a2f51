"""The shapes a field can have, as scenarios describe them and as nodes are told of them."""

import math
from typing import Annotated

import msgspec

Metres = Annotated[float, msgspec.Meta(gt=0)]
Lines = Annotated[int, msgspec.Meta(ge=1, le=1000)]
Segments = Annotated[int, msgspec.Meta(ge=1, le=1000)]


class Grid(msgspec.Struct, frozen=True, tag_field="kind", tag="grid", forbid_unknown_fields=True):
    """Square cells in the first quadrant. Cell `k` is column `k // rows`, row `k % rows`.

    `centre_offset_m` is the position of the first centre on both axes (None: half a cell, so that the origin
    is the outer corner of cell 0). A visit is complete `visit_within_m` from a centre.
    """

    columns: Lines = 20
    rows: Lines = 20
    cell_m: Metres = 30.0
    centre_offset_m: Annotated[float, msgspec.Meta(ge=0)] | None = None
    visit_within_m: Metres = 3.0

    def sites_m(self) -> list[tuple[float, float]]:
        """Centres of all cells, in order of their number."""
        first = self.cell_m / 2 if self.centre_offset_m is None else self.centre_offset_m
        return [
            (first + column * self.cell_m, first + row * self.cell_m)
            for column in range(self.columns)
            for row in range(self.rows)
        ]

    def neighbours(self, site: int) -> list[tuple[int, float]]:
        """The up to eight cells around a cell, in order of their number, and how far their centres are."""
        column, row = divmod(site, self.rows)
        return [
            (
                other_column * self.rows + other_row,
                self.cell_m * math.hypot(other_column - column, other_row - row),
            )
            for other_column in range(max(0, column - 1), min(self.columns, column + 2))
            for other_row in range(max(0, row - 1), min(self.rows, row + 2))
            if (other_column, other_row) != (column, row)
        ]


class Polyline(msgspec.Struct, frozen=True, tag_field="kind", tag="polyline", forbid_unknown_fields=True):
    """An open polyline that is patrolled in segments, numbered from 1 at its first point.

    `segments`: how many of equal length, `gap_m` apart; or the [start, end] of each in metres along the line.
    `approach_m`: how far from a segment's end a robot begins to change between line and passing lane. The
    passing lane runs `lane_m` to the left of the line, the places of the queue stand `slot_m` apart behind it
    at the tower. `wire.line.Line` has the geometry.
    """

    points_m: tuple[tuple[float, float], ...]
    segments: Segments | tuple[tuple[float, float], ...]
    gap_m: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    approach_m: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    lane_m: Metres = 0.3
    slot_m: Metres = 0.3


Field = Grid | Polyline
