"""The roster: what the tower knows of each robot, from what it heard, and who counts as lost."""

import math
from collections.abc import Iterator

import msgspec

from swarm_agent.line_radio import Report, State, Word
from wire.channels import number_of
from wire.messages import NodeId


class Robot(msgspec.Struct):
    """A robot as the tower knows it. `acknowledged`: the last order it has heard; `hops`: of its last report.

    `since_tick`: when it was first heard to be in its present state; `said_tick`: when it said so last.
    """

    node: str
    state: State
    segment: int
    battery_v: float
    low: bool
    acknowledged: int
    heard_tick: int
    said_tick: int
    since_tick: int
    hops: int = 0
    lost: bool = False

    @property
    def number(self) -> int:
        """The number in its name."""
        return number_of(self.node)

    @property
    def claims(self) -> int:
        """The segment that it patrols or is on the way to, or 0."""
        return self.segment if self.state in ("patrol", "out") and not self.low and not self.lost else 0


class Silence(msgspec.Struct, frozen=True):
    """When a silent robot counts as lost, in ticks.

    `answer` before it counts as lost after `after`, everybody is called. When `suspect` robots or more do not
    answer, or fell silent within `after` of each other, a split of the radio is likelier than that many
    deaths: until they are heard again they count as lost only after `split`. Ours.
    """

    after: int
    suspect: int
    split: int
    answer: int = 1


class Roster:
    """All robots that were ever heard of."""

    def __init__(self, silence: Silence) -> None:
        self._silence = silence
        self._robots: dict[str, Robot] = {}
        self._suspected: set[str] = set()
        self._called_tick = -1

    def __iter__(self) -> Iterator[Robot]:
        """All robots in order of their numbers, the lost ones too."""
        return iter(sorted(self._robots.values(), key=lambda one: one.number))

    def get(self, node: str) -> Robot | None:
        """What is known of one robot."""
        return self._robots.get(node)

    def present(self) -> list[Robot]:
        """All robots that are not lost, in order of their numbers."""
        return [one for one in self if not one.lost]

    def hear(self, tick: int, node: str, said_tick: int, report: Report, hops: int) -> bool:
        """Take over a robot's word of itself, unless a later one has come already. Is there anything new?"""
        before = self._robots.get(node)
        if before is not None:
            before.heard_tick = max(before.heard_tick, tick)
            self._suspected.discard(node)
            if said_tick < before.said_tick:
                return False
        word = (report.state, report.segment, report.battery_v, report.low, report.order)
        same_state = before is not None and before.state == report.state
        since_tick = before.since_tick if same_state else tick
        lost = before is not None and before.lost
        self._robots[node] = Robot(node, *word, tick, said_tick, since_tick, hops, lost)
        if before is None:
            return True
        known = (before.state, before.segment, before.battery_v, before.low, before.acknowledged)
        return known != word

    def lose(self, node: str) -> None:
        """Count a robot as lost."""
        if node in self._robots:
            self._robots[node].lost = True
            self._suspected.discard(node)

    def is_lost(self, node: str) -> bool:
        """Was this robot heard of, and does it count as lost?"""
        return node in self._robots and self._robots[node].lost

    def find(self, node: str) -> None:
        """A robot that was lost is there again."""
        if node in self._robots:
            self._robots[node].lost = False

    def forgive(self, tick: int) -> None:
        """Nobody could be heard until now: everybody's silence begins anew."""
        self._suspected.clear()
        for robot in self._robots.values():
            robot.heard_tick = tick

    @property
    def cut_off(self) -> frozenset[str]:
        """Robots that a split of the radio seems to keep from being heard."""
        return frozenset(self._suspected)

    def call(self, tick: int) -> None:
        """Everybody is called now, and answers if this is heard."""
        self._called_tick = tick

    def next_call_tick(self) -> int | None:
        """When everybody is to be called next, as somebody would soon count as lost who was not called."""
        due = [
            self._lost_tick(one) - self._silence.answer
            for one in self._robots.values()
            if not one.lost and one.node not in self._suspected and one.heard_tick > self._called_tick
        ]
        return min(due, default=None)

    def newly_lost(self, tick: int) -> list[str]:
        """Robots that count as lost from now on, in order of their numbers."""
        silent = [one for one in self if self._is_silent(tick, one)]
        for robot in silent:
            apart = [abs(one.heard_tick - robot.heard_tick) for one in silent]
            together = sum(ticks <= self._silence.after for ticks in apart)
            if together >= self._silence.suspect and not robot.lost:
                self._suspected.add(robot.node)
        return [one.node for one in silent if not one.lost and tick >= self._lost_tick(one)]

    def next_loss_tick(self) -> int | None:
        """When a robot may count as lost next, should nothing be heard until then."""
        return min((self._lost_tick(one) for one in self._robots.values() if not one.lost), default=None)

    def _is_silent(self, tick: int, robot: Robot) -> bool:
        """Not heard for long, or not in answer to the call?"""
        called = robot.heard_tick < self._called_tick <= tick - self._silence.answer
        return called or tick - robot.heard_tick >= self._silence.after

    def _lost_tick(self, robot: Robot) -> int:
        suspected = robot.node in self._suspected
        return robot.heard_tick + (self._silence.split if suspected else self._silence.after)


def can_be_true(tick: int, word: Word, segments: int) -> bool:
    """Is it a robot's word of itself, and of a line with so many segments?"""
    said = word.message
    if not isinstance(said, Report) or word.said_tick > tick:
        return False
    return said.segment <= segments and math.isfinite(said.battery_v) and _is_node(word.origin)


def _is_node(name: str) -> bool:
    try:
        msgspec.convert(name, NodeId)
    except msgspec.ValidationError:
        return False
    return True
