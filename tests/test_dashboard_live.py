"""The live dashboard: it shows what the world says, says what it missed, and holds nobody up."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

import msgspec
import pytest

from deploy.following import Follower, Handover
from deploy.scene import Scene
from tests.test_dashboard import LAST_TICK, Run, rows_of
from wire import channels, codec
from wire.credentials import Ticket, fresh, hand_over, make_book
from wire.link import Publisher, open_router
from wire.messages import Event, Facts, TruthBlock
from world_server.access import access_control


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return Run(tmp_path_factory.mktemp("run"))


def test_a_sink_that_hangs_delays_nobody(run: Run) -> None:
    """Source: design, section 8: a frozen viewer must never slow the mission."""
    hanging, released, shown = threading.Event(), threading.Event(), []

    class Hanging:
        def show(self, snapshot: object) -> None:
            shown.append(snapshot)
            hanging.set()
            released.wait()

        def close(self) -> None:
            pass

    scene = Scene(run.scenario)
    handover = Handover(Hanging)
    for facts in run.facts:
        scene.take(facts)
        handover.put(scene.snapshot())
        if facts.tick == 0:
            assert hanging.wait(10)
    assert not handover.finish(within_s=0.01), "it hangs, and we know it"
    assert len(shown) == 1
    released.set()
    assert handover.finish(within_s=10)
    assert len(shown) == 2, "of all that waited, the latest only"
    assert shown[1].time_s == LAST_TICK
    states = [(change.time_s, change.state) for change in shown[1].changes if change.node == "r4"]
    assert (100.0, "dead") in states, "what happened meanwhile is not lost with the snapshots"


def test_missed_blocks_are_named_and_a_world_that_replays_is_ignored(run: Run, tmp_path: Path) -> None:
    shown = []
    follower = Follower(Scene(run.scenario), shown.append, tmp_path)
    for number in (0, 3, 0):
        first = 100 * number
        facts = tuple(run.facts[first : first + 100])
        follower.enqueue(TruthBlock, codec.encode(TruthBlock(number, run.scenario.node_ids, facts)))
    follower.enqueue(TruthBlock, b"garbage")
    follower.enqueue(Event, codec.encode(Event(399, "end", "", "")))
    follower.follow(lambda: True)
    lines = [line.text for snapshot in shown for line in snapshot.lines]
    assert any("missed 2 blocks" in text for text in lines)
    assert any("cannot read a TruthBlock" in text for text in lines)
    assert shown[-1].time_s == 399


def test_who_joins_late_reads_the_beginning_in_the_run_folder(run: Run) -> None:
    shown = []
    follower = Follower(Scene(run.scenario), shown.append, run.folder)
    late = TruthBlock(7, run.scenario.node_ids, tuple(run.facts[300:]))
    follower.enqueue(TruthBlock, codec.encode(late))
    follower.enqueue(Event, codec.encode(Event(LAST_TICK, "end", "", "run hash 0")))
    follower.follow(lambda: True)
    whole = Scene(run.scenario)
    for facts in run.facts:
        whole.take(facts)
    assert (shown[-1].heat_s == whole.snapshot().heat_s).all()
    texts = [line.text for snapshot in shown for line in snapshot.lines]
    assert texts == ["kill r4, confirmed", "restart r4, confirmed", "end of the run: run hash 0"]


class Live:
    """A router with a dashboard process as its only client; the test is the world and the launcher."""

    def __init__(self, run: Run, folder: Path) -> None:
        self.run, self.folder = run, folder
        shutil.copy(run.folder / "scenario.toml", folder)
        book = make_book("run1", f"tcp/127.0.0.1:{free_port()}", run.scenario.node_ids)
        self.link = open_router(book, access_control(book), fresh("world"))
        self.joined = threading.Event()
        observer = book.ticket("observer1")
        self.link.watch_sessions(
            lambda session, _: self.joined.set() if session == observer.credential.session else None
        )
        key = channels.key("run1", channels.TRUTH)
        self.lossless = self.link.publisher(key)  # a burst, as a test makes it, would be dropped in part
        self.droppable = self.link.publisher(key, droppable=True)
        self.event = self.link.publisher(channels.key("run1", channels.EVENT), droppable=True)
        self.process, self.said = start_dashboard(folder, observer)
        assert self.joined.wait(60)

    def put(self, publisher: Publisher, number: int, facts: list[Facts]) -> None:
        publisher.put(codec.encode(TruthBlock(number, self.run.scenario.node_ids, tuple(facts))))

    def end(self, tick: int) -> None:
        """As the world does: into the log, and to whoever listens."""
        event = Event(tick, "end", "", "run hash 0", {"completed": True})
        line = {"tick": tick, "kind": "end", "node": "", "text": event.text, "data": event.data}
        (self.folder / "events.jsonl").write_bytes(msgspec.json.encode(line) + b"\n")
        self.event.put(codec.encode(event))

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        self.said.close()
        self.link.close()


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def start_dashboard(folder: Path, ticket: Ticket) -> tuple[subprocess.Popen, object]:
    """The process as the launcher starts it, and what it says on its descriptor."""
    secret = hand_over(ticket)
    reading, writing = os.pipe()
    command = [
        sys.executable,
        "-m",
        "deploy.dashboard",
        "--folder",
        str(folder),
        "--mode",
        "file",
        "--ticket-fd",
        str(secret),
        "--say-fd",
        str(writing),
        "--parent-pid",
        str(os.getpid()),
    ]
    process = subprocess.Popen(command, pass_fds=(secret, writing))
    os.close(secret)
    os.close(writing)
    return process, os.fdopen(reading)


@pytest.fixture
def live(run: Run, tmp_path: Path) -> Live:
    live = Live(run, tmp_path)
    yield live
    live.close()


def test_a_live_dashboard_shows_what_the_world_says(live: Live) -> None:
    assert live.said.readline() == "live.rrd\n"
    for number in range(8):
        live.put(live.lossless, number, live.run.facts[50 * number : 50 * number + 50])
    live.put(live.lossless, 8, live.run.facts[400:])
    live.end(LAST_TICK)
    assert live.process.wait(60) == 0
    rows = rows_of(live.folder / "live.rrd")
    assert rows["/map/robots Points2D:positions"][-1][0] == LAST_TICK
    assert (100.0, ["dead"]) in rows["/states/r4 StateChange:state"]
    assert any("end of the run" in text for _, [text] in rows["/events TextLog:text"])


def test_a_frozen_dashboard_stops_neither_the_world_nor_its_own_end(live: Live) -> None:
    """More than all buffers hold is put while it stands still. A put that blocks does so for 5 s at least:
    then Zenoh gives the peer up."""
    assert live.said.readline() == "live.rrd\n"
    live.put(live.droppable, 0, live.run.facts[:1])
    os.kill(live.process.pid, signal.SIGSTOP)
    done = threading.Event()

    def put_much() -> None:
        heavy = live.run.facts[1]
        heavy = msgspec.structs.replace(heavy, reports=(("r2", bytes(1_000_000)),))
        for number in range(1, 20):
            live.put(live.droppable, number, [heavy])
        done.set()

    threading.Thread(target=put_much, daemon=True).start()
    assert done.wait(4), "the world was blocked by a frozen listener"
    os.kill(live.process.pid, signal.SIGCONT)
    live.end(LAST_TICK)
    assert live.process.wait(60) == 0
