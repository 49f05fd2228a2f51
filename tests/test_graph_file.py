"""Graph files: what is right parses to the known graph; what is damaged is refused in one line."""

import hashlib
import os
from collections import Counter
from math import dist, isfinite
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from deploy.graph_file import GraphFileError, PatrolGraph, read_graph
from tests.graph_texts import SMALL, WITHOUT_OFFSET, grid_text

# The graph files that come with patrolling_sim are not part of this project; this names where they lie.
FOLDER_VARIABLE = "PICKET_PATROL_GRAPHS"


class Facts(NamedTuple):
    """What is known of a shipped file of patrolling_sim, lengths in metres."""

    sha256: str
    nodes: int
    edges: int
    offset: tuple[float, float]
    resolution: float
    cost: float
    euclid: float
    diameter: float
    degrees: tuple[int, float, int]
    leaves: int


SHIPPED = {
    "1r5": Facts("a72bc0d016da0202", 12, 11, (0, 0), 0.05, 42.5, 30.4, 22.2, (1, 1.83, 3), 7),
    "DIAG_labs": Facts("6f639deebf5dfdf6", 27, 26, (0, 0), 0.05, 77.4, 76.9, 66.0, (1, 1.93, 4), 15),
    "ctcv": Facts("49eb851b1971ad6c", 18, 17, (-29.675, -7.4), 0.05, 59.8, 60.4, 53.0, (1, 1.89, 3), 6),
    "cumberland": Facts("9e8023e944cb2928", 40, 44, (0, 0), 0.075, 250.9, 242.7, 72.9, (1, 2.20, 4), 18),
    "example": Facts("e4158291c3530120", 29, 34, (0, 0), 0.15, 264.0, 232.3, 69.5, (1, 2.48, 4), 9),
}
GRID = Facts("", 25, 40, (0, 0), 0.075, 228.0, 228.0, 45.6, (2, 3.20, 4), 0)


def costs_m(graph: PatrolGraph) -> dict[tuple[int, int], float]:
    return {(node.id, arc.neighbour): arc.cost_m for node in graph.nodes for arc in node.arcs}


def diameter_m(graph: PatrolGraph) -> float:
    """The longest of all shortest paths, by Floyd and Warshall."""
    ids = range(len(graph.nodes))
    arcs = costs_m(graph)
    far = [[0.0 if a == b else arcs.get((a, b), float("inf")) for b in ids] for a in ids]
    for via in ids:
        far = [[min(far[a][b], far[a][via] + far[via][b]) for b in ids] for a in ids]
    return max(map(max, far))


def check_facts(graph: PatrolGraph, facts: Facts, content: str | bytes) -> None:
    """Degrees count what the file lists, so the arcs that are dropped too."""
    edges, arcs = graph.edges(), costs_m(graph)
    assert (len(graph.nodes), len(edges)) == (facts.nodes, facts.edges)
    assert len(arcs) == sum(len(node.arcs) for node in graph.nodes) == 2 * facts.edges
    assert (graph.offset_m, graph.metres_per_px) == (facts.offset, facts.resolution)
    assert sum(arcs[edge] for edge in edges) == pytest.approx(facts.cost, abs=0.051)
    places = [(node.x_m, node.y_m) for node in graph.nodes]
    assert sum(dist(places[a], places[b]) for a, b in edges) == pytest.approx(facts.euclid, abs=0.051)
    assert diameter_m(graph) == pytest.approx(facts.diameter, abs=0.051)
    assert all(arcs[a, b] == arcs[b, a] for a, b in edges)
    degrees = [len(node.arcs) for node in graph.nodes]
    least, mean, most = facts.degrees
    assert (min(degrees), max(degrees), Counter(degrees)[1]) == (least, most, facts.leaves)
    listed = (len(content.split()) - 6 - 4 * facts.nodes) / 3
    assert listed / facts.nodes == pytest.approx(mean, abs=0.0051)


def complaint(content: str | bytes) -> str:
    with pytest.raises(GraphFileError) as caught:
        read_graph(content, "mine.graph")
    said = str(caught.value)
    assert len(said.splitlines()) == 1
    assert said.startswith("mine.graph: line ")
    return said


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_file_is_the_graph_that_is_known(name):
    folder = os.environ.get(FOLDER_VARIABLE)
    if folder is None:
        pytest.skip(
            f"the maps of patrolling_sim are not part of Picket; {FOLDER_VARIABLE} says where they lie"
        )
    path = Path(folder) / f"{name}.graph"
    if not path.exists():
        pytest.skip(f"{FOLDER_VARIABLE} has no {name}.graph")
    content = path.read_bytes()
    facts = SHIPPED[name]
    assert hashlib.sha256(content).hexdigest().startswith(facts.sha256), "another version of the file"
    check_facts(read_graph(content, path.name), facts, content)


def test_the_generated_grid_is_the_graph_that_is_known():
    graph = read_graph(grid_text(), "grid.graph")
    check_facts(graph, GRID, grid_text())
    assert (graph.nodes[0].x_m, graph.nodes[0].y_m) == pytest.approx((1.425, 24.375))
    assert all(cost_m == pytest.approx(5.7) for cost_m in costs_m(graph).values())


@pytest.mark.parametrize(
    "content", [SMALL, SMALL.encode(), " ".join(SMALL.split()), SMALL.replace(" ", "\r\n")]
)
def test_a_small_file_parses_however_its_lines_are_broken(content):
    graph = read_graph(content, "small.graph")
    assert (graph.width_px, graph.height_px, graph.metres_per_px) == (200, 100, 0.05)
    assert graph.offset_m == (-2.5, 1.25)
    assert [node.id for node in graph.nodes] == [0, 1, 2, 3]
    assert (graph.nodes[1].x_m, graph.nodes[1].y_m) == pytest.approx((60.5 * 0.05 - 2.5, 2.25))
    assert graph.edges() == [(0, 1), (1, 2), (1, 3)]


def test_a_second_arc_to_the_same_neighbour_is_dropped_and_costs_may_differ_by_direction():
    arcs = {node.id: node.arcs for node in read_graph(SMALL, "small.graph").nodes}
    assert [(arc.neighbour, arc.direction, arc.cost_px) for arc in arcs[1]] == [
        (0, "W", 50),
        (2, "N", 30),
        (3, "SE", 35),
    ]
    assert (arcs[1][1].cost_px, arcs[2][0].cost_px) == (30, 40)
    assert arcs[2][0].cost_m == pytest.approx(2.0)


@pytest.mark.parametrize("text", [SMALL, grid_text()])
def test_a_file_without_offsets_is_the_same_graph_at_the_origin(text):
    header = text.split()[:4]
    whole = read_graph(text, "new.graph")
    bare = read_graph(" ".join([*header, *text.split()[6:]]), "old.graph")
    assert bare.offset_m == (0, 0)
    for old, new in zip(bare.nodes, whole.nodes, strict=True):
        assert old.arcs == new.arcs
        assert old.x_m + whole.offset_m[0] == pytest.approx(new.x_m)
        assert old.y_m + whole.offset_m[1] == pytest.approx(new.y_m)


def test_a_single_node_and_a_one_way_arc_parse():
    assert read_graph("1 9 9 1 0 0  0 4 5 0", "one.graph").nodes[0].y_m == 5
    assert read_graph("1 9 9 1  0 4 5 0", "old.graph").nodes[0].y_m == 5
    assert read_graph("2 9 9 1 0 0  0 4 5 1 1 E 3  1 7 5 0", "way.graph").edges() == [(0, 1)]


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [
        ("4 200", "x 200", "line 1: number of nodes must be a whole number from 1 to 200, got x"),
        ("4 200", "0 200", "line 1: number of nodes must be a whole number from 1 to 200, got 0"),
        ("4 200", "201 200", "from 1 to 200, got 201"),
        ("4 200", "-4 200", "from 1 to 200, got -4"),
        ("4 200", "4.0 200", "from 1 to 200, got 4.0"),
        ("200 100", "0 100", "line 1: image width in pixels must be a whole number from 1 to"),
        ("200 100", "200 1_0", "line 1: image height in pixels must be a whole number from 1 to"),
        ("0.05", "0", "line 1: metres per pixel must be a number > 0 and <= 1e+09, got 0"),
        ("0.05", "1e-999", "metres per pixel must be a number > 0 and <= 1e+09, got 1e-999"),
        ("0.05", "-0.05", "metres per pixel must be a number > 0 and <= 1e+09, got -0.05"),
        ("0.05", "nan", "metres per pixel must be a number > 0 and <= 1e+09, got nan"),
        ("-2.5", "inf", "line 2: offset x in metres must be a number >= -1e+09 and <= 1e+09, got inf"),
        ("1.25", "1e999", "line 2: offset y in metres must be a number >= -1e+09 and <= 1e+09, got 1e999"),
        ("1.25", "1,25", "offset y in metres must be a number >= -1e+09 and <= 1e+09, got 1,25"),
        ("1.25", "1" * 300_000 + "x", "line 2: offset y in metres must be a number"),
        ("0 10 20", "1 10 20", "line 3: node 0: id must be 0, got 1"),
        ("2 60 50", "3 60 50", "line 5: node 2: id must be 2, got 3; or is the degree 4 of node 1 (line 4)"),
        ("60.5", "-60.5", "line 4: node 1: x in pixels must be a number >= 0 and <= 1e+09, got -60.5"),
        ("60 50", "60 fifty", "line 5: node 2: y in pixels must be a number >= 0 and <= 1e+09, got fifty"),
        ("20 1  1", "20 9  1", "line 3: node 0: degree must be a whole number from 0 to 8, got 9"),
        ("20 4  0", "20 -4  0", "line 4: node 1: degree must be a whole number from 0 to 8, got -4"),
        ("20 4  0", "20 3  0", "line 4: node 2: id must be 2, got 3; or is the degree 3 of node 1 (line 4)"),
        ("20 4  0", "20 5  0", "line 5: node 1: arc 5: direction must be one of N NE E SE S SW W NW, got 60"),
        ("1 E", "4 E", "line 3: node 0: arc 1: neighbour must be a whole number from 0 to 3, got 4"),
        ("1 E", "-1 E", "line 3: node 0: arc 1: neighbour must be a whole number from 0 to 3, got -1"),
        ("1 E", "0 E", "line 3: node 0: arc 1: neighbour must be another node, got 0"),
        ("2 N 30", "2 n 30", "line 4: node 1: arc 2: direction must be one of N NE E SE S SW W NW, got n"),
        ("2 N 30", "2 N 0", "line 4: node 1: arc 2: cost must be a whole number from 1 to 4294967295, got 0"),
        ("2 N 30", "2 N -30", "arc 2: cost must be a whole number from 1 to 4294967295, got -30"),
        ("2 N 30", "2 N 30.5", "arc 2: cost must be a whole number from 1 to 4294967295, got 30.5"),
        ("2 N 30", "2 N inf", "arc 2: cost must be a whole number from 1 to 4294967295, got inf"),
        ("2 N 30", "2 N " + "9" * 5000, "arc 2: cost must be a whole number from 1 to 4294967295, got 9999"),
        ("0 NW 50", "0 NW 51", "node 1: arc 3: cost must be 50 as in the first arc to node 0, got 51"),
        ("4 200", "5 200", "line 6: node 4: id must be 4, but the file ends here; it is cut off, or a count"),
        ("NW 35\n", "NW 35\n\nmore", "line 8: what follows node 3 must be nothing, got more"),
        ("NW 35\n", "NW 35 1 W 3", "nothing, got 1; or is the number of nodes 4 (line 1) or the degree 1 of"),
        ("3 80 0 1  1 NW 35\n", "", "node 3: id must be 3, but the file ends here"),
        ("NW 35\n", "NW", "line 6: node 3: arc 1: cost must be a whole number from 1 to 4294967295, but the"),
        ("60.5", "6\x00", "line 4: must be plain ASCII text, got the character '\\x00'"),
        ("60.5", "６", "line 4: must be plain ASCII text, got the character '\\uff16'"),
    ],
)
def test_each_damage_is_refused_with_its_place(old, new, wanted):
    assert old in SMALL
    said = complaint(SMALL.replace(old, new, 1))
    assert wanted in said
    assert len(said) < 300


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [
        ("0 10 20", "7 10 20", "line 2: node 0: id must be 0, got 7"),
        ("0 10 20", "0 ten 20", "line 2: node 0: x in pixels must be a number >= 0 and <= 1e+09, got ten"),
        ("0 10 20", "0 10 -20", "line 2: node 0: y in pixels must be a number >= 0 and <= 1e+09, got -20"),
        ("1 E", "4 E", "line 2: node 0: arc 1: neighbour must be a whole number from 0 to 3, got 4"),
        ("3 80 0 1  1 NW 35\n", "", "line 4: node 3: id must be 3, but the file ends here"),
    ],
)
def test_damage_to_a_file_without_offsets_is_not_sought_in_its_offsets(old, new, wanted):
    assert wanted in complaint(WITHOUT_OFFSET.replace(old, new, 1))


@pytest.mark.parametrize("content", ["", b"", "  \n\n\t\r\n"])
def test_an_empty_file_is_refused(content):
    assert "the file is empty; it must begin with the number of nodes" in complaint(content)


@pytest.mark.parametrize("content", [b"\x89PNG\r\n", b"\xff\xfe4\x00", "\ufeff" + SMALL, "\udc80"])
def test_what_is_not_text_is_refused(content):
    assert "line 1: must be plain ASCII text, got the character" in complaint(content)


def test_a_complaint_is_one_line_whatever_the_file_is_called():
    with pytest.raises(GraphFileError) as caught:
        read_graph("", "my\nown\u2028.graph")
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("text", [SMALL, WITHOUT_OFFSET, grid_text()])
def test_every_truncation_is_refused(text):
    words = text.split()
    for length in range(len(words)):
        assert complaint(" ".join(words[:length]))


tokens = st.sampled_from(
    ["0", "1", "4", "-1", "nan", "inf", "-0.0", "1e308", "1e-320", "N", "SW", "0x1", "", "٣"]
)
changes = st.tuples(
    st.sampled_from(["set", "insert", "delete", "repeat"]), st.integers(0, 200), tokens | st.text()
)


def parses_or_is_refused(content: str | bytes) -> None:
    try:
        graph = read_graph(content, "mine.graph")
    except GraphFileError as error:
        assert len(str(error).splitlines()) == 1
        assert str(error).startswith("mine.graph: line ")
        return
    ids = {node.id for node in graph.nodes}
    assert graph.metres_per_px > 0
    assert sorted(ids) == list(range(len(graph.nodes)))
    for node in graph.nodes:
        assert isfinite(node.x_m) and isfinite(node.y_m)
        assert all(arc.neighbour in ids - {node.id} for arc in node.arcs)
        assert all(isfinite(arc.cost_m) and arc.cost_px > 0 for arc in node.arcs)


@settings(max_examples=300)
@given(st.sampled_from([SMALL, WITHOUT_OFFSET, grid_text()]), st.lists(changes, min_size=1, max_size=4))
def test_a_damaged_file_parses_or_is_refused_in_one_line(text, damage):
    words = text.split()
    for verb, place, token in damage:
        place %= len(words) + 1
        if verb == "insert":
            words.insert(place, token)
        elif verb == "delete":
            words[place : place + 1] = []
        elif verb == "repeat":
            words[place:place] = words[place : place + 3]
        else:
            words[place : place + 1] = [token]
    parses_or_is_refused(" ".join(words))


@given(st.binary() | st.text())
@example(b"4")
@example("4 1 1 1")
def test_any_content_parses_or_is_refused_in_one_line(content):
    parses_or_is_refused(content)
