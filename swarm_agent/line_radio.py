"""What robots and tower of a line patrol say to each other, and how it travels hop by hop along the line.

Source: reports and orders as in papers/line-patrol.txt, section III (Algorithms 2 and 3); the paper
sends all messages directly, the flooding is ours. What is said goes out as one frame; who hears it and stands
further along in its direction says it again, once, until it is too old or has come too far.
"""

from collections.abc import Iterable, Sequence
from typing import Annotated, Literal, NamedTuple

import msgspec

from swarm_agent.behaviour import Heard

State = Literal["queue", "out", "patrol", "home"]
"""Waiting at the tower; on the way to a segment; patrolling it; on the way to the tower."""
Tick = Annotated[int, msgspec.Meta(ge=0, le=2**53)]
SegmentNumber = Annotated[int, msgspec.Meta(ge=0, le=1000)]
Metres = Annotated[float, msgspec.Meta(ge=0, le=1e9)]
Name = tuple[str, int, int]
"""Of an envelope: origin, said_tick and number."""
AGAIN_TICKS = 5
"""A report that nobody was heard to carry on is said again after so many ticks."""


class Report(msgspec.Struct, frozen=True, array_like=True, tag="report"):
    """A robot's word of itself: what it does, where (segment 0: none), and its charge.

    `order`: number of the last order it has heard; `laps` since it took the segment; `low`: it goes home for
    its battery's sake; `hops`: how many hops that order took.
    """

    state: State
    segment: SegmentNumber
    battery_v: Annotated[float, msgspec.Meta(ge=0, le=1000)]
    order: Tick = 0
    laps: Tick = 0
    low: bool = False
    hops: Tick = 0


class Order(msgspec.Struct, frozen=True, array_like=True, tag="order"):
    """The tower's word to one robot: take this segment, or, with segment 0, come home after this lap.

    Numbers grow for ever, over restarts of the tower too; the highest one holds.
    """

    number: Tick
    to: str
    segment: SegmentNumber


class Roll(msgspec.Struct, frozen=True, array_like=True, tag="roll"):
    """The tower is there. With `answer` every robot is to report at once."""

    answer: bool = False


class Envelope(msgspec.Struct, frozen=True, array_like=True):
    """A message on its way. `origin`, `said_tick` and `number` name it; who has seen it is done with it.

    `distance_m`: how far from the tower, along the line, whoever sent this copy stands. `relay`: is it to be
    said again? A report travels towards the tower, everything else away from it.
    """

    origin: str
    said_tick: Tick
    number: Tick
    message: Report | Order | Roll
    distance_m: Metres
    relay: bool = False
    hops: Tick = 0


class Word(NamedTuple):
    """A message that is new to this node."""

    origin: str
    said_tick: int
    message: Report | Order | Roll
    hops: int


class Place(NamedTuple):
    """Where a node stands: `distance_m` from the tower along the line, `apart_m` straight.

    Who `waits` in the queue passes nothing on: from wherever it is heard on the line, the tower is too.
    """

    distance_m: float
    apart_m: float
    waits: bool = False


class Relay:
    """A node's part in the flooding: what is new, what must be said again, and is the tower in range?

    Contact is the tower's own voice, heard lately and from no nearer: who drives away from the tower leaves
    its range before long. What is said where there is contact the tower hears; it need not be said again.

    The line has a hole while a segment is vacant. A report is kept, and said again, until a copy is heard
    from nearer the tower: so it gets across when the hole closes. Who carried it on may drive outward with
    it; whoever hears it from there later takes it up again. Orders the tower repeats itself.
    """

    def __init__(self, node: str, tower: str, age_ticks: int, hops_most: int, contact_ticks: int) -> None:
        self._node, self._tower = node, tower
        self._age_ticks, self._hops_most, self._contact_ticks = age_ticks, hops_most, contact_ticks
        self._seen: dict[Name, int] = {}
        """When each message was last said here, or heard from further on its way."""
        self._contact: tuple[int, float] | None = None
        """When the tower was heard, and the straight distance up to which that counts."""
        self._onward: list[Envelope] = []
        self._kept: dict[Name, tuple[Envelope, int]] = {}
        """Reports that nobody was heard to carry on yet, and when they are said again."""
        self._said = (-1, 0)

    def hear(self, tick: int, heard: Sequence[Heard], place: Place) -> list[Word]:
        """What is new in an inbox; what of it no copy has carried further than here is kept for `outbox`."""
        self._seen = {name: last for name, last in self._seen.items() if tick - name[1] <= self._age_ticks}
        new: dict[Name, Envelope] = {}
        returned: dict[Name, Envelope] = {}
        carried = set()
        for sender, sent_tick, envelope, *_ in heard:
            if sender == self._tower:
                self._hear_tower(tick, sent_tick, place.apart_m)
            name = _name(envelope)
            if tick - envelope.said_tick > self._age_ticks:
                continue
            if not _is_behind(envelope, place.distance_m):
                carried.add(name)
            if name in self._kept and envelope.distance_m < self._kept[name][0].distance_m:
                del self._kept[name]
            if name in self._seen:
                lately = tick - self._seen[name] < AGAIN_TICKS
                if isinstance(envelope.message, Report) and not lately and name not in self._kept:
                    returned[name] = envelope
            elif envelope.origin != self._node:
                new.setdefault(name, envelope)
        if not place.waits and self._node != self._tower:
            both = (new | returned).items()
            onward = [one for name, one in both if name not in carried and self._travels_on(one)]
            self._onward += [self._copy(tick, one, place, one.hops + 1) for one in onward]
        self._seen |= dict.fromkeys((*new, *(carried & self._seen.keys())), tick)
        return [Word(one.origin, one.said_tick, one.message, one.hops) for one in new.values()]

    def in_contact(self, tick: int, apart_m: float) -> bool:
        """Does the tower hear what is said this far from it, for all that is known of its range?"""
        if self._contact is None:
            return False
        heard_tick, reach_m = self._contact
        return tick - heard_tick <= self._contact_ticks and apart_m <= reach_m

    def outbox(
        self, tick: int, messages: Iterable[Report | Order | Roll], place: Place, relay: bool
    ) -> tuple[Envelope, ...]:
        """Everything to be said now: what others said and is to travel on, then our own messages."""
        again = [one for one, due_tick in self._kept.values() if due_tick <= tick]
        onward, self._onward = [self._copy(tick, one, place, one.hops) for one in again] + self._onward, []
        last_tick, number = self._said
        number = number if last_tick == tick else 0
        own = []
        for message in messages:
            own.append(Envelope(self._node, tick, number, message, place.distance_m, relay))
            number += 1
        self._said = (tick, number)
        self._keep(tick, (*onward, *own))
        self._seen |= {_name(one): tick for one in (*onward, *own)}
        return (*onward, *own)

    def next_tick(self) -> int | None:
        """When a report is to be said again."""
        return min((due_tick for _, due_tick in self._kept.values()), default=None)

    def _keep(self, tick: int, said: Iterable[Envelope]) -> None:
        """Of reports that are to travel on the latest of each robot is kept, until it is too old."""
        for one in said:
            if isinstance(one.message, Report):
                older = [name for name in self._kept if name[0] == one.origin and name <= _name(one)]
                for name in older:
                    del self._kept[name]
                if one.relay and tick + AGAIN_TICKS - one.said_tick <= self._age_ticks:
                    self._kept[_name(one)] = (one, tick + AGAIN_TICKS)

    def _hear_tower(self, tick: int, sent_tick: int, apart_m: float) -> None:
        farther = self._contact is None or apart_m >= self._contact[1]
        if farther or not self.in_contact(tick, apart_m):
            self._contact = (sent_tick, apart_m)

    def _travels_on(self, envelope: Envelope) -> bool:
        for_us = isinstance(envelope.message, Order) and envelope.message.to == self._node
        return envelope.relay and envelope.hops < self._hops_most and not for_us

    def _copy(self, tick: int, envelope: Envelope, place: Place, hops: int) -> Envelope:
        """The copy that is said here."""
        arrives = isinstance(envelope.message, Report) and self.in_contact(tick, place.apart_m)
        further = {"distance_m": place.distance_m, "hops": hops, "relay": not arrives}
        return msgspec.structs.replace(envelope, **further)


def _name(envelope: Envelope) -> Name:
    return (envelope.origin, envelope.said_tick, envelope.number)


def _is_behind(envelope: Envelope, distance_m: float) -> bool:
    """Does this copy come from further back on its way?"""
    if isinstance(envelope.message, Report):
        return distance_m < envelope.distance_m
    return distance_m > envelope.distance_m
