"""Fields that do not fit: each mistake is one line with file, field, value and what would be right."""

from pathlib import Path

import pytest

from deploy.__main__ import carry_out
from deploy.scenario_file import load_scenario, to_toml
from tests.graph_texts import SMALL, WITHOUT_OFFSET, grid_text
from tests.test_scenario import complaint
from wire.fields import Edge

AREA = """
mission = "area"
duration_s = 10

[field]
{field}

[robots]
behaviour = "random"
start = {start}
"""
TRIANGLE = "nodes_m = [[0, 0], [3, 4], [0, 8]]\nedges = [[0, 1], [1, 2, 7.5], [2, 1, 9]]\n"


def written(folder: Path, field: str, start: str = "[0, 1]") -> Path:
    """A scenario file with this field."""
    path = folder / "mine.toml"
    path.write_text(AREA.format(field=field, start=start))
    return path


def graph(text: str) -> str:
    return f'kind = "graph"\n{text}'


def refused(folder: Path, field: str, start: str = "[0, 1]", *settings: str) -> str:
    return complaint(written(folder, field, start), *settings).removeprefix("mine.toml: ")


def test_an_inline_graph_is_completed_and_comes_back(tmp_path):
    scenario = load_scenario(written(tmp_path, graph(TRIANGLE)))
    assert scenario.field.edges == (Edge(0, 1, 5.0), Edge(1, 2, 7.5), Edge(2, 1, 9.0))
    assert scenario.robot_ids == ("r2", "r3")
    (tmp_path / "again.toml").write_text(to_toml(scenario))
    assert load_scenario(tmp_path / "again.toml") == scenario


def test_straight_lengths_stand_in_for_all_others(tmp_path):
    scenario = load_scenario(written(tmp_path, graph(TRIANGLE + 'lengths = "straight"')))
    assert [edge.length_m for edge in scenario.field.edges] == [5.0, 5.0, 5.0]


@pytest.mark.parametrize("name", ["mine.graph", "mine.graph.toml"])
def test_a_file_lies_beside_its_scenario_and_is_not_needed_again(name, tmp_path, monkeypatch):
    (tmp_path / "maps").mkdir()
    file = tmp_path / "maps" / name
    file.write_text(TRIANGLE if name.endswith("toml") else SMALL)
    scenario = load_scenario(written(tmp_path, graph(f'graph = "maps/{name}"')))
    file.rename(tmp_path / name)
    (tmp_path / "again.toml").write_text(to_toml(scenario))
    assert load_scenario(tmp_path / "again.toml") == scenario
    assert scenario.field.graph == ""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "maps" / "mine.toml"
    path.write_text(AREA.format(field=graph('graph = "elsewhere.graph"'), start="[0]"))
    assert load_scenario(path, [f"field.graph={name}"]).field == scenario.field, "an option's lies here"


@pytest.mark.parametrize("text", [SMALL, WITHOUT_OFFSET])
def test_a_graph_file_has_costs_and_one_edge_for_equal_ways(text, tmp_path):
    (tmp_path / "small.graph").write_text(text)
    field = load_scenario(written(tmp_path, graph('graph = "small.graph"'))).field
    assert [edge[:2] for edge in field.edges] == [(0, 1), (1, 2), (1, 3), (2, 1)]
    assert [edge.length_m for edge in field.edges] == pytest.approx([2.5, 1.5, 1.75, 2.0])
    field = load_scenario(written(tmp_path, graph('graph = "small.graph"\nlengths = "straight"'))).field
    assert dict(field.neighbours(0))[1] == pytest.approx(50.5 * 0.05)


def test_a_grid_file_is_the_shipped_grid(tmp_path):
    (tmp_path / "grid.graph").write_text(grid_text())
    mine = load_scenario(written(tmp_path, graph('graph = "grid.graph"'))).field
    shipped = load_scenario(Path("deploy/scenarios/graph-grid.toml").absolute()).field
    for node, point in enumerate(shipped.nodes_m):
        assert mine.nodes_m[node] == pytest.approx(point)
        assert dict(mine.neighbours(node)) == pytest.approx(dict(shipped.neighbours(node)))


def test_behaviour_is_short_for_the_behaviour_of_robots(tmp_path):
    path = written(tmp_path, graph(TRIANGLE))
    assert load_scenario(path, ["behaviour=sebs"]).robots.behaviour == "sebs"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "field must have either graph, a file, or nodes_m and edges, got neither"),
        (
            TRIANGLE + 'graph = "x.graph"',
            "field must have either graph, a file, or nodes_m and edges, got both",
        ),
        ("nodes_m = []\nedges = [[0, 1]]", "field must have from 1 to 65536 sites, got 0"),
        ("nodes_m = [[0, 0, 0]]", "field.nodes_m[0] must be a list of length 2, got 3, got [0, 0, 0]"),
        ("nodes_m = [[0, inf]]", "field.nodes_m[0][1] must be finite, got inf"),
        ("nodes_m = [[0, 2e6]]", "field.nodes_m[0] must be within 1e+06 m, got [0.0, 2000000.0]"),
        ("nodes_m = [[0, 1], [0, 1]]", "field.nodes_m[1] must be another place than node 0, got [0.0, 1.0]"),
        (
            "nodes_m = [[0, 1], [0, 2]]",
            "field.edges must connect all nodes, but no way leads from node 0 to node 1",
        ),
        (
            "nodes_m = [[0, 0], [1, 0]]\nedges = [[0, 2]]",
            "field.edges[0] must join nodes from 0 to 1, got [0, 2]",
        ),
        (
            "nodes_m = [[0, 0], [1, 0]]\nedges = [[0, -1]]",
            "field.edges[0][1] must be a whole number >= 0, got -1",
        ),
        ("nodes_m = [[0, 0], [1, 0]]\nedges = [[1, 1]]", "field.edges[0] must join two nodes, got [1, 1]"),
        (
            "nodes_m = [[0, 0], [1, 0]]\nedges = [[0, 1], [0, 1, 3]]",
            "field.edges[1] must differ from those before it, got [0, 1]",
        ),
        (
            "nodes_m = [[0, 0], [1, 0]]\nedges = [[0, 1, 0]]",
            "field.edges[0][2] must be a number > 0.0, got 0",
        ),
        (
            "nodes_m = [[0, 0], [1, 0]]\nedges = [[0, 1, 1e9]]",
            "field.edges[0] must be from 0.001 to 1e+06 m long, got 1000000000.0",
        ),
        (
            "nodes_m = [[0, 0], [1e-6, 0]]\nedges = [[0, 1]]",
            "field.edges[0] must be from 0.001 to 1e+06 m long, got 1e-06",
        ),
        (TRIANGLE + 'lengths = "long"', "field.lengths must be cost or straight, got 'long'"),
        (TRIANGLE + "node_m = []", "field.node_m is not a field; did you mean nodes_m?"),
    ],
)
def test_a_graph_that_does_not_fit_is_refused(text, said, tmp_path):
    assert refused(tmp_path, graph(text)) == said


@pytest.mark.parametrize(
    ("start", "said"),
    [
        ("[0, 3]", "robots.start[1] must be a site from 0 to 2, got 3"),
        ("[0, -1]", "robots.start[1] must be a whole number >= 0, got -1"),
        ("[]", "robots.start must have one site for each of 0 robots, got 0"),
        ("[0, 1]\ncount = 3", "robots.start must have one site for each of 3 robots, got 2"),
        ('[0]\nids = ["r4", "r5"]', "robots.start must have one site for each of 2 robots, got 1"),
        ('{kind = "fan"}', "robots needs either count or ids, or a list of sites as start"),
    ],
)
def test_a_start_that_does_not_fit_is_refused(start, said, tmp_path):
    assert refused(tmp_path, graph(TRIANGLE), start) == said


@pytest.mark.parametrize(
    ("holes", "said"),
    [
        ("[[1, 0], [3, 0]]", "field.holes[1] must be a cell from [0, 0] to [2, 1], got [3, 0]"),
        ("[[1, 2]]", "field.holes[0] must be a cell from [0, 0] to [2, 1], got [1, 2]"),
        ("[[-1, 0]]", "field.holes[0][0] must be a whole number >= 0, got -1"),
        ("[[1, 0], [1, 0]]", "field.holes[1] must differ from those before it, got [1, 0]"),
        ("[[0, 0], [0, 1], [1, 0], [1, 1], [2, 0], [2, 1]]", "field must have from 1 to 65536 sites, got 0"),
        ("[[1, 0], [1, 1]]", "field.holes must leave one piece, but cut cell [2, 0] off from [0, 0]"),
    ],
)
def test_holes_that_do_not_fit_are_refused(holes, said, tmp_path):
    assert refused(tmp_path, f'kind = "grid"\ncolumns = 3\nrows = 2\nholes = {holes}') == said


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("gone.graph", None, "field.graph: {path} cannot be read: No such file or directory"),
        (".", None, "field.graph: {path} cannot be read: Is a directory"),
        ("a\\u0000b", None, "no file can be called that"),
        ("bad.graph", b"4 200 100", "field.graph: bad.graph: line 1: metres per pixel must be"),
        ("way.graph", b"2 9 9 1 0 0  0 4 5 1 1 E 3  1 7 5 0", "must be a way back to node 0, got none"),
        ("bad.toml", b"nodes_m = [", "field.graph: bad.toml: not valid TOML: "),
        ("bad.toml", b"\xff", "field.graph: bad.toml: not UTF-8 text (byte 0); a graph of ours is TOML"),
        ("bad.toml", b"edges = []", "field.graph: bad.toml: nodes_m is missing"),
        ("bad.toml", b"nodes_m = 3", "field.graph: bad.toml: nodes_m must be a list, got 3"),
        ("bad.toml", b"nodes = [[0, 1]]", "bad.toml: nodes is not a field; did you mean nodes_m?"),
        ("bad.toml", b"nodes_m = [[0, nan]]", "field.nodes_m[0] must be within 1e+06 m, got [0.0, nan]"),
        ("bad.toml", b"nodes_m = [[0, 1], ['x', 2]]", "bad.toml: nodes_m[1][0] must be a number, got 'x'"),
    ],
)
def test_a_graph_file_that_does_not_fit_is_refused(name, content, said, tmp_path):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    told = refused(tmp_path, graph(f'graph = "{name}"'))
    assert said.format(path=tmp_path / name) in told


def test_what_belongs_to_one_mission_is_refused_in_the_other(tmp_path):
    path = "deploy/scenarios/line-patrol.toml"
    assert "robots.start must be queue or poses for mission line" in complaint(
        Path(path), "robots.start=[0, 1]"
    )
    said = complaint(Path(path), "robots.shared_last_visit=true")
    assert said == "line-patrol.toml: robots.shared_last_visit is for mission area only"


def test_the_command_line_refuses_a_graph_in_one_line(tmp_path, capsys):
    command = [
        "run",
        "graph-exact",
        "--in-process",
        "--out",
        str(tmp_path),
        "--set",
        "field.graph=gone.graph",
    ]
    assert carry_out(command) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1 and "gone.graph cannot be read: No such file" in said
    assert not list(tmp_path.iterdir())
