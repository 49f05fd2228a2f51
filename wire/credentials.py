"""Who is who in a run: one secret and one session id per process, made by the launcher, never on disk.

The access rules bind a user's rights to both its password and its session id, so that a second connection
with a live node's password has no rights at all, and one that borrows the session id too is refused.
"""

import ctypes
import os
import secrets
from collections.abc import Iterable

import msgspec

OBSERVERS = ("observer1", "observer2")
OPERATORS = tuple(f"operator{number}" for number in range(1, 9))
"""One for each request under way: a session id cannot join again before its last session is all gone."""
SUPERVISOR = "supervisor"


class Credential(msgspec.Struct, frozen=True):
    """What one process needs to join: `session` is its Zenoh id, 32 hexadecimal digits."""

    user: str
    password: str
    session: str


class Book(msgspec.Struct, frozen=True):
    """All credentials of a run; only the launcher and the world ever hold it."""

    run: str
    endpoint: str
    nodes: dict[str, Credential]
    others: dict[str, Credential]

    @property
    def everyone(self) -> list[Credential]:
        """All credentials, nodes first."""
        return [*self.nodes.values(), *self.others.values()]

    def ticket(self, user: str) -> "Ticket":
        """The ticket of one node, observer, operator or supervisor."""
        return Ticket(self.run, self.endpoint, self.nodes.get(user) or self.others[user])


class Ticket(msgspec.Struct, frozen=True):
    """What one client process is handed at birth, on an inherited descriptor."""

    run: str
    endpoint: str
    credential: Credential


def make_book(run: str, endpoint: str, node_ids: Iterable[str]) -> Book:
    """Fresh secrets for the whole pool of ids, spares included: the router's rules cannot change later."""
    nodes = {node: fresh(node) for node in node_ids}
    others = {user: fresh(user) for user in (*OBSERVERS, *OPERATORS, SUPERVISOR)}
    return Book(run, endpoint, nodes, others)


def fresh(user: str) -> Credential:
    """A new secret and session id for one user."""
    # Digits 1 to f only: Zenoh trims zero bytes from ids, and a trimmed id would not match its rule.
    session = "".join(secrets.choice("123456789abcdef") for _ in range(32))
    return Credential(user, secrets.token_urlsafe(24), session)


def hand_over(secret: Ticket | Book | bytes) -> int:
    """An anonymous file that holds `secret`; the descriptor is to be inherited by exactly one child."""
    descriptor = os.memfd_create("picket", 0)
    os.write(descriptor, secret if isinstance(secret, bytes) else msgspec.msgpack.encode(secret))
    os.lseek(descriptor, 0, os.SEEK_SET)
    return descriptor


def receive(descriptor: int, kind: type) -> object:
    """Read what `hand_over` wrote, and close the descriptor so that nothing else inherits it."""
    with os.fdopen(descriptor, "rb") as stream:
        return msgspec.msgpack.decode(stream.read(), type=kind)


def die_with_parent(parent_pid: int) -> None:
    """Let the kernel kill this process when its parent ends, however the parent ends (Linux)."""
    set_parent_death_signal, kill = 1, 9  # PR_SET_PDEATHSIG in <sys/prctl.h>, SIGKILL
    ctypes.CDLL(None).prctl(set_parent_death_signal, kill)
    if os.getppid() != parent_pid:  # it ended before the line above
        os._exit(1)
