"""Who is behind a connection from this machine, so that a stranger can be told by its process."""

import os
from pathlib import Path

SHOWN = 100


def process_behind(address: str) -> str:
    """The process that connected from `address`, such as `tcp/127.0.0.1:40278`; the address where unknown."""
    socket = f"socket:[{_inode(address)}]"
    for place in Path("/proc").glob("[0-9]*/fd/*"):
        try:
            if os.readlink(place) == socket:
                command = (
                    (place.parents[1] / "cmdline")
                    .read_bytes()
                    .replace(b"\0", b" ")
                    .decode("utf-8", "replace")
                )
                return f"process {place.parts[2]} ({command.strip()[:SHOWN]}) at {address}"
        except OSError:  # it has ended, or is another user's
            continue
    return f"a client at {address or 'an unknown address'}"


def _inode(address: str) -> str:
    """The kernel's number of the socket that is bound to a local TCP address, empty when there is none."""
    try:
        port = int(address.rpartition(":")[2])
        lines = Path("/proc/net/tcp").read_text("ascii").splitlines()[1:]
    except (ValueError, OSError):
        return ""
    for line in lines:
        _, local, remote, _, _, _, _, _, _, inode, *_ = line.split()
        if int(local.rpartition(":")[2], 16) == port and int(remote.rpartition(":")[2], 16) != 0:
            return inode
    return ""
