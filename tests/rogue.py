"""A rogue client, in a process of its own: tries everything on every key and tells what came of it.

`python -m tests.rogue FD`: FD holds a Plan. It speaks Zenoh directly, as an attacker would. Its standard
output is JSON lines: whether it joined and listens; after a line on its standard input, when its attempts are
over; and after another one what it heard.
"""

import contextlib
import json
import os
import sys

import msgspec
import zenoh

from wire import codec
from wire.credentials import Credential, receive
from wire.messages import (
    Action,
    Done,
    Exited,
    Fault,
    Finish,
    GoTo,
    Order,
    Percept,
    Pose,
    Request,
    Senses,
    Started,
)

CONNECT_WITHIN_MS = 4000
FORGED_TICKS = range(600)
"""A forged action for each of these ticks: one of them carries the number of the grant that is open."""


class Plan(msgspec.Struct):
    """Where the run is, who to pretend to be, whom to harm, and what to say as itself."""

    run: str
    endpoint: str
    credential: Credential | None
    victims: tuple[str, ...]
    own_node: str = ""
    own_messages: tuple[bytes, ...] = ()
    may_ask: bool = False
    """Is it an operator, whose wishes come true? It asks for nothing that would change the run."""


def main() -> None:
    """Join, try, listen until told to stop, tell."""
    plan = receive(int(sys.argv[1]), Plan)
    try:
        session = zenoh.open(_config(plan))
    except zenoh.ZError as error:
        tell(joined=False, error=str(error))
        return
    rogue = Rogue(session, plan)
    rogue.listen()
    tell(joined=True)
    sys.stdin.readline()
    rogue.forge()
    rogue.speak()
    rogue.ask()
    tell(tried=True)
    sys.stdin.readline()
    tell(heard=sorted(rogue.heard), samples=len(rogue.samples), replies=rogue.replies)


def tell(**facts: object) -> None:
    """One line of JSON for the test."""
    print(json.dumps(facts), flush=True)


class Rogue:
    """One session and everything it heard."""

    def __init__(self, session: zenoh.Session, plan: Plan) -> None:
        self.session = session
        self.plan = plan
        self.samples: list[str] = []
        self.replies: list[str] = []
        self._kept: list[object] = []
        self._own_tokens: set[str] = set()

    @property
    def heard(self) -> set[str]:
        """Every key on which anything was heard."""
        return set(self.samples)

    def listen(self) -> None:
        """Subscribe to everything in every way there is."""
        run = f"picket/{self.plan.run}"
        keys = [
            "**",
            "picket/**",
            f"{run}/**",
            f"{run}/node/*/percept",
            f"{run}/node/*/action",
            f"{run}/world/*",
            f"{run}/world/truth",
            f"{run}/world/event",
            f"{run}/supervisor/*",
            f"{run}/supervisor/order",
            f"{run}/supervisor/done",
            f"{run}/control",
        ]
        keys += [
            f"{run}/node/{node}/{what}"
            for node in self.plan.victims
            for what in ("percept", "action", "alive")
        ]
        keys += [f"{run}/node/{self.plan.own_node}/percept"] if self.plan.own_node else []
        for key in keys:
            self._kept.append(
                self.session.declare_subscriber(key, self._hear, allowed_origin=zenoh.Locality.REMOTE)
            )
        for key in ("**", f"{run}/**", f"{run}/node/*/alive"):
            token = self.session.liveliness().declare_subscriber(key, self._hear_token, history=True)
            self._kept.append(token)
        for key in (f"{run}/control", "**"):
            queryable = self.session.declare_queryable(
                key, self._hear_query, allowed_origin=zenoh.Locality.REMOTE
            )
            self._kept.append(queryable)

    def forge(self) -> None:
        """Say as somebody else whatever would harm most, delete every key, and take every token."""
        run, put = f"picket/{self.plan.run}", self._put
        end = codec.encode(Percept(1, 2**53, "end", Senses()))
        for victim in self.plan.victims:
            for tick in FORGED_TICKS:
                put(
                    f"{run}/node/{victim}/action",
                    codec.encode(Action(tick, tick, GoTo(0.0, 0.0), (b"lies",), tick + 1)),
                )
            put(f"{run}/node/{victim}/action", b"\xff garbage")
            grant = codec.encode(Percept(1, 1, "wake", Senses(Pose(0.0, 0.0, 0.0))))
            for forged in (grant, end):
                put(f"{run}/node/{victim}/percept", forged)
            self.session.delete(f"{run}/node/{victim}/action")
            self.session.delete(f"{run}/node/{victim}/percept")
            self._take_token(f"{run}/node/{victim}/alive")
            for notice in (Finish(), Exited(victim, 0, -9), Started(victim, 1, 7), Done(1, True)):
                put(f"{run}/supervisor/done", codec.encode(notice))
            put(f"{run}/supervisor/order", codec.encode(Order(1, Fault(1, "kill", victim))))
            put(f"{run}/control", codec.encode(Request("kill", victim)))
        for key in ("node/*/action", "node/*/percept", "**", "world/truth", "world/event", "supervisor/*"):
            for data in (end, codec.encode(Finish()), codec.encode(Action(1, 1, None, (), 2))):
                put(f"{run}/{key}", data)
            self.session.delete(f"{run}/{key}")

    def speak(self) -> None:
        """Take its own token and say, on its own key, whatever bytes the test wants."""
        if not self.plan.own_node:
            return
        own = f"picket/{self.plan.run}/node/{self.plan.own_node}"
        self._take_token(f"{own}/alive")
        self.session.delete(f"{own}/action")
        for data in self.plan.own_messages:
            self._put(f"{own}/action", data)

    def ask(self) -> None:
        """Query the control channel, everything, and the router's own administration."""
        run = f"picket/{self.plan.run}"
        harmful = [Request("pause"), *(Request("kill", victim) for victim in self.plan.victims)]
        for wish in [Request("status")] + ([] if self.plan.may_ask else harmful):
            self._query(f"{run}/control", codec.encode(wish))
        for selector in ("**", f"{run}/**", "@/**"):
            self._query(selector, b"")
        for reply in self.session.liveliness().get("**", timeout=1.0):
            if reply.ok is not None and str(reply.ok.key_expr) not in self._own_tokens:
                self.replies.append(f"token {reply.ok.key_expr}")

    def _put(self, key: str, data: bytes) -> None:
        """Say something that is not dropped because there is so much of it."""
        self.session.put(key, data, congestion_control=zenoh.CongestionControl.BLOCK)

    def _take_token(self, key: str) -> None:
        """Take a token, drop it, as if its owner had died, and take it again."""
        self._own_tokens.add(key)
        self.session.liveliness().declare_token(key).undeclare()
        self._kept.append(self.session.liveliness().declare_token(key))

    def _query(self, selector: str, data: bytes) -> None:
        for reply in self.session.get(
            selector, payload=data, timeout=1.0, allowed_destination=zenoh.Locality.REMOTE
        ):
            if reply.ok is not None:
                self.replies.append(str(reply.ok.key_expr))

    def _hear(self, sample: zenoh.Sample) -> None:
        self.samples.append(str(sample.key_expr))

    def _hear_token(self, sample: zenoh.Sample) -> None:
        if str(sample.key_expr) not in self._own_tokens:  # a session hears its own
            self.samples.append(f"token {sample.key_expr}")

    def _hear_query(self, query: zenoh.Query) -> None:
        self.samples.append(f"query {query.key_expr}")
        query.drop()


def _config(plan: Plan) -> zenoh.Config:
    settings = {
        "mode": "client",
        "connect/endpoints": [plan.endpoint],
        "connect/timeout_ms": CONNECT_WITHIN_MS,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
    }
    if plan.credential is not None:
        settings["transport/auth/usrpwd"] = {
            "user": plan.credential.user,
            "password": plan.credential.password,
        }
        settings["id"] = plan.credential.session
    config = zenoh.Config()
    for path, value in settings.items():
        config.insert_json5(path, json.dumps(value))
    return config


if __name__ == "__main__":
    with contextlib.suppress(BrokenPipeError):
        main()
    os._exit(0)
