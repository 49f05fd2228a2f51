"""The surveillance graph of mission clear, as it is drawn: a tree from left to right in a view of its own."""

from collections.abc import Iterator

import networkx

from deploy.scenes.mission import GREEN, GREY, ORANGE, RED, VIOLET, WHITE, Colour, Point, Sketch
from swarm_agent.graph_copy import Delta, Edge, Vertex

CANVAS = (480.0, 250.0)
"""Width and height of the drawing, in units of the view's own."""
FOOT = 25.0
"""Room below it for a line of words."""
WIDEST_STEP, WIDEST_ROW = 130.0, 50.0
"""Small graphs are not pulled apart farther than that."""
MARGIN = 30.0


def sketched(graph: Delta, words: str = "") -> Sketch:
    """Vertices with their weights in the colours of their states; between them the weights of edges.

    Edges have no words and colours in Rerun's graphs, so each has a box of its own in its middle; and so have
    the `words` below.
    """
    places = _places(graph)
    swept = graph.main.vertex if graph.main else None
    names = [f"v{vertex.number}" for vertex in graph.vertices]
    labels = [f"v{vertex.number}: {vertex.robots}" for vertex in graph.vertices]
    colours = [WHITE if vertex.number == swept else _state(vertex) for vertex in graph.vertices]
    points = [places[vertex.number] for vertex in graph.vertices]
    links = []
    for edge in graph.edges:
        name = f"e{edge.low}-{edge.high}"
        links += [(f"v{edge.low}", name), (name, f"v{edge.high}")]
        (low_x, low_y), (high_x, high_y) = places[edge.low], places[edge.high]
        names.append(name)
        labels.append(f"line {edge.line}: {edge.robots}" if edge.line else str(edge.robots))
        colours.append(_hold(edge))
        points.append(((low_x + high_x) / 2, (low_y + high_y) / 2))
    if words:
        names.append("words")
        labels.append(words)
        colours.append(GREY)
        points.append((CANVAS[0] / 2, CANVAS[1] + FOOT / 2))
    return Sketch(tuple(names), tuple(points), tuple(labels), tuple(colours), tuple(links))


def _state(vertex: Vertex) -> Colour:
    if vertex.clear:
        return GREEN
    return ORANGE if vertex.explored else RED


def _hold(edge: Edge) -> Colour:
    if edge.line:
        return ORANGE
    return VIOLET if edge.kind == "cycle" else GREY


def _places(graph: Delta) -> dict[int, Point]:
    """Where vertices stand on the canvas: steps from the first one to the right, branches below another."""
    net = networkx.Graph()
    net.add_nodes_from(vertex.number for vertex in graph.vertices)
    net.add_edges_from((edge.low, edge.high) for edge in graph.edges)
    grid: dict[int, tuple[int, float]] = {}
    row = 0
    for part in sorted(networkx.connected_components(net), key=min):
        tree = networkx.bfs_tree(net, min(part), sort_neighbors=sorted)
        for number, step, leaf in _leaves_first(tree, min(part)):
            below = [grid[child][1] for child in tree[number]]
            grid[number] = (step, sum(below) / len(below) if below else float(row))
            row += leaf
    width, height = CANVAS
    steps = max((step for step, _ in grid.values()), default=0)
    across = min(WIDEST_STEP, (width - 2 * MARGIN) / max(1, steps))
    down = min(WIDEST_ROW, (height - MARGIN) / max(1, row - 1))
    left, top = (width - across * steps) / 2, (height - down * max(0, row - 1)) / 2
    return {number: (left + across * step, top + down * at) for number, (step, at) in grid.items()}


def _leaves_first(tree: networkx.DiGraph, root: int) -> Iterator[tuple[int, int, bool]]:
    """Every vertex after its children: its number, its steps from the root, and whether it is a leaf."""
    steps = networkx.single_source_shortest_path_length(tree, root)
    for number in networkx.dfs_postorder_nodes(tree, root):
        yield number, steps[number], not tree[number]
