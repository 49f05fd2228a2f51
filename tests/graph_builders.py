"""Graphs for tests: random ones, the shipped ones, and the maps of patrolling_sim where they are at hand."""

import os
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from deploy.field_file import whole_graph
from deploy.scenario_file import find_scenario
from tests.test_graph_file import FOLDER_VARIABLE
from wire.fields import Edge, Graph

GRAPHS = Path(find_scenario("graph-grid")).parent / "graphs"
STEP_M = Fraction(1, 2)
"""What the lengths of random graphs are whole multiples of: a tick's way."""


def chance(*key: int) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(key)))


@cache
def made_up(number: int) -> Graph:
    """A random connected graph: a random tree, some edges more, some of which cost more on the way back."""
    draw = chance(number)
    count = 8 + 4 * number
    pairs = {(int(draw.integers(node)), node) for node in range(1, count)}
    pairs |= {tuple(sorted(draw.choice(count, 2, replace=False).tolist())) for _ in range(count // 2)}
    edges = []
    for start, end in sorted(pairs):
        edges.append(Edge(start, end, float(STEP_M * int(draw.integers(1, 13)))))
        if draw.random() < 0.2:
            edges.append(Edge(end, start, float(STEP_M * int(draw.integers(1, 13)))))
    return Graph(nodes_m=tuple(map(tuple, draw.uniform(0, 50, (count, 2)).tolist())), edges=tuple(edges))


def data_graph(name: str) -> Graph:
    """A map of patrolling_sim, if there is one."""
    folder = os.environ.get(FOLDER_VARIABLE)
    if folder is None or not (Path(folder) / f"{name}.graph").exists():
        pytest.skip(
            f"the maps of patrolling_sim are not part of Picket; {FOLDER_VARIABLE} says where they lie"
        )
    return whole_graph(Graph(graph=str(Path(folder) / f"{name}.graph")))
