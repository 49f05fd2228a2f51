"""The launcher: starts the world and all nodes, carries out the world's orders, leaves nothing behind."""

import asyncio
import contextlib
import os
import socket
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from deploy.process import CONTINUE, KILL, STOP, Child, on_interrupt
from deploy.run_folder import LEDGER, LiveRun, RunError, announce_live
from wire import channels, codec
from wire.credentials import OBSERVERS, OPERATORS, SUPERVISOR, hand_over, make_book
from wire.link import Link, LinkError, open_client
from wire.messages import Done, Exited, Facts, Fault, Finish, Notice, Order, Started, TruthBlock
from wire.scenario import Scenario
from world_server.journal import memories

WORLD_READY_WITHIN_S = 30.0
NODES_END_WITHIN_S = 5.0
DASHBOARD_ENDS_WITHIN_S = 5.0


class LaunchError(Exception):
    """A run that could not be started or did not end well; the text says why, with the last lines."""


class Launcher:
    """One run from the first process to the last."""

    def __init__(
        self, scenario: Scenario, folder: Path, last_tick: int, watch: Callable[[Facts], None]
    ) -> None:
        """Raises RunError when the port is taken."""
        self.interrupted = False
        endpoint = f"tcp/127.0.0.1:{free_port(scenario.wire.port)}"
        self.book = make_book(folder.name, endpoint, (*scenario.node_ids, *scenario.spare_ids))
        self.processes: list[tuple[str, str, Child, int]] = []
        """Every node process that was ever started: node, role, child, incarnation."""
        self._scenario = scenario
        self._folder = folder
        self._last_tick = last_tick
        self._watch = watch
        self._living: dict[str, tuple[Child, int]] = {}
        self._link: Link | None = None
        self._dashboard: Child | None = None
        self._tasks: set[asyncio.Task] = set()

    async def run(self, dashboard: str | None, say: Callable[[str], None]) -> None:
        """Run to the end. `dashboard`: mode of the live dashboard, or None. Raises LaunchError."""
        on_interrupt(self._interrupt)
        tickets = tuple(self.book.ticket(operator) for operator in OPERATORS)
        live = announce_live(LiveRun(str(self._folder.resolve()), tickets, os.getpid()))
        try:
            await self._start_world()
            await self._join()
            for node in self.start_order():
                self._start_node(node, 0, b"")
            if dashboard:
                await self._start_dashboard(dashboard, say)
            await self._world.ended.wait()
            if self._world.status != 0 and not self.interrupted:
                raise LaunchError(f"the world ended with {self._world.status}:\n{self._world.last_lines()}")
        finally:
            live.unlink(missing_ok=True)
            await self._sweep_up()

    def roll(self) -> list[dict[str, Any]]:
        """Every process that was started, as `summary.json` tells of them."""
        return [
            roll_entry(node, role, child.pid, incarnation, child.status)
            for node, role, child, incarnation in self.processes
        ]

    def start_order(self) -> Sequence[str]:
        """In which order nodes are started; it makes no difference to the run, and a test sees to that."""
        return self._scenario.node_ids

    async def _start_world(self) -> None:
        ready, writing = os.pipe()
        book = hand_over(self.book)
        arguments = [str(self._folder), "--book-fd", str(book), "--ready-fd", str(writing)]
        arguments += ["--last-tick", str(self._last_tick)]
        log = self._folder / "logs" / "world.log"
        self._world = Child("world", "world_server", arguments, log, (book, writing))
        self.processes.append(("world", "world", self._world, 0))
        self._world.watch(lambda child: None)
        with os.fdopen(ready, "rb") as stream:
            reading = asyncio.get_running_loop().run_in_executor(None, stream.readline)
            try:
                line = await asyncio.wait_for(reading, WORLD_READY_WITHIN_S)
            except TimeoutError:
                line = b""
        if not line:
            await self._world.wait(1.0)
            raise LaunchError(f"the world did not start:\n{self._world.last_lines()}")

    async def _join(self) -> None:
        """Open the supervisor's link: orders come in, notices go out, facts are watched for the progress."""
        loop = asyncio.get_running_loop()
        try:
            self._link = await loop.run_in_executor(None, open_client, self.book.ticket(SUPERVISOR))
        except LinkError as error:
            raise LaunchError(str(error)) from None
        run = self.book.run
        self._notices = self._link.publisher(channels.key(run, channels.NOTICE))
        enter = loop.call_soon_threadsafe
        self._link.subscribe(channels.key(run, channels.ORDER), lambda _, data: enter(self._on_order, data))
        self._link.subscribe(channels.key(run, channels.TRUTH), lambda _, data: enter(self._on_truth, data))

    def _start_node(self, node: str, incarnation: int, memory: bytes) -> None:
        is_tower = node == self._scenario.tower.id
        descriptors = [hand_over(self.book.ticket(node))]
        arguments = [node, "--ticket-fd", str(descriptors[0])]  # the name is for those who read `ps`
        if memory:
            descriptors.append(hand_over(memory))
            arguments += ["--memory-fd", str(descriptors[1])]
        if is_tower:
            arguments += ["--ledger", str(self._folder / LEDGER)]
        module = "tower" if is_tower else "swarm_agent"
        child = Child(node, module, arguments, self._folder / "logs" / f"{node}.log", descriptors)
        self._living[node] = (child, incarnation)
        self.processes.append((node, "tower" if is_tower else "robot", child, incarnation))
        self._notify(Started(node, child.pid, incarnation))
        child.watch(lambda ended: self._on_exit(node, ended, incarnation))

    async def _start_dashboard(self, mode: str, say: Callable[[str], None]) -> None:
        ticket = hand_over(self.book.ticket(OBSERVERS[0]))
        reading, writing = os.pipe()
        arguments = ["--folder", str(self._folder), "--mode", mode, "--ticket-fd", str(ticket)]
        arguments += ["--say-fd", str(writing)]
        log = self._folder / "logs" / "dashboard.log"
        self._dashboard = Child("dashboard", "deploy.dashboard", arguments, log, (ticket, writing))
        self._dashboard.watch(lambda child: None)
        loop = asyncio.get_running_loop()
        stream = os.fdopen(reading, "rb")
        loop.add_reader(stream, lambda: self._on_dashboard_line(stream, say))

    @staticmethod
    def _on_dashboard_line(stream, say: Callable[[str], None]) -> None:
        line = stream.readline()
        if line:
            return say(line.decode("utf-8", "replace").rstrip())
        asyncio.get_running_loop().remove_reader(stream)
        stream.close()

    def _on_order(self, data: bytes) -> None:
        order = codec.decode(Order, data)
        task = asyncio.get_running_loop().create_task(self._carry_out(order.number, order.fault))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _carry_out(self, number: int, fault: Fault) -> None:
        """Do what only the launcher can, see that it happened, and say so."""
        child, incarnation = self._living.get(fault.node, (None, -1))
        if fault.verb == "restart":
            memory = b""
            if fault.memory == "kept":
                path = self._folder / "journal"
                memory = await asyncio.get_running_loop().run_in_executor(None, memories, path, fault.node)
            self._start_node(fault.node, incarnation + 1, memory)
        elif child is None or child.status is not None:
            return self._notify(Done(number, False, "its process is gone already"))
        elif fault.verb == "kill":
            child.expected = True
            child.send(KILL)
            await child.ended.wait()
        elif fault.verb == "freeze":
            child.send(STOP)
            await child.stopped()
        elif fault.verb == "thaw":
            child.send(CONTINUE)
            await child.continued()
        self._notify(Done(number, True))

    def _on_exit(self, node: str, child: Child, incarnation: int) -> None:
        if not child.expected and self._world.status is None:
            self._notify(Exited(node, incarnation, child.status, child.last_lines()))

    def _on_truth(self, data: bytes) -> None:
        for facts in codec.decode(TruthBlock, data).facts:
            self._watch(facts)

    def _notify(self, notice: Notice) -> None:
        if self._link is not None:
            self._notices.put(codec.encode(notice))

    def _interrupt(self) -> None:
        """The first Ctrl-C asks the world to end at the next tick; another one ends everything now."""
        if self.interrupted:
            return self._world.send(KILL)
        self.interrupted = True
        self._notify(Finish())

    async def _sweep_up(self) -> None:
        """Nothing is left behind: nodes are given a moment to end by themselves, then no choice."""
        nodes = [child for child, _ in self._living.values() if child.status is None]
        world_ended_well = self._world.status == 0
        if world_ended_well:
            await asyncio.gather(*(child.wait(NODES_END_WITHIN_S) for child in nodes if not child.frozen))
        await asyncio.gather(*(child.end() for child in [*nodes, self._world]))
        if self._dashboard is not None:
            await self._dashboard.wait(DASHBOARD_ENDS_WITHIN_S if world_ended_well else 0.1)
            await self._dashboard.end()
        if self._link is not None:
            link, self._link = self._link, None
            await asyncio.get_running_loop().run_in_executor(None, link.close)


def roll_entry(node: str, role: str, pid: int, incarnation: int, status: int | None) -> dict[str, Any]:
    """How `summary.json` tells of one process."""
    return {"node": node, "role": role, "pid": pid, "incarnation": incarnation, "exit": status}


def free_port(wanted: int) -> int:
    """`wanted`, or any free loopback port for 0. Raises RunError when it is taken."""
    with contextlib.closing(socket.socket()) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", wanted))
        except OSError as error:
            why = error.strerror.lower()
            raise RunError(f"wire.port {wanted}: {why}; choose another, or 0 for any free one") from None
        return probe.getsockname()[1]
