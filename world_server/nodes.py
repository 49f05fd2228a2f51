"""What the world keeps about each node: whether it runs, when it wants to be woken, and its inbox."""

from typing import NamedTuple

from wire import codec
from wire.messages import WAKE_ON_ARRIVAL, WAKE_ON_BLOCKED, WAKE_ON_FRAME, WAKE_ON_SENSOR, Action, Frame, Why
from world_server.motion import Body
from world_server.records import FrameRef

ALIVE, FROZEN, DEAD, FLAT = 0, 1, 2, 3
STATES = ("alive", "frozen", "dead", "flat")
INBOX_BYTES = codec.MAX_BYTES // 2  # an inbox must fit into a percept
LETTER_BYTES = 32  # more than what a frame needs around its payload


class Letter(NamedTuple):
    """A frame on its way: when it is heard, sender's row and place in its outbox. Receivers share it.

    `bearing`: range_m and bearing_rad at which a receiver measured the sender, in missions that have it.
    """

    heard_tick: int
    sent_tick: int
    sender: int
    index: int
    frame: Frame
    reference: FrameRef
    bearing: tuple[float, float] = (0.0, 0.0)


class Node:
    """One node as the world sees it. Rows are places in the list of all nodes, ordered by number."""

    def __init__(self, name: str, body: Body, sensor_range_m: float, inbox_frames: int) -> None:
        self.name = name
        self.body = body
        self.sensor_range_m = sensor_range_m
        self.mode = ALIVE
        self.incarnation = 0
        self.newborn = True
        self.every = 1
        self.grants = 0
        self.refused_frames = 0
        self.seen: tuple[str, ...] = ()
        self.arrival_pending = False
        self.on_patrol = False
        self.blocked_by: str | None = None
        self.blocked_pending = False
        self.flat = False
        self._held_up: tuple[str, float] | None = None
        self._errand: object = None
        self._letters: list[Letter] = []
        self._inbox_frames = inbox_frames
        self._wake_tick: int | None = 0
        self._wake_on = 0

    def due(self, tick: int, seen: tuple[str, ...] | None) -> Why | None:
        """Why this node is to be granted `tick`, or None. `seen`: names in sight, where it asked for them."""
        if self.mode != ALIVE or tick % self.every:
            return None
        if self.newborn:
            return "start"
        if self._wake_tick is not None and self._wake_tick <= tick:
            return "wake"
        if self._wake_on & WAKE_ON_FRAME and any(letter.heard_tick <= tick for letter in self._letters):
            return "frame"
        if self._wake_on & WAKE_ON_ARRIVAL and self.arrival_pending:
            return "arrival"
        if self._wake_on & WAKE_ON_BLOCKED and self.blocked_pending:
            return "blocked"
        if seen is not None and seen != self.seen:
            return "sensor"
        return None

    @property
    def watches(self) -> bool:
        """Does the node want to be woken when what it sees changes?"""
        return self.mode == ALIVE and bool(self._wake_on & WAKE_ON_SENSOR)

    def next_due(self, tick: int) -> int | None:
        """The first tick after `tick` at which time or a frame on its way makes this node due."""
        wanted = self._next_wanted(tick)
        return None if wanted is None else -(-wanted // self.every) * self.every

    def _next_wanted(self, tick: int) -> int | None:
        if self.mode != ALIVE:
            return None
        if self.arrival_pending and self._wake_on & WAKE_ON_ARRIVAL:
            return tick + 1
        if self.blocked_pending and self._wake_on & WAKE_ON_BLOCKED:
            return tick + 1
        heard = [letter.heard_tick for letter in self._letters] if self._wake_on & WAKE_ON_FRAME else []
        wake = [] if self._wake_tick is None else [self._wake_tick]
        return max(tick + 1, min(heard + wake)) if heard or wake else None

    def heard(self, tick: int) -> list[Letter]:
        """Letters that this node hears by `tick`, in order of tick, sender and place; the newest that fit."""
        letters = sorted(letter for letter in self._letters if letter.heard_tick <= tick)
        letters = letters[-self._inbox_frames :]
        room = INBOX_BYTES
        for newer, letter in enumerate(reversed(letters)):
            room -= len(letter.frame.payload) + LETTER_BYTES
            if room < 0:
                return letters[len(letters) - newer :]
        return letters

    def deliver(self, letter: Letter) -> None:
        """Put a frame into the inbox; when it is full the oldest goes. Frames under way take no place."""
        letters, most = self._letters, self._inbox_frames
        letters.append(letter)  # in order of hearing, as all frames of a run take equally long
        while len(letters) > most and letters[most].heard_tick <= letter.sent_tick + 1:
            del letters[0]

    def answered(self, tick: int, action: Action) -> None:
        """Take over what an accepted action says of waking; what was in the inbox has been heard."""
        self._letters = [letter for letter in self._letters if letter.heard_tick > tick]
        self._wake_tick, self._wake_on = action.wake_tick, action.wake_on
        self.newborn = False
        self.grants += 1
        self.refused_frames = 0
        self.blocked_pending = False
        self.arrival_pending = self.body.command(action.motion)
        if action.motion is not None:
            self.on_patrol = True
            self.blocked_by = self._held_up = None

    def hold_up(self, by: str | None, body_m: float) -> None:
        """Note the body that this one waits behind, if any, once for each that it comes up against.

        Waiting again behind the same one is news only when it has gone on by more than a body's distance.
        """
        self.blocked_by = by
        if by is None:
            self.blocked_pending = False
            return
        travelled_m = self.body.travelled_m
        held_up = self._held_up
        if held_up is None or held_up[0] != by or travelled_m - held_up[1] > body_m:
            self._held_up, self.blocked_pending = (by, travelled_m), True

    @property
    def silent(self) -> bool:
        """Dead or without charge: the radio is off."""
        return self.flat or self.mode == DEAD

    def thaw(self) -> None:
        """The process goes on."""
        self.mode = FLAT if self.flat else ALIVE

    def run_flat(self) -> None:
        """The charge is used up: the body stops, the radio falls silent, the mind is asked no more."""
        self.flat = True
        self.mode = FLAT if self.mode == ALIVE else self.mode
        self._fall_silent()

    def recharge(self) -> None:
        """There is charge again."""
        self.flat = False
        self.mode = ALIVE if self.mode == FLAT else self.mode

    def die(self) -> None:
        """The body stays where it is; radio and mind are gone."""
        self.mode = DEAD
        self._errand = self._fall_silent()

    def _fall_silent(self) -> object:
        """Stop and forget all that was to come. Returns the errand that is broken off."""
        self._letters = []
        self._wake_tick, self._wake_on = None, 0
        self.arrival_pending = self.blocked_pending = False
        self.blocked_by = self._held_up = None
        return self.body.halt()

    def rise(self, tick: int, keeps_memory: bool) -> None:
        """A new process for the old body. A kept memory goes on with its errand, so that a visit completed
        as it died counts when it wakes, for it and for the world.
        """
        self.mode = FLAT if self.flat else ALIVE
        if keeps_memory and not self.flat:
            self.body.resume(self._errand)
        self.incarnation += 1
        self.newborn = self.newborn or not keeps_memory  # who never began has nothing to keep
        self.refused_frames, self.arrival_pending, self.seen = 0, False, ()
        self._wake_tick = tick
