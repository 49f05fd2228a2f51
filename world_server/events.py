"""The event log: one line of JSON per event, complete whatever happens to those who listen."""

import json
from typing import TextIO

from wire.messages import Event


class EventLog:
    """Appends events to an open text file, each flushed at once."""

    def __init__(self, stream: TextIO, tick_s: float) -> None:
        self._stream = stream
        self._tick_s = tick_s

    def write(self, event: Event) -> None:
        """Append one event."""
        line = {"tick": event.tick, "sim_s": event.tick * self._tick_s, "kind": event.kind}
        line |= {"node": event.node, "text": event.text, "data": event.data}
        self._stream.write(json.dumps(line) + "\n")
        self._stream.flush()
