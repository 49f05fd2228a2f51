"""The tower of a line patrol: roster, queue, recall and dispatch behind one radio.

Source: papers/line-patrol.txt, section III, Algorithms 2 and 3: the tower is their group leader. Roll calls,
numbered orders that are repeated, losses, the ledger and the start after a kill are ours.
"""

from collections.abc import Sequence
from typing import Annotated, Literal

import msgspec
import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from swarm_agent.line_radio import Envelope, Order, Place, Relay, Report, Roll, Word
from tower import dispatch, queue
from tower.desk import Desk, Entry
from tower.orders import Orders
from tower.recall import robot_to_recall
from tower.roster import Robot, Roster, Silence, can_be_true
from wire.channels import number_of
from wire.line import Line
from wire.messages import WAKE_ON_FRAME, Configuration, Percept

Positive = Annotated[float, msgspec.Meta(gt=0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0)]
Rule = Literal["base", "proactive", "leapfrog", "leapfrog+proactive", "overlap"]
LOW = " low"
HERE = Place(0.0, 0.0)


class LineKeeperParameters(Parameters, frozen=True):
    """`rule`: which of the paper's algorithms; with overlap the robots patrol by themselves.

    Algorithm 3: `low_v` is b_l, `margin_v` is e, and it is asked every `round_s`, as the roll is called. A
    robot is lost after `silence_s`; when `suspect_partition` or more are silent at once, after `partition_s`.
    `retry_s` before, everybody is called. An order is repeated every `retry_s`. At first one robot leaves the
    queue every `dispatch_interval_s`, with at least `ready_v`. After its start the tower listens for
    `listen_s`. Radio: `hops_most`, `age_s` and `contact_s` as for the robots.
    """

    rule: Rule = "proactive"
    low_v: Positive = 8.5
    margin_v: Positive = 0.1
    round_s: Positive = 200.0
    silence_s: Positive = 300.0
    suspect_partition: Annotated[int, msgspec.Meta(ge=2)] = 3
    partition_s: Positive = 1800.0
    retry_s: Positive = 30.0
    dispatch_interval_s: Positive = 10.0
    ready_v: Positive = 8.7
    hops_most: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 64
    age_s: Positive = 60.0
    contact_s: Positive = 600.0
    listen_s: NotNegative = 30.0

    def __post_init__(self) -> None:
        if self.partition_s < self.silence_s:
            raise ValueError(f"partition_s must be >= silence_s ({self.silence_s}), got {self.partition_s}")


class LineKeeper(Behaviour):
    """Hears reports, gives orders, writes down both."""

    Parameters = LineKeeperParameters
    Radio = Envelope

    def __init__(
        self, parameters: LineKeeperParameters, configuration: Configuration, generator: np.random.Generator
    ) -> None:
        super().__init__(parameters, configuration, generator)
        ticks = self._ticks
        self.line = Line(configuration.field, configuration.tower_m)
        after, split, answer = map(ticks, (parameters.silence_s, parameters.partition_s, parameters.retry_s))
        self.roster = Roster(Silence(after, parameters.suspect_partition, split, answer))
        self.orders = Orders(ticks(parameters.retry_s))
        self.vacant: dict[int, int] = {}
        """Segments that nobody covers, and since when."""
        self.recalled: dict[str, int] = {}
        """Robots recalled by Algorithm 3 that have not been in the queue since, and when they were."""
        self.once_covered: set[int] = set()
        name = configuration.node
        radio = (ticks(parameters.age_s), parameters.hops_most, ticks(parameters.contact_s))
        self._relay = Relay(name, name, *radio)
        self._round_ticks = ticks(parameters.round_s)
        self._round_tick = self._listen_until = self._send_tick = 0
        self._promised_tick: int | None = None
        self._record: list[Entry] = []
        self._shown: Desk | None = None

    def remember(self, entries: Sequence[Entry]) -> None:
        """Fold the ledger: what was true when the tower was killed, as far as it had heard."""
        for entry in entries:
            self._take_note(entry)

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Hear, see who is lost, recall, dispatch, and say what is due."""
        tick = percept.tick
        self._record = []
        begins = self._promised_tick is None or tick > self._promised_tick
        if begins:
            self._begin(tick)
        hops = self._hear(tick, heard)
        self._count_losses(tick)
        calls = begins or tick >= self._round_tick
        if tick >= self._listen_until and self.parameters.rule != "overlap":
            if calls:
                self._recall(tick)
            self._resolve_double_claims(tick)
            self._dispatch(tick)
        call_tick = self.roster.next_call_tick()
        answer = begins or (call_tick is not None and tick >= call_tick)
        say = self._say(tick, calls, answer, any(_is_unaware(one.message) for one in heard))
        self._promised_tick = self._next_tick(tick)
        record = tuple(self._record)
        return Move(None, say, self._promised_tick, WAKE_ON_FRAME, self._report(hops), record)

    def _begin(self, tick: int) -> None:
        """Born, or frozen for a while: who was silent meanwhile is given time to answer the roll call."""
        if self._promised_tick is None:
            self._note(tick, Entry("born"))
        self.roster.forgive(tick)
        self._listen_until = tick + round(self.parameters.listen_s / self.configuration.tick_s)

    def _hear(self, tick: int, heard: Sequence[Heard]) -> tuple[int, ...]:
        segments = len(self.line.segments)
        words = [one for one in self._relay.hear(tick, heard, HERE) if can_be_true(tick, one, segments)]
        for word in words:
            one = word.message
            text = one.state + LOW * one.low
            entry = Entry("heard", word.origin, one.segment, one.battery_v, one.order, text)
            if self.roster.is_lost(word.origin):
                self._note(tick, Entry("returned", word.origin))
            if self._hear_report(tick, word):
                self._record.append(entry)
        return tuple(one.hops for one in words)

    def _hear_report(self, tick: int, word: Word) -> bool:
        """Take a report to heart. Is there anything new in it?"""
        news = self.roster.hear(tick, word.origin, word.said_tick, word.message, word.hops)
        robot = self.roster.get(word.origin)
        self.orders.hear(tick, robot)
        recalled_tick = self.recalled.get(word.origin)
        if recalled_tick is not None and robot.state == "queue" and robot.said_tick > recalled_tick:
            del self.recalled[word.origin]
        return news

    def _count_losses(self, tick: int) -> None:
        for node in self.roster.newly_lost(tick):
            self._note(tick, Entry("lost", node))

    def _recall(self, tick: int) -> None:
        """Algorithm 3, once a round."""
        if "proactive" not in self.parameters.rule:
            return
        batteries_v = {
            one.node: one.battery_v
            for one in self.roster.present()
            if one.state == "patrol" and not one.low
            if one.node not in self.recalled.keys() | self.roster.cut_off
            if self.orders.segment(one.node) != 0
        }
        node = robot_to_recall(batteries_v, self.parameters.low_v, self.parameters.margin_v)
        if node is not None:
            self._note(tick, Entry("recall", node, battery_v=batteries_v[node]))
            self._order(tick, node, 0)

    def _resolve_double_claims(self, tick: int) -> None:
        for node in dispatch.one_too_many(self.roster.present(), self._ordered()):
            self._order(tick, node, 0)

    def _dispatch(self, tick: int) -> None:
        """Fill vacancies until nobody more can be sent now."""
        self._compare_coverage(tick)
        while (sending := self._next_sending(tick)) is not None:
            if sending.from_queue and self._deploys():
                self._send_tick = tick + self._ticks(self.parameters.dispatch_interval_s)
            self._order(tick, sending.node, sending.segment)
            self._compare_coverage(tick)

    def _next_sending(self, tick: int) -> dispatch.Sending | None:
        """Under shifting rules too robots come directly from the queue until all was covered once."""
        waiting = self._ready()
        deploys = self._deploys()
        shift = "leapfrog" not in self.parameters.rule and not (deploys and waiting)
        if deploys and tick < self._send_tick:
            waiting = []
        place = {number: place for place, number in enumerate(dispatch.deployment_order(self.line))}
        vacancies = sorted(self.vacant, key=lambda one: (self.vacant[one], place[one]))
        robots, ordered = self.roster.present(), self._ordered()
        busy = self.recalled.keys() | self.roster.cut_off
        situation = dispatch.Situation(robots, ordered, vacancies, waiting, busy)
        return dispatch.next_sending(situation, self.line, shift)

    def _deploys(self) -> bool:
        return len(self.once_covered) < len(self.line.segments)

    def _ready(self) -> list[Robot]:
        return queue.ready(self.roster.present(), self.orders, self.parameters.ready_v)

    def _ordered(self) -> dict[str, int]:
        return {node: self.orders.segment(node) for node in self.orders}

    def _compare_coverage(self, tick: int) -> None:
        """Write down which segments have fallen vacant or are covered again."""
        covered = dispatch.covered(self.roster.present(), self._ordered())
        for segment in (one.number for one in self.line.segments):
            if segment not in covered and segment not in self.vacant:
                self._note(tick, Entry("vacant", segment=segment))
            elif segment in covered and (segment in self.vacant or segment not in self.once_covered):
                self._note(tick, Entry("covered", segment=segment))

    def _order(self, tick: int, node: str, segment: int) -> None:
        order = self.orders.give(tick, node, segment)
        self._record.append(Entry("order", node, segment, number=order.number))

    def _note(self, tick: int, entry: Entry) -> None:
        """Write down something that has just become true, and let it be true."""
        self._record.append(entry)
        self._take_note(msgspec.structs.replace(entry, tick=tick))

    def _take_note(self, entry: Entry) -> None:
        """The one place where an entry, of now or of a former life, changes what the tower knows."""
        match entry.kind:
            case "heard":
                state, low = entry.text.removesuffix(LOW), entry.text.endswith(LOW)
                report = Report(state, entry.segment, entry.battery_v, entry.number, 0, low)
                self._hear_report(entry.tick, Word(entry.node, entry.tick, report, 0))
            case "order":
                order = Order(entry.number, entry.node, entry.segment)
                self.orders.keep(entry.tick, order, said_tick=entry.tick)
            case "recall":
                self.recalled[entry.node] = entry.tick
            case "lost":
                self.roster.lose(entry.node)
                self.orders.drop(entry.node)
                self.recalled.pop(entry.node, None)
            case "returned":
                self.roster.find(entry.node)
            case "vacant":
                self.vacant[entry.segment] = entry.tick
            case "covered":
                self.vacant.pop(entry.segment, None)
                self.once_covered.add(entry.segment)

    def _say(self, tick: int, calls: bool, answer: bool, show: bool) -> tuple[Envelope, ...]:
        """The roll and the orders that are due; what may not be heard directly is to be passed on.

        To `show` that it is in range the tower calls the roll once more.
        """
        direct, passed_on = [], []
        if calls:
            self._round_tick = tick + self._round_ticks
        if answer:
            self.roster.call(tick)
            passed_on.append(Roll(answer))
        elif calls or show:
            direct.append(Roll())
        for order, again in self.orders.due(tick):
            far = again or self._is_far(tick, order.to)
            (passed_on if far else direct).append(order)
        own = self._relay.outbox(tick, direct, HERE, relay=False)
        return own + self._relay.outbox(tick, passed_on, HERE, relay=True)

    def _is_far(self, tick: int, node: str) -> bool:
        """Did its last report come by others, or none for a round?"""
        robot = self.roster.get(node)
        return robot is None or robot.hops > 0 or tick - robot.heard_tick > self._round_ticks

    def _next_tick(self, tick: int) -> int:
        """The next thing that is due, should nothing be heard until then."""
        roster = self.roster
        due = [self._round_tick, self.orders.next_tick(), roster.next_call_tick(), roster.next_loss_tick()]
        if tick < self._listen_until:
            due.append(self._listen_until)
        elif tick < self._send_tick and self._deploys() and self.vacant and self._ready():
            due.append(self._send_tick)
        return max(tick + 1, min(one for one in due if one is not None))

    def _report(self, hops: tuple[int, ...]) -> Desk | None:
        """For observers: only when something changed, reports were heard or orders given."""
        waiting = queue.in_line(self.roster.present(), self.orders)
        lost = tuple(one.node for one in self.roster if one.lost)
        names = tuple(one.node for one in waiting), tuple(sorted(self.vacant))
        desk = Desk(*names, tuple(sorted(self.recalled, key=number_of)), lost)
        orders = tuple(one.number for one in self._record if one.kind == "order")
        if desk == self._shown and not hops and not orders:
            return None
        self._shown = desk
        return msgspec.structs.replace(desk, hops=hops, orders=orders)

    def _ticks(self, duration_s: float) -> int:
        return max(1, round(duration_s / self.configuration.tick_s))


def _is_unaware(envelope: Envelope) -> bool:
    """Does who said this not know that the tower hears it?"""
    return envelope.relay and isinstance(envelope.message, Report)
