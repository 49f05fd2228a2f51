"""Robots on no line belong behind lines: who is ahead of one, because it went back, goes through it."""

import numpy as np

from swarm_agent.sweep.geometry import clearance_m, unit
from swarm_agent.sweep.moves import toward
from swarm_agent.sweep.robot import Link, Robot

GAP_M = 0.5  # between two robots is room for a third that goes through
BESIDE_M, NEAR_M = 0.35, 1.0
WIDTH_M = 0.12
MIDDLE = 0.25  # of a link, to both sides of its middle: there one may go through


def back_across(robot: Robot, only_main: bool) -> complex | None:
    """A step to behind the nearest link; None for who is there, or cannot go through.

    `only_main`: not through lines that stand, for it has just gone through one of these.
    """
    main = robot.graph.main
    links = [link for link in robot.links() if _far_m(robot, link) < NEAR_M]
    if only_main:
        links = [link for link in links if main is not None and link[0].beacon.line == main.line]
    if not links:
        return None
    left, right = min(links, key=lambda link: _far_m(robot, link))
    ahead = 1j * unit(right.here - left.here)
    ahead_m = ((robot.here - left.here) / ahead).real
    if ahead_m <= 0 or abs(right.here - left.here) < GAP_M:
        return None
    middle = (left.here + right.here) / 2
    aside_m = abs(((robot.here - middle) / ahead).imag)
    through = aside_m < MIDDLE * abs(right.here - left.here)
    goal = middle + (-BESIDE_M if through else BESIDE_M) * ahead
    if clearance_m(robot.walls(left, right), robot.here, goal) < WIDTH_M:
        return None
    return toward(robot, goal) or None


def _far_m(robot: Robot, link: Link) -> float:
    """How far it is from a link."""
    left, right = link
    return clearance_m(np.array([robot.here]), left.here, right.here)
