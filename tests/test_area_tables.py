"""What `area.npz` holds: maps of visits, curves, and the time until the tower has word of a visit."""

import numpy as np

from deploy.metrics.area import AreaMetrics
from deploy.metrics.word_of_visits import WordOfVisits
from swarm_agent.knowledge import News
from tests.builders import facts, scenario, table
from tests.live_runs import fault, rehearsed, small
from tower.base_station import Awareness
from wire import codec
from wire.fields import Grid
from wire.messages import Facts
from wire.scenario import PlannedFault
from world_server.nodes import ALIVE, DEAD


def knows(news: News) -> tuple[str, bytes]:
    return "r1", codec.encode(Awareness(news, False))


def test_visits_are_counted_by_phase_robot_and_site_from_metrics_from_s_on():
    plan = (PlannedFault(6.0, "kill", ("r3",)), PlannedFault(8.0, "restart", ("r3",)))
    fold = AreaMetrics(scenario(2, field=Grid(2, 1), metrics_from_s=3.0, faults=plan))
    seen = {2: ("r2", 0), 3: ("r2", 0), 5: ("r3", 1), 6: ("r2", 1), 7: ("r2", 1), 8: ("r3", 0)}
    for tick, visit in seen.items():
        fold.feed(facts(tick, [visit]))
    tables = fold.tables()
    assert tables["phase_ticks"].tolist() == [3, 6, 8]
    assert tables["visits"].tolist() == [[[1, 0], [0, 1]], [[0, 2], [0, 0]], [[0, 0], [1, 0]]]


def test_curves_are_sampled_each_minute_with_the_robots_that_are_active():
    """Ticks between facts are samples too: what held at the last one holds still."""

    def states(tick: int, *modes: int) -> Facts:
        return Facts(tick, b"", b"", bytes(modes), b"", (), (), (), (0, 0, 0, 0, 0, 0))

    fold = AreaMetrics(scenario(2, field=Grid(2, 1), duration_s=400.0))
    fold.feed(states(0, ALIVE, ALIVE, ALIVE))
    fold.feed(states(100, ALIVE, ALIVE, DEAD))
    fold.feed(states(180, ALIVE, ALIVE, DEAD))
    curves = fold.tables()["curves"]
    assert curves[:, 0].tolist() == [0, 60, 120, 180]
    assert curves[:, 1].tolist() == [0, 60, 120, 180], "graph idleness of a field that nobody visits"
    assert curves[:, -1].tolist() == [2, 2, 1, 1]


def test_a_visit_is_told_of_by_word_of_it_or_of_a_later_one():
    fold = WordOfVisits(2, 0)
    fold.visit(10, 0)
    fold.visit(15, 0)
    fold.visit(12, 1)
    fold.learn(20, 0, 10)
    assert fold.summary(20, 1.0) == {"word_mean_s": 10, "word_worst_s": 10}
    fold.learn(25, 0, 17)
    assert fold.summary(30, 1.0) == {"word_mean_s": 10, "word_worst_s": 18}, "site 1 waits since tick 12"
    assert fold.tables()["untold_tick"].tolist() == [-1, 12]


def test_word_is_what_the_tower_reports_and_nobody_else():
    fold = AreaMetrics(scenario(2, field=Grid(2, 1)))
    fold.feed(facts(3, [("r2", 1)]))
    fold.feed(facts(5, reports=[("r2", knows(table(s1=3))[1])]))
    assert fold.tables()["untold_tick"].tolist() == [-1, 3]
    fold.feed(facts(7, reports=[knows(table(s1=3))]))
    assert fold.tables()["untold_tick"].tolist() == [-1, -1]
    assert fold.summary()["word_worst_s"] == 4


def test_a_run_leaves_its_tables_beside_its_summary(tmp_path):
    from deploy.recorder import summarise
    from deploy.scenario_file import load_scenario

    path = small(tmp_path, faults=fault(100, "kill", "r5"))
    folder = rehearsed(tmp_path, path)
    summary = summarise(folder, load_scenario(path), "small", 1.0, [])
    with np.load(folder / "area.npz") as tables:
        assert tables["visits"].shape == (2, 4, 36)
        assert tables["visits"].sum() > summary["metrics"]["visits"] > 0, "first visits end no interval"
        assert tables["curves"][:, -1].tolist() == [4, 4, 3, 3]
    assert not list(folder.glob("*.part"))
