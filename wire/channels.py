"""The address book: every key expression of a run, who says what on it, and who hears it."""

import re
from functools import cache
from typing import NamedTuple

ROOT = "picket"
NODE_ID = re.compile(r"[a-z][a-z_]{0,15}[0-9]{1,4}")


class Channel(NamedTuple):
    """One row of the address book; `key` is relative to `picket/<run>/`."""

    name: str
    key: str
    message: str
    says: str
    hears: str


PERCEPT = Channel("percept", "node/{node}/percept", "Percept", "world", "that node only")
ACTION = Channel("action", "node/{node}/action", "Action", "that node", "world")
ALIVE = Channel("alive", "node/{node}/alive", "liveliness token", "that node", "world")
TRUTH = Channel("truth", "world/truth", "TruthBlock", "world", "observers")
EVENT = Channel("event", "world/event", "Event", "world", "observers")
CONTROL = Channel("control", "control", "Request, answered by Reply", "operator", "world (query)")
ORDER = Channel("order", "supervisor/order", "Order", "world", "launcher")
NOTICE = Channel("notice", "supervisor/done", "Notice", "launcher", "world")

CHANNELS = (PERCEPT, ACTION, ALIVE, TRUTH, EVENT, CONTROL, ORDER, NOTICE)


def key(run: str, channel: Channel, node: str = "*") -> str:
    """The full key expression of `channel` in `run`; without a node, the pattern that covers all nodes."""
    return f"{ROOT}/{run}/{channel.key.format(node=node)}"


def node_of(key_expression: str) -> str:
    """The sender as the key says it: the only identity that is believed."""
    return key_expression.split("/")[3]


@cache
def number_of(node: str) -> int:
    """The node's number, by which everything is ordered: `r2` comes before `r10`."""
    return int(re.search(r"[0-9]+$", node).group())


def table() -> str:
    """The address book as the Markdown table of the README."""
    lines = ["| key below `picket/<run>/` | says | hears | content |", "|---|---|---|---|"]
    for channel in CHANNELS:
        shown = channel.key.format(node="<id>")
        lines.append(f"| `{shown}` | {channel.says} | {channel.hears} | {channel.message} |")
    return "\n".join(lines)
