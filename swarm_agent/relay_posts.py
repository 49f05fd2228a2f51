"""Where robots must stand so that a chain of short links reaches a site, and the ways between sites.

Ours. A link is at most `reach_m` long, and a chain begins at the tower. From each post a way must lead to the
next along which the link to the first holds: on a graph what is near need not be reached so.
"""

import heapq
import math
from typing import NamedTuple

import numpy as np

from wire.fields import Field

Point = tuple[float, float]
OUT_OF_REACH = 2**31
ROUNDING_M = 1e-6


class Ways(NamedTuple):
    """Shortest ways from `start`. `far_m`: float64, (sites,), infinite where no way leads."""

    start: int
    far_m: np.ndarray
    came_from: list[int]

    def first_step(self, site: int) -> int:
        """The neighbour of the start on the way to a site; the start itself where there is none."""
        if math.isinf(self.far_m[site]):
            return self.start
        while site != self.start and self.came_from[site] != self.start:
            site = self.came_from[site]
        return site


class Roads:
    """The ways between the sites of a field."""

    def __init__(self, field: Field) -> None:
        self._neighbours = [field.neighbours(site) for site in range(len(field.sites_m()))]

    def ways(self, start: int, free: np.ndarray) -> Ways:
        """The shortest ways from a site through `free` sites (Dijkstra); of equal ones the first found."""
        is_free = free.tolist()
        far_m, came_from = [math.inf] * len(is_free), [-1] * len(is_free)
        far_m[start] = 0.0
        queue = [(0.0, start)]
        while queue:
            here_m, here = heapq.heappop(queue)
            if here_m > far_m[here]:
                continue
            for site, cost_m in self._neighbours[here]:
                there_m = here_m + cost_m
                if is_free[site] and there_m < far_m[site]:
                    far_m[site], came_from[site] = there_m, here
                    heapq.heappush(queue, (there_m, site))
        return Ways(start, np.array(far_m), came_from)


class RelayPosts:
    """The sites of a field as places to stand.

    `links`: int64, (sites,): how many links, and robots, a chain to the site has: 1 within `reach_m` of
    the tower; OUT_OF_REACH where no chain leads.
    """

    def __init__(self, sites_m: np.ndarray, roads: Roads, tower_m: Point, reach_m: float) -> None:
        self._sites_m, self._tower_m, self._reach_m = sites_m, np.array(tower_m), reach_m + ROUNDING_M
        self.links = np.full(len(sites_m), OUT_OF_REACH)
        self._before = np.full(len(sites_m), -1)
        home = int(np.argmin(self._away_m(tower_m)))
        reached = np.isfinite(roads.ways(home, self.near(tower_m)).far_m) & self.near(tower_m)
        links = 1
        while reached.any():
            self.links[reached] = links
            links += 1
            reached = self._behind(np.flatnonzero(reached), roads, links)

    def near(self, *points_m: Point) -> np.ndarray:
        """The sites within reach of all these points: bool, (sites,)."""
        reached = np.ones(len(self._sites_m), dtype=bool)
        for point_m in points_m:
            reached &= self._away_m(point_m) <= self._reach_m
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

    def _behind(self, posts: np.ndarray, roads: Roads, links: int) -> np.ndarray:
        """The sites that are so many links away: within reach of one of these posts, and of no post before.

        Of several posts the one is taken that divides the way from the tower most evenly.
        """
        open_sites = np.flatnonzero(self.links == OUT_OF_REACH)
        ideal_m = self._tower_m + (self._sites_m[open_sites] - self._tower_m) * ((links - 1) / links)
        least_m = np.full(len(open_sites), np.inf)
        for post in posts.tolist():
            near = self.near(self._sites_m[post])
            if not near[open_sites].any():
                continue
            leads = np.isfinite(roads.ways(post, near).far_m)[open_sites]
            off_m = np.hypot(*(ideal_m - self._sites_m[post]).T)
            better = leads & (off_m < least_m)
            least_m[better] = off_m[better]
            self._before[open_sites[better]] = post
        behind = np.zeros(len(self.links), dtype=bool)
        behind[open_sites[np.isfinite(least_m)]] = True
        return behind

    def _away_m(self, point_m: Point) -> np.ndarray:
        away_m = self._sites_m - point_m
        return np.hypot(away_m[:, 0], away_m[:, 1])
