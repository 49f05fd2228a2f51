"""Grants out, actions in: the node processes as the clock sees them. One owner thread reads one queue.

Everything that reaches the world arrives here and is believed only as far as its key proves: an action from
a node with an open grant that carries that grant's number; everything else is counted, told as an event with
the sender's id, and dropped.
"""

import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from queue import Empty, SimpleQueue
from typing import Any

from wire import channels, codec
from wire.credentials import Book
from wire.link import Link
from wire.messages import (
    Action,
    Done,
    Event,
    Exited,
    Facts,
    Fault,
    Finish,
    Notice,
    Order,
    Percept,
    Reply,
    Request,
    Senses,
    Started,
    TruthBlock,
)
from wire.scenario import Scenario
from world_server.clock import Befallen

START_WITHIN_S = 60.0
ORDER_WITHIN_S = 30.0
TOKEN_WITHIN_S = 5.0
SHOW_EVERY_S = 0.1
SHOW_AT_MOST = 500
WATCHDOG_AT = (1, 3, 10)
FAULT_VERBS = ("kill", "freeze", "thaw", "restart")


class Abort(Exception):
    """The run cannot go on; the text says why."""


class LiveSwarm:
    """All node processes of a run, behind one link. Also the ear for operators and for the launcher."""

    def __init__(self, link: Link, book: Book, scenario: Scenario, write_event: Callable[[Event], None]) -> None:
        self.finishing = False
        self._scenario = scenario
        self._write_event = write_event
        self._tick = 0
        self._queue: SimpleQueue = SimpleQueue()
        self._alive: set[str] = set()
        self._pids: dict[str, int] = {}
        self._incarnations: dict[str, int] = dict.fromkeys(scenario.node_ids, -1)
        self._open: dict[str, tuple[int, bytes]] = {}
        self._answers: dict[str, Action] = {}
        self._gone: dict[str, str] = {}
        self._wishes: list[tuple[Request, Callable[[bytes], None]]] = []
        self._refusals: Counter = Counter()
        self._order = 0
        self._done: dict[int, Done] = {}
        self._paused, self._steps = False, 0
        self._pace = scenario.clock.rate if scenario.clock.kind == "paced" else None
        self._pace_origin: tuple[int, float] | None = None
        self._shown: list[Facts] = []
        self._shown_at, self._block = 0.0, 0
        self._known_sessions = {one.session for one in book.everyone} | {link.session_id}
        self._listen(link, book)

    def _listen(self, link: Link, book: Book) -> None:
        run, put = book.run, self._queue.put
        self._percepts = {
            node: link.publisher(channels.key(run, channels.PERCEPT, node)) for node in self._scenario.node_ids
        }
        self._orders = link.publisher(channels.key(run, channels.ORDER))
        self._truth = link.publisher(channels.key(run, channels.TRUTH), droppable=True)
        self._events = link.publisher(channels.key(run, channels.EVENT), droppable=True)
        link.subscribe(channels.key(run, channels.ACTION), lambda key, data: put((self._on_action, key, data)))
        link.subscribe(channels.key(run, channels.NOTICE), lambda _, data: put((self._on_notice, data)))
        link.watch_tokens(channels.key(run, channels.ALIVE), lambda key, alive: put((self._on_token, key, alive)))
        link.watch_sessions(lambda session: put((self._on_session, session)))
        link.answer(channels.key(run, channels.CONTROL), lambda data, reply: put((self._on_request, data, reply)))

    # What the clock asks for

    def gather(self) -> None:
        """Wait until every node has started and is heard of. Raises Abort with the names of the missing."""
        nodes = set(self._scenario.node_ids)
        self._wait(lambda: nodes <= self._alive | self._gone.keys() or self.finishing, START_WITHIN_S)
        missing = sorted(nodes - self._alive, key=channels.number_of)
        if missing and not self.finishing:
            raise Abort(f"no sign of {', '.join(map(self._called, missing))} within {START_WITHIN_S:.0f} s")

    def exchange(self, tick: int, percepts: Mapping[str, Percept]) -> Mapping[str, Action]:
        """Put every grant, collect every answer; names whoever is late, and acts on it as the policy says."""
        self._tick, self._answers = tick, {}
        for node, percept in percepts.items():
            if node not in self._gone:
                self._open[node] = (percept.grant, codec.encode(percept))
        for node, (_, data) in self._open.items():
            self._percepts[node].put(data)
        since, warned = time.monotonic(), 0
        while self._open:
            budget_s = self._scenario.watchdog.budget_s
            limit = since + budget_s * WATCHDOG_AT[warned] if warned < len(WATCHDOG_AT) else None
            if not self._take(limit):
                self._warn(time.monotonic() - since)
                warned += 1
                if warned == len(WATCHDOG_AT):
                    self._lose_patience()
        for node in percepts.keys() & self._gone.keys():
            if node not in self._answers:
                self._gone.pop(node)
        return self._answers

    def enforce(self, fault: Fault) -> str:
        """Order a fault from the launcher and see it happen. Returns why not, empty when it did."""
        began = time.monotonic()
        self._order += 1
        number, node = self._order, fault.node
        self._orders.put(codec.encode(Order(number, fault)))
        self._wait(lambda: number in self._done, ORDER_WITHIN_S)
        done = self._done.pop(number, None)
        if done is None or not done.confirmed:
            return done.reason if done else f"no word from the launcher within {ORDER_WITHIN_S:.0f} s"
        if fault.verb == "kill":
            self._wait(lambda: node not in self._alive, TOKEN_WITHIN_S)
        elif fault.verb in ("restart", "thaw"):
            self._wait(lambda: node in self._alive or node in self._gone, ORDER_WITHIN_S)
            if node in self._gone:
                return self._gone.pop(node)
            if node not in self._alive:
                return f"it did not come back within {ORDER_WITHIN_S:.0f} s"
        pause_ms = round(1000 * (time.monotonic() - began), 2)
        data = {"verb": fault.verb, "confirmed": True, "pid": self._pids.get(node), "pause_ms": pause_ms}
        self.tell(Event(fault.tick, "fault", node, f"{fault.verb} {self._called(node)}, confirmed", data))
        return ""

    def boundary(self, tick: int) -> Iterator[Befallen]:
        """Hold for the pace and for a pause; then give out deaths and operators' wishes, in order of arrival."""
        self._tick = tick
        self._drain()
        self._hold(tick)
        for node in sorted(self._gone, key=channels.number_of):
            self._gone.pop(node)
            yield Befallen(Fault(tick, "kill", node), True, lambda trouble: None)
        while self._wishes:
            wish, reply = self._wishes.pop(0)
            yield Befallen(Fault(tick, wish.verb, wish.node, wish.memory), False, self._answerer(wish, reply))
        if self._steps:
            self._steps -= 1

    def tell(self, event: Event) -> None:
        """Write an event down and tell observers."""
        self._write_event(event)
        self._events.put(codec.encode(event))

    def show(self, facts: Facts) -> None:
        """Collect facts and give them to observers a few times a second."""
        self._shown.append(facts)
        now = time.monotonic()
        if now - self._shown_at > SHOW_EVERY_S or len(self._shown) >= SHOW_AT_MOST:
            self._flush(now)

    def finish(self, tick: int) -> None:
        """Tell all nodes that it is over, and observers the last facts."""
        self._flush(time.monotonic())
        end = codec.encode(Percept(tick, 2**53, "end", Senses()))
        for node in self._alive & set(self._percepts):
            self._percepts[node].put(end)

    # What arrives

    def _on_action(self, key: str, data: bytes) -> None:
        node = channels.node_of(key)
        if node not in self._open:
            known = node in self._percepts
            return self._refuse(node, "no grant is open" if known else "it is a spare without a body", data)
        grant, _ = self._open[node]
        try:
            action = codec.decode(Action, data)
        except codec.Malformed as error:
            return self._refuse(node, f"malformed: {error}", data)
        if (action.grant, action.tick) != (grant, self._tick):
            return self._refuse(node, f"stale: grant {action.grant} of tick {action.tick}", data)
        self._answers[node] = action
        del self._open[node]

    def _refuse(self, node: str, why: str, data: bytes) -> None:
        """Tell of the 1st, 10th, 100th ... refusal of a kind, so that a flood of garbage floods nothing else."""
        kind = why.split(":")[0]
        self._refusals[node, kind] += 1
        count = self._refusals[node, kind]
        if str(count).strip("0") == "1":
            text = f"an action of {node} was refused: {why}"
            self.tell(Event(self._tick, "refused", node, text, {"bytes": len(data), "count": count}))

    def _on_token(self, key: str, alive: bool) -> None:
        node = channels.node_of(key)
        if not alive:
            return self._alive.discard(node)
        if node not in self._percepts:
            return self.tell(Event(self._tick, "refused", node, f"{node} is a spare without a body; it is ignored"))
        self._alive.add(node)
        if node in self._open:  # its link broke with a grant under way: put it again, it is idempotent
            self._percepts[node].put(self._open[node][1])

    def _on_session(self, session: str) -> None:
        if session not in self._known_sessions:
            text = f"session {session} joined with somebody's password, but is not theirs: it has no rights"
            self.tell(Event(self._tick, "stranger", "", text, {"session": session}))

    def _on_notice(self, data: bytes) -> None:
        notice = codec.decode(Notice, data)
        match notice:
            case Started(node, pid, incarnation):
                self._pids[node], self._incarnations[node] = pid, incarnation
            case Done(number):
                self._done[number] = notice
            case Exited(node, incarnation, status, last_lines):
                if incarnation == self._incarnations[node]:
                    self._on_death(node, status, last_lines)
            case Finish():
                self.finishing = True

    def _on_death(self, node: str, status: int, last_lines: str) -> None:
        """A process ended that nobody ordered to end."""
        how = f"killed by signal {-status}" if status < 0 else f"exit code {status}"
        text = f"{self._called(node)} died: {how}"
        self.tell(Event(self._tick, "death", node, text, {"status": status, "last_lines": last_lines}))
        self._gone[node] = text
        self._alive.discard(node)
        self._open.pop(node, None)

    def _on_request(self, data: bytes, reply: Callable[[bytes], None]) -> None:
        try:
            request = codec.decode(Request, data)
        except codec.Malformed as error:
            return reply(codec.encode(Reply(False, f"not a request: {error}")))
        if request.verb in FAULT_VERBS:
            return self._wishes.append((request, reply))
        reply(codec.encode(self._steer(request)))

    def _steer(self, request: Request) -> Reply:
        """Carry out a request that touches only the pace of time."""
        match request.verb:
            case "pause":
                self._paused = True
            case "resume":
                self._paused, self._pace_origin = False, None
            case "step":
                self._paused, self._steps = True, self._steps + max(1, round(request.value))
            case "speed":
                if request.value < 0:
                    return Reply(False, f"speed must be >= 0 (0: as fast as it goes), got {request.value}")
                self._pace, self._pace_origin = request.value or None, None
        return Reply(True, request.verb, self._status())

    # How

    def _wait(self, until: Callable[[], bool], at_most_s: float) -> None:
        limit = time.monotonic() + at_most_s
        while not until() and self._take(limit):
            pass

    def _take(self, limit: float | None) -> bool:
        """Handle one thing that arrived, waiting for it until `limit`. False when nothing came."""
        try:
            timeout = None if limit is None else max(0.0, limit - time.monotonic())
            handler, *given = self._queue.get(timeout=timeout)
        except Empty:
            return False
        handler(*given)
        return True

    def _drain(self) -> None:
        while not self._queue.empty():
            self._take(time.monotonic())

    def _hold(self, tick: int) -> None:
        """Let time stand still while paused, and until the pace allows this tick."""
        while not self.finishing and not self._wishes:
            if self._paused:
                if self._steps:
                    return
                self._flush(time.monotonic())  # observers of a run that stands still see where it stands
                self._take(None)
            elif self._pace is None or not self._take(self._due(tick)):
                return

    def _due(self, tick: int) -> float:
        """When the pace allows this tick."""
        if self._pace_origin is None:
            self._pace_origin = (tick, time.monotonic())
        origin, began = self._pace_origin
        return began + (tick - origin) * self._scenario.tick_s / self._pace

    def _warn(self, waited_s: float) -> None:
        for node, (grant, _) in self._open.items():
            text = f"{self._called(node)} has not answered grant {grant} for {waited_s:.1f} s"
            data = {"pid": self._pids.get(node), "grant": grant, "waited_s": round(waited_s, 3)}
            self.tell(Event(self._tick, "watchdog", node, text, data))

    def _lose_patience(self) -> None:
        policy = self._scenario.watchdog.policy
        late = list(self._open)
        if policy == "abort":
            raise Abort(f"no answer from {', '.join(map(self._called, late))}; watchdog.policy is abort")
        for node in late if policy == "declare_dead" else ():
            if node in self._open and not self.enforce(Fault(self._tick, "kill", node)):
                self._open.pop(node, None)

    def _answerer(self, wish: Request, reply: Callable[[bytes], None]) -> Callable[[str], None]:
        def answer(trouble: str) -> None:
            text = trouble or f"{wish.verb} {wish.node} at tick {self._tick}, confirmed"
            reply(codec.encode(Reply(not trouble, text, self._status())))

        return answer

    def _status(self) -> dict[str, Any]:
        scenario = self._scenario
        return {
            "tick": self._tick,
            "sim_s": self._tick * scenario.tick_s,
            "duration_s": scenario.duration_s,
            "paused": self._paused,
            "rate": self._pace,
            "alive": sorted(self._alive & set(self._percepts), key=channels.number_of),
            "waiting_for": list(self._open),
        }

    def _called(self, node: str) -> str:
        return f"{node} (pid {self._pids[node]})" if node in self._pids else node

    def _flush(self, now: float) -> None:
        if self._shown:
            block = TruthBlock(self._block, self._scenario.node_ids, tuple(self._shown))
            self._truth.put(codec.encode(block))
            self._shown, self._shown_at, self._block = [], now, self._block + 1
