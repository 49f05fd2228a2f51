"""Hand-made facts of a line patrol: two segments, robots r2, r3 and r4, and a tower r1."""

import msgspec

from deploy.metrics.line import LineMetrics
from swarm_agent.line_radio import Report
from tests.builders import facts
from wire import codec
from wire.fields import Polyline
from wire.scenario import InQueue, Robots, Scenario

LINE = Polyline(((-10.0, 0.0), (10.0, 0.0)), 2, gap_m=2.0)
ALL_ALIVE = bytes(4)
R3_DEAD, R3_FLAT = bytes((0, 0, 2, 0)), bytes((0, 0, 3, 0))
LEFT, MID, RIGHT = 0, 1, 2


def plan(**fields) -> Scenario:
    """A tower r1, robots r2, r3 and r4, and two segments."""
    robots = Robots("stand_still", 3, start=InQueue())
    return Scenario(mission="line", duration_s=1000.0, field=LINE, robots=robots, **fields)


def fed(*ticks, fold: LineMetrics | None = None, **fields) -> LineMetrics:
    """A fold that has been fed ticks: (tick, {robot: (state, segment, laps)}, further facts)."""
    fold = fold or LineMetrics(plan(**fields))
    for tick, states, *rest in ticks:
        said = [
            (node, codec.encode(Report(state, segment, 9.0, laps=laps)))
            for node, (state, segment, laps) in states.items()
        ]
        what = {"modes": ALL_ALIVE} | (rest[0] if rest else {})
        fold.feed(msgspec.structs.replace(facts(tick, reports=said), **what))
    return fold


def visits(*told: tuple[str, int, int]) -> dict:
    """Facts of visits: (robot, segment, place)."""
    return {"visits": tuple((node, 3 * (segment - 1) + place) for node, segment, place in told)}


def queue(*robots: str) -> dict:
    return dict.fromkeys(robots, ("queue", 0, 0))


def patrol(**segments: int) -> dict:
    return {node: ("patrol", segment, 0) for node, segment in segments.items()}


DEPLOYED = (0, patrol(r2=1, r3=2) | queue("r4"))
