"""What a node knows of the field: assumed idleness, and the standard frame that carries it.

Any behaviour that says its news in a `Bulletin` is understood by the tower, whatever else it adds.
Source: Kobayashi et al. 2025, section IV-A and Algorithm 1; the memory of what neighbours have is ours.
"""

from collections.abc import Sequence
from typing import Any, Generic, TypeVar

import msgspec
import numpy as np

from swarm_agent.behaviour import Heard

Own = TypeVar("Own")


class News(msgspec.Struct, frozen=True, array_like=True):
    """Times of last known visits. `visited_tick`: uint32; `sites`: uint16, empty for all in order."""

    visited_tick: bytes
    sites: bytes = b""

    def __post_init__(self) -> None:
        times, odd = divmod(len(self.visited_tick), 4)
        if odd or (self.sites and len(self.sites) != 2 * times):
            raise ValueError("news with columns of unequal length")


def merge_news(visited_tick: np.ndarray, *news: News) -> None:
    """Raise entries of `visited_tick` (uint32) to the newest; news of a field of another size is ignored."""
    sites = len(visited_tick)
    tables = [one.visited_tick for one in news if not one.sites and len(one.visited_tick) == 4 * sites]
    if tables:
        rows = (len(tables) + 1, sites)
        np.maximum.reduce(np.ndarray(rows, "<u4", b"".join([visited_tick, *tables])), out=visited_tick)
    for one in (one for one in news if one.sites):
        chosen = np.frombuffer(one.sites, dtype="<u2")
        if chosen.max() < sites:
            np.maximum.at(visited_tick, chosen, np.frombuffer(one.visited_tick, dtype="<u4"))


class Bulletin(msgspec.Struct, Generic[Own], frozen=True, array_like=True):
    """One frame: news for all, what the sender just heard, and the behaviour's own message.

    `heard`: (sender, tick it was sent) of frames in the last inbox. `since_tick`: when this mind began, so
    that others notice a lost memory.
    """

    news: News
    heard: tuple[tuple[str, int], ...] = ()
    since_tick: int = 0
    message: Own | None = None


AnyBulletin = Bulletin[Any]


class AssumedIdleness:
    """A node's table of last known visits. Only times are kept: idleness is now minus time (spec of [8])."""

    def __init__(self, sites: int) -> None:
        self.visited_tick = np.zeros(sites, dtype="<u4")

    def note_visit(self, site: int, tick: int) -> None:
        """A patrol of `site` was completed at `tick` (Algorithm 1, lines 5-6)."""
        self.visited_tick[site] = tick

    def idle_ticks(self, tick: int) -> np.ndarray:
        """Assumed idleness of every site at `tick`: int64, (sites,) (lines 2-4)."""
        return tick - self.visited_tick.astype(np.int64)

    def merge(self, *news: News) -> None:
        """Take over every entry that is strictly newer than ours (lines 13-19)."""
        merge_news(self.visited_tick, *news)

    def replace(self, visited_tick: bytes) -> None:
        """Know what somebody knows better: uint32, (sites,)."""
        self.visited_tick[:] = np.frombuffer(visited_tick, dtype="<u4")

    def newest(self, items: int, among: np.ndarray | None = None) -> News:
        """The `items` entries with the largest times (line 10), lower site first among equals.

        `among`: bool, (sites,), restricts the choice.
        """
        if among is None and items >= len(self.visited_tick):
            return News(self.visited_tick.tobytes())
        sites = np.flatnonzero(self.visited_tick if among is None else among)
        order = np.argsort(-self.visited_tick[sites].astype(np.int64), kind="stable")
        chosen = sites[order[:items]].astype("<u2")
        return News(self.visited_tick[chosen].tobytes(), chosen.tobytes())


class NeighbourMemory:
    """What each neighbour is known to have, so that scarce items are not spent on old news.

    An entry counts as known to a neighbour that said it, or that acknowledged the frame that carried it.
    """

    def __init__(self, node: str, sites: int) -> None:
        self._node = node
        self._sites = sites
        self._known: dict[str, np.ndarray] = {}
        self._since: dict[str, int] = {}
        self._sent: dict[int, News] = {}

    def listen(self, heard: list[Heard]) -> None:
        """Learn from the bulletins of one inbox what their senders have."""
        for sender, _, bulletin, *_ in heard:
            if self._since.get(sender) != bulletin.since_tick:
                self._since[sender] = bulletin.since_tick
                self._known[sender] = np.zeros(self._sites, dtype="<u4")
            merge_news(self._known[sender], bulletin.news)
            for name, tick in bulletin.heard:
                if name == self._node and tick in self._sent:
                    merge_news(self._known[sender], self._sent[tick])

    def unknown_to(self, neighbours: list[str], visited_tick: np.ndarray) -> np.ndarray:
        """Which of our entries some neighbour is not known to have: bool, (sites,)."""
        if not neighbours:
            return visited_tick > 0
        oldest = np.min([self._known[one] for one in neighbours], axis=0)
        return visited_tick > oldest

    def remember_sent(self, tick: int, news: News, keep_ticks: int = 64) -> None:
        """Keep what was said at `tick` until it may have been acknowledged."""
        self._sent[tick] = news
        self._sent.pop(tick - keep_ticks, None)


class Reporter:
    """When a robot speaks that need not speak at every tick: with a message of its own, or to the tower.

    Source: Kobayashi et al. 2025, section V-A2: comparators share what they know with the base station "on
    connection". Connected is who hears the tower, and the tower's own table says what it lacks. What was just
    told is not told again before the tower's answer had time to come.
    """

    PATIENCE_TICKS = 8

    def __init__(self, tower: str, knowledge: AssumedIdleness) -> None:
        sites = len(knowledge.visited_tick)
        self._tower = tower
        self._knowledge = knowledge
        self._known = np.zeros(sites, dtype="<u4")
        self._told = np.zeros(sites, dtype="<u4")
        self._told_tick = self._tower_since = self.since_tick = -1

    def frames(self, tick: int, heard: Sequence[Heard], message: Any = None) -> tuple[Bulletin, ...]:
        """One frame with the whole table, or none. Call it at every step."""
        if self.since_tick < 0:
            self.since_tick = tick
        connected = self._listen(heard)
        if connected and tick > self._told_tick + self.PATIENCE_TICKS:
            self._told[:] = 0
        news = self._knowledge.visited_tick > np.maximum(self._known, self._told)
        if message is None and not (connected and news.any()):
            return ()
        if connected:
            self._told_tick = tick
            self._told[:] = self._knowledge.visited_tick
        return (Bulletin(self._knowledge.newest(len(news)), (), self.since_tick, message),)

    def _listen(self, heard: Sequence[Heard]) -> bool:
        """Learn what the tower has. Returns whether it was heard."""
        said = [bulletin for sender, _, bulletin, *_ in heard if sender == self._tower]
        for bulletin in said:
            if bulletin.since_tick != self._tower_since:
                self._tower_since = bulletin.since_tick
                self._known[:] = self._told[:] = 0
            merge_news(self._known, bulletin.news)
        return bool(said)
