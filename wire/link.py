"""The link: the only user of Zenoh. One owner thread per process; callbacks only enqueue.

The world holds the session in router mode and everybody else is a client of it: explicit endpoints, no
scouting, no shared memory (it leaks around killed processes), a password and a session id for everyone.
"""

import json
import os
import threading
from collections.abc import Callable
from typing import Any

# Read once when zenoh is loaded: one runtime thread does all the work, which costs a quarter less processor
# time than the default pools. A close that hangs is bounded below.
_RUNTIME = (
    "(rx:(handover:app),tx:(handover:app),acc:(handover:app),net:(handover:app),app:(worker_threads:1))"
)
os.environ.setdefault("ZENOH_RUNTIME", _RUNTIME)

import zenoh  # noqa: E402

from wire.credentials import Book, Credential, Ticket, hand_over  # noqa: E402

CLOSE_WITHIN_S = 2.0
CONNECT_WITHIN_S = 20.0
LEASE_MS = 60_000  # a stopped process is the watchdog's business; a killed one is seen at once anyway


class LinkError(Exception):
    """The link could not be opened; the text says to what and what to look at."""


class Publisher:
    """One key, one reliable express lane. `put` hands the bytes to Zenoh and returns."""

    def __init__(self, session: zenoh.Session, key: str, droppable: bool) -> None:
        control = zenoh.CongestionControl.DROP if droppable else zenoh.CongestionControl.BLOCK
        priority = zenoh.Priority.DATA if droppable else zenoh.Priority.REAL_TIME
        self._publisher = session.declare_publisher(
            key, congestion_control=control, priority=priority, express=not droppable
        )

    def put(self, data: bytes) -> None:
        """Send `data`; silently nothing once the session is gone (its owner learns that elsewhere)."""
        self._publisher.put(data)


class Link:
    """An open session, as a client or as the router of a run."""

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self._kept: list[Any] = []  # a dropped handle undeclares its subscription

    @property
    def session_id(self) -> str:
        """This session's own id, 32 hexadecimal digits."""
        return str(self._session.info.zid())

    def publisher(self, key: str, droppable: bool = False) -> Publisher:
        """A publisher on `key`; droppable means that a slow listener loses messages instead of slowing us."""
        return Publisher(self._session, key, droppable)

    def subscribe(self, key: str, enqueue: Callable[[str, bytes], None]) -> None:
        """Hand every message of others on `key` to `enqueue(key, data)`, on a thread of Zenoh's."""
        remote = zenoh.Locality.REMOTE
        handle = self._session.declare_subscriber(
            key, lambda sample: enqueue(str(sample.key_expr), _put_bytes(sample)), allowed_origin=remote
        )
        self._kept.append(handle)

    def announce(self, key: str) -> None:
        """Take the liveliness token `key`; it vanishes with this process."""
        self._kept.append(self._session.liveliness().declare_token(key))

    def watch_tokens(self, key: str, enqueue: Callable[[str, bool], None]) -> None:
        """Tell `enqueue(key, alive)` of every token that comes or goes, those already there included."""
        put = zenoh.SampleKind.PUT
        handle = self._session.liveliness().declare_subscriber(
            key, lambda sample: enqueue(str(sample.key_expr), sample.kind == put), history=True
        )
        self._kept.append(handle)

    def watch_sessions(self, enqueue: Callable[[str, str], None]) -> None:
        """Tell `enqueue(session id, address)` of every session that connects to this router."""
        put = zenoh.SampleKind.PUT

        def on_transport(event: Any) -> None:
            if event.kind == put:
                session = event.transport.zid
                found = [link.dst for link in self._session.info.links() if link.zid == session]
                enqueue(str(session), found[0] if found else "")

        handle = self._session.info.declare_transport_events_listener(on_transport, history=True)
        self._kept.append(handle)

    def answer(self, key: str, enqueue: Callable[[bytes, Callable[[bytes], None]], None]) -> None:
        """Hand every query on `key` to `enqueue(data, reply)`; `reply(bytes)` may be called anywhere."""

        def on_query(query: zenoh.Query) -> None:
            def reply(data: bytes) -> None:
                query.reply(key, data)
                query.drop()

            enqueue(bytes(query.payload) if query.payload else b"", reply)

        self._kept.append(self._session.declare_queryable(key, on_query))

    def ask(self, key: str, data: bytes, timeout_s: float) -> bytes | None:
        """Query `key` and return the answer, or None when none came in time."""
        for reply in self._session.get(key, payload=data, timeout=timeout_s):
            if reply.ok is not None:
                return bytes(reply.ok.payload)
        return None

    def close(self) -> None:
        """Close within a bounded time: Zenoh's own close may block on a peer that is gone or stopped."""
        self._kept.clear()
        closer = threading.Thread(target=self._session.close, daemon=True)
        closer.start()
        closer.join(CLOSE_WITHIN_S)


def _put_bytes(sample: zenoh.Sample) -> bytes:
    """The payload; a delete on the key counts as an empty message, which no codec accepts."""
    return bytes(sample.payload) if sample.kind == zenoh.SampleKind.PUT else b""


def open_client(ticket: Ticket) -> Link:
    """Join a run. Raises LinkError when the router is not there or refuses the credentials."""
    config = _config("client", ticket.credential)
    _set(config, "connect/endpoints", [ticket.endpoint])
    _set(config, "connect/timeout_ms", int(CONNECT_WITHIN_S * 1000))
    return _open(config, f"no connection to {ticket.endpoint}: no world there, or the credentials are wrong")


def open_router(book: Book, access_control: dict[str, Any], world: Credential) -> Link:
    """Open the run's router. Raises LinkError when its port is taken."""
    config = _config("router", world)
    lines = "".join(f"{one.user}:{one.password}\n" for one in book.everyone)
    descriptor = hand_over(lines.encode())
    _set(config, "transport/auth/usrpwd/dictionary_file", f"/proc/self/fd/{descriptor}")
    _set(config, "listen/endpoints", [book.endpoint])
    _set(config, "access_control", access_control)
    try:
        return _open(config, f"cannot listen on {book.endpoint}: is the port taken?")
    finally:
        os.close(descriptor)


def _config(mode: str, who: Credential) -> zenoh.Config:
    config = zenoh.Config()
    _set(config, "mode", mode)
    _set(config, "id", who.session)
    _set(config, "scouting/multicast/enabled", False)
    _set(config, "scouting/gossip/enabled", False)
    _set(config, "transport/shared_memory/enabled", False)
    _set(config, "transport/link/tx/lease", LEASE_MS)
    _set(config, "transport/auth/usrpwd", {"user": who.user, "password": who.password})
    return config


def _set(config: zenoh.Config, path: str, value: Any) -> None:
    config.insert_json5(path, json.dumps(value))


def _open(config: zenoh.Config, trouble: str) -> Link:
    try:
        return Link(zenoh.open(config))
    except zenoh.ZError as error:
        raise LinkError(f"{trouble} ({str(error).split(' at /')[0]})") from None
