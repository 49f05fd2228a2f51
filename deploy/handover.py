"""From the fold to a slow sink: the latest snapshot wins, and nothing that happened is lost with the others."""

import threading
from collections.abc import Callable

from deploy.scene import Snapshot

LINES_AT_MOST = 10_000  # a sink that hangs for ever must not fill the memory


class Handover:
    """One slot between the thread that folds and the one daemon thread that shows.

    `show` may block for ever: `put` never waits for it, and `finish` waits only as long as it is told.
    """

    def __init__(self, show: Callable[[Snapshot], None]) -> None:
        self._show = show
        self._changed = threading.Condition()
        self._waiting: Snapshot | None = None
        self._finishing = False
        self._thread = threading.Thread(target=self._serve, name="sink", daemon=True)
        self._thread.start()

    def put(self, snapshot: Snapshot) -> None:
        """Show `snapshot` as soon as the sink is free; it takes the place of one that still waits."""
        with self._changed:
            if self._waiting is not None:
                snapshot = snapshot.after(self._waiting)
                snapshot = snapshot._replace(
                    lines=snapshot.lines[-LINES_AT_MOST:], changes=snapshot.changes[-LINES_AT_MOST:]
                )
            self._waiting = snapshot
            self._changed.notify()

    def finish(self, within_s: float) -> bool:
        """Show what waits and end. False when the sink hangs; its thread then dies with the process."""
        with self._changed:
            self._finishing = True
            self._changed.notify()
        self._thread.join(within_s)
        return not self._thread.is_alive()

    def _serve(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting is not None or self._finishing)
                snapshot, self._waiting = self._waiting, None
            if snapshot is None:
                return
            self._show(snapshot)
