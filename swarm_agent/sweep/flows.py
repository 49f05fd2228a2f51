"""What a line knows of itself, told from neighbour to neighbour, one hop a tick, from both of its ends."""

from swarm_agent.sweep import robust_line
from swarm_agent.sweep.radio import MOST, NOBODY, OTHER, SIDES, WALL, Flow, Side
from swarm_agent.sweep.robot import Robot


def hear(robot: Robot) -> None:
    """Take over what both neighbours tell, if they stand beside it too."""
    for side in SIDES:
        peer = robot.neighbour(side)
        held = peer is not None and peer.beacon.beside(OTHER[side]) == robot.number
        beacon = peer.beacon if held else None
        robot.told[side] = None if beacon is None else _about(beacon, side)


def tell(robot: Robot) -> None:
    """Add its own news to what is told from each end, and tell it on."""
    for side in SIDES:
        before = robot.told[side]
        is_end = robot.on_line and robot.beside[side] == WALL
        robot.flows[side] = _joined(robot, side, before) if is_end or (robot.on_line and before) else None


def _about(beacon, side: Side) -> Flow | None:
    return beacon.from_left if side == "left" else beacon.from_right


def _joined(robot: Robot, side: Side, before: Flow | None) -> Flow:
    own = Flow(
        1,
        robot.news_tick,
        robot.moved,
        robot.open,
        robot.halt,
        robot.pinned or robot.close,
        robot.pinned,
        wants(robot),
        spare(robot),
        robot.angle_rad,
        robot.order if side == "right" else 0,
        robot.taut if side == "left" else 0,
        robot.meets != NOBODY,
        robot.role == "leader" and robot.is_barred,
    )
    if before is None:
        return own
    return Flow(
        min(before.count + 1, MOST),
        min(before.since, own.since),
        max(before.moved, own.moved),
        before.open or own.open,
        before.halt or own.halt,
        before.pinned or own.pinned,
        before.pivot or own.pivot,
        before.want or own.want,
        min(before.spare + own.spare, MOST),
        before.angle_rad,
        before.order,
        max(before.taut, own.taut),
        before.meets or own.meets,
        before.barred,
    )


def wants(robot: Robot) -> bool:
    """Is there a gap beside the right leader that needs one more robot, or a pivot that needs a second?"""
    if robot.pinned:
        beside = [robot.neighbour(side) for side in SIDES]
        if robot.is_robust:
            return robust_line.wants_at(robot)
        return robot.is_main and not any(one and one.beacon.ready for one in beside)
    if robot.is_robust:
        return robust_line.wants(robot)
    right = robot.neighbour("right")
    if right is None or robot.old or robot.role == "leaving" or right.beacon.role != "leader":
        return False
    if right.beacon.left != robot.number:
        return False
    return abs(right.here - robot.here) > robot.parameters.follow_m or right.beacon.close


def spare(robot: Robot) -> int:
    """How many robots follow it in file."""
    tails = [
        peer.beacon.tail
        for peer in robot.peers.known.values()
        if peer.beacon.role == "reserve" and peer.beacon.ahead == robot.number
    ]
    return min(sum(tails), MOST)
