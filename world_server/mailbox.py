"""One queue, one owner: Zenoh's threads only put things in; the world's own thread handles them."""

import math
import time
from collections.abc import Callable
from queue import Empty, SimpleQueue
from threading import TIMEOUT_MAX


class Mailbox:
    """What has arrived, each thing with the function that handles it."""

    def __init__(self) -> None:
        self._queue: SimpleQueue = SimpleQueue()

    def into(self, handler: Callable[..., None]) -> Callable[..., None]:
        """A callback for any thread: has `handler` called with the same arguments by the owner."""
        return lambda *given: self._queue.put((handler, given))

    def take(self, limit_s: float = math.inf) -> bool:
        """Handle one thing, waiting for it until that time of the clock. False when nothing came."""
        try:
            timeout_s = min(max(0.0, limit_s - time.monotonic()), TIMEOUT_MAX)
            handler, given = self._queue.get(timeout=timeout_s)
        except Empty:
            return False
        handler(*given)
        return True

    def wait(self, until: Callable[[], bool], at_most_s: float) -> None:
        """Handle what arrives until something is so, or that much time has passed."""
        limit_s = time.monotonic() + at_most_s
        while not until() and self.take(limit_s):
            pass

    def drain(self) -> None:
        """Handle what is there now, not what a flood goes on adding meanwhile."""
        for _ in range(self._queue.qsize()):
            self.take(0.0)
