"""What pictures of all missions are made of, and what a mission may add to bodies and radio."""

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from wire.messages import Facts

Colour = tuple[int, int, int]
Point = tuple[float, float]

BASE, FROZEN, DEAD, FLAT = "base station", "frozen", "dead", "flat"
WHITE, GREY = (240, 240, 245), (120, 124, 140)
ORANGE, VIOLET, YELLOW = (255, 170, 60), (214, 110, 255), (245, 215, 70)
GREEN, BLUE, ICE, RED = (64, 214, 150), (80, 170, 255), (190, 235, 255), (255, 70, 70)
OWN = {BASE: WHITE, FROZEN: ICE, DEAD: RED, FLAT: VIOLET}
"""States that every mission has, with their colours."""
INFERNO: tuple[Colour, ...] = (
    (0, 0, 4),
    (31, 12, 72),
    (85, 15, 109),
    (136, 34, 106),
    (186, 54, 85),
    (227, 89, 51),
    (249, 140, 10),
    (249, 201, 50),
    (252, 255, 164),
)
"""Nine colours of the scale of that name, as many steps apart as the next."""


class Plot(NamedTuple):
    """One diagram over time; `series` are names and colours of its curves, `span` its vertical range."""

    name: str
    title: str
    series: tuple[tuple[str, Colour], ...]
    span: tuple[float, float] | None = None


class Strip(NamedTuple):
    """A stretch of the field that is painted anew in every snapshot; its label stands at `label_m`."""

    points_m: tuple[Point, ...]
    label_m: Point


class Paint(NamedTuple):
    """How one strip looks now."""

    colour: Colour
    label: str


class Pen(NamedTuple):
    """How strokes are drawn: a higher `order` over a lower one; in pixels where `width_m` is 0."""

    order: float
    width_px: float = 1.0
    width_m: float = 0.0


class Strokes(NamedTuple):
    """Lines on the map, (points, 2) each, and a colour for each of them, or one for all."""

    lines_m: Sequence[np.ndarray]
    colours: Sequence[Colour]


class Sketch(NamedTuple):
    """A graph as it is drawn in a view of its own, y downwards; `links` are pairs of names."""

    names: tuple[str, ...]
    points: tuple[Point, ...]
    labels: tuple[str, ...]
    colours: tuple[Colour, ...]
    links: tuple[tuple[str, str], ...]


def hot(share: float) -> Colour:
    """The colour of a value on the scale of the heat map (inferno), where 1 is hottest."""
    place = min(1.0, max(0.0, share)) * (len(INFERNO) - 1)
    step = min(int(place), len(INFERNO) - 2)
    cold, warm = INFERNO[step], INFERNO[step + 1]
    red, green, blue = (
        round(one + (place - step) * (other - one)) for one, other in zip(cold, warm, strict=True)
    )
    return red, green, blue


class Mission:
    """What a mission adds. Area and line are such; what a mission does not say is as here."""

    plots: tuple[Plot, ...]
    states: ClassVar[dict[str, Colour]]
    """What a living robot may be doing."""
    bounds_m: tuple[float, float, float, float]
    """Left, bottom, right, top of what is to be seen."""
    radius_m: float
    """Of a robot as it is drawn."""
    title: str = "Map"
    """Of the map."""
    legend: str
    """A sentence or two about what is drawn of this mission."""
    hottest_s: float = 0.0
    """The value at the end of the heat map's colour scale."""
    strips: tuple[Strip, ...] = ()
    sites: tuple[Point, ...] = ()
    """Places that are painted anew in every snapshot, as discs."""
    ways: tuple[tuple[Point, ...], ...] = ()
    """Thin lines beneath everything."""
    places: tuple[Point, ...] = ()
    """Where robots wait."""
    notes: tuple[tuple[Point, str], ...] = ()
    """Words on the map."""
    names_say_trouble: bool = False
    """Does a name say `dead`, `flat` or `frozen`, because colours alone would not?"""
    shows_traffic: bool = True
    """Are deliveries and goals drawn on the map, and how far the base station reaches?"""
    pens: ClassVar[dict[str, Pen]] = {}
    """What there is of strokes, by name."""
    fixed: ClassVar[dict[str, Strokes]] = {}
    """Strokes that hold for all times."""
    canvas: tuple[float, float] | None = None
    """Width and height of the view for a graph, if there is one; `graph_title` is its name."""
    graph_title: str = ""

    def take(self, facts: Facts, links: np.ndarray) -> None:
        """Fold one tick."""
        raise NotImplementedError

    def doing(self, row: int) -> str:
        """What the living robot in `row` does, one of `states`."""
        raise NotImplementedError

    def curves(self) -> dict[str, tuple[float, ...]]:
        """Present values of all series, by plot."""
        raise NotImplementedError

    def colour(self, row: int) -> Colour:
        """The colour of the living robot in `row`."""
        return self.states[self.doing(row)]

    def heat_s(self) -> np.ndarray | None:
        """The heat map: (rows, columns), row 0 at the bottom."""
        return None

    def glow(self) -> tuple[Colour, ...]:
        """The colour of each of `sites`."""
        return ()

    def strokes(self) -> dict[str, Strokes | None]:
        """Strokes as they are now; None where there are none. The same object again: nothing has changed."""
        return {}

    def sketch(self) -> Sketch | None:
        """The graph as it is now. The same object again: nothing has changed."""
        return None

    def news(self) -> list[tuple[str, str]]:
        """What happened in the tick that was folded last, for the event log: levels and texts."""
        return []

    def paints(self) -> tuple[Paint, ...]:
        """How each of `strips` looks."""
        return ()
