"""Proactive recall: which robot is called home for its battery's sake.

Source: papers/line-patrol.txt, Algorithm 3. The seed prints the upper threshold as b_i + e; b_l + e is meant.
"""

from collections.abc import Mapping

from wire.channels import number_of


def robot_to_recall(batteries_v: Mapping[str, float], low_v: float, margin_v: float) -> str | None:
    """The robot that Algorithm 3 recalls among these patrolling robots, or nobody.

    Equal batteries stand in order of node number. Of three that are nearly equal the second goes, as printed,
    so that never many are low at once. With two robots there is no third one to be near, so the first goes;
    a single robot goes only when it is below the lower threshold. Both are our reading.
    """
    nodes = sorted(batteries_v, key=lambda node: (batteries_v[node], number_of(node)))
    levels = [batteries_v[node] for node in nodes]
    if not nodes:
        return None
    if levels[0] < low_v:
        return nodes[0]
    if levels[0] >= low_v + margin_v or not _near(levels, 1, margin_v):
        return None
    return nodes[1] if _near(levels, 2, margin_v) else nodes[0]


def _near(levels: list[float], place: int, margin_v: float) -> bool:
    """Is the battery at this place of the list less than half a margin above the one before it?"""
    return place < len(levels) and levels[place] < levels[place - 1] + margin_v / 2
