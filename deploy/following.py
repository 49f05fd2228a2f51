"""From what an observer hears to a slow sink: everything is folded, the latest snapshot is shown.

No Rerun here and no Zenoh: messages come in as bytes, snapshots go out to a sink that may hang for ever.
"""

import threading
import time
from collections.abc import Callable
from itertools import takewhile
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Protocol

import msgspec

from deploy.scene import Scene, Snapshot
from wire import codec
from wire.messages import Event, TruthBlock
from world_server.journal import JournalError, commits

LINES_AT_MOST = 10_000  # a sink that hangs for ever must not fill the memory
SHOW_EVERY_S = 0.25
QUIET_S = 2.0


class Sink(Protocol):
    """What shows snapshots. Every call may block for ever."""

    def show(self, snapshot: Snapshot) -> None:
        """Show one snapshot."""

    def close(self) -> None:
        """Show everything that is still on its way, and end."""


class Handover:
    """One slot between the thread that folds and the one daemon thread that makes, feeds and closes a sink.

    `put` never waits for the sink, and `finish` only as long as it is told.
    """

    def __init__(self, make: Callable[[], Sink]) -> None:
        self.trouble = ""
        """Why the sink can show nothing more; empty as long as it can."""
        self._make = make
        self._changed = threading.Condition()
        self._waiting: Snapshot | None = None
        self._finishing = False
        self._thread = threading.Thread(target=self._serve, name="sink", daemon=True)
        self._thread.start()

    def put(self, snapshot: Snapshot) -> None:
        """Show `snapshot` when the sink is free. It replaces one that waits, and keeps its happenings."""
        with self._changed:
            if self._waiting is not None:
                both = snapshot.after(self._waiting)
                lines, changes = both.lines[-LINES_AT_MOST:], both.changes[-LINES_AT_MOST:]
                snapshot = both._replace(lines=lines, changes=changes)
            self._waiting = snapshot
            self._changed.notify()

    def finish(self, within_s: float) -> bool:
        """Show what waits, and end. False when the sink hangs; its thread then dies with the process."""
        with self._changed:
            self._finishing = True
            self._changed.notify()
        self._thread.join(within_s)
        return not self._thread.is_alive()

    def _serve(self) -> None:
        try:
            self._feed(self._make())
        except Exception as error:  # noqa: BLE001  whatever the sink's trouble is, the run goes on
            self.trouble = str(error) or type(error).__name__

    def _feed(self, sink: Sink) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting is not None or self._finishing)
                snapshot, self._waiting = self._waiting, None
            if snapshot is None:
                return sink.close()
            sink.show(snapshot)


class Follower:
    """Folds every block and event of a live run, and hands snapshots over a few times a second."""

    def __init__(self, scene: Scene, put: Callable[[Snapshot], None], folder: Path) -> None:
        self._scene = scene
        self._put = put
        self._folder = folder
        self._told: set[tuple[int, str]] = set()
        self._queue: SimpleQueue[tuple[type, bytes]] = SimpleQueue()
        self._next_block = 0
        self._end_tick: int | None = None
        self._fresh, self._shown_at, self._heard_at = False, 0.0, time.monotonic()

    def enqueue(self, kind: type, data: bytes) -> None:
        """Take a TruthBlock or Event as bytes, from any thread."""
        self._queue.put((kind, data))

    def follow(self, wanted: Callable[[], bool]) -> None:
        """Work until the run is over, or nobody wants to see it any more."""
        while wanted() and not self._over():
            try:
                self._take(*self._queue.get(timeout=SHOW_EVERY_S))
            except Empty:
                pass
            if self._fresh and time.monotonic() - self._shown_at >= SHOW_EVERY_S:
                self._show()
        if self._fresh:
            self._show()

    def _take(self, kind: type, data: bytes) -> None:
        self._heard_at = time.monotonic()
        try:
            message = codec.decode(kind, data)
            self._block(message) if isinstance(message, TruthBlock) else self._event(message)
        except (codec.Malformed, JournalError) as error:
            self._scene.warn(f"the dashboard cannot read a {kind.__name__}: {error}")

    def _block(self, block: TruthBlock) -> None:
        missed, late = block.number - self._next_block, self._scene.time_s < 0
        self._next_block = block.number + 1
        if missed > 0 and not (late and self._catch_up(block.facts[0].tick)):
            first_s = block.facts[0].tick * self._scene.scenario.tick_s
            self._scene.warn(
                f"the dashboard missed {missed} blocks of facts before {first_s:g} s; "
                "until their next visit, sites visited then look older than they are"
            )
        for facts in block.facts:
            self._scene.take(facts)
        self._fresh = self._scene.time_s >= 0

    def _catch_up(self, before_tick: int) -> bool:
        """Who joins late reads what was before in the run folder. False if it is not there."""
        journal = self._folder / "journal"
        if not journal.exists():
            return False
        for commit in takewhile(lambda commit: commit.tick < before_tick, commits(journal)):
            self._scene.take(commit.facts)
        for event in read_events(self._folder / "events.jsonl"):
            if event.tick < before_tick and (event.tick, event.text) not in self._told:
                self._event(event)
        return True

    def _event(self, event: Event) -> None:
        self._scene.note(event)
        self._told.add((event.tick, event.text))
        self._fresh = self._scene.time_s >= 0
        if event.kind == "end":
            self._end_tick = event.tick

    def _over(self) -> bool:
        """Is the last tick here, or the run over and nothing more coming?"""
        quiet = time.monotonic() - self._heard_at > QUIET_S
        if self._end_tick is None and quiet:
            self._heard_at = time.monotonic()
            self._event_log_ended()
            return False
        end_s = (self._end_tick or 0) * self._scene.scenario.tick_s
        return self._end_tick is not None and (quiet or self._scene.time_s >= end_s)

    def _event_log_ended(self) -> None:
        """The end may be lost on its way to us (we are droppable), but not in the run folder.

        An end before what we have seen is that of an earlier part of the run, which was then resumed.
        """
        for event in read_events(self._folder / "events.jsonl")[-1:]:
            if event.kind == "end" and event.tick * self._scene.scenario.tick_s >= self._scene.time_s >= 0:
                self._event(event)

    def _show(self) -> None:
        self._put(self._scene.snapshot())
        self._fresh, self._shown_at = False, time.monotonic()


def read_events(path: Path) -> list[Event]:
    """The event log of a run folder, empty if there is none; a last line that was cut off is left out."""
    events = []
    for line in path.read_bytes().splitlines() if path.exists() else ():
        try:
            said: dict[str, Any] = msgspec.json.decode(line)
        except msgspec.DecodeError:
            break
        events.append(Event(said["tick"], said["kind"], said["node"], said["text"], said["data"]))
    return events
