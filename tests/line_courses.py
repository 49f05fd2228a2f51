"""Short line patrols for tests of failures: shipped scenarios with poor batteries, and what came of them.

T is the time for one segment, one way, c that of one turn: a lap takes 2 (T + c). All bounds are for true
positions and for what robots report of themselves, in simulated seconds, at ticks of one second.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from deploy.metrics.line import LineMetrics
from deploy.metrics.vacancies import Vacancy, segment_of
from deploy.rehearsal import Rehearsal, rehearse
from deploy.scenario_file import SHIPPED, load_scenario, to_toml
from swarm_agent.line_radio import Report
from tests.dying_keeper import Death
from tower.desk import Desk
from wire import codec
from wire.line import Line
from wire.messages import Facts, Fault
from wire.scenario import PlannedFault, Scenario
from world_server.clock import Befallen, Clock
from world_server.events import EventLog
from world_server.journal import Journal, commits
from world_server.nodes import FLAT
from world_server.records import Commit
from world_server.world import World

NOISE = 1.1
"""With noise on the velocities nothing takes longer than it should by more than this factor."""
Doing = dict[str, tuple[str, int]]
"""What each robot does and on which segment, as it said last; the dead are left out."""


def line_run(name: str, duration_s: float, drain: float, *settings: str, **fields: Any) -> Scenario:
    """A shipped scenario for some time, with `drain` times its drain."""
    drains = {"patrolling": 0.33, "travelling": 0.33, "queueing": 0.10}
    fast = [f"battery.{what}_v_h={drain * volts:.6g}" for what, volts in drains.items()]
    path = SHIPPED / f"line-{name}.toml"
    given = load_scenario(path, [*fast, *settings], duration_s=duration_s, faults=[])
    return msgspec.structs.replace(given, **fields)


class Times(NamedTuple):
    """How long things take in a scenario, in seconds at full speed without noise."""

    segment: float
    turn: float
    gap: float
    way: float
    """From the farthest place of the queue to the farthest near end, or back, with four quarter turns."""
    listen: float
    hops: float = 3.0
    """A tick for the roll call, one for the answer, one for the order."""

    @property
    def lap(self) -> float:
        """There and back."""
        return 2 * (self.segment + self.turn)

    @property
    def recovery(self) -> float:
        """From the moment at which a tower sees a vacancy until one robot has traversed the segment whole.

        A neighbour moves out: it has just turned at its far end, goes back, turns, comes out again, crosses
        the gap and traverses: 3 (T + c) and the gap, 3 T in the paper. Or a robot comes from the queue: its
        way and T. The bound is the sum of both.
        """
        moving = 3 * (self.segment + self.turn) + self.gap
        return NOISE * (self.way + moving) + self.hops

    @property
    def after_birth(self) -> float:
        """From the start of a tower until every segment has been traversed whole by its own robot."""
        return self.listen + self.recovery


def times(given: Scenario) -> Times:
    """For equal segments."""
    line, robots, field = Line(given.field, (given.tower.x_m, given.tower.y_m)), given.robots, given.field
    speed, turn = robots.max_speed_m_s, pi / robots.max_turn_rad_s
    queue_m = field.lane_m + field.slot_m * (len(given.robot_ids) - 1)
    out_m = max(abs(one.near_m - line.tower_arc_m) for one in line.segments) + field.lane_m
    listen = float(given.tower.parameters["listen_s"])
    way = (queue_m + out_m) / speed + 2 * turn
    return Times(line.segments[0].length_m / speed, turn, field.gap_m / speed, way, listen)


class Run(NamedTuple):
    """A line patrol that is over."""

    scenario: Scenario
    folder: Path
    facts: list[Facts]

    def desks(self) -> Iterator[tuple[int, Desk]]:
        """Tick and report of all that the tower told observers."""
        for one in self.facts:
            yield from ((one.tick, desk) for desk in desks_of(one, self.scenario.tower.id))

    def metrics(self) -> dict[str, Any]:
        """Its metrics."""
        fold = LineMetrics(self.scenario)
        for one in self.facts:
            fold.feed(one)
        return fold.summary()

    def words(self) -> Iterator[tuple[int, str, Report]]:
        """Tick, robot and report of all that robots said of themselves."""
        for one in self.facts:
            for node, told in one.reports:
                if node != self.scenario.tower.id:
                    yield one.tick, node, codec.decode(Report, told)

    def states(self) -> Iterator[tuple[int, Doing]]:
        """For each tick what the robots do."""
        doing: Doing = {}
        for one in self.facts:
            listen(doing, one, self.scenario.tower.id)
            yield one.tick, dict(doing)

    def faults(self, verb: str) -> list[Fault]:
        """What befell whom."""
        return [fault for one in self.facts for fault in one.faults if fault.verb == verb]

    def flat(self) -> set[str]:
        """Robots that ever ran out of charge."""
        nodes = self.scenario.node_ids
        return {nodes[row] for one in self.facts for row, mode in enumerate(one.modes) if mode == FLAT}

    def covered_after(self, tick: int) -> dict[int, int]:
        """For each segment how long after a tick one of its own robots first had traversed it whole."""
        segments = range(1, len(Line(self.scenario.field, (0.0, 0.0)).segments) + 1)
        since = {segment: Vacancy(segment, "death", tick) for segment in segments}
        for one, (_, doing) in zip(self.facts, self.states(), strict=True):
            for node, site in one.visits:
                state, segment = doing.get(node, ("", 0))
                if segment == segment_of(site) and state in ("patrol", "out"):
                    since[segment].visit(one.tick, node, site % 3)
        ticks = {segment: vacancy.covered_tick for segment, vacancy in since.items()}
        return {segment: covered - tick for segment, covered in ticks.items() if covered is not None}

    def longest_double(self, frozen: Iterable[str] = ()) -> int:
        """For how long at most two robots or more said at once that they patrol one segment."""
        longest, since = 0, {}
        for tick, doing in self.states():
            on = defaultdict(list)
            for node, (state, segment) in doing.items():
                if state == "patrol" and node not in frozen:
                    on[segment].append(node)
            since = {segment: since.get(segment, tick) for segment, nodes in on.items() if len(nodes) > 1}
            longest = max([longest, *(tick - begin for begin in since.values())])
        return longest


def rehearsed_line(
    folder: Path, given: Scenario, until: Callable[[Facts, Doing], bool] = lambda facts, doing: False
) -> Run:
    """Rehearse a line patrol, to its end or until facts and what the robots do are as wanted."""
    folder.mkdir(parents=True, exist_ok=True)
    facts: list[Facts] = []
    doing: Doing = {}

    def watch(one: Commit, swarm: Rehearsal) -> None:
        facts.append(one.facts)
        listen(doing, one.facts, given.tower.id)
        swarm.finishing = until(one.facts, doing)

    rehearse(given, to_toml(given), folder, given.last_tick, watch)
    return Run(given, folder, facts)


def desks_of(facts: Facts, tower: str) -> list[Desk]:
    """What the tower told observers in a tick: one report or none."""
    return [codec.decode(Desk, told) for node, told in facts.reports if node == tower]


def listen(doing: Doing, facts: Facts, tower: str) -> None:
    """Take in what robots say of themselves, and who is killed."""
    for node, told in facts.reports:
        if node != tower:
            report = codec.decode(Report, told)
            doing[node] = (report.state, report.segment)
    for fault in facts.faults:
        if fault.verb == "kill":
            doing.pop(fault.node, None)


def run_of(given: Scenario, folder: Path) -> Run:
    """A run that is over, from its folder."""
    return Run(given, folder, [one.facts for one in commits(folder / "journal")])


class DeadlyRehearsal(Rehearsal):
    """A rehearsal whose tower dies as its parameters say, and is started again some time after each death."""

    def __init__(self, dead_ticks: int, scenario: Scenario, *what: Any) -> None:
        super().__init__(scenario, *what)
        self._deaths = [Death(*one) for one in scenario.tower.parameters["deaths"]]
        self._dead_ticks = dead_ticks
        self._since_tick = 0
        """When it was born, or died."""
        self._alive = True
        self._last_ticks = times(scenario).after_birth + 1

    def boundary(self, tick: int) -> Iterator[Befallen]:
        """Its deaths between ticks, and every new life; the end some time after the last."""
        if self._alive and self._tower not in self._minds:
            self._since_tick, self._alive = tick - 1, False
        if self._alive and self._deaths and self._deaths[0].when == "boundary":
            if tick - self._since_tick >= self._deaths[0].after:
                self._since_tick, self._alive = tick, False
                yield Befallen(Fault(tick, "kill", self._tower), False, lambda trouble: None)
        elif not self._alive and tick - self._since_tick >= self._dead_ticks:
            self._since_tick, self._alive = tick, True
            self._deaths = self._deaths[1:]
            yield Befallen(Fault(tick, "restart", self._tower), False, lambda trouble: None)
        elif self._alive and not self._deaths:
            self.finishing = tick - self._since_tick >= self._last_ticks


def rehearsed_deaths(folder: Path, given: Scenario, dead_ticks: int) -> Run:
    """Rehearse a line patrol whose tower dies.

    The plan of the run's scenario has what others are to do at which tick for the same to happen again.
    """
    folder.mkdir(parents=True)
    world, facts = World(given), []
    with (folder / "journal").open("wb") as stream, (folder / "events.jsonl").open("w") as lines:
        journal = Journal(stream, given, to_toml(given), world.poses().tobytes())
        tell = EventLog(lines, given.tick_s).write
        swarm = DeadlyRehearsal(dead_ticks, given, folder, tell, lambda one: facts.append(one.facts))
        Clock(world, swarm, journal, given.last_tick).run()
    run = Run(given, folder, facts)
    ways = [Death(*one).when for one in given.tower.parameters["deaths"]]
    kills = [one for one, when in zip(run.faults("kill"), ways, strict=False) if when == "boundary"]
    plan = sorted([*kills, *run.faults("restart")], key=lambda one: one.tick)
    faults = tuple(PlannedFault(float(one.tick), one.verb, (one.node,)) for one in plan)
    duration_s = float(facts[-1].tick)
    return run._replace(scenario=msgspec.structs.replace(given, faults=faults, duration_s=duration_s))


def lives(run: Run) -> list[tuple[int, int]]:
    """From when to when the tower was alive, the last tick excluded."""
    ends = [
        (one.tick, one.verb) for one in run.facts for one in one.faults if one.node == run.scenario.tower.id
    ]
    ticks = [0, *(tick for tick, _ in ends), run.facts[-1].tick + 1]
    return [(begin, end) for number, (begin, end) in enumerate(pairwise(ticks)) if number % 2 == 0]
