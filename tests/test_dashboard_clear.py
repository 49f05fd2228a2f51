"""The picture of a clearing: what is contaminated, lines, roles, the graph; in recordings and live."""

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from deploy.dashboard import record
from deploy.drawing import Picture
from deploy.following import Follower
from deploy.scene import Scene, describe
from deploy.scenes.clear import MAIN, STANDING, ClearMission
from deploy.scenes.mission import BLUE, GREEN, GREY, ORANGE, RED, VIOLET, WHITE, YELLOW
from deploy.scenes.shapes import area_m2
from tests.builders import facts
from tests.clear_builders import clearing
from tests.clear_runs import (
    CLAIM_TICK,
    GRAPH,
    KILL_TICK,
    LAST_TICK,
    SPLIT_TICK,
    STOPS_TICK,
    box_facts,
    box_scenario,
    contaminated,
    front_m,
    places_m,
)
from tests.line_runs import write_line_run
from tests.test_dashboard import rows_of, views_of
from tests.test_dashboard_line import drawn
from wire import codec
from wire.clearing import Clearing, Standing
from wire.messages import Event, Facts, TruthBlock
from world_server.judges import outline_of

EVERY_S = 1
TICKS = 4
"""In a second."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("clear")
    write_line_run(folder, box_scenario(), box_facts())
    return folder


@pytest.fixture(scope="module")
def rows(folder: Path) -> dict[str, list]:
    return rows_of(record(folder, every_s=EVERY_S))


def strips(rows: dict[str, list], name: str) -> dict[float, np.ndarray]:
    """The strokes of a name by time, in the field's frame."""
    found = rows[f"/map/{name} LineStrips2D:strips"]
    return {time_s: np.array(strokes) * (1, -1) for time_s, strokes in found}


def scene_at(tick: int) -> Scene:
    scene = Scene(box_scenario())
    for one in box_facts(tick):
        scene.take(one)
    return scene


def lone(*reports: tuple[str, bytes], clearing: Clearing | None = Clearing(1.0)) -> Facts:
    """Facts of tick 1 in which robots say that."""
    poses, goals = np.zeros((6, 3)).tobytes(), np.full((6, 2), np.nan).tobytes()
    return msgspec.structs.replace(
        facts(1, reports=reports), poses=poses, goals=goals, modes=bytes(6), clearing=clearing
    )


def test_a_snapshot_is_one_row_of_everything(rows: dict[str, list]) -> None:
    times = [*range(0, LAST_TICK // TICKS + 1, EVERY_S)]
    names = (
        "/map/robots Points2D:positions",
        "/map/names Points2D:labels",
        "/map/lines LineStrips2D:strips",
        "/map/sight LineStrips2D:strips",
        *(f"/plots/{name} Scalars:scalars" for name in ("contaminated", "lost", "lines", "radio")),
    )
    for name in names:
        assert [time_s for time_s, _ in rows[name]] == times, name


def test_what_is_drawn_as_contaminated_is_so(rows: dict[str, list]) -> None:
    for time_s, strokes in strips(rows, "contaminated").items():
        assert strokes[:, :, 0].min() == pytest.approx(front_m(int(time_s * TICKS)), abs=1e-5)
        heights = np.unique(strokes[:, :, 1])
        step_m = np.diff(heights).mean()
        painted_m2 = np.abs(np.diff(strokes[:, :, 0], axis=1)).sum() * step_m
        assert painted_m2 == pytest.approx(contaminated(int(time_s * TICKS)).area, rel=0.01)


def test_an_area_that_stays_as_it_is_is_not_drawn_again(rows: dict[str, list]) -> None:
    times = [*range(STOPS_TICK // TICKS + 1)]
    for name in ("contaminated", "front"):
        assert [time_s for time_s, _ in rows[f"/map/{name} LineStrips2D:strips"]] == times


def test_where_nothing_is_contaminated_any_more_the_area_is_taken_away() -> None:
    scene, logged = scene_at(4), []

    class Stream:
        def log(self, entity: str, *what: object, static: bool = False) -> None:
            logged.append((entity, type(what[0]).__name__))

        def set_time(self, timeline: str, duration: float) -> None:
            pass

    picture = Picture(Stream(), scene)
    picture.show(scene.snapshot())
    assert ("map/contaminated", "Clear") not in logged
    nothing = outline_of(contaminated(0).difference(contaminated(0)))
    scene.take(msgspec.structs.replace(box_facts(8)[-1], clearing=Clearing(0.0, outline=nothing)))
    picture.show(scene.snapshot())
    assert {("map/contaminated", "Clear"), ("map/front", "Clear")} < set(logged)


def test_lines_go_from_wall_to_wall_and_nowhere_else(rows: dict[str, list]) -> None:
    links = strips(rows, "lines")
    for time_s in (0.0, 10.0, SPLIT_TICK / TICKS, KILL_TICK / TICKS):
        tick = int(time_s * TICKS)
        _, *robots = places_m(tick).tolist()
        x_m, dead = front_m(tick), tick >= KILL_TICK
        expected = [] if dead else [(robots[0], robots[1]), (robots[1], robots[2])]
        expected += [(robots[3], robots[4])] if tick >= SPLIT_TICK else []
        expected += [(robots[0], [x_m, 3.0]), (robots[2], [x_m, 0.0])]
        assert np.allclose(links[time_s], expected, atol=1e-5)


def test_the_line_that_moves_has_another_colour_than_those_that_stand(rows: dict[str, list]) -> None:
    colours = {
        time_s: [drawn(one) for one in painted] for time_s, painted in rows["/map/lines LineStrips2D:colors"]
    }
    assert colours[0.0] == [MAIN] * 4
    assert sorted(colours[30.0]) == sorted([STANDING, MAIN, MAIN])


def test_only_the_living_see(rows: dict[str, list]) -> None:
    circles_m = strips(rows, "sight")
    assert len(circles_m[0.0]) == 5
    assert len(circles_m[KILL_TICK / TICKS]) == 4
    assert np.allclose(np.hypot(*(circles_m[0.0][0] - places_m(0)[1]).T), 0.7, atol=1e-5)


def test_robots_have_the_colour_and_the_lane_of_their_role(rows: dict[str, list]) -> None:
    lanes = {
        node: [(time_s, role) for time_s, [role] in rows[f"/states/{node} StateChange:state"]]
        for node in ("r2", "r3", "r5", "r6")
    }
    assert lanes["r2"] == [(0.0, "leader")]
    assert lanes["r3"] == [(0.0, "centre"), (KILL_TICK / TICKS, "dead")]
    assert lanes["r5"] == [(0.0, "reserve"), (SPLIT_TICK / TICKS, "centre")]
    assert lanes["r6"] == [(0.0, "joining"), (SPLIT_TICK / TICKS, "leader")]
    _, colours = rows["/map/robots Points2D:colors"][-1]
    assert [drawn(one) for one in colours] == [YELLOW, RED, YELLOW, GREEN, YELLOW]
    assert drawn(rows["/map/robots Points2D:colors"][0][1][3]) == BLUE
    assert rows["/map/names Points2D:labels"][-1][1] == ["r2", "r3 dead", "r4", "r5", "r6"]


def test_who_says_nothing_that_is_understood_is_free() -> None:
    scene = Scene(box_scenario())
    said = (
        ("r2", b"garbage"),
        ("r3", codec.encode(Standing("emperor"))),
        ("r1", codec.encode(Standing("centre"))),
    )
    scene.take(lone(*said))
    snapshot = scene.snapshot()
    assert snapshot.colours[1:] == (GREY,) * 5
    assert snapshot.strokes["lines"] is None
    assert snapshot.sketch is None


def test_neighbours_that_nobody_knows_and_walls_that_nobody_sees_are_no_line() -> None:
    scene = Scene(box_scenario())
    said = Standing("centre", 1, True, "r77", "r6", wall_m=(math.nan, 0.0))
    far = Standing("leader", 1, True, "r2", "wall", wall_m=(0.0, 1e300))
    reports = {"r2": said, "r5": msgspec.structs.replace(far, left=""), "r6": Standing("reserve")}
    scene.take(lone(*((node, codec.encode(one)) for node, one in reports.items())))
    assert scene.snapshot().strokes["lines"] is None


def test_a_robot_that_comes_in_is_linked_to_by_those_who_hold_it() -> None:
    scene = Scene(box_scenario())
    line = {"r2": Standing("leader", 1, True, "wall", "r3"), "r3": Standing("joining", 1, False, "r2", "r4")}
    scene.take(lone(*((node, codec.encode(one)) for node, one in line.items())))
    lines = scene.snapshot().strokes["lines"]
    assert (len(lines.lines_m), lines.colours) == (1, (MAIN,))


def test_curves_are_the_area_the_losses_and_the_robots_on_lines(rows: dict[str, list]) -> None:
    for time_s, [area] in rows["/plots/contaminated Scalars:scalars"]:
        assert area == pytest.approx(contaminated(int(time_s * TICKS)).area)
    lost, lines = dict(rows["/plots/lost Scalars:scalars"]), dict(rows["/plots/lines Scalars:scalars"])
    assert lost[29.0] == [0, 0, 0, 0]
    assert lost[30.0] == [2.0, 0, 0, 0]
    assert (lines[0.0], lines[20.0], lines[30.0]) == ([3, 0, 2, 0], [3, 2, 0, 0], [2, 2, 0, 1])


def test_decisions_losses_and_claims_stand_in_the_event_log(rows: dict[str, list]) -> None:
    texts = [(time_s, text) for time_s, [text] in rows["/events TextLog:text"]]
    levels = [level for _, [level] in rows["/events TextLog:level"]]
    assert texts == [
        (SPLIT_TICK / TICKS, "r2 splits its line at an obstacle"),
        (KILL_TICK / TICKS, "2.00 m² contaminated again: with the robot that died"),
        (CLAIM_TICK / TICKS, "r2 claims that the team has failed"),
    ]
    assert levels == ["INFO", "WARN", "WARN"]


def test_a_breach_is_an_error_however_small_and_clear_is_said_once() -> None:
    scene = Scene(box_scenario())
    scene.take(lone(clearing=Clearing(1.0, 1e-3)))
    for tick in (2, 3):
        scene.take(msgspec.structs.replace(lone(clearing=Clearing(0.0)), tick=tick))
    lines = scene.snapshot().lines
    assert [(line.level, line.time_s) for line in lines] == [("ERROR", 0.25), ("INFO", 0.5)]
    assert "breach" in lines[0].text


def test_the_graph_is_drawn_when_a_robot_tells_a_newer_one(rows: dict[str, list]) -> None:
    times = {name: [time_s for time_s, _ in found] for name, found in rows.items() if "/graph" in name}
    assert times
    assert all(seen == [SPLIT_TICK / TICKS] for seen in times.values())
    [(_, labels)] = rows["/graph GraphNodes:labels"]
    assert labels == ["v0: 2", "v1: 4", "v2: 3", "v3: 5", "2", "line 1: 3", "1"]
    [(_, colours)] = rows["/graph GraphNodes:colors"]
    assert [drawn(one) for one in colours] == [GREEN, ORANGE, WHITE, RED, GREY, ORANGE, VIOLET]
    [(_, links)] = rows["/graph GraphEdges:edges"]
    assert {(link["first"], link["second"]) for link in links} == {
        (f"v{edge.low}", f"e{edge.low}-{edge.high}") for edge in GRAPH.edges
    } | {(f"e{edge.low}-{edge.high}", f"v{edge.high}") for edge in GRAPH.edges}


def test_traffic_of_the_radio_is_not_on_the_map(rows: dict[str, list]) -> None:
    """Everybody near hears everybody: links would hide the lines."""
    assert not [name for name in rows if name.startswith(("/map/links", "/map/goals", "/map/reach"))]
    text = describe(Scene(box_scenario()))
    assert "delivered" not in text
    assert "orange lost again" in text


def test_walls_lie_within_the_bounds_and_turn_with_the_world() -> None:
    for turned_rad in (0.0, 1.0):
        mission = ClearMission(clearing(turned_rad=turned_rad))
        left, bottom, right, top = mission.bounds_m
        walls = mission.fixed["walls"].lines_m[0]
        assert (walls > (left, bottom)).all()
        assert (walls < (right, top)).all()
        assert area_m2(walls) == pytest.approx(20.0)
        corner = walls[1] - walls[0]
        assert math.atan2(corner[1], corner[0]) == pytest.approx(turned_rad)


def test_the_blueprint_has_all_views(folder: Path, rows: dict[str, list]) -> None:
    assert views_of(folder / "recording.rrd") == {
        "2D": 1,
        "Graph": 1,
        "TimeSeries": 4,
        "StateTimeline": 1,
        "TextLog": 1,
        "TextDocument": 1,
    }


def test_live_it_is_the_same_picture(tmp_path: Path) -> None:
    given, shown, told = box_scenario(), [], box_facts()
    follower = Follower(Scene(given), shown.append, tmp_path)
    for number, first in enumerate(range(0, LAST_TICK + 1, 40)):
        block = TruthBlock(number, given.node_ids, tuple(told[first : first + 40]))
        follower.enqueue(TruthBlock, codec.encode(block))
    follower.enqueue(Event, codec.encode(Event(LAST_TICK, "end", "", "run hash 0")))
    follower.follow(lambda: True)
    last = scene_at(LAST_TICK).snapshot()
    assert shown[-1].time_s == LAST_TICK / TICKS
    assert (shown[-1].colours, shown[-1].sketch) == (last.colours, last.sketch)
    assert shown[-1].curves["lines"] == last.curves["lines"]
    for name, strokes in last.strokes.items():
        assert np.array_equal(shown[-1].strokes[name].lines_m, strokes.lines_m)
