"""The radio: a list of rules, each of which passes a transmission on, drops it, or delays it.

A transmission is one frame on its way to one receiver. All transmissions of a tick are judged together, as
columns, on the positions settled in that tick. The first rule that does not pass a transmission on decides.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from wire.channels import number_of
from wire.scenario import Latency, Loss, Partition, RadioSection, Range, Scenario
from world_server.chance import generator

PASS, DROP = -1, 0


class Transmissions(NamedTuple):
    """All (frame, receiver) pairs of one tick: rows of both nodes, and the frame's place in the outbox.

    `apart_m`: (nodes, nodes) distances between the settled positions.
    """

    tick: int
    senders: np.ndarray
    frames: np.ndarray
    receivers: np.ndarray
    apart_m: np.ndarray


class Deliveries(NamedTuple):
    """What gets through: columns of sender row, frame, receiver row and the tick at which it is heard."""

    senders: np.ndarray
    frames: np.ndarray
    receivers: np.ndarray
    heard_tick: np.ndarray


class Tally(NamedTuple):
    """Counts of one tick, in the order of Facts.radio."""

    sent: int
    delivered: int
    out_of_range: int
    lost: int
    oversize: int
    bytes: int


_NONE = np.empty(0, dtype=np.int64)
NOTHING = Deliveries(_NONE, _NONE, _NONE, _NONE), Tally(0, 0, 0, 0, 0, 0)
"""A tick in which nobody says anything."""

Rule = Callable[[Transmissions], np.ndarray]
"""From transmissions to verdicts: PASS, DROP, or the number of ticks until the frame is heard."""


class Radio:
    """The rules of a scenario, ready to judge."""

    def __init__(self, section: RadioSection, nodes: Sequence[str], seed: int, tick_s: float) -> None:
        self._nodes = nodes
        self._limit = section.bytes_per_tick
        numbered = enumerate(section.rules)
        self._rules = [(rule, _make(place, rule, nodes, seed, tick_s)) for place, rule in numbered]

    def transmit(
        self,
        tick: int,
        outboxes: Mapping[int, Sequence[bytes]],
        apart_m: np.ndarray,
        deaf: Sequence[int] = (),
    ) -> tuple[Deliveries, dict[int, int], Tally]:
        """Judge the outboxes (by row) of one tick on the settled distances, (nodes, nodes).

        `deaf`: rows that cannot hear. Returns the deliveries, the number of frames refused per row for the
        byte limit, and the counts.
        """
        accepted, refused, spent = self._within_limit(outboxes)
        sent = _pairs(tick, accepted, apart_m, deaf)
        delay = np.full(len(sent.senders), PASS)
        out_of_range = 0
        for description, rule in self._rules:
            open_pairs = delay == PASS
            verdict = np.where(open_pairs, rule(sent), delay)
            if isinstance(description, Range):
                out_of_range += int(np.count_nonzero(open_pairs & (verdict == DROP)))
            delay = verdict
        delay[delay == PASS] = 1
        through = delay > DROP
        deliveries = Deliveries(
            sent.senders[through], sent.frames[through], sent.receivers[through], tick + delay[through]
        )
        delivered = int(np.count_nonzero(through))
        lost = len(delay) - delivered - out_of_range
        frames = sum(len(outbox) for outbox in accepted.values())
        tally = Tally(frames, delivered, out_of_range, lost, sum(refused.values()), spent)
        return deliveries, refused, tally

    def _within_limit(
        self, outboxes: Mapping[int, Sequence[bytes]]
    ) -> tuple[dict[int, Sequence[bytes]], dict[int, int], int]:
        """Frames that fit into each sender's bytes per tick, in their order; and how many did not."""
        accepted, refused, spent = {}, {}, 0
        for row, outbox in outboxes.items():
            used, fitting = 0, 0
            for frame in outbox:
                if used + len(frame) > self._limit:
                    break
                used, fitting = used + len(frame), fitting + 1
            accepted[row] = outbox[:fitting]
            spent += used
            if fitting < len(outbox):
                refused[row] = len(outbox) - fitting
        return accepted, refused, spent


def for_scenario(scenario: Scenario) -> Radio:
    """The radio of a scenario."""
    return Radio(scenario.radio, scenario.node_ids, scenario.seed, scenario.tick_s)


def distances_m(positions_m: np.ndarray) -> np.ndarray:
    """All distances between positions (nodes, 2): (nodes, nodes)."""
    away = positions_m[:, None, :] - positions_m[None, :, :]
    return np.sqrt(away[..., 0] ** 2 + away[..., 1] ** 2)


def _pairs(
    tick: int, outboxes: Mapping[int, Sequence[bytes]], apart_m: np.ndarray, deaf: Sequence[int]
) -> Transmissions:
    """Every frame paired with every node that could hear it, in order of sender, frame, receiver."""
    nodes = len(apart_m)
    frames = [(row, index) for row in sorted(outboxes) for index in range(len(outboxes[row]))]
    rows, indices = np.array(frames, dtype=np.int64).reshape(-1, 2).T
    hears = np.ones((len(frames), nodes), dtype=bool)
    hears[np.arange(len(frames)), rows] = False
    if deaf:
        hears[:, deaf] = False
    frame, receivers = hears.nonzero()
    return Transmissions(tick, rows[frame], indices[frame], receivers, apart_m)


def _make(
    place: int, rule: Range | Loss | Latency | Partition, nodes: Sequence[str], seed: int, tick_s: float
) -> Rule:
    match rule:
        case Range(range_m=range_m):
            return lambda sent: np.where(sent.apart_m[sent.senders, sent.receivers] <= range_m, PASS, DROP)
        case Loss(probability=probability):
            return lambda sent: _lose(sent, probability, nodes, seed, place)
        case Latency(ticks=ticks):
            return lambda sent: np.full(len(sent.senders), ticks)
        case Partition():
            return _partition(rule, nodes, tick_s)


def _lose(sent: Transmissions, probability: float, nodes: Sequence[str], seed: int, place: int) -> np.ndarray:
    """Draw for every frame and every possible receiver, so that who else is there changes nobody's luck.

    `place` of the rule in the list: two rules draw independently.
    """
    verdict = np.full(len(sent.senders), PASS)
    if probability == 0:
        return verdict
    for row in np.unique(sent.senders).tolist():
        own = sent.senders == row
        chance = generator(seed, "loss", number_of(nodes[row]), sent.tick, place)
        draws = chance.random((int(sent.frames[own].max()) + 1, len(nodes)))
        verdict[own] = np.where(draws[sent.frames[own], sent.receivers[own]] < probability, DROP, PASS)
    return verdict


def _partition(rule: Partition, nodes: Sequence[str], tick_s: float) -> Rule:
    """Nothing passes between groups while the partition lasts; nodes in no group form one of their own."""
    group_of = {node: number for number, group in enumerate(rule.groups, start=1) for node in group}
    groups = np.array([group_of.get(node, 0) for node in nodes])
    until_s = float("inf") if rule.until_s is None else rule.until_s

    def judge(sent: Transmissions) -> np.ndarray:
        lasting = rule.from_s <= sent.tick * tick_s < until_s
        apart = groups[sent.senders] != groups[sent.receivers]
        return np.where(apart & lasting, DROP, PASS)

    return judge
