"""What the journal holds: one record per commit, enough to rebuild the world and to feed a mind again."""

from wire.messages import Action, Configuration, Count, Facts, Message, NodeId, Senses, Why


class FrameRef(Message):
    """A frame in an inbox, by the action that carried it; the payload itself is stored there, once."""

    sender: NodeId
    sent_tick: Count
    index: Count


class Grant(Message):
    """A percept that was answered."""

    node: NodeId
    grant: Count
    why: Why
    senses: Senses
    inbox: tuple[FrameRef, ...]
    configuration: Configuration | None


class Commit(Message):
    """One tick as it was settled: what was granted, what was answered, and what came of it.

    `actions` stand in the order of `grants`. `deliveries` are the columns sender row, frame, receiver row
    (uint16) and the tick at which it is heard (uint32) of every transmission that got through.
    """

    tick: Count
    grants: tuple[Grant, ...]
    actions: tuple[Action, ...]
    deliveries: tuple[bytes, bytes, bytes, bytes]
    facts: Facts


class Header(Message):
    """The beginning of a journal. `first_poses`: float64, (nodes, 3)."""

    seed: Count
    scenario_toml: str
    nodes: tuple[NodeId, ...]
    first_poses: bytes


class End(Message):
    """The end of a journal that was closed, not cut off."""

    tick: Count
    completed: bool
    run_hash: str
