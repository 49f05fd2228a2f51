"""Below the graph of a clearing: how old the one is that the tower heard."""

from pathlib import Path

import msgspec

from deploy.dashboard import record
from deploy.scene import Scene, Snapshot
from deploy.scenes.clear import ClearMission
from tests.clear_runs import GRAPH, LAST_TICK, SPLIT_TICK, box_facts, box_scenario
from tests.line_runs import write_line_run
from tests.test_dashboard import rows_of
from wire import codec
from wire.clearing import Overheard
from wire.messages import Facts

HEARD_TICK = SPLIT_TICK + 10
WORD = codec.encode(Overheard(HEARD_TICK, codec.encode(GRAPH)))


def run(*reports: tuple[int, bytes], last_tick: int = LAST_TICK) -> list[Facts]:
    """The synthetic clearing, with what the tower reports, by tick."""
    told = dict(reports)
    return [
        msgspec.structs.replace(one, reports=(*one.reports, ("r1", told[one.tick])))
        if one.tick in told
        else one
        for one in box_facts(last_tick)
    ]


def seen(facts: list[Facts]) -> Snapshot:
    scene = Scene(box_scenario())
    for one in facts:
        scene.take(one)
    return scene.snapshot()


def words(snapshot: Snapshot) -> list[str]:
    return [label for label in snapshot.sketch.labels if label.startswith("tower")]


def test_it_ages_until_the_tower_hears_it_again() -> None:
    first = (HEARD_TICK + 1, WORD)
    assert words(seen(run(first, last_tick=HEARD_TICK))) == []
    assert words(seen(run(first, last_tick=HEARD_TICK + 1))) == ["tower: graph of tick 90, 0.2 s old"]
    assert words(seen(run(first, last_tick=150))) == ["tower: graph of tick 90, 15.0 s old"]
    again = (141, codec.encode(Overheard(140)))
    assert words(seen(run(first, again, last_tick=150))) == ["tower: graph of tick 140, 2.5 s old"]


def test_the_graph_above_is_the_newest_of_any_robot() -> None:
    older = msgspec.structs.replace(GRAPH, vertices=GRAPH.vertices[:1], edges=(), main=None)
    told = codec.encode(Overheard(HEARD_TICK, codec.encode(older)))
    with_it, without = seen(run((HEARD_TICK + 1, told))), seen(run())
    assert with_it.sketch.labels[:-1] == without.sketch.labels
    assert with_it.sketch.links == without.sketch.links


def test_a_tower_with_other_words_and_a_mute_one_have_no_line() -> None:
    assert words(seen(run((HEARD_TICK, b"garbage"), (HEARD_TICK + 1, codec.encode(GRAPH))))) == []
    assert words(seen(run((HEARD_TICK, WORD), (HEARD_TICK + 1, b"")))) == [
        "tower: graph of tick 90, 17.5 s old"
    ]


def test_the_line_has_room_below_the_graph() -> None:
    sketch = seen(run((HEARD_TICK + 1, WORD))).sketch
    *others, (x, y) = sketch.points
    width, height = ClearMission.canvas
    assert 0 < x < width and max(other[1] for other in others) + 10 < y < height


def test_it_is_in_a_recording(tmp_path: Path) -> None:
    write_line_run(tmp_path, box_scenario(), run((HEARD_TICK + 1, WORD)))
    rows = rows_of(record(tmp_path, every_s=5))["/graph GraphNodes:labels"]
    assert {time_s: labels[-1] for time_s, labels in rows if time_s in (25.0, 40.0)} == {
        25.0: "tower: graph of tick 90, 2.5 s old",
        40.0: "tower: graph of tick 90, 17.5 s old",
    }
