"""Pattern search: the least value of a function that can only be asked, never derived.

Compass search: ask the neighbours of a point, one step up and down each axis; go to the best of them while
one is better, else halve the step. Source: Kolda, Lewis and Torczon 2003, "Optimization by direct search",
SIAM Review 45(3); Hooke and Jeeves 1961, J. ACM 8(2), named such methods direct search. We ask all neighbours
before we go, so that they can be tried side by side, and leave out the pattern moves of Hooke and Jeeves. A
neighbour beyond a bound is put on the bound.

Coordinates are exact fractions: a point that is reached by two ways is one point, and asked once.
"""

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import NamedTuple

Point = tuple[Fraction, ...]


class Axis(NamedTuple):
    """One parameter: where it begins, its bounds (the start is within them), and is it whole numbers only?"""

    start: Fraction
    low: Fraction
    high: Fraction
    whole: bool = False


def search(
    axes: Sequence[Axis],
    ask: Callable[[list[Point]], list[float]],
    step: Fraction,
    smallest_step: Fraction,
    budget: int,
) -> dict[Point, float]:
    """Every point that was asked with its value, in order; the first of the least values is the result.

    `ask` gets points that it never got before and answers their values; infinity: not possible there. The
    first point is the start, alone. `step` and `smallest_step` (> 0) are shares of each axis; whole axes go
    whole steps, one at least. The search ends when no neighbour within the smallest step is better, or after
    `budget` points.
    """
    here = tuple(axis.start for axis in axes)
    values = {here: ask([here])[0]}
    while step >= smallest_step and len(values) < budget:
        around = neighbours(here, axes, step)
        new = [point for point in around if point not in values][: budget - len(values)]
        if new:
            values.update(zip(new, ask(new), strict=True))
        best = min(around, key=lambda point: values.get(point, math.inf))
        if values.get(best, math.inf) < values[here]:
            here = best
        else:
            step /= 2
    return values


def neighbours(here: Point, axes: Sequence[Axis], step: Fraction) -> list[Point]:
    """One step down and up every axis, as far as its bounds let; without the point itself."""
    found = []
    for place, axis in enumerate(axes):
        way = step * (axis.high - axis.low)
        if axis.whole:
            way = Fraction(max(1, math.floor(way)))
        for to in (max(axis.low, here[place] - way), min(axis.high, here[place] + way)):
            if to != here[place]:
                found.append((*here[:place], to, *here[place + 1 :]))
    return found
