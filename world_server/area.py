"""Mission "area" as the world plays it: bodies pass each other freely on their way to their sites.

On a grid they drive straight to wherever they are sent, on a graph along its edges.
"""

import numpy as np

from wire.fields import Graph
from wire.messages import Pose
from wire.scenario import Scenario
from world_server.cells import Sites
from world_server.edges import EdgeBody, Routes
from world_server.mission import Mission, Pairs, Visits
from world_server.motion import Body
from world_server.nodes import ALIVE


class Area(Mission):
    """Bodies drive to sites, and whoever arrives has visited."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario)
        field = scenario.field
        self._sites = Sites(field)
        self._routes = Routes(field) if isinstance(field, Graph) else None
        self._visited_tick = np.zeros(len(field.sites_m()), dtype="<u4")

    def body(self, name: str, pose: Pose) -> Body:
        """The body of a node."""
        scenario = self._scenario
        if name == scenario.tower.id:
            return Body(pose, 0.0, 0.0)
        if self._routes is not None:
            return EdgeBody(pose, scenario.robots.max_speed_m_s, self._routes)
        return Body(pose, scenario.robots.max_speed_m_s, scenario.robots.max_turn_rad_s)

    @property
    def restless(self) -> bool:
        """Is the next tick to be settled even though nobody moves or is due?"""
        return bool(self._complete())

    def last_visits(self, tick: int) -> bytes:
        """What robots sense of visits as a tick begins, as Senses have it: nothing unless it is granted."""
        if not self._scenario.robots.shared_last_visit:
            return b""
        visited_tick = self._visited_tick.copy()
        visited_tick[[site for _, site in self._complete()]] = tick
        return visited_tick.tobytes()

    def visits(self, tick: int) -> Visits:
        """The visits that are complete as the tick begins; each counts once."""
        visits = self._complete()
        if visits:
            done = {name for name, _ in visits}
            for node in self._nodes:
                node.on_patrol = node.on_patrol and node.name not in done
            self._visited_tick[[site for _, site in visits]] = tick
        return visits

    def settle(self, tick: int) -> tuple[Visits, Pairs]:
        """One tick of all bodies. Returns further visits of the tick, and who has come too close to whom."""
        for node in self._nodes:
            arrived = node.body.arrived
            node.body.advance(self._scenario.tick_s)
            if node.body.arrived and not arrived:
                node.arrival_pending = True
        return (), ()

    def _complete(self) -> Visits:
        on_patrol = {node.name: node.body for node in self._nodes if node.mode == ALIVE and node.on_patrol}
        return self._sites.visits(on_patrol)
