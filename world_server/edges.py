"""Bodies on a patrol graph: they are always on an edge or at a node, and take the cheapest way to their goal.

Along an edge a body goes at full speed by its length; where it is seen is in proportion on the straight line
between the nodes. Turning takes no time, nor does passing a node. All of this is our choice: it is what
event-driven simulations of patrolling on graphs assume (M2Bench, arXiv 2605.09633).
"""

import math
from typing import NamedTuple

from wire.fields import Graph, Point
from wire.messages import Follow, GoTo, Motion, Pose
from world_server.motion import Body

ROUNDING = 1e-6
"""Less than this share of a tick's way is rounding: a length of whole ticks takes exactly so many."""


class Routes:
    """The cheapest ways of a graph, found when they are first asked for."""

    def __init__(self, field: Graph) -> None:
        import networkx  # takes a while, and other fields do without it

        self.field = field
        self.number = {node_m: number for number, node_m in enumerate(field.nodes_m)}
        self.lengths_m = [dict(field.neighbours(node)) for node in range(len(field.nodes_m))]
        self._net = networkx.DiGraph()
        self._dijkstra = networkx.single_source_dijkstra_path_length
        self._net.add_nodes_from(range(len(field.nodes_m)))
        self._net.add_weighted_edges_from(  # against their direction: costs are asked for by goal
            (end, start, length_m)
            for start, lengths_m in enumerate(self.lengths_m)
            for end, length_m in lengths_m.items()
        )
        self._costs_m: dict[int, dict[int, float]] = {}

    def nearest(self, point: Point) -> int:
        """The node at a point, else the one that is nearest in a straight line; the lower of two."""
        nodes_m = self.field.nodes_m
        if (node := self.number.get(point)) is not None:
            return node
        return min(range(len(nodes_m)), key=lambda one: math.dist(nodes_m[one], point))

    def cost_m(self, node: int, goal: int) -> float:
        """The cost of the cheapest way."""
        if goal not in self._costs_m:
            self._costs_m[goal] = self._dijkstra(self._net, goal)
        return self._costs_m[goal][node]

    def next_node(self, node: int, goal: int) -> int:
        """Where the cheapest way to another node leads first; the lowest of equal ones."""
        lengths_m = self.lengths_m[node]
        return min(lengths_m, key=lambda one: lengths_m[one] + self.cost_m(one, goal))


class Stretch(NamedTuple):
    """Part of an edge that is behind a body: `gone_m` of its length."""

    start: int
    end: int
    length_m: float
    gone_m: float


class EdgeBody(Body):
    """A body that begins at the node nearest to its pose. Sent to any point, it goes to the nearest node.

    Sent to a neighbour of the node where it stands it takes the edge that leads there, even where another way
    costs less: what a behaviour asks `neighbours` for is what it gets. Told to stay it stands where it is, on
    an edge too; sent elsewhere from there it goes on or turns back, whichever way is cheaper.
    """

    def __init__(self, pose: Pose, max_speed_m_s: float, routes: Routes) -> None:
        super().__init__(pose, max_speed_m_s, 0.0)
        self._routes = routes
        self._stretch: Stretch | None = None
        self._stand_at(routes.nearest((pose.x_m, pose.y_m)))

    def command(self, motion: Motion | None) -> bool:
        """Take over a motion; None keeps the present one. True when it is already where it is sent."""
        if isinstance(motion, Follow):
            motion = GoTo(*motion.path_m[-1])
        if isinstance(motion, GoTo):
            node = self._routes.nearest((motion.x_m, motion.y_m))
            motion = GoTo(*self._routes.field.nodes_m[node], motion.within_m)
            if motion != self.goal:
                self._set_out(node)
        return super().command(motion)

    def advance(self, tick_s: float) -> None:
        """One tick along edges; what one leaves of the tick is spent on the next."""
        left_m = self._max_speed_m_s * tick_s
        rounding_m = ROUNDING * left_m
        while left_m > rounding_m and not self.at_rest:
            stretch = self._stretch or self._way_on()
            rest_m = stretch.length_m - stretch.gone_m
            if rest_m > left_m + rounding_m:
                self._stand_on(stretch._replace(gone_m=stretch.gone_m + left_m))
            else:
                self._stand_on(stretch)
                self._stand_at(stretch.end)
            left_m -= rest_m

    def _set_out(self, goal: int) -> None:
        """Begin the way to another node, from a node or from the middle of an edge."""
        stretch = self._stretch
        if stretch is not None and stretch.gone_m > 0:
            self._turn_if_cheaper(stretch, goal)
        else:
            self._stretch = self._edge(goal) if goal in self._routes.lengths_m[self._node] else None

    def _turn_if_cheaper(self, stretch: Stretch, goal: int) -> None:
        start, end, length_m, gone_m = stretch
        back_m = self._routes.lengths_m[end][start]
        returned_m = gone_m / length_m * back_m
        ahead_m = length_m - gone_m + self._routes.cost_m(end, goal)
        if returned_m + self._routes.cost_m(start, goal) < ahead_m:
            self._stand_on(Stretch(end, start, back_m, back_m - returned_m))

    def _way_on(self) -> Stretch:
        """The edge that leads from this node towards the goal."""
        goal = self._routes.number[self.goal.x_m, self.goal.y_m]
        return self._edge(self._routes.next_node(self._node, goal))

    def _edge(self, end: int) -> Stretch:
        return Stretch(self._node, end, self._routes.lengths_m[self._node][end], 0.0)

    def _stand_at(self, node: int) -> None:
        """Be at a node, exactly; the heading stays that of the edge by which it came."""
        self._node, self._stretch = node, None
        self.x_m, self.y_m = self._routes.field.nodes_m[node]

    def _stand_on(self, stretch: Stretch) -> None:
        """Be on an edge, in proportion on the straight line, heading along it."""
        start_m, end_m = (self._routes.field.nodes_m[node] for node in stretch[:2])
        share = stretch.gone_m / stretch.length_m
        self._stretch = stretch
        self.x_m = start_m[0] + share * (end_m[0] - start_m[0])
        self.y_m = start_m[1] + share * (end_m[1] - start_m[1])
        self.heading_rad = math.atan2(end_m[1] - start_m[1], end_m[0] - start_m[0])
