"""The node: a mind in a process. Percept bytes in, action bytes out; everything else is the behaviour's."""

import sys
from itertools import repeat
from queue import SimpleQueue

import msgspec
import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Ledger, Move, find_behaviour
from wire import channels, codec
from wire.credentials import Ticket
from wire.link import open_client
from wire.messages import Action, Configuration, Frame, Percept


class Mind:
    """The pure part of a node: a function from one percept's bytes to one action's bytes, with memory."""

    def __init__(self, package: str, ledger: Ledger | None = None) -> None:
        self._package = package
        self._ledger = ledger
        self._behaviour: Behaviour | None = None
        self._answered = -1
        self._last_answer = b""
        self.undecodable_frames = 0

    def answer(self, percept_bytes: bytes) -> bytes | None:
        """The action for one grant; the same again for a repeated grant; None at the end of the run."""
        percept = codec.decode(Percept, percept_bytes)
        if percept.why == "end":
            return None
        if percept.grant == self._answered:
            return self._last_answer
        if percept.configuration is not None:
            self._behaviour = _embody(percept.configuration, self._package)
            if self._ledger is not None:
                self._behaviour.remember(self._ledger.read(percept.grant))
        assert self._behaviour is not None, "the first percept of a node carries its configuration"
        move = self._behaviour.step(percept, self._decode(percept.inbox, percept.senses.bearings))
        if move.record:
            assert self._ledger is not None, "a move with entries for a ledger, in a node without one"
            self._ledger.write(percept.grant, percept.tick, move.record)
        self._last_answer = self._encode(percept, move)
        self._answered = percept.grant
        return self._last_answer

    def close(self) -> None:
        """The run is over: the ledger is put away."""
        if self._ledger is not None:
            self._ledger.close()

    def _decode(self, inbox: tuple[Frame, ...], bearings: bytes = b"") -> list[Heard]:
        """What was heard in the behaviour's vocabulary; what is not in it is counted and dropped."""
        if self._behaviour.Radio is None:
            return []
        decode, heard = codec.decoder(self._behaviour.Radio), []
        measured = np.frombuffer(bearings, "<f4").reshape(-1, 2).tolist() or repeat(())
        for frame, bearing in zip(inbox, measured, strict=False):
            try:
                message = decode(frame.payload)
            except codec.Malformed:
                self.undecodable_frames += 1
            else:
                heard.append(Heard(frame.sender, frame.sent_tick, message, *bearing))
        return heard

    @staticmethod
    def _encode(percept: Percept, move: Move) -> bytes:
        action = Action(
            percept.tick,
            percept.grant,
            move.motion,
            tuple(codec.encode(message) for message in move.say),
            move.wake_tick,
            move.wake_on,
            b"" if move.report is None else codec.encode(move.report),
        )
        answer = codec.encode(action)
        codec.decode(Action, answer)  # a wrong answer must fail here, by name, and not hang the world
        return answer


def _embody(configuration: Configuration, package: str) -> Behaviour:
    behaviour = find_behaviour(configuration.behaviour, package)
    parameters = codec.decode(behaviour.Parameters, configuration.parameters)
    sequence = np.random.SeedSequence(configuration.generator_key)
    return behaviour(parameters, configuration, np.random.Generator(np.random.Philox(sequence)))


def live(ticket: Ticket, package: str, memory: list[bytes], ledger: Ledger | None = None) -> None:
    """Join the run and answer grants until the end. `memory`: percepts of a former life, lived first."""
    mind = Mind(package, ledger)
    for percept_bytes in memory:
        mind.answer(percept_bytes)
    node, grants = ticket.credential.user, SimpleQueue()
    link = open_client(ticket)
    action = link.publisher(channels.key(ticket.run, channels.ACTION, node))
    link.subscribe(channels.key(ticket.run, channels.PERCEPT, node), lambda _, data: grants.put(data))
    link.announce(channels.key(ticket.run, channels.ALIVE, node))
    try:
        while (answer := _answer(mind, grants.get())) is not None:
            if answer:
                action.put(answer)
    finally:
        mind.close()
        link.close()


def _answer(mind: Mind, data: bytes) -> bytes | None:
    """A percept that does not decode is no grant: say so in the log and go on."""
    try:
        return mind.answer(data)
    except codec.Malformed as error:
        print(f"a percept was dropped: {error}", file=sys.stderr, flush=True)
        return b""


def percepts_of(memory: bytes) -> list[bytes]:
    """Split what the launcher hands to a node restarted with its memory."""
    return msgspec.msgpack.decode(memory, type=list[bytes]) if memory else []
