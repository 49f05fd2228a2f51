"""Where robots must stand so that a chain of short links reaches a site, and the way there through free sites.

Ours. A link is as long as `reach_m` at most; a chain begins at the tower.
"""

import heapq
import math
from typing import NamedTuple

import numpy as np

from wire.fields import Field

Point = tuple[float, float]
OUT_OF_REACH = 2**31
ROUNDING_M = 1e-6


class RelayPosts:
    """The sites of a field as places to stand: how many links each is from the tower, and through which sites.

    `links`: int64, (sites,): 1 within `reach_m` of the tower, one more for each relay; OUT_OF_REACH where no
    chain of any length leads.
    """

    def __init__(self, sites_m: np.ndarray, tower_m: Point, reach_m: float) -> None:
        self._sites_m, self._tower_m, self._reach_m = sites_m, np.array(tower_m), reach_m + ROUNDING_M
        self.links = np.full(len(sites_m), OUT_OF_REACH)
        self._before = np.full(len(sites_m), -1)
        edge = np.flatnonzero(self.near(tower_m))
        self.links[edge] = links = 1
        while len(edge):
            links += 1
            ahead = [
                site for site in np.flatnonzero(self.links == OUT_OF_REACH) if self._hang(site, edge, links)
            ]
            edge = np.array(ahead, dtype=np.int64)
            self.links[edge] = links

    def near(self, *points_m: Point) -> np.ndarray:
        """The sites within reach of all these points: bool, (sites,)."""
        reached = np.ones(len(self._sites_m), dtype=bool)
        for x_m, y_m in points_m:
            away_m = self._sites_m - (x_m, y_m)
            reached &= np.hypot(away_m[:, 0], away_m[:, 1]) <= self._reach_m
        return reached

    def chain(self, site: int) -> list[int]:
        """Where the first, second, ... robot of a chain to this site stands; the last one stands on it."""
        posts = [site]
        while self._before[posts[0]] >= 0:
            posts.insert(0, int(self._before[posts[0]]))
        return posts

    def around(self, posts: list[int], place: int) -> np.ndarray:
        """Where the robot in this place of a chain (0 is next to the tower) may be: bool, (sites,).

        The last one must be on its post; for the others it is enough to be within reach of the posts before
        and behind.
        """
        if place == len(posts) - 1:
            return np.arange(len(self._sites_m)) == posts[place]
        before = self._tower_m if place == 0 else self._sites_m[posts[place - 1]]
        return self.near(before, self._sites_m[posts[place + 1]])

    def _hang(self, site: int, edge: np.ndarray, links: int) -> bool:
        """Find the post before a site that is so many links away: near the point that divides the way evenly."""
        away_m = self._sites_m[edge] - self._sites_m[site]
        edge = edge[np.hypot(away_m[:, 0], away_m[:, 1]) <= self._reach_m]
        if not len(edge):
            return False
        ideal_m = self._tower_m + (self._sites_m[site] - self._tower_m) * (links - 1) / links
        off_m = self._sites_m[edge] - ideal_m
        self._before[site] = edge[np.argmin(np.hypot(off_m[:, 0], off_m[:, 1]))]
        return True


class Ways(NamedTuple):
    """Shortest ways from one site. `far_m`: float64, (sites,), infinite where none leads; `_from`: the site before."""

    start: int
    far_m: np.ndarray
    came_from: list[int]

    def first_step(self, site: int) -> int:
        """The neighbour of the start on the way to a site that can be reached; the start itself for itself."""
        while site != self.start and self.came_from[site] != self.start:
            site = self.came_from[site]
        return site


class Roads:
    """The ways between the sites of a field."""

    def __init__(self, field: Field) -> None:
        self._neighbours = [field.neighbours(site) for site in range(len(field.sites_m()))]

    def ways(self, start: int, free: np.ndarray) -> Ways:
        """The shortest ways from a site that lead through `free` sites only (Dijkstra); equal ones by number."""
        open_sites = free.tolist()
        far_m, came_from = [math.inf] * len(open_sites), [-1] * len(open_sites)
        far_m[start] = 0.0
        queue = [(0.0, start)]
        while queue:
            here_m, here = heapq.heappop(queue)
            if here_m > far_m[here]:
                continue
            for site, cost_m in self._neighbours[here]:
                there_m = here_m + cost_m
                if open_sites[site] and there_m < far_m[site]:
                    far_m[site], came_from[site] = there_m, here
                    heapq.heappush(queue, (there_m, site))
        return Ways(start, np.array(far_m), came_from)
