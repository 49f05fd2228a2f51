"""What a field to be visited needs: sites that exist once, can be reached, and are not too many."""

import math

from deploy.mistake import Mistake
from wire.fields import Edge, Graph, Grid
from wire.scenario import Scenario

MAX_SITES = 2**16  # sites travel as uint16
SHORTEST_M, FARTHEST_M = 1e-3, 1e6


def check_field(field: Grid | Graph) -> None:
    """Raises Mistake for the first part of a field that does not fit."""
    if isinstance(field, Graph):
        _check_nodes(field)
        _check_edges(field)
    else:
        _check_cells(field)
    apart = _unreached(field)
    if apart is None:
        return
    if isinstance(field, Graph):
        raise Mistake(f"field.edges must connect all nodes, but no way leads from node 0 to node {apart}")
    first, other = field.cells[0], field.cells[apart]
    raise Mistake(f"field.holes must leave one piece, but cut cell {list(other)} off from {list(first)}")


def check_start(scenario: Scenario) -> None:
    """Raises Mistake where robots are to start at sites that do not exist."""
    start, robots = scenario.robots.start, len(scenario.robot_ids)
    if not isinstance(start, tuple):
        return
    if len(start) != robots or not robots:
        raise Mistake(f"robots.start must have one site for each of {robots} robots, got {len(start)}")
    sites = len(scenario.field.sites_m())
    for place, site in enumerate(start):
        if site >= sites:
            raise Mistake(f"robots.start[{place}] must be a site from 0 to {sites - 1}, got {site}")


def _check_cells(grid: Grid) -> None:
    seen: set[tuple[int, int]] = set()
    for number, hole in enumerate(grid.holes):
        place, got = f"field.holes[{number}]", f"got {list(hole)}"
        if hole[0] >= grid.columns or hole[1] >= grid.rows:
            last = f"[{grid.columns - 1}, {grid.rows - 1}]"
            raise Mistake(f"{place} must be a cell from [0, 0] to {last}, {got}")
        if hole in seen:
            raise Mistake(f"{place} must differ from those before it, {got}")
        seen.add(hole)
    _check_number(grid.columns * grid.rows - len(seen))


def _check_number(sites: int) -> None:
    if not 1 <= sites <= MAX_SITES:
        raise Mistake(f"field must have from 1 to {MAX_SITES} sites, got {sites}")


def _check_nodes(graph: Graph) -> None:
    _check_number(len(graph.nodes_m))
    seen: dict[tuple[float, float], int] = {}
    for number, node_m in enumerate(graph.nodes_m):
        place, got = f"field.nodes_m[{number}]", f"got {list(node_m)}"
        if not max(map(abs, node_m)) <= FARTHEST_M or any(map(math.isnan, node_m)):
            raise Mistake(f"{place} must be within {FARTHEST_M:g} m, {got}")
        if node_m in seen:
            raise Mistake(f"{place} must be another place than node {seen[node_m]}, {got}")
        seen[node_m] = number


def _check_edges(graph: Graph) -> None:
    seen: set[tuple[int, int]] = set()
    for number, edge in enumerate(graph.edges):
        place, got = f"field.edges[{number}]", f"got {list(edge[:2])}"
        if max(edge.start, edge.end) >= len(graph.nodes_m):
            raise Mistake(f"{place} must join nodes from 0 to {len(graph.nodes_m) - 1}, {got}")
        if edge.start == edge.end:
            raise Mistake(f"{place} must join two nodes, {got}")
        if edge[:2] in seen:
            raise Mistake(f"{place} must differ from those before it, {got}")
        seen.add(edge[:2])
        _check_length(place, edge)


def _check_length(place: str, edge: Edge) -> None:
    if edge.length_m is not None and not SHORTEST_M <= edge.length_m <= FARTHEST_M:
        raise Mistake(f"{place} must be from {SHORTEST_M:g} to {FARTHEST_M:g} m long, got {edge.length_m}")


def _unreached(field: Grid | Graph) -> int | None:
    """The first site to which no way leads from the first one; every edge leads both ways."""
    reached, coming = {0}, [0]
    while coming:
        for site, _ in field.neighbours(coming.pop()):
            if site not in reached:
                reached.add(site)
                coming.append(site)
    return next((site for site in range(len(field.sites_m())) if site not in reached), None)
