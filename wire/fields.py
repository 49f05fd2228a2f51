"""The shapes a field can have, as scenarios describe them and as nodes are told of them."""

from typing import Annotated

import msgspec

Metres = Annotated[float, msgspec.Meta(gt=0)]
Lines = Annotated[int, msgspec.Meta(ge=1, le=1000)]


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


Field = Grid  # a union as soon as there is a second shape
