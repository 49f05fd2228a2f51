"""The picture of a line patrol: ages of segments, charges, lanes; in recordings and live."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from deploy.dashboard import record
from deploy.following import Follower
from deploy.scene import Scene, describe
from deploy.scenes.line import LineMission
from deploy.scenes.mission import BLUE, GREEN, GREY, RED, VIOLET, YELLOW
from swarm_agent.line_radio import Report
from tests.line_runs import EMPTY_V, FULL_V, Struck, line_facts, line_scenario, write_line_run
from tests.test_dashboard import rows_of, views_of
from wire import codec
from wire.fields import Polyline
from wire.messages import Event, Facts, TruthBlock
from wire.scenario import Scenario

DURATION_S, SPARSE = 600, 5
STRUCK = (Struck(200, 5, 2), Struck(300, 3, 1), Struck(400, 8, 3))
DEAD, FROZEN, FLAT = "r6", "r4", "r9"
LAP_S = 2 * (5.0 / 6) / 0.1 + 2 * np.pi / 2.0


class Run:
    """A synthetic run in a folder, and its facts."""

    def __init__(self, folder: Path) -> None:
        self.scenario = line_scenario(DURATION_S)
        self.facts = list(line_facts(self.scenario, STRUCK))
        self.folder = folder
        write_line_run(folder, self.scenario, self.facts)

    def ages_s(self, tick: int) -> list[int]:
        """Of all segments, counted anew."""
        visited = [0] * 18
        for facts in self.facts[: tick + 1]:
            for _, site in facts.visits:
                visited[site] = facts.tick
        return [tick - min(visited[first : first + 3]) for first in range(0, 18, 3)]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return Run(tmp_path_factory.mktemp("line"))


@pytest.fixture(scope="module")
def rows(run: Run) -> dict[str, list]:
    return rows_of(record(run.folder, every_s=SPARSE))


def drawn(colour: int) -> tuple[int, int, int]:
    """Red, green and blue of a colour as it is stored."""
    return colour >> 24, colour >> 16 & 255, colour >> 8 & 255


def lone(tick: int, given: Scenario, **fields: object) -> Facts:
    """Facts in which nothing happened but what is given."""
    nodes = len(given.node_ids)
    poses, goals = np.zeros((nodes, 3)).tobytes(), np.full((nodes, 2), np.nan).tobytes()
    still = Facts(tick, poses, goals, bytes(nodes), b"", (), (), (), (0, 0, 0, 0, 0, 0))
    return msgspec.structs.replace(still, **fields)


def test_a_snapshot_is_one_row_of_everything(rows: dict[str, list]) -> None:
    times = [*range(0, DURATION_S + 1, SPARSE)]
    names = (
        "/map/robots Points2D:positions",
        "/map/strips LineStrips2D:colors",
        "/map/numbers Points2D:labels",
    )
    plots = (f"/plots/{name} Scalars:scalars" for name in ("coverage", "robots", "battery", "radio"))
    for name in (*names, *plots):
        assert [time_s for time_s, _ in rows[name]] == times, name


def test_segments_say_how_old_they_are(run: Run, rows: dict[str, list]) -> None:
    for time_s, labels in rows["/map/numbers Points2D:labels"]:
        ages_s = run.ages_s(int(time_s))
        assert labels == [f"{number}: {age_s} s" for number, age_s in enumerate(ages_s, start=1)]


def test_colours_of_segments_go_from_green_to_red_with_their_age(run: Run, rows: dict[str, list]) -> None:
    seen = set()
    for time_s, colours in rows["/map/strips LineStrips2D:colors"]:
        for age_s, colour in zip(run.ages_s(int(time_s)), map(drawn, colours), strict=True):
            if age_s <= LAP_S:
                assert colour == GREEN
            elif age_s >= 4 * LAP_S:
                assert colour == RED
            else:
                assert colour not in (GREEN, RED)
            seen.add(colour)
    assert {GREEN, RED} < seen, "of a dead robot's segment, too"


def test_a_segment_is_as_old_as_its_least_recently_visited_site() -> None:
    given = line_scenario()
    mission = LineMission(given)
    for tick, sites in ((50, (3, 5)), (60, (4,)), (70, (3,)), (80, ())):
        visits = tuple(("r2", site) for site in sites)
        mission.take(lone(tick, given, visits=visits), np.zeros((0, 2), int))
    assert [one.label for one in mission.paints()][:3] == ["1: 80 s", "2: 30 s", "3: 80 s"]
    assert mission.curves()["coverage"] == pytest.approx(((5 * 80 + 30) / 6, 80))


def test_where_segments_are_many_only_old_ones_tell_their_age() -> None:
    given = line_scenario(field=Polyline(((0.0, 0.0), (26.0, 0.0)), 13, gap_m=0.2))
    mission = LineMission(given)
    mission.take(lone(4, given), np.zeros((0, 2), int))
    assert [one.label for one in mission.paints()][:2] == ["1", "2"]
    mission.take(lone(900, given, visits=(("r2", 0), ("r2", 1), ("r2", 2))), np.zeros((0, 2), int))
    assert [one.label for one in mission.paints()][:2] == ["1", "2: 900 s"]


def test_halfway_between_fresh_and_stale_is_yellow() -> None:
    given = line_scenario(tick_s=0.01)
    mission = LineMission(given)
    mission.take(lone(round(2.5 * LAP_S / 0.01), given), np.zeros((0, 2), int))
    assert all(np.abs(np.subtract(one.colour, YELLOW)).max() <= 1 for one in mission.paints())


def test_curves_of_coverage_are_the_mean_and_the_worst_age(run: Run, rows: dict[str, list]) -> None:
    for time_s, [mean_s, worst_s] in rows["/plots/coverage Scalars:scalars"]:
        ages_s = run.ages_s(int(time_s))
        assert worst_s == max(ages_s)
        assert mean_s == pytest.approx(np.mean(ages_s))


def test_there_is_a_battery_curve_for_every_robot(run: Run, rows: dict[str, list]) -> None:
    for time_s, charges_v in rows["/plots/battery Scalars:scalars"]:
        true_v = np.frombuffer(run.facts[int(time_s)].battery_v, "<f4")[1:]
        assert charges_v == pytest.approx(true_v.tolist())
    names = [plot for plot in Scene(run.scenario).plots if plot.name == "battery"][0].series
    assert tuple(name for name, _ in names) == run.scenario.robot_ids


def test_robots_are_coloured_by_charge() -> None:
    given = line_scenario()
    scene = Scene(given)
    charges_v = np.full(len(given.node_ids), np.nan, "<f4")
    charges_v[1:4] = FULL_V, (FULL_V + EMPTY_V) / 2, EMPTY_V
    scene.take(lone(1, given, battery_v=charges_v.tobytes()[:16] + np.full(5, 9, "<f4").tobytes()))
    assert scene.snapshot().colours[1:4] == (GREEN, YELLOW, RED)


def test_without_batteries_robots_are_coloured_by_what_they_do() -> None:
    given = line_scenario(battery=False)
    scene = Scene(given)
    said = (("r2", codec.encode(Report("patrol", 1, 9.0))), ("r3", codec.encode(Report("out", 2, 9.0))))
    scene.take(lone(1, given, reports=(*said, ("r4", b"garbage"))))
    snapshot = scene.snapshot()
    assert snapshot.colours[1:5] == (GREEN, BLUE, GREY, GREY)
    assert "battery" not in snapshot.curves
    assert [plot.name for plot in scene.plots] == ["coverage", "robots", "radio"]


def test_who_is_struck_is_named_and_keeps_a_colour_of_its_own(rows: dict[str, list]) -> None:
    labels = rows["/map/names Points2D:labels"][-1][1]
    assert {f"{DEAD} dead", f"{FROZEN} frozen", f"{FLAT} flat"} <= set(labels)
    colours = [drawn(colour) for colour in rows["/map/robots Points2D:colors"][-1][1]]
    assert colours[labels.index(f"{FLAT} flat")] == VIOLET
    assert colours[labels.index(f"{DEAD} dead")] == RED
    assert rows["/map/names Points2D:labels"][0][1] == [f"r{number}" for number in range(2, 10)]


@pytest.mark.parametrize(
    ("node", "time_s", "state"), [(DEAD, 200.0, "dead"), (FROZEN, 300.0, "frozen"), (FLAT, 400.0, "flat")]
)
def test_lanes_show_what_robots_say_and_what_befalls_them(
    rows: dict[str, list], node: str, time_s: float, state: str
) -> None:
    lane = [(when_s, what) for when_s, [what] in rows[f"/states/{node}" + " StateChange:state"]]
    assert lane[0] == (0.0, "queue")
    assert (time_s, state) in lane
    assert {what for when_s, what in lane if when_s < time_s} <= {"queue", "out", "patrol", "home"}


def test_robots_that_do_not_patrol_are_counted(rows: dict[str, list]) -> None:
    counts = dict(rows["/plots/robots Scalars:scalars"])
    assert counts[0.0] == [8, 0, 0]
    assert counts[float(DURATION_S)][2] == len(STRUCK)
    assert all(sum(count) <= 8 for count in counts.values())
    assert any(under_way for _, under_way, _ in counts.values())


def test_everything_lies_within_the_bounds(run: Run) -> None:
    """The tower's queue beside the line too, wherever the line goes."""
    bent = Polyline(((5.0, 5.0), (0.0, 5.0), (0.0, -5.0)), 4, gap_m=0.3)
    for given in (run.scenario, line_scenario(field=bent)):
        mission = LineMission(given)
        left, bottom, right, top = mission.bounds_m
        strips = [point for one in mission.strips for point in (*one.points_m, one.label_m)]
        for x_m, y_m in (*strips, *mission.places, *(point for way in mission.ways for point in way)):
            assert left <= x_m <= right
            assert bottom <= y_m <= top
        assert len(mission.places) == len(given.robot_ids)
    assert (0.0, 5.0) in mission.ways[0]


def test_robots_are_drawn_as_large_as_they_are_unless_that_were_invisible() -> None:
    assert LineMission(line_scenario()).radius_m == 0.1
    long = line_scenario(field=Polyline(((0.0, 0.0), (600.0, 0.0)), 6))
    assert LineMission(long).radius_m == pytest.approx(5.0)


def test_the_blueprint_has_all_views(run: Run, rows: dict[str, list]) -> None:
    assert views_of(run.folder / "recording.rrd") == {
        "2D": 1,
        "TimeSeries": 4,
        "StateTimeline": 1,
        "TextLog": 1,
        "TextDocument": 1,
    }


def test_the_description_says_how_to_read_it(run: Run) -> None:
    text = describe(Scene(run.scenario))
    assert f"red after 4 laps ({4 * LAP_S:.0f} s)" in text
    assert "green 9 V, red 8 V" in text


def test_live_it_is_the_same_picture(run: Run, tmp_path: Path) -> None:
    shown = []
    follower = Follower(Scene(run.scenario), shown.append, tmp_path)
    for number, first in enumerate(range(0, DURATION_S + 1, 100)):
        block = TruthBlock(number, run.scenario.node_ids, tuple(run.facts[first : first + 100]))
        follower.enqueue(TruthBlock, codec.encode(block))
    follower.enqueue(Event, codec.encode(Event(DURATION_S, "end", "", "run hash 0")))
    follower.follow(lambda: True)
    whole = Scene(run.scenario)
    for facts in run.facts:
        whole.take(facts)
    last = whole.snapshot()
    assert shown[-1].time_s == DURATION_S
    assert (shown[-1].paints, shown[-1].colours) == (last.paints, last.colours)
    assert shown[-1].curves["battery"] == last.curves["battery"]
