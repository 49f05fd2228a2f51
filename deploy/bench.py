"""`picket bench`: what a lockstep tick costs, beside the bare wire that carries the same bytes.

For each number of nodes a run and a bare wire (deploy/floor.py) live side by side and take turns: a block of
ticks of the one, then the same ticks of the other, which replays the sizes of the first one's messages.
Printed are medians over blocks, and medians of the ratios of neighbouring blocks.
"""

import asyncio
import os
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from statistics import median
from typing import NamedTuple

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from deploy.bench_sides import Interrupted, Spent, floor_side, memory_of, run_side
from deploy.floor import Sizes
from deploy.rehearsal import Rehearsal
from deploy.scenario_file import find_scenario, load_scenario, to_toml
from wire import codec
from wire.messages import Action, Percept
from wire.scenario import Scenario
from world_server.clock import Clock
from world_server.journal import Journal
from world_server.world import World

LIKE = "area-patrol-n15"
PUBLISHED = (5, 10, 15)
FOR_OTHERS = {"takeover_discount": 0.5, "report_priority_max_s": 425.0, "spread_m": 525.0}
"""LR-PT's parameters for teams that the paper did not tune for: those of the paper's largest team."""
FIRST_TICK = 1  # the grants of tick 0 carry the configurations
INTERRUPTED = 130
LEGEND = """\
floor: wall time of a tick, the same bytes over the same link, without Picket
ratio: Picket's wall time to the floor's; minds apart: less the minds' processor
time, shared among the cores. world, minds: processor time of a tick rehearsed
in one process without a wire, the minds of all nodes together
RSS, PSS: resident memory of a robot process, shared pages whole and divided
"""


class Rehearsed(NamedTuple):
    """Ticks in one process, no wire: the size of every message, and processor seconds per tick."""

    percept_bytes: Sizes
    action_bytes: Sizes
    minds_s: float
    world_s: float


class Result(NamedTuple):
    """One size of team. Wall seconds per tick of each block; processor seconds per tick; bytes per robot."""

    nodes: int
    floor_s: list[float]
    picket_s: list[float]
    minds_s: float
    world_s: float
    floor_spent: Spent
    picket_spent: Spent
    resident: float
    proportional: float

    def ratio(self, apart_s: float = 0.0) -> float:
        """Picket's ticks, less `apart_s` each, to the floor's: median over pairs of blocks."""
        pairs = zip(self.picket_s, self.floor_s, strict=True)
        return median((picket - apart_s) / floor for picket, floor in pairs)


def bench(sizes: list[int], ticks: int, rounds: int) -> int:
    """Measure teams of these numbers of nodes, the tower counted; print the table. Returns the exit code."""
    console, results = Console(), []
    cores = len(os.sched_getaffinity(0))
    console.print(
        f"LR-PT on {cores} cores, {rounds} pairs of blocks of {ticks} ticks\n"
        "N counts all nodes: 1 is the tower alone",
        highlight=False,
    )
    try:
        for nodes in sizes:
            with console.status(f"N = {nodes}"), tempfile.TemporaryDirectory(prefix="picket-bench-") as place:
                results.append(asyncio.run(_measure(nodes, ticks, rounds, Path(place))))
    except (Interrupted, KeyboardInterrupt):
        return INTERRUPTED
    console.print(_table(results, cores))
    console.print(LEGEND, highlight=False)
    for result in results:
        console.print(_account(result), highlight=False, soft_wrap=True)
    return 0


async def _measure(nodes: int, ticks: int, rounds: int, place: Path) -> Result:
    scenario = _scenario(nodes, FIRST_TICK + ticks * rounds)
    rehearsed = _rehearse(scenario, place)
    floor_s: list[float] = []
    picket_s: list[float] = []
    sizes = rehearsed.percept_bytes[FIRST_TICK:], rehearsed.action_bytes[FIRST_TICK:]
    async with floor_side(scenario, *sizes, place) as floor, run_side(scenario, place) as run:
        before = floor.spent(), run.spent()
        for number in range(rounds):
            turns = [(floor, floor_s), (run, picket_s)]
            for side, seconds in turns if number % 2 else reversed(turns):
                seconds.append(await side.block(ticks) / ticks)
        after = floor.spent(), run.spent()
        memory = [memory_of(child.pid) for child in run.robots()]
    spent = [end.minus(begin).over(ticks * rounds) for begin, end in zip(before, after, strict=True)]
    resident, proportional = (median(column) for column in zip(*memory, strict=True))
    return Result(nodes, floor_s, picket_s, *rehearsed[2:], *spent, resident, proportional)


def _scenario(nodes: int, last_tick: int) -> Scenario:
    """The scenario of 15 nodes with another number of them; the pace holds it until the bench lets it go."""
    parameters = {} if nodes in PUBLISHED else FOR_OTHERS
    team = {"count": nodes - 1} if nodes > 1 else {"ids": []}
    robots = {"behaviour": "lr_pt", "parameters": parameters, **team}
    clock = {"kind": "paced", "rate": 1e-6}
    path = find_scenario(LIKE)
    return load_scenario(path, robots=robots, clock=clock, duration_s=last_tick, metrics_from_s=0)


class _Measured(Rehearsal):
    """A rehearsal that notes the size of every message and how long the minds take."""

    def exchange(self, tick: int, percepts: Mapping[str, Percept]) -> Mapping[str, Action]:
        """Every mind answers its percept, as bytes; a mind that raises ends the bench."""
        asked = {node: codec.encode(percept) for node, percept in percepts.items()}
        began = time.thread_time()
        answers = {node: self._minds[node].answer(data) for node, data in asked.items()}
        self.minds_s += time.thread_time() - began
        self.percept_bytes.append(tuple(map(len, asked.values())))
        self.action_bytes.append(tuple(map(len, answers.values())))
        return {node: codec.decode(Action, data) for node, data in answers.items()}


def _rehearse(scenario: Scenario, place: Path) -> Rehearsed:
    world = World(scenario)
    swarm = _Measured(scenario, place, lambda event: None, lambda facts: None)
    swarm.percept_bytes, swarm.action_bytes, swarm.minds_s = [], [], 0.0
    with (place / "rehearsed").open("wb") as stream:
        journal = Journal(stream, scenario, to_toml(scenario), world.poses().tobytes())
        began = time.thread_time()
        last_tick, _ = Clock(world, swarm, journal, scenario.last_tick).run()
        spent_s = time.thread_time() - began
    ticks = last_tick + 1
    sizes = tuple(swarm.percept_bytes), tuple(swarm.action_bytes)
    return Rehearsed(*sizes, swarm.minds_s / ticks, (spent_s - swarm.minds_s) / ticks)


def _table(results: list[Result], cores: int) -> Table:
    table = Table(box=SIMPLE_HEAD, padding=(0, 1), pad_edge=False)
    headings = (
        "N",
        "floor\nµs",
        "Picket\nµs",
        "Picket\nticks/s",
        "\nratio",
        "minds\napart",
        "world\nµs",
        "minds\nµs",
        "RSS\nMB",
        "PSS\nMB",
    )
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    for one in results:
        picket_s = median(one.picket_s)
        apart_s = one.minds_s / min(cores, one.nodes)
        table.add_row(
            str(one.nodes),
            _us(median(one.floor_s)),
            _us(picket_s),
            f"{1 / picket_s:.0f}",
            f"{one.ratio():.2f}",
            f"{one.ratio(apart_s):.2f}",
            _us(one.world_s),
            _us(one.minds_s),
            f"{one.resident / 1e6:.1f}",
            f"{one.proportional / 1e6:.1f}",
        )
    return table


def _account(one: Result) -> str:
    """What costs the rest: processor time beyond the floor's, of the real processes."""
    floor, picket = one.floor_spent, one.picket_spent
    more = picket.minus(floor)
    return (
        f"N = {one.nodes}: processor time per tick, floor -> Picket: coordinator -> world "
        f"{_us(floor.centre_s)} -> {_us(picket.centre_s)} µs (+{_us(more.centre_s)}), all nodes "
        f"{_us(floor.nodes_s)} -> {_us(picket.nodes_s)} µs (+{_us(more.nodes_s)})"
    )


def _us(seconds: float) -> str:
    return f"{seconds * 1e6:.0f}"
