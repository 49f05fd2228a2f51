"""A surveillance graph and the team that draws it: robots on lines, counted apart from the graph."""

import numpy as np

from swarm_agent.surveillance_graph import SurveillanceGraph


def begun(*robots: int) -> SurveillanceGraph:
    """A first line that had so many robots, one after the other."""
    graph = SurveillanceGraph("r1")
    graph.begin(robots[0])
    for count in robots[1:]:
        graph.measure(count)
    return graph


class Team:
    """Robots on lines, counted on their own, that do at random what lines do; `stationary` by line."""

    def __init__(self, chance: np.random.Generator) -> None:
        self.chance = chance
        self.graph = SurveillanceGraph("r1")
        self.robots = self.some(2, 5)
        self.graph.begin(self.robots)
        self.stationary: dict[int, int] = {}
        self.blocking = 0
        """Of the main line: the fewest robots since its last vertex, 0 on the first ground."""

    def some(self, fewest: int, most: int) -> int:
        return int(self.chance.integers(fewest, most + 1))

    def act(self) -> str:
        """One random event; its name, or nothing when all is clear."""
        if self.graph.main is None:
            if not self.stationary:
                return ""
            line = sorted(self.stationary)[self.some(0, len(self.stationary) - 1)]
            if self.some(0, 3) == 0 and self.stationary[line] > 1:
                self.stationary[line] -= 1
                self.graph.tighten(line, self.stationary[line])
                return "tighten"
            self.graph.activate(line)
            self.robots = self.blocking = self.stationary.pop(line)
            return "activate"
        event = ("move", "move", "move", "split", "dissolve", "park", "meet")[self.some(0, 6)]
        return getattr(self, event)()

    def move(self) -> str:
        """One robot more or less; after more and then fewer the line has a new vertex behind it."""
        before, vertices = self.robots, len(self.graph.net)
        self.robots = max(1, self.robots + (1 if self.some(0, 1) else -1))
        self.graph.measure(self.robots)
        narrowed = len(self.graph.net) > vertices
        assert not narrowed or before > self.robots
        if narrowed:
            self.blocking = self.robots
        elif self.blocking:
            self.blocking = min(self.blocking, self.robots)
        return "narrowing" if narrowed else "move"

    def split(self) -> str:
        left, right = self.some(1, self.robots), self.some(1, self.robots)
        lines = self.graph.split(left, right)
        self.stationary.update(zip(lines, (left, right), strict=True))
        return "split"

    def dissolve(self) -> str:
        if len(self.graph.net) < 25 and not self.stationary:
            return self.move()
        assert self.graph.dissolve() == ()
        return "dissolve"

    def park(self) -> str:
        if not self.blocking or self.merged():
            return self.move()
        (line,) = self.graph.park(self.robots)
        self.stationary[line] = self.blocking
        return "park"

    def merged(self) -> bool:
        swept = self.graph.main.vertex
        return sum(self.graph.vertex(beside).clear for beside in self.graph.net[swept]) > 1

    def meet(self) -> str:
        if not self.stationary or not self.blocking:
            return self.move()
        line = min(self.stationary)
        met = self.stationary.pop(line)
        self.robots += met
        self.blocking += met
        self.graph.meet(line, self.robots)
        return "meet"
