"""The rehearsal: the same world, clock and codec with all minds in this process and no Zenoh.

Minds share nothing: they meet only through encoded bytes, exactly as processes do.
"""

import os
import traceback
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path

from deploy.run_folder import LEDGER
from swarm_agent.node import Mind, percepts_of
from tower.ledger import Ledger
from wire import codec
from wire.messages import Action, Event, Fault, Percept
from wire.scenario import Scenario
from world_server.clock import Befallen, Clock
from world_server.events import EventLog
from world_server.journal import Journal, memories
from world_server.records import Commit, End
from world_server.world import World


class Rehearsal:
    """The swarm as minds in this process. A fault is carried out on a mind: dropped, skipped, made anew."""

    def __init__(
        self, scenario: Scenario, folder: Path, tell: Callable[[Event], None], show: Callable[[Commit], None]
    ) -> None:
        self.finishing = False
        self.tell = tell
        self.show = show
        self._tower = scenario.tower.id
        self._folder = folder
        self._minds = {node: self._newborn(node) for node in scenario.node_ids}

    def exchange(self, tick: int, percepts: Mapping[str, Percept]) -> Mapping[str, Action]:
        """Every mind answers its percept, as bytes; one that raises is dead."""
        actions = {}
        for node, percept in percepts.items():
            try:
                answer = self._minds[node].answer(codec.encode(percept))
            except Exception:  # noqa: BLE001  a behaviour's error is that robot's death, whatever it is
                lines = traceback.format_exc()
                self.tell(
                    Event(
                        tick, "death", node, f"{node} died: exit code 1", {"status": 1, "last_lines": lines}
                    )
                )
                del self._minds[node]
            else:
                actions[node] = codec.decode(Action, answer)
        return actions

    def enforce(self, fault: Fault) -> str:
        """Carry out a planned fault."""
        if fault.verb == "kill":
            self._minds.pop(fault.node, None)
        elif fault.verb == "restart":
            self._minds[fault.node] = self._newborn(fault.node)
            if fault.memory == "kept":
                for percept in percepts_of(memories(self._folder / "journal", fault.node)):
                    self._minds[fault.node].answer(percept)
        data = {"verb": fault.verb, "confirmed": True, "pid": os.getpid(), "pause_ms": 0.0}
        self.tell(Event(fault.tick, "fault", fault.node, f"{fault.verb} {fault.node}, confirmed", data))
        return ""

    def boundary(self, tick: int) -> Iterable[Befallen]:
        """Nothing unplanned happens in a rehearsal."""
        return ()

    def close(self) -> None:
        """The run is over."""
        for mind in self._minds.values():
            mind.close()

    def _newborn(self, node: str) -> Mind:
        if node == self._tower:
            return Mind("tower", Ledger(self._folder / LEDGER))
        return Mind("swarm_agent.behaviours")


Watch = Callable[[Commit, Rehearsal], None]


def rehearse(
    scenario: Scenario,
    toml: str,
    folder: Path,
    last_tick: int,
    watch: Watch = lambda commit, swarm: None,
    journalled: bool = True,
) -> End:
    """Run a scenario in this process; events go to `folder`, and the journal if there is to be one.

    `watch` sees every commit and may set the swarm's `finishing`. Memories can be kept only with a journal.
    """
    world = World(scenario)
    with ExitStack() as stack:
        stream = stack.enter_context((folder / "journal").open("wb")) if journalled else None
        events = EventLog(stack.enter_context((folder / "events.jsonl").open("w")), scenario.tick_s)
        journal = Journal(stream, scenario, toml, world.poses().tobytes())
        swarm = Rehearsal(scenario, folder, events.write, lambda commit: watch(commit, swarm))
        tick, completed = Clock(world, swarm, journal, last_tick).run()
        swarm.close()
        events.write(Event(tick, "end", "", f"run hash {journal.run_hash}", {"completed": completed}))
        return End(tick, completed, journal.run_hash)
