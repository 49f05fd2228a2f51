"""The two sides of the bench: a run that stands still until it is ordered to step, and the bare wire."""

import asyncio
import os
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import NamedTuple

import msgspec

from deploy.floor import CoordinatorPlan, NodePlan, Sizes
from deploy.launcher import Launcher, LaunchError, free_port
from deploy.process import KILL, Child
from deploy.run_folder import find_live, new_folder
from deploy.scenario_file import to_toml
from wire import channels, codec
from wire.credentials import Ticket, fresh, hand_over, make_book
from wire.link import Link, open_client
from wire.messages import Facts, Reply, Request
from wire.scenario import Scenario
from world_server.access import access_control

START_WITHIN_S = 60.0
BLOCK_WITHIN_S = 600.0


class Interrupted(Exception):
    """Somebody pressed Ctrl-C."""


class Spent(NamedTuple):
    """Processor seconds of the process in the middle and of all nodes together."""

    centre_s: float
    nodes_s: float

    def minus(self, other: "Spent") -> "Spent":
        """What was spent since `other`, or more than it."""
        return Spent(self.centre_s - other.centre_s, self.nodes_s - other.nodes_s)

    def over(self, ticks: int) -> "Spent":
        """What was spent per tick."""
        return Spent(self.centre_s / ticks, self.nodes_s / ticks)


class FloorSide(NamedTuple):
    """The processes of the bare wire, and the pipes to its coordinator."""

    children: list[Child]
    orders: int
    reports: asyncio.StreamReader

    async def block(self, ticks: int) -> float:
        """Run this many ticks; returns seconds."""
        os.write(self.orders, b"%d\n" % ticks)
        return float(await self.line())

    async def line(self) -> str:
        """The coordinator's next word. Raises LaunchError when it has ended."""
        line = await asyncio.wait_for(self.reports.readline(), BLOCK_WITHIN_S)
        if not line:
            raise LaunchError(f"the bare wire broke:\n{self.children[0].last_lines()}")
        return line.decode().strip()

    def spent(self) -> Spent:
        """Processor time until now."""
        centre_s, *nodes_s = (processor_s(child.pid) for child in self.children)
        return Spent(centre_s, sum(nodes_s))


@asynccontextmanager
async def floor_side(
    scenario: Scenario, percept_bytes: Sizes, action_bytes: Sizes, place: Path
) -> AsyncIterator[FloorSide]:
    """Start the bare wire with the credentials and the rules of a run; end it whatever happens."""
    book = make_book(place.name, f"tcp/127.0.0.1:{free_port(0)}", scenario.node_ids)
    plan = CoordinatorPlan(book, access_control(book), fresh("world"), percept_bytes)
    (ordered, ordering), (reported, reporting) = os.pipe(), os.pipe()
    arguments = ["coordinator", "--order-fd", str(ordered), "--report-fd", str(reporting)]
    coordinator = _floor_child("coordinator", arguments, plan, place, (ordered, reporting))
    floor = FloorSide([coordinator], ordering, asyncio.StreamReader())
    await asyncio.get_running_loop().connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(floor.reports), os.fdopen(reported, "rb")
    )
    try:
        await floor.line()
        for node, own_bytes in zip(scenario.node_ids, zip(*action_bytes, strict=True), strict=True):
            floor.children.append(_floor_child(node, ["node"], NodePlan(book.ticket(node), own_bytes), place))
        await floor.line()
        yield floor
    finally:
        os.close(ordering)
        for child in floor.children:  # they have nothing to save
            child.send(KILL)
        await asyncio.gather(*(child.ended.wait() for child in floor.children))


def _floor_child(
    name: str, arguments: list[str], plan: msgspec.Struct, place: Path, descriptors: tuple[int, ...] = ()
) -> Child:
    handed = hand_over(msgspec.msgpack.encode(plan))
    arguments = [*arguments, "--plan-fd", str(handed)]
    log = place / f"floor-{name}.log"
    child = Child(name, "deploy.floor", arguments, log, (handed, *descriptors))
    child.watch(lambda ended: None)
    return child


class RunSide:
    """A run that stands still at a tick boundary until it is ordered to make some steps."""

    def __init__(self, scenario: Scenario, folder: Path) -> None:
        self._launcher = Launcher(scenario, folder, scenario.last_tick, self._on_facts)
        self._running = asyncio.create_task(self._launcher.run(None, lambda line: None))
        self._tick = -1
        self._news = asyncio.Event()
        self._ticket: Ticket | None = None
        self._link: Link | None = None
        self._folder = folder

    async def pause(self) -> None:
        """Wait until it runs, and let it stand still after tick 0."""
        await self._until(0, START_WITHIN_S)
        self._ticket = find_live(str(self._folder)).tickets[0]
        self._link = await asyncio.to_thread(open_client, self._ticket)
        await self._ask(Request("pause"))

    async def block(self, ticks: int) -> float:
        """Run this many ticks; returns seconds."""
        last, began = self._tick + ticks, time.perf_counter()
        await self._ask(Request("step", value=ticks))
        await self._until(last, BLOCK_WITHIN_S)
        return time.perf_counter() - began

    def robots(self) -> list[Child]:
        """The processes of all robots, or the tower's where there is none."""
        nodes = [child for _, role, child, _ in self._launcher.processes if role != "world"]
        return nodes[1:] or nodes

    def spent(self) -> Spent:
        """Processor time until now."""
        world, *nodes = (processor_s(child.pid) for _, _, child, _ in self._launcher.processes)
        return Spent(world, sum(nodes))

    async def finish(self) -> None:
        """Run the last tick; the world and all nodes end by themselves."""
        await self._ask(Request("step"))
        await self._running

    async def end(self) -> None:
        """End it, unless it has ended."""
        if self._link is not None:
            await asyncio.to_thread(self._link.close)
        self._running.cancel()
        await asyncio.wait([self._running])

    def _on_facts(self, facts: Facts) -> None:
        self._tick = facts.tick
        self._news.set()

    async def _until(self, tick: int, at_most_s: float) -> None:
        """Wait for the facts of a tick."""
        news = asyncio.create_task(self._reach(tick))
        await asyncio.wait((self._running, news), timeout=at_most_s, return_when=asyncio.FIRST_COMPLETED)
        news.cancel()
        if self._launcher.interrupted:
            raise Interrupted
        if self._running.done():
            self._running.result()
            raise LaunchError("the run ended before it was measured")
        if self._tick < tick:
            raise LaunchError(f"the run came to a standstill at tick {self._tick}")

    async def _reach(self, tick: int) -> None:
        while self._tick < tick:
            self._news.clear()
            await self._news.wait()

    async def _ask(self, request: Request) -> None:
        key = channels.key(self._ticket.run, channels.CONTROL)
        data = await asyncio.to_thread(self._link.ask, key, codec.encode(request), START_WITHIN_S)
        if data is None or not codec.decode(Reply, data).accepted:
            raise LaunchError(f"the world did not accept the request to {request.verb}")


@asynccontextmanager
async def run_side(scenario: Scenario, place: Path) -> AsyncIterator[RunSide]:
    """Start a run and let it stand still; end it whatever happens."""
    folder = new_folder("bench", place)
    (folder / "scenario.toml").write_text(to_toml(scenario), "utf-8")
    run = RunSide(scenario, folder)
    try:
        await run.pause()
        yield run
        await run.finish()
    finally:
        await run.end()


def processor_s(pid: int) -> float:
    """Processor seconds that all threads of a process have used."""
    every_thread = 2  # the kernel's number for a process's clock: the inverted pid, then which clock it is
    return time.clock_gettime((~pid << 3) | every_thread)


def memory_of(pid: int) -> tuple[int, int]:
    """Resident bytes of a process, and with shared pages divided among those who share them."""
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text("utf-8").splitlines()[1:]
    fields = {name: words.split()[0] for name, _, words in (line.partition(":") for line in lines)}
    return 1024 * int(fields["Rss"]), 1024 * int(fields["Pss"])
