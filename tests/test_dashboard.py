"""What is in a recording is what was true."""

import shutil
from collections import defaultdict
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

from deploy.dashboard import record
from deploy.drawing import Picture
from deploy.rehearsal import rehearse
from deploy.scenario_file import find_scenario, load_scenario, to_toml
from deploy.scene import Scene
from wire.messages import Facts
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


def views_of(path: Path) -> dict[str, int]:
    """How many views of each kind the blueprint of a recording has."""
    reader, seen = RrdReader(path), defaultdict(int)
    for chunk in reader.stream(store=reader.blueprints()[0]):
        batch = chunk.to_record_batch()
        if "ViewBlueprint:class_identifier" in batch.schema.names:
            for value in batch.column("ViewBlueprint:class_identifier").to_pylist():
                seen[value[0]] += 1
    return seen


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
    assert all(one[1] != other[1] for one, other in pairwise(lane)), "only on change"


def test_the_blueprint_has_all_views(run: Run, rows: dict[str, list]) -> None:
    assert views_of(run.folder / "recording.rrd") == {
        "2D": 1,
        "TimeSeries": 3,
        "StateTimeline": 1,
        "TextLog": 1,
        "TextDocument": 1,
    }


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
