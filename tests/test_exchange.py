"""What arrives at the world is believed only as far as its key proves, and nothing can end it."""

from collections.abc import Callable

import pytest

from tests.builders import scenario
from wire import channels, codec
from wire.credentials import fresh, make_book
from wire.messages import Action, Event, Exited, GoTo, Percept, Pose, Reply, Request, Senses, Started
from world_server.exchange import LiveSwarm

TEAM = scenario(2)
SPARE = "r4"
BOOK = make_book("test", "tcp/127.0.0.1:1", (*TEAM.node_ids, SPARE))
TICK, GRANT = 5, 3


class Wire:
    """A link without a network: what the world listens to, and what it says."""

    session_id = "1" * 32

    def __init__(self) -> None:
        self.said: list[tuple[str, bytes]] = []
        self.on: dict[str, Callable[..., None]] = {}

    def publisher(self, key: str, droppable: bool = False) -> "Wire.Publisher":
        return self.Publisher(self, key)

    def subscribe(self, key: str, enqueue: Callable[[str, bytes], None]) -> None:
        self.on[key] = enqueue

    def watch_tokens(self, key: str, enqueue: Callable[[str, bool], None]) -> None:
        self.on[key] = enqueue

    def watch_sessions(self, enqueue: Callable[[str, str], None]) -> None:
        self.on["sessions"] = enqueue

    def answer(self, key: str, enqueue: Callable[[bytes, Callable[[bytes], None]], None]) -> None:
        self.on[key] = enqueue

    class Publisher:
        """Notes down what is put."""

        def __init__(self, wire: "Wire", key: str) -> None:
            self.wire, self.key = wire, key

        def put(self, data: bytes) -> None:
            self.wire.said.append((self.key, data))


class Ear:
    """A world's exchange with a wire of its own, and everything that it told."""

    def __init__(self) -> None:
        self.wire = Wire()
        self.events: list[Event] = []
        self.swarm = LiveSwarm(self.wire, BOOK, TEAM, self.events.append)

    def hear(self, channel: channels.Channel, *what: object, node: str = "*") -> None:
        """Something arrives on a channel."""
        key = channels.key(BOOK.run, channel, node)
        listening = channels.key(BOOK.run, channel)
        if channel is channels.CONTROL:
            return self.wire.on[listening](*what)
        self.wire.on[listening](key, *what)

    def act(self, node: str, data: bytes) -> None:
        """An action arrives on the key of a node."""
        self.hear(channels.ACTION, data, node=node)

    def ask(self, data: bytes) -> Reply:
        """A request arrives at the next boundary; returns what is replied."""
        replies: list[bytes] = []
        self.hear(channels.CONTROL, data, replies.append)
        list(self.swarm.boundary(TICK))
        return codec.decode(Reply, replies[0])

    def boundary(self) -> None:
        """Everything that arrived is handled."""
        assert list(self.swarm.boundary(TICK)) == []

    def exchange(self) -> dict[str, Action]:
        """Grant r2 a tick, and return what is accepted."""
        return dict(
            self.swarm.exchange(TICK, {"r2": Percept(TICK, GRANT, "wake", Senses(Pose(0.0, 0.0, 0.0)))})
        )


@pytest.fixture
def ear() -> Ear:
    return Ear()


def action(tick: int = TICK, grant: int = GRANT, x_m: float = 1.0) -> bytes:
    return codec.encode(Action(tick, grant, GoTo(x_m, 0.0), (), tick + 1))


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b"", "malformed: no bytes at all"),
        (b"\xff" * 40, "malformed: schema version 255"),
        (action()[:-1], "malformed: "),
        (codec.encode(Request("status")), "malformed: "),
        (b"\x01" + bytes(codec.MAX_BYTES), "malformed: "),
        (codec.encode(Action(TICK, GRANT, None, (b"",) * 1025, TICK + 1)), "malformed: "),
        (action(grant=GRANT - 1), "stale: grant 2 of tick 5"),
        (action(grant=GRANT + 1), "stale: grant 4 of tick 5"),
        (action(tick=TICK - 1), "stale: grant 3 of tick 4"),
    ],
)
def test_what_is_no_answer_to_the_open_grant_is_an_event_and_the_answer_still_counts(
    ear: Ear, data: bytes, why: str
) -> None:
    ear.act("r2", data)
    ear.act("r2", action(x_m=7.0))
    assert ear.exchange()["r2"].motion == GoTo(7.0, 0.0)
    (told,) = ear.events
    assert (told.kind, told.node, told.data["bytes"]) == ("refused", "r2", len(data))
    assert told.text.startswith(f"an action of r2 was refused: {why}")


def test_only_the_first_answer_to_a_grant_counts(ear: Ear) -> None:
    ear.act("r2", action(x_m=1.0))
    ear.act("r2", action(x_m=2.0))
    assert ear.exchange()["r2"].motion == GoTo(1.0, 0.0)
    ear.boundary()
    assert [one.text for one in ear.events] == ["an action of r2 was refused: no grant is open"]


def test_nobody_answers_for_another(ear: Ear) -> None:
    for node in ("r1", "r3", SPARE, "*", "nobody"):
        ear.act(node, action(x_m=9.0))
    ear.act("r2", action(x_m=1.0))
    assert {node: one.motion for node, one in ear.exchange().items()} == {"r2": GoTo(1.0, 0.0)}
    assert [one.node for one in ear.events] == ["r1", "r3", SPARE, "*", "nobody"]


def test_a_flood_of_garbage_is_a_handful_of_events(ear: Ear) -> None:
    for _ in range(1500):
        ear.act(SPARE, b"garbage")
        ear.hear(channels.ALIVE, True, node=SPARE)
        ear.hear(channels.ALIVE, False, node=SPARE)
    ear.boundary()
    assert sorted(one.data["count"] for one in ear.events) == [1, 1, 10, 10, 100, 100, 1000, 1000]
    assert {one.node for one in ear.events} == {SPARE}


def test_a_flood_that_never_ends_does_not_hold_up_time(ear: Ear) -> None:
    def answer_with_more(*refused: object) -> None:
        ear.act(SPARE, b"more")

    ear.swarm._refuse = answer_with_more  # every message that is refused brings another one
    ear.act(SPARE, b"garbage")
    ear.boundary()


def test_a_spares_token_is_no_life(ear: Ear) -> None:
    ear.hear(channels.ALIVE, True, node=SPARE)
    assert ear.ask(codec.encode(Request("status"))).data["alive"] == []
    assert [(one.kind, one.node) for one in ear.events] == [("refused", SPARE)]


def test_a_notice_that_is_none_is_an_event(ear: Ear) -> None:
    for data in (b"", b"\xff", codec.encode(Request("status"))):
        ear.hear(channels.NOTICE, data)
    ear.boundary()
    assert [one.kind for one in ear.events] == ["refused"] * 3


def test_word_of_nodes_that_do_not_exist_changes_nothing(ear: Ear) -> None:
    ear.hear(channels.NOTICE, codec.encode(Exited("r9", 0, -9)))
    ear.hear(channels.NOTICE, codec.encode(Exited("r2", 4, -9)))
    ear.hear(channels.NOTICE, codec.encode(Started("r9", 1, 0)))
    ear.boundary()
    assert ear.events == []


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0])
@pytest.mark.parametrize("verb", ["step", "speed"])
def test_a_request_with_an_impossible_number_is_answered_with_the_reason(
    ear: Ear, verb: str, value: float
) -> None:
    good = Request(verb, value=1.0)
    data = codec.encode(good).replace(codec.encode(1.0)[1:], codec.encode(value)[1:])
    reply = ear.ask(data)
    assert not reply.accepted
    assert f"got {value}" in reply.text or "finite" in reply.text


@pytest.mark.parametrize("value", [5e-324, 1e-12, 1e300])
def test_no_speed_is_too_small_or_too_large_for_the_clock(ear: Ear, value: float) -> None:
    assert ear.ask(codec.encode(Request("speed", value=value))).accepted
    ear.hear(channels.CONTROL, codec.encode(Request("kill", "r2")), lambda data: None)
    assert next(iter(ear.swarm.boundary(TICK + 1))).fault.verb == "kill"


def test_garbage_for_a_request_is_answered(ear: Ear) -> None:
    reply = ear.ask(b"\xff")
    assert not reply.accepted
    assert reply.text.startswith("not a request: ")


def test_a_session_that_is_nobodys_is_told_and_one_of_the_book_is_not(ear: Ear) -> None:
    stranger = fresh("r2").session
    for session in (BOOK.nodes["r2"].session, ear.wire.session_id, stranger):
        ear.wire.on["sessions"](session, "")
    ear.boundary()
    (told,) = ear.events
    assert (told.kind, told.data["session"]) == ("stranger", stranger)
