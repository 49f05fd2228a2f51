"""The dashboard: what is in a recording is what was true, live or afterwards, and nobody waits for a viewer."""

import os
import shutil
import subprocess
import sys
import threading
from collections import defaultdict
from pathlib import Path

import msgspec
import numpy as np
import pytest
from rerun.chunk import RrdReader

from deploy.dashboard import record
from deploy.following import Follower, Handover
from deploy.rehearsal import rehearse
from deploy.scenario_file import find_scenario, load_scenario, to_toml
from deploy.scene import Scene
from wire import channels, codec
from wire.credentials import Ticket, fresh, hand_over, make_book
from wire.link import open_router
from wire.messages import Event, Facts, TruthBlock
from wire.scenario import Scenario
from world_server.access import access_control
from world_server.journal import commits

LAST_TICK = 400
FAULTS = '[{at_s = 100, verb = "kill", nodes = ["r4"]}, {at_s = 250, verb = "restart", nodes = ["r4"]}]'
SPARSE = 3
RANGE_M = 180.0


class Run:
    """A short rehearsal in a folder, and its facts."""

    def __init__(self, folder: Path) -> None:
        settings = ["robots.count=9", f"faults={FAULTS}", f"duration_s={LAST_TICK}", "metrics_from_s=0"]
        self.scenario = load_scenario(find_scenario("area-patrol"), settings)
        self.folder = folder
        toml = to_toml(self.scenario)
        (folder / "scenario.toml").write_text(toml)
        rehearse(self.scenario, toml, folder, LAST_TICK)
        self.facts = [commit.facts for commit in commits(folder / "journal")]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return Run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def rows(run: Run) -> dict[str, list]:
    return rows_of(record(run.folder, every_s=SPARSE))


def rows_of(path: Path) -> dict[str, list]:
    """(sim_time in s, value) in order of time, for every `entity component` of a recording."""
    found = defaultdict(list)
    for chunk in RrdReader(path).stream():
        batch = chunk.to_record_batch()
        if "sim_time" not in batch.schema.names:
            continue
        times = batch.column("sim_time").cast("int64").to_pylist()
        for name in batch.schema.names:
            if ":" in name:
                values = batch.column(name).to_pylist()
                found[f"{chunk.entity_path} {name}"] += [
                    (time_ns / 1e9, value)
                    for time_ns, value in zip(times, values, strict=True)
                    if value is not None
                ]
    return {name: sorted(values, key=lambda row: row[0]) for name, values in found.items()}


def positions(rows: dict[str, list]) -> dict[float, np.ndarray]:
    """Field positions of all robots at each time: float32 as drawn, y turned up again."""
    return {time_s: np.array(points) * (1, -1) for time_s, points in rows["/map/robots Points2D:positions"]}


def test_a_snapshot_is_one_row_and_time_only_goes_on(rows: dict[str, list]) -> None:
    times = [time_s for time_s, _ in rows["/map/robots Points2D:positions"]]
    assert times == [*range(0, LAST_TICK, SPARSE), LAST_TICK]
    for name in ("/map/idleness DepthImage:buffer", "/plots/radio Scalars:scalars"):
        assert [time_s for time_s, _ in rows[name]] == times


def test_every_robot_is_drawn_inside_the_field(rows: dict[str, list]) -> None:
    for points in positions(rows).values():
        assert points.shape == (9, 2)
        assert (points >= 0).all()
        assert (points <= 600).all()


def test_positions_are_the_true_ones(run: Run, rows: dict[str, list]) -> None:
    truth = np.frombuffer(run.facts[300].poses, "<f8").reshape(-1, 3)[1:, :2]
    assert np.allclose(positions(rows)[300.0], truth, atol=1e-3)


def test_every_link_ends_at_nodes_and_is_no_longer_than_the_range(rows: dict[str, list]) -> None:
    drawn = 0
    where = positions(rows)
    for time_s, strips in rows["/map/links LineStrips2D:strips"]:
        nodes = {(0.0, 0.0)} | {tuple(point) for point in where[time_s].tolist()}
        for ends in (np.array(strips) * (1, -1)).tolist():
            assert {tuple(end) for end in ends} <= nodes
            assert np.hypot(*np.subtract(*ends)) <= RANGE_M + 1e-3
            drawn += 1
    assert drawn > LAST_TICK / SPARSE


def test_links_are_cleared_where_nothing_was_delivered() -> None:
    """Otherwise the viewer would show the last links for ever."""
    scene, logged = silent_scene(), []
    from deploy.dashboard import Picture

    class Stream:
        def log(self, entity: str, what: object, static: bool = False) -> None:
            logged.append((entity, type(what).__name__))

        def set_time(self, timeline: str, duration: float) -> None:
            pass

    Picture(Stream(), scene).show(scene.snapshot())
    assert ("map/links", "Clear") in logged
    assert ("map/goals", "Clear") in logged


def silent_scene() -> Scene:
    """A scene at tick 0 in which nobody moves or says anything."""
    scene = Scene(load_scenario(find_scenario("area-patrol")))
    nodes = len(scene.nodes)
    poses, goals = np.zeros((nodes, 3)), np.full((nodes, 2), np.nan)
    scene.take(Facts(0, poses.tobytes(), goals.tobytes(), bytes(nodes), b"", (), (), (), (0, 0, 0, 0, 0, 0)))
    return scene


def test_the_hottest_cell_is_the_worst_idleness(rows: dict[str, list]) -> None:
    images = rows["/map/idleness DepthImage:buffer"]
    curves = rows["/plots/idleness Scalars:scalars"]
    for (_, [buffer]), (_, [mean_s, worst_s]) in zip(images, curves, strict=True):
        idle_s = np.array(buffer, "u1").view("<f4")
        assert len(idle_s) == 400
        assert idle_s.max() == worst_s
        assert idle_s.mean() == pytest.approx(mean_s, rel=1e-5)


def test_the_heat_map_has_its_top_row_first(run: Run, rows: dict[str, list]) -> None:
    visited = np.zeros(400, int)
    for facts in run.facts:
        for _, site in facts.visits:
            visited[site] = facts.tick
    idle_s = LAST_TICK - visited.reshape(20, 20).T[::-1]
    _, [buffer] = rows["/map/idleness DepthImage:buffer"][-1]
    assert (np.array(buffer, "u1").view("<f4").reshape(20, 20) == idle_s).all()


def test_events_stand_at_their_own_times_with_a_level(rows: dict[str, list]) -> None:
    texts = [(time_s, text) for time_s, [text] in rows["/events TextLog:text"]]
    assert (100.0, "kill r4, confirmed") in texts
    assert (250.0, "restart r4, confirmed") in texts
    assert texts[-1][0] == LAST_TICK
    assert texts[-1][1].startswith("end of the run")
    assert [level for _, [level] in rows["/events TextLog:level"]] == ["WARN", "INFO", "INFO"]


def test_the_lane_of_a_killed_robot_shows_when_it_was_dead(rows: dict[str, list]) -> None:
    lane = [(time_s, state) for time_s, [state] in rows["/states/r4 StateChange:state"]]
    assert lane[0][1] != "dead"
    deaths = [index for index, (_, state) in enumerate(lane) if state == "dead"]
    assert [lane[index][0] for index in deaths] == [100.0]
    assert lane[deaths[0] + 1][0] == 250.0
    assert all(one[1] != other[1] for one, other in zip(lane, lane[1:], strict=False)), "only on change"


def test_the_blueprint_has_all_views(run: Run, rows: dict[str, list]) -> None:
    reader = RrdReader(run.folder / "recording.rrd")
    seen = defaultdict(int)
    for chunk in reader.stream(store=reader.blueprints()[0]):
        batch = chunk.to_record_batch()
        if "ViewBlueprint:class_identifier" in batch.schema.names:
            for value in batch.column("ViewBlueprint:class_identifier").to_pylist():
                seen[value[0]] += 1
    assert seen == {"2D": 1, "TimeSeries": 3, "StateTimeline": 1, "TextLog": 1, "TextDocument": 1}


def test_a_journal_cut_off_by_a_kill_is_recorded_up_to_the_cut(run: Run, tmp_path: Path) -> None:
    for name in ("scenario.toml", "events.jsonl"):
        shutil.copy(run.folder / name, tmp_path)
    journal = (run.folder / "journal").read_bytes()
    (tmp_path / "journal").write_bytes(journal[: len(journal) // 2])
    events = (tmp_path / "events.jsonl").read_bytes()
    (tmp_path / "events.jsonl").write_bytes(events[: events.index(b"end") + 2])
    rows = rows_of(record(tmp_path))
    last = [commit.tick for commit in commits(tmp_path / "journal")][-1]
    assert 100 < last < LAST_TICK
    assert rows["/map/robots Points2D:positions"][-1][0] == last
    assert len(rows["/events TextLog:text"]) == 2


# Following a live run


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
    follower = Follower(Scene(run.scenario), shown.append, tmp_path / "events.jsonl")
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
            lambda session: self.joined.set() if session == observer.credential.session else None
        )
        self.truth = self.link.publisher(channels.key("run1", channels.TRUTH), droppable=True)
        self.event = self.link.publisher(channels.key("run1", channels.EVENT), droppable=True)
        self.process, self.said = start_dashboard(folder, observer)
        assert self.joined.wait(60)

    def put(self, number: int, facts: list[Facts]) -> None:
        self.truth.put(codec.encode(TruthBlock(number, self.run.scenario.node_ids, tuple(facts))))

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
    import socket

    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def start_dashboard(folder: Path, ticket: Ticket) -> tuple[subprocess.Popen, object]:
    """The process as the launcher starts it, and what it says on its descriptor."""
    secret = hand_over(ticket)
    reading, writing = os.pipe()
    command = [sys.executable, "-m", "deploy.dashboard", "--folder", str(folder), "--mode", "file",
               "--ticket-fd", str(secret), "--say-fd", str(writing), "--parent-pid", str(os.getpid())]
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
        live.put(number, live.run.facts[50 * number : 50 * number + 50])
    live.put(8, live.run.facts[400:])
    live.end(LAST_TICK)
    assert live.process.wait(60) == 0
    rows = rows_of(live.folder / "live.rrd")
    assert rows["/map/robots Points2D:positions"][-1][0] == LAST_TICK
    assert (100.0, ["dead"]) in rows["/states/r4 StateChange:state"]
    assert any("end of the run" in text for _, [text] in rows["/events TextLog:text"])


def test_a_frozen_dashboard_stops_neither_the_world_nor_its_own_end(live: Live) -> None:
    """More than all socket buffers hold is put while it stands still; it then says what it missed."""
    import signal

    assert live.said.readline() == "live.rrd\n"
    live.put(0, live.run.facts[:1])
    os.kill(live.process.pid, signal.SIGSTOP)
    done = threading.Event()

    def put_much() -> None:
        heavy = live.run.facts[1]
        heavy = msgspec.structs.replace(heavy, reports=(("r2", bytes(1_000_000)),))
        for number in range(1, 200):
            live.put(number, [heavy])
        done.set()

    threading.Thread(target=put_much, daemon=True).start()
    assert done.wait(60), "the world was blocked by a frozen listener"
    os.kill(live.process.pid, signal.SIGCONT)
    live.end(LAST_TICK)
    assert live.process.wait(60) == 0


def test_scenarios_of_a_run_are_read_back_equal(run: Run) -> None:
    text = (run.folder / "scenario.toml").read_text("utf-8")
    assert msgspec.toml.decode(text, type=Scenario) == run.scenario
