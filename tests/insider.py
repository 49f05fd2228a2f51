"""A robot that patrols as it should, and whose code misuses the one link that its process has.

In a process it finds the link in memory and tries, through that session with all its rights, to hear and to
say what is others'. In a rehearsal there is no link, and it only patrols. What it heard is in its reports,
and so in the run's hash.
"""

import gc
from collections.abc import Sequence

import msgspec

from swarm_agent.behaviour import Heard, Move
from swarm_agent.behaviours.lr_pt import LrPt
from wire import codec
from wire.link import Link
from wire.messages import Action, Finish, GoTo, Percept, Request, Senses

BEGIN_TICK = 5
NEIGHBOURS = ("r1", "r2", "r3", "r4", "r5")


class Loot(msgspec.Struct, frozen=True, array_like=True):
    """Keys of others on which an insider heard anything."""

    keys: tuple[str, ...]


class Insider(LrPt):
    """LR-PT, and more than that."""

    def __init__(self, *given) -> None:
        super().__init__(*given)
        self.heard: set[str] = set()

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Patrol, and use the link if there is one."""
        if percept.tick == BEGIN_TICK:
            for link in [one for one in gc.get_objects() if type(one) is Link]:
                self._misuse(link)
        move = super().step(percept, heard)
        return msgspec.structs.replace(move, report=Loot(tuple(sorted(self.heard))))

    def _misuse(self, link: Link) -> None:
        kept = next(str(one.key_expr) for one in link._kept if hasattr(one, "key_expr"))
        run, own = kept.split("/node/")[0], self.configuration.node
        others = [node for node in NEIGHBOURS if node != own]
        for key in (
            "**",
            f"{run}/**",
            f"{run}/world/truth",
            f"{run}/world/event",
            f"{run}/supervisor/order",
            *(f"{run}/node/{node}/{what}" for node in others for what in ("percept", "action")),
        ):
            link.subscribe(key, self._listener(f"{run}/node/{own}/percept"))
        forged = codec.encode(Action(BEGIN_TICK + 1, BEGIN_TICK + 1, GoTo(0.0, 0.0), (), BEGIN_TICK + 2))
        end = codec.encode(Percept(BEGIN_TICK, 2**53, "end", Senses()))
        for node in others:
            link.publisher(f"{run}/node/{node}/action").put(forged)
            link.publisher(f"{run}/node/{node}/percept").put(end)
            link.announce(f"{run}/node/{node}/alive")
        link.publisher(f"{run}/supervisor/done").put(codec.encode(Finish()))
        link.publisher(f"{run}/control").put(codec.encode(Request("kill", "r1")))
        link.publisher(f"{run}/node/{own}/action").put(b"\xff garbage on my own key")
        link.publisher(f"{run}/node/{own}/action").put(codec.encode(Action(1, 1, GoTo(0.0, 0.0), (), 2)))

    def _listener(self, own: str):
        def hear(key: str, data: bytes) -> None:
            if key != own:
                self.heard.add(key)

        return hear
