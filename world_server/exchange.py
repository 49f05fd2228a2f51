"""Grants out, actions in: the node processes as the clock sees them. One owner thread reads one queue.

Everything that reaches the world arrives here and is believed only as far as its key proves: an action from
a node with an open grant that carries that grant's number; everything else is counted, told as an event with
the sender's id, and dropped.
"""

import math
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from wire import channels, codec
from wire.credentials import Book
from wire.link import Link
from wire.messages import (
    Action,
    Done,
    Event,
    Exited,
    Fault,
    Finish,
    Notice,
    Order,
    Percept,
    Reply,
    Request,
    Senses,
    Started,
)
from wire.scenario import Scenario
from world_server.clock import Abort, Befallen, Interrupted
from world_server.mailbox import Mailbox
from world_server.observers import Observers
from world_server.pace import Pace
from world_server.strangers import process_behind

START_WITHIN_S = 60.0
ORDER_WITHIN_S = 30.0
REMEMBER_WITHIN_S = 1800.0  # a mind that is to be kept is first fed with all it ever heard
TOKEN_WITHIN_S = 5.0
LAST_ANSWERS_WITHIN_S = 1.0
WATCHDOG_AT = (1, 3, 10)
FAULT_VERBS = ("kill", "freeze", "thaw", "restart")


class LiveSwarm:
    """All node processes of a run, behind one link. Also the ear for operators and for the launcher."""

    def __init__(
        self, link: Link, book: Book, scenario: Scenario, write_event: Callable[[Event], None]
    ) -> None:
        self.finishing = False
        self._last_moment = math.inf
        self._scenario = scenario
        self._tick = 0
        self._mailbox = Mailbox()
        self._alive: set[str] = set()
        self._pids: dict[str, int] = {}
        self._incarnations: dict[str, int] = dict.fromkeys(scenario.node_ids, -1)
        self._open: dict[str, tuple[int, bytes]] = {}
        self._answers: dict[str, Action] = {}
        self._gone: dict[str, str] = {}
        self._wishes: list[tuple[Request, Callable[[bytes], None]]] = []
        self._order = 0
        self._done: dict[int, Done] = {}
        self._pace = Pace(scenario.clock, scenario.tick_s)
        self._observers = Observers(link, book.run, scenario.node_ids, write_event)
        self.tell, self.show = self._observers.tell, self._observers.show
        self._known_sessions = {one.session for one in book.everyone} | {link.session_id}
        self._listen(link, book)

    def _listen(self, link: Link, book: Book) -> None:
        def key(channel: channels.Channel, node: str = "*") -> str:
            return channels.key(book.run, channel, node)

        self._percepts = {
            node: link.publisher(key(channels.PERCEPT, node)) for node in self._scenario.node_ids
        }
        self._orders = link.publisher(key(channels.ORDER))
        into = self._mailbox.into
        link.subscribe(key(channels.ACTION), into(self._on_action))
        link.subscribe(key(channels.NOTICE), into(self._on_notice))
        link.watch_tokens(key(channels.ALIVE), into(self._on_token))
        link.watch_sessions(into(self._on_session))
        link.answer(key(channels.CONTROL), into(self._on_request))

    def gather(self) -> None:
        """Wait until every node has started and is heard of. Raises Abort, with the names of the missing."""
        nodes = set(self._scenario.node_ids)
        self._mailbox.wait(lambda: nodes <= self._alive or self._gone or self.finishing, START_WITHIN_S)
        missing = sorted(nodes - self._alive, key=channels.number_of)
        if self._gone and not self.finishing:
            raise Abort("; ".join(self._gone.values()) + ", before the run began; its log says more")
        if missing and not self.finishing:
            raise Abort(f"no sign of {', '.join(map(self._called, missing))} within {START_WITHIN_S:.0f} s")

    def exchange(self, tick: int, percepts: Mapping[str, Percept]) -> Mapping[str, Action]:
        """Put every grant, collect every answer; names whoever is late, and acts on it as the policy says."""
        self._tick, self._answers = tick, {}
        for node, percept in percepts.items():
            if node not in self._gone:
                data = codec.encode(percept)
                self._open[node] = (percept.grant, data)
                self._percepts[node].put(data)  # at once: nodes think while others' grants are encoded
        self._await_answers()
        for node in percepts.keys() & self._gone.keys():
            if node not in self._answers:
                self._gone.pop(node)
        return self._answers

    def _await_answers(self) -> None:
        since, warned = time.monotonic(), 0
        while self._open:
            budget_s = self._scenario.watchdog.budget_s
            limit = since + budget_s * WATCHDOG_AT[warned] if warned < len(WATCHDOG_AT) else math.inf
            if self._mailbox.take(min(limit, self._last_moment)):
                continue
            if self.finishing:
                raise Interrupted
            self._warn(time.monotonic() - since)
            warned += 1
            if warned == len(WATCHDOG_AT):
                self._lose_patience()

    def enforce(self, fault: Fault) -> str:
        """Order a fault from the launcher and see it happen. Returns why not, empty when it did."""
        began = time.monotonic()
        self._order += 1
        number, node = self._order, fault.node
        self._orders.put(codec.encode(Order(number, fault)))
        patience_s = REMEMBER_WITHIN_S if fault.memory == "kept" else ORDER_WITHIN_S
        self._mailbox.wait(lambda: number in self._done, patience_s)
        done = self._done.pop(number, None)
        if done is None or not done.confirmed:
            return done.reason if done else f"no word from the launcher within {patience_s:.0f} s"
        if fault.verb == "kill":
            self._mailbox.wait(lambda: node not in self._alive, TOKEN_WITHIN_S)
        elif fault.verb in ("restart", "thaw"):
            self._mailbox.wait(lambda: node in self._alive or node in self._gone, patience_s)
            if node in self._gone:
                return self._gone.pop(node)
            if node not in self._alive:
                return f"it did not come back within {patience_s:.0f} s"
        pause_ms = round(1000 * (time.monotonic() - began), 2)
        data = {"verb": fault.verb, "confirmed": True, "pid": self._pids.get(node), "pause_ms": pause_ms}
        self.tell(Event(fault.tick, "fault", node, f"{fault.verb} {self._called(node)}, confirmed", data))
        return ""

    def boundary(self, tick: int) -> Iterator[Befallen]:
        """Hold for the pace and for a pause; give out deaths and operators' wishes as they arrive."""
        self._tick = tick
        self._mailbox.drain()
        while True:
            wanted = self._hold(tick)
            for node in sorted(self._gone, key=channels.number_of):
                self._gone.pop(node)
                yield Befallen(Fault(tick, "kill", node), True, lambda trouble: None)
            if not wanted:
                return
            wish, reply = self._wishes.pop(0)
            fault = Fault(tick, wish.verb, wish.node, wish.memory, wish.place)
            yield Befallen(fault, False, self._answerer(wish, reply))

    def finish(self, tick: int) -> None:
        """Tell all nodes that it is over, and observers the last facts."""
        self._observers.flush()
        end = codec.encode(Percept(tick, 2**53, "end", Senses()))
        for node in self._alive & set(self._percepts):
            self._percepts[node].put(end)

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
        text = f"an action of {node} was refused: {why}"
        kind = why.split(":")[0]
        self._observers.tell_some(self._tick, "refused", node, text, {"bytes": len(data)}, of=kind)

    def _on_token(self, key: str, alive: bool) -> None:
        node = channels.node_of(key)
        if not alive:
            return self._alive.discard(node)
        if node not in self._percepts:
            text = f"{node} is a spare without a body; it is ignored"
            return self._observers.tell_some(self._tick, "refused", node, text, {})
        self._alive.add(node)
        if node in self._open:  # its link broke with a grant under way: put it again, it is idempotent
            self._percepts[node].put(self._open[node][1])

    def _on_session(self, session: str, address: str) -> None:
        if session not in self._known_sessions:
            who, data = process_behind(address), {"session": session, "address": address}
            text = f"{who} joined with somebody's password, but not with their session: it has no rights"
            self._observers.tell_some(self._tick, "stranger", "", text, data)

    def _on_notice(self, key: str, data: bytes) -> None:
        try:
            notice = codec.decode(Notice, data)
        except codec.Malformed as error:
            text = f"a notice of the launcher was refused: {error}"
            return self.tell(Event(self._tick, "refused", "", text))
        match notice:
            case Started(node, pid, incarnation):
                self._pids[node], self._incarnations[node] = pid, incarnation
            case Done(number):
                self._done[number] = notice
            case Exited(node, incarnation, status, last_lines):
                if incarnation == self._incarnations.get(node):
                    self._on_death(node, status, last_lines)
            case Finish():
                self.finishing = True
                self._last_moment = time.monotonic() + LAST_ANSWERS_WITHIN_S

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
        self._pace.steer(request)
        reply(codec.encode(Reply(True, request.verb, self._status())))

    def _hold(self, tick: int) -> bool:
        """Let time stand still until the pace allows this tick, or, when True, somebody wants something."""
        while not self.finishing and not self._wishes:
            due_s = self._pace.due_s(tick, time.monotonic())
            if due_s == math.inf:
                self._observers.flush()  # who looks at a run that stands still sees where it stands
            if due_s <= time.monotonic() or not self._mailbox.take(due_s):
                break
        if self._wishes and not self.finishing:
            return True
        late_s = self._pace.begin(tick, time.monotonic())
        if late_s:
            text = f"{late_s:.1f} s behind the pace of {self._pace.rate:g} simulated seconds per second"
            self._observers.tell_some(tick, "late", "", text, {"late_s": round(late_s, 3)}, of="pace")
        return False

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
            "paused": self._pace.paused,
            "rate": self._pace.rate,
            "alive": sorted(self._alive & set(self._percepts), key=channels.number_of),
            "waiting_for": list(self._open),
            "pids": self._pids,
        }

    def _called(self, node: str) -> str:
        return f"{node} (pid {self._pids[node]})" if node in self._pids else node
