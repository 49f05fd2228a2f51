"""The field of a scenario, whole: files are read in, so that nothing needs the file again.

Our own graph files are TOML with two fields: `nodes_m`, a list of [x_m, y_m], and `edges`, a list of
[start, end] or [start, end, length_m]. All other files are read as `.graph` files of patrolling_sim.
"""

import tomllib
from pathlib import Path

import msgspec

from deploy.explain import explain
from deploy.graph_file import GraphFileError, read_graph
from deploy.mistake import Mistake
from wire.fields import Edge, Field, FloorPlan, Graph, Point
from wire.scenario import Scenario, Sensors


class GraphToml(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a graph file of our own says; a Graph has the meaning."""

    nodes_m: tuple[Point, ...]
    edges: tuple[Edge, ...] = ()


def whole(scenario: Scenario) -> Field:
    """The scenario's field with all that is in the file it names. Raises Mistake."""
    field = scenario.field
    if isinstance(field, Graph):
        return whole_graph(field)
    return _whole_plan(field, scenario) if isinstance(field, FloorPlan) else field


def _whole_plan(field: FloorPlan, scenario: Scenario) -> FloorPlan:
    """The plan's rings; of a random plan those that robots with these senses and parameters can clear."""
    from deploy.clear_checks import obstacle_m  # polygons take a while to import
    from deploy.plan_file import read_plan, rings_of
    from world_server.floorplan import PlanError
    from world_server.random_plans import random_plan

    given = [name for name in ("plan", "random", "rings_m") if getattr(field, name)]
    if len(given) != 1:
        raise Mistake(f"field must have one of plan, random and rings_m, got {' and '.join(given) or 'none'}")
    if field.metres_per_px is not None and not field.plan:
        raise Mistake("field.metres_per_px is for a picture as plan only")
    if field.rings_m:
        return field
    try:
        if field.plan:
            rings_m = rings_of(read_plan(Path(field.plan), field.metres_per_px))
        else:
            drawn, detect_m = field.random, (scenario.sensors or Sensors()).detect_m
            rooms = (drawn.columns, drawn.rows)
            rings_m = rings_of(random_plan(drawn.seed, rooms, drawn.islands, obstacle_m(scenario), detect_m))
    except PlanError as error:
        raise Mistake(f"field.random: {error}") from None
    except Mistake as mistake:
        raise Mistake(f"field.plan: {mistake}") from None
    return FloorPlan(rings_m=rings_m, turned_rad=field.turned_rad)


def whole_graph(field: Graph) -> Graph:
    """The graph with all nodes and edges of the file it names, and all lengths. Raises Mistake."""
    inline = bool(field.nodes_m or field.edges)
    if bool(field.graph) == inline:
        got = "both" if inline else "neither"
        raise Mistake(f"field must have either graph, a file, or nodes_m and edges, got {got}")
    if field.graph:
        given = _read(Path(field.graph))
        field = msgspec.structs.replace(field, graph="", nodes_m=given.nodes_m, edges=given.edges)
    return msgspec.structs.replace(field, edges=tuple(_measured(field, edge) for edge in field.edges))


def _read(path: Path) -> GraphToml:
    try:
        content = path.read_bytes()
    except (OSError, ValueError) as error:  # a name that no file can have is a ValueError
        why = getattr(error, "strerror", None) or "no file can be called that"
        raise Mistake(f"field.graph: {path} cannot be read: {why}") from None
    try:
        return _ours(content) if path.suffix == ".toml" else _theirs(content, path.name)
    except GraphFileError as error:
        raise Mistake(f"field.graph: {error}") from None
    except Mistake as mistake:
        raise Mistake(f"field.graph: {path.name}: {mistake}") from None


def _ours(content: bytes) -> GraphToml:
    try:
        document = tomllib.loads(content.decode("utf-8"))
        return msgspec.convert(document, GraphToml)
    except UnicodeDecodeError as error:
        raise Mistake(f"not UTF-8 text (byte {error.start}); a graph of ours is TOML") from None
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise Mistake(f"not valid TOML: {error}") from None
    except msgspec.ValidationError as error:
        raise Mistake(explain(str(error), document, GraphToml)) from None


def _theirs(content: bytes, file: str) -> GraphToml:
    """A way back that costs the same is the same edge."""
    graph = read_graph(content, file)
    costs_m = {(node.id, arc.neighbour): arc.cost_m for node in graph.nodes for arc in node.arcs}
    for start, end in costs_m:
        if (end, start) not in costs_m:
            raise Mistake(f"node {end}: there must be a way back to node {start}, got none")
    edges = [
        Edge(start, end, cost_m)
        for (start, end), cost_m in costs_m.items()
        if start < end or costs_m.get((end, start)) != cost_m
    ]
    return GraphToml(tuple((node.x_m, node.y_m) for node in graph.nodes), tuple(edges))


def _measured(field: Graph, edge: Edge) -> Edge:
    """The edge with its length; one whose nodes do not exist stays as it is, for the checks to refuse."""
    known = max(edge.start, edge.end) < len(field.nodes_m)
    straight = field.lengths == "straight" or edge.length_m is None
    return edge._replace(length_m=field.straight_m(edge)) if known and straight else edge
