"""The lockstep clock: the only code that makes time go on. The same for processes and for the rehearsal."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple, Protocol

from wire.messages import Action, Event, Fault, Percept
from world_server.fault_plan import FaultPlan
from world_server.journal import Journal
from world_server.records import Commit
from world_server.world import World


class Abort(Exception):
    """The run cannot go on; the text says why."""


class Interrupted(Exception):
    """The run is to end, and some node does not answer: the tick under way is given up."""


class Befallen(NamedTuple):
    """Something unplanned at a boundary: a fault to carry out, or one that has already happened.

    `answer` is told why it was not done, or nothing when it was.
    """

    fault: Fault
    happened: bool
    answer: Callable[[str], None]


class Swarm(Protocol):
    """The other side of the clock: node processes behind Zenoh, or minds in this process."""

    finishing: bool
    """Has anybody asked for the end of the run?"""

    def exchange(self, tick: int, percepts: Mapping[str, Percept]) -> Mapping[str, Action]:
        """Every action that was answered to these grants; a node that is missing has died.

        Raises Interrupted.
        """

    def enforce(self, fault: Fault) -> str:
        """Make a fault really happen. Returns why it could not be confirmed, empty when it was."""

    def boundary(self, tick: int) -> Iterable[Befallen]:
        """What came unplanned since the last tick; holds time while a person or the pace wants it held."""

    def tell(self, event: Event) -> None:
        """Tell observers of an event."""

    def show(self, commit: Commit) -> None:
        """Show observers a tick."""


class Clock:
    """Runs a world from tick 0 to its last: boundary, grants, answers, commit."""

    def __init__(self, world: World, swarm: Swarm, journal: Journal, last_tick: int) -> None:
        self._world = world
        self._swarm = swarm
        self._journal = journal
        self._plan = FaultPlan(world)
        self._last_tick = last_tick
        self._longest = 2 * last_tick if world.scenario.ends_with_visit else last_tick
        self._oversize: Counter = Counter()

    def run(self) -> tuple[int, bool]:
        """Run to the end. Returns the last tick that was committed, and whether the mission was completed."""
        tick = committed = 0
        while True:
            try:
                visited = self._step(tick)
            except Interrupted:
                break
            committed = tick
            if self._is_over(tick, visited) or self._swarm.finishing:
                break
            tick = self._after(tick)
        completed = committed >= self._last_tick
        self._journal.close(committed, completed)
        return committed, completed

    def _is_over(self, tick: int, visited: bool) -> bool:
        return tick >= self._longest or (visited and tick >= self._last_tick)

    def _step(self, tick: int) -> bool:
        """One tick. Returns whether anything was visited."""
        faults = self._boundary(tick)
        percepts = self._world.percepts(tick)
        actions = self._swarm.exchange(tick, percepts)
        for node in percepts:
            if node not in actions:  # it died with its grant open: as if it had been killed before the tick
                faults.append(Fault(tick, "kill", node))
                self._world.apply(faults[-1])
        commit = self._world.commit(tick, percepts, actions, tuple(faults))
        self._journal.append(commit)
        if self._world.ends_tick is not None:
            self._longest = self._last_tick = min(self._last_tick, self._world.ends_tick)
        self._swarm.show(commit)
        for node, frames in self._world.oversize.items():
            self._tell_oversize(tick, node, frames)
        return bool(commit.facts.visits)

    def _tell_oversize(self, tick: int, node: str, frames: int) -> None:
        """What is too long is never silence: the 1st, 10th, 100th ... tick of a sender is an event."""
        self._oversize[node] += 1
        count = self._oversize[node]
        if str(count).strip("0") == "1":
            limit = self._world.scenario.radio.bytes_per_tick
            text = f"frames of {node} were refused: {frames} did not fit into {limit} bytes per tick"
            self._swarm.tell(Event(tick, "oversize", node, text, {"frames": frames, "count": count}))

    def _after(self, tick: int) -> int:
        """The next tick at which anything happens, a planned fault and the end included."""
        coming = (self._longest, self._plan.next_tick(tick), self._world.next_tick(tick))
        return max(tick + 1, min(one for one in coming if one is not None))

    def _boundary(self, tick: int) -> list[Fault]:
        faults = []
        for fault in self._plan.due(tick):
            if not self._befall(fault, happened=False):
                faults.append(fault)
        for fault, happened, answer in self._swarm.boundary(tick):
            trouble = self._befall(fault, happened)
            answer(trouble)
            if not trouble:
                faults.append(fault)
        return faults

    def _befall(self, fault: Fault, happened: bool) -> str:
        """Let a fault happen, unless it has. Returns why it could not, empty when it did."""
        trouble = self._world.can(fault)
        if not trouble and not happened:
            trouble = self._slow(fault) if fault.verb == "slow" else self._swarm.enforce(fault)
        if trouble:
            text = f"{fault.verb} {fault.node} was not done: {trouble}"
            data = {"verb": fault.verb, "confirmed": False}
            self._swarm.tell(Event(fault.tick, "fault", fault.node, text, data))
            return trouble
        self._world.apply(fault)
        return ""

    def _slow(self, fault: Fault) -> str:
        """Slowness is a matter of grants: nothing is done to a process."""
        text = f"slow {fault.node}: it is granted each {fault.every} ticks"
        data = {"verb": "slow", "confirmed": True, "every": fault.every}
        self._swarm.tell(Event(fault.tick, "fault", fault.node, text, data))
        return ""
