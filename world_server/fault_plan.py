"""The faults of a scenario that are still to come: at a time, or as soon as the referee says so."""

from collections.abc import Iterable

from wire.messages import Fault
from wire.scenario import PlannedFault, Scenario
from world_server.world import World


class FaultPlan:
    """What is planned. A fault for a role waits until some robot has it."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._scenario: Scenario = world.scenario
        timed = [one for one in self._scenario.faults if one.at_s is not None]
        timed.sort(key=lambda one: one.at_s)
        self._coming = timed + [one for one in self._scenario.faults if one.at_s is None]

    def due(self, tick: int) -> Iterable[Fault]:
        """The next fault that is to happen at the boundary before this tick, again and again; then none."""
        while (found := self._first_ripe(tick)) is not None:
            self._coming.remove(found)
            for node in self._targets(found):
                yield Fault(tick, found.verb, node, found.memory, found.place, found.every)

    def next_tick(self, tick: int) -> int | None:
        """The next tick at whose boundary a fault is to happen, as far as can be told now."""
        if self._first_ripe(tick + 1) is not None:
            return tick + 1
        later = [self._scenario.tick_of(one.at_s) for one in self._coming if one.at_s is not None]
        return min((one for one in later if one > tick), default=None)

    def _first_ripe(self, tick: int) -> PlannedFault | None:
        return next((one for one in self._coming if self._is_ripe(one, tick)), None)

    def _is_ripe(self, fault: PlannedFault, tick: int) -> bool:
        if fault.at_s is not None and self._scenario.tick_of(fault.at_s) > tick:
            return False
        if fault.when_cleared_share is not None and self._world.cleared_share < fault.when_cleared_share:
            return False
        return not fault.role or bool(self._targets(fault))

    def _targets(self, fault: PlannedFault) -> tuple[str, ...]:
        if not fault.role:
            return self._scenario.nodes_of(fault)
        node = self._world.middle_in_role(fault.role)
        return () if node is None else (node,)
