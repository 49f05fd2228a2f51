"""Behaviours that do what a test tells them and report what they were told."""

from collections.abc import Sequence

import msgspec

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from wire.messages import Dock, Follow, GoTo, Motion, Percept, Stay


class Note(msgspec.Struct, frozen=True, array_like=True):
    """What scripted robots say to each other."""

    text: str


class Script(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One robot's part. `go`: tick -> [x_m, y_m, within_m], an empty list stays. `say`: tick -> texts.

    `follow`: tick -> the points of a path. `dock`: ticks.
    """

    wake_ticks: tuple[int, ...] = ()
    every_tick: bool = False
    wake_on: int = 0
    go: dict[str, tuple[float, ...]] = {}
    say: dict[str, tuple[str, ...]] = {}
    say_always: str = ""
    fail_at: int = -1
    follow: dict[str, tuple[tuple[float, float], ...]] = {}
    backwards: bool = False
    dock: tuple[int, ...] = ()


class Log(msgspec.Struct, frozen=True, array_like=True):
    """What a scripted robot reports of one grant."""

    why: str
    x_m: float
    y_m: float
    heard: tuple[tuple[str, int, str], ...]
    in_sight: tuple[str, ...]
    refused_frames: int
    grants: int
    draw: float
    arrived: bool
    travelled_m: float
    blocked_by: str | None
    battery_v: float | None


class ScriptedParameters(Parameters, frozen=True):
    """A script for each robot; one that has none sleeps for good."""

    scripts: dict[str, Script] = {}


class Scripted(Behaviour):
    """Plays its script and remembers how many grants it lived through."""

    Parameters = ScriptedParameters
    Radio = Note

    def __init__(self, parameters, configuration, generator) -> None:
        super().__init__(parameters, configuration, generator)
        self.script = parameters.scripts.get(configuration.node, Script())
        self.grants = 0

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Play the line of this tick."""
        tick, script = percept.tick, self.script
        if tick == script.fail_at:
            raise RuntimeError("as the script says")
        self.grants += 1
        said = script.say.get(str(tick), ()) + ((script.say_always,) if script.say_always else ())
        later = [one for one in script.wake_ticks if one > tick]
        wake = tick + 1 if script.every_tick else min(later, default=None)
        return Move(
            self._motion(tick), tuple(map(Note, said)), wake, script.wake_on, self._log(percept, heard)
        )

    def _motion(self, tick: int) -> Motion | None:
        script, where = self.script, self.script.go.get(str(tick))
        if tick in script.dock:
            return Dock()
        if str(tick) in script.follow:
            return Follow(script.follow[str(tick)], script.backwards)
        return None if where is None else GoTo(*where) if where else Stay()

    def _log(self, percept: Percept, heard: Sequence[Heard]) -> Log:
        senses = percept.senses
        return Log(
            percept.why,
            senses.pose.x_m,
            senses.pose.y_m,
            tuple((one.sender, one.sent_tick, one.message.text) for one in heard),
            tuple(one.node for one in senses.in_sight),
            senses.refused_frames,
            self.grants,
            self.generator.random(),
            senses.arrived,
            senses.travelled_m,
            senses.blocked_by,
            senses.battery_v,
        )
