"""What leaves the world for those who only listen: events at once, facts a few times a second."""

import time
from collections import Counter
from collections.abc import Callable
from typing import Any

from wire import channels, codec
from wire.link import Link
from wire.messages import Event, Facts, TruthBlock
from world_server.records import Commit

SHOW_EVERY_S = 0.1
SHOW_NODE_TICKS = 10_000  # a block must stay well below what a codec reads


class Observers:
    """All observers of a run, and its event log. A slow listener loses messages and slows nobody."""

    def __init__(
        self, link: Link, run: str, nodes: tuple[str, ...], write_event: Callable[[Event], None]
    ) -> None:
        self._truth = link.publisher(channels.key(run, channels.TRUTH), droppable=True)
        self._events = link.publisher(channels.key(run, channels.EVENT), droppable=True)
        self._nodes = nodes
        self._at_most = max(1, SHOW_NODE_TICKS // len(nodes))
        self._write_event = write_event
        self._counts: Counter = Counter()
        self._shown: list[Facts] = []
        self._shown_at, self._block = 0.0, 0

    def tell(self, event: Event) -> None:
        """Write an event down and tell observers."""
        self._write_event(event)
        self._events.put(codec.encode(event))

    def tell_some(
        self, tick: int, kind: str, node: str, text: str, data: dict[str, Any], of: str = ""
    ) -> None:
        """Tell of the 1st, 10th, 100th ... event of a kind, so that a flood of garbage floods nothing else.

        `of`: what distinguishes kinds, where the text holds more than that.
        """
        self._counts[kind, node, of or text] += 1
        count = self._counts[kind, node, of or text]
        if str(count).strip("0") == "1":
            self.tell(Event(tick, kind, node, text, data | {"count": count}))

    def show(self, commit: Commit) -> None:
        """Collect the facts of ticks and give them to observers a few times a second."""
        self._shown.append(commit.facts)
        if time.monotonic() - self._shown_at > SHOW_EVERY_S or len(self._shown) >= self._at_most:
            self.flush()

    def flush(self) -> None:
        """Give out the facts collected so far."""
        if self._shown:
            self._truth.put(codec.encode(TruthBlock(self._block, self._nodes, tuple(self._shown))))
            self._shown, self._shown_at, self._block = [], time.monotonic(), self._block + 1
