"""Shapes and graphs in the picture of a clearing."""

import math

import numpy as np
import pytest

from deploy.scenes.shapes import circles, filled, rings_of, seen_from
from deploy.scenes.sketch import CANVAS, sketched
from swarm_agent.graph_copy import Delta, Edge, Version, Vertex
from tests.clear_builders import ELL


def test_every_graph_has_room_on_its_canvas() -> None:
    """A long chain, a star, several parts, a cycle: nothing lies outside, no two regions on each other."""
    pairs = (
        [(number, number + 1) for number in range(30)],
        [(0, number) for number in range(1, 20)],
        [(0, 1), (2, 3), (2, 4)],
        [(0, 1), (1, 2), (0, 2)],
        [],
    )
    for some in pairs:
        count = max((high for _, high in some), default=0) + 1
        vertices = tuple(Vertex(number, 1) for number in range(count))
        edges = tuple(Edge(low, high, 1, "move") for low, high in some)
        sketch = sketched(Delta(Version(), Version(1), 0, None, vertices, edges))
        points = np.array(sketch.points)
        assert (points >= 0).all()
        assert (points <= CANVAS).all()
        assert len(set(sketch.points[:count])) == count


def test_holes_are_not_filled() -> None:
    hole = [(1, 1), (2, 1), (2, 2), (1, 2), (1, 1)]
    rings = [np.array([*ELL, ELL[0]], float), np.array(hole, float)]
    strokes = filled(rings, 0.05)
    lengths_m = strokes[:, 1, 0] - strokes[:, 0, 0]
    assert (lengths_m > 0).all()
    assert lengths_m.sum() * 0.05 == pytest.approx(19.0, rel=0.01)
    middle = (strokes[:, 0, 1] > 1) & (strokes[:, 0, 1] < 2)
    assert not ((strokes[middle, 0, 0] < 1.5) & (strokes[middle, 1, 0] > 1.5)).any()


def test_shapes_of_nothing() -> None:
    assert rings_of(np.full((1, 2), np.nan, "<f4").tobytes()) == []
    assert rings_of(b"") == []
    assert len(filled([], 0.1)) == 0
    assert len(circles(np.zeros((0, 2)), 1.0)) == 0


def test_a_way_is_told_in_the_frame_of_the_body() -> None:
    assert seen_from(np.array([1.0, 2.0, math.pi / 2]), (0.5, 0.25)) == pytest.approx((0.75, 2.5))
