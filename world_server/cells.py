"""Visits: which robot completed which site of the field, judged by the world and not by what robots say."""

import math
from collections.abc import Mapping

from wire.fields import Field
from world_server.motion import Body


class Sites:
    """The places of a field that are to be visited.

    A visit is complete when a living robot is within reach of the site that it was heading for, once for
    each time it was sent there; sites that it merely passes do not count.
    Source: Kobayashi et al. 2025, section III-A.
    """

    def __init__(self, field: Field) -> None:
        self._within_m = field.visit_within_m
        self._number = {site: number for number, site in enumerate(field.sites_m())}

    def visits(self, awake: Mapping[str, Body]) -> tuple[tuple[str, int], ...]:
        """(node, site) for each of these robots that is at its goal, where the goal is a site."""
        found = []
        for node, body in awake.items():
            goal = body.goal
            site = None if goal is None else self._number.get((goal.x_m, goal.y_m))
            if site is not None and math.hypot(goal.x_m - body.x_m, goal.y_m - body.y_m) <= self._within_m:
                found.append((node, site))
        return tuple(found)
