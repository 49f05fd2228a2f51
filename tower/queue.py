"""The queue at the tower: robots wait there, first come, first sent.

Source: papers/line-patrol.txt, section III: extra robots are queued at the tower until they are needed.
"""

from collections.abc import Iterable

from tower.roster import Robot


def in_line(robots: Iterable[Robot], ordered: Iterable[str] = ()) -> list[Robot]:
    """Who waits, in order of arrival, ties by number; who is `ordered` to go somewhere waits no longer."""
    away = set(ordered)
    waiting = [one for one in robots if one.state == "queue" and not one.lost and one.node not in away]
    return sorted(waiting, key=lambda one: (one.since_tick, one.number))


def ready(robots: Iterable[Robot], ordered: Iterable[str], ready_v: float) -> list[Robot]:
    """Those in line whose battery is good for a patrol."""
    return [one for one in in_line(robots, ordered) if one.battery_v >= ready_v]
