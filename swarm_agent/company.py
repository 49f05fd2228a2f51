"""What a robot of a chain knows of the others: their last words, who is there, how far the tower is.

Ours. The tower's own frames are the clock of the chain: what a robot knows of its layer is as old as the
newest frame of the tower that has come through to it. Of an older one, or a longer way of the same one,
nobody takes notice, so robots cut off from the tower cannot keep each other believing that they are not.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Annotated

import msgspec

from swarm_agent.behaviour import Heard
from wire.channels import number_of
from wire.messages import NodeId

Metres = Annotated[float, msgspec.Meta(ge=-1e9, le=1e9)]  # which also refuses NaN
Site = Annotated[int, msgspec.Meta(ge=0)]
CUT_OFF = -1


class Word(msgspec.Struct, frozen=True, array_like=True):
    """What a robot says of itself: where it is, the sites it goes to next and in the end, whom it hangs on.

    `layer`: links to the tower, CUT_OFF for none; `beacon_tick`: when the tower said what came through last.
    `roll`: (robot, tick) of who is known to have been there.
    """

    x_m: Metres
    y_m: Metres
    next: Site
    goal: Site
    layer: Annotated[int, msgspec.Meta(ge=CUT_OFF)]
    beacon_tick: int
    parent: NodeId | None
    roll: tuple[tuple[NodeId, int], ...] = ()


class Company:
    """The other nodes, as their frames tell. What is older than `memory_ticks` is forgotten.

    A robot that nobody was in touch with for `roll_ticks` is off the roll. Words of a field with more than
    these `sites` are not understood.
    """

    def __init__(self, node: str, tower: str, sites: int, memory_ticks: int, roll_ticks: int) -> None:
        self._node, self._tower, self._sites = node, tower, sites
        self._memory_ticks, self._roll_ticks = memory_ticks, roll_ticks
        self._said: dict[str, tuple[int, Word | None]] = {}
        self._leaning: dict[str, int] = {}
        self._roll: dict[str, int] = {}
        self._accepted_tick = -1
        self.layer, self.beacon_tick = CUT_OFF, -1

    def listen(self, tick: int, heard: Sequence[Heard]) -> None:
        """Take in one inbox."""
        self._roll[self._node] = tick
        for sender, sent_tick, bulletin, *_ in heard:
            word = bulletin.message
            if sent_tick < tick - self._memory_ticks:
                continue  # found after a freeze
            if sender == self._tower:
                self._said[sender] = (sent_tick, None)
                self._offer(tick, sent_tick, 1)
            elif word is not None and max(word.next, word.goal) < self._sites:
                self._said[sender] = (sent_tick, word)
                if word.parent == self._node:
                    self._leaning[sender] = sent_tick
                if word.layer != CUT_OFF:
                    self._offer(tick, word.beacon_tick, word.layer + 1)
                for robot, seen_tick in word.roll:
                    if seen_tick > self._roll.get(robot, -1):
                        self._roll[robot] = seen_tick
        self._said = {one: said for one, said in self._said.items() if said[0] >= tick - self._memory_ticks}
        if tick - self._accepted_tick > self._memory_ticks:
            self.layer = CUT_OFF

    def roll(self, tick: int) -> list[tuple[str, int]]:
        """Every robot known to have been in touch lately, and when, in order of their numbers."""
        present = [one for one in self._roll.items() if one[1] >= tick - self._roll_ticks]
        return sorted(present, key=lambda one: number_of(one[0]))

    def hears_tower(self) -> bool:
        """Was the tower heard just now?"""
        return self._tower in self._said

    def others(self) -> Iterator[tuple[str, Word]]:
        """The robots heard just now and their last words, in order of their numbers."""
        for name in sorted(self._said, key=number_of):
            word = self._said[name][1]
            if word is not None:
                yield name, word

    def children(self, tick: int) -> Iterator[Word]:
        """The robots that hang on this one, or did a moment ago and may not have heard of a change."""
        for name, word in self.others():
            if self._leaning.get(name, -math.inf) >= tick - self._memory_ticks:
                yield word

    def _offer(self, tick: int, beacon_tick: int, layer: int) -> None:
        newer = beacon_tick > self.beacon_tick
        if newer or (beacon_tick == self.beacon_tick and layer < self.layer):
            self.layer, self.beacon_tick, self._accepted_tick = layer, beacon_tick, tick
