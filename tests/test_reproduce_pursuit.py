"""`picket reproduce pursuit-evasion`: which runs there are, what is said of them, and a whole tiny study."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import shapely
from pyarrow import parquet

from deploy.__main__ import carry_out
from deploy.metrics.clear import Instant
from deploy.scenario_file import SHIPPED, ScenarioError, load_scenario
from deploy.studies.pursuit import plan, report, sections
from deploy.studies.pursuit.claims import verdicts
from deploy.studies.pursuit.figures import draw
from deploy.studies.pursuit.literal import read_literally
from deploy.studies.pursuit.places import places_around
from deploy.studies.pursuit.runs import Runs, save
from tests.clear_builders import ELL
from tests.made_up_runs import EXTENT, LEFT, run, runs
from wire.scenario import Cluster
from world_server.floorplan import PlanError

FALSE = {"cleared": False, "claim": "done", "contaminated_area_m2": 3.25, "clear_time_s": None}


def test_places_are_equally_far_apart_along_the_wall_from_the_lower_left_anticlockwise():
    assert places_around(shapely.box(0, 0, 4.8, 2.8), 4) == [(0.4, 0.4), (3.4, 0.4), (4.4, 2.4), (1.4, 2.4)]
    ell = places_around(shapely.Polygon(ELL), 8)
    ring = shapely.Polygon(ELL).buffer(-0.4).exterior
    assert len(set(ell)) == 8 and all(ring.distance(shapely.Point(one)) < 1e-3 for one in ell)


def test_a_plan_that_is_narrow_somewhere_has_places_in_all_its_parts_and_some_have_none():
    rooms = shapely.union_all([shapely.box(0, 0, 2, 2), shapely.box(2, 0.9, 3, 1.5), shapely.box(3, 0, 5, 2)])
    found = places_around(rooms, 5)
    assert [x_m < 2 for x_m, _ in found] == [True, True, True, False, False]
    with pytest.raises(PlanError, match=re.escape("nowhere are robots 0.4 m from the walls")):
        places_around(shapely.box(0, 0, 5, 0.7), 4)


def test_the_full_study_has_every_team_at_every_place_and_every_start_has_room_for_the_largest():
    study = plan.study(plan.FULL)
    trials = study.every_team()
    assert len({one.name for one in trials}) == len(trials) == 8 * 8 + 32 * 8 * len(plan.FULL.teams)
    kinds = [ground.kind for ground in study.grounds]
    assert kinds.count("cave") == 1 and kinds.count("2 x 2 rooms, an island") == 8
    assert len(set(study.grounds)) == 33, "no plan twice"
    cave = study.grounds[0]
    for place in range(1, 9):
        given = plan.Trial(cave, place, 16, 1).scenario()
        assert given.faults == () and given.sensors.referee == "both" and given.duration_s == 5400
        assert given.robots.start == Cluster(*plan.places(cave)[place - 1])
        assert given.robots.parameters["team"] == 16
    last = plan.Trial(study.grounds[-1], 8, 8, 2).scenario()
    assert last.seed == 2 and len(last.field.rings_m) == 1 + study.grounds[-1].random.islands
    assert (last.tower.x_m, last.tower.y_m) == plan.places(study.grounds[-1])[7]


def test_larger_teams_are_tried_where_the_fewest_that_clear_are_among_the_largest():
    study = plan.study(EXTENT)
    fewest = {("cave", 1): 8, ("cave", 2): 6, ("rooms2x2-plan1", 1): 7}
    assert [(one.place, one.robots) for one in study.larger_teams(fewest)] == [(1, 9), (1, 10)]
    assert study.larger_teams({}) == [] and study.larger_teams({("cave", 1): 6}) == []
    twice = study._replace(seeds=2, only="seed2").larger_teams({("cave", 1): 7})
    assert [one.name for one in twice] == ["cave-start1-n9-seed2"]


def test_the_largest_team_and_the_number_of_plans_can_be_given_and_runs_chosen_by_name():
    study = plan.study(plan.FULL, most=7, plans=1)
    assert [ground.teams for ground in study.grounds] == [(6, 7), plan.FULL.teams]
    chosen = study._replace(only="cave-start1-n7").every_team()
    assert [one.name for one in chosen] == ["cave-start1-n7-seed1"]
    with pytest.raises(
        ScenarioError, match="no run has this in its name; one is called cave-start1-n6-seed1"
    ):
        study._replace(only="start11").every_team()


def test_the_fewest_is_the_smallest_team_that_clears_in_every_run_and_knows_it():
    found = runs(
        {
            ("cave", 1, 6): LEFT,
            ("cave", 1, 7): FALSE,
            ("cave", 2, 7): LEFT,
            **{("rooms2x3-plan1", 1, robots): LEFT for robots in (6, 7)},
        }
    )
    cave, first, second, _ = found.grounds
    assert found.fewest_of(cave) == [8, 6] and found.fewest_of(second) == [None, 6]
    assert list(found.teams(cave, 1)) == [6, 7, 8, 9, 10], "two more than the fewest"
    assert [one.trial.robots for one in found.best(cave)] == [8, 6]
    twice = runs({("cave", 1, 6): {}}, plan.study(EXTENT)._replace(seeds=2))
    some = [one if one.trial.name != "cave-start1-n6-seed2" else run(one.trial, **LEFT) for one in twice.all]
    assert Runs(some).fewest_of(cave) == [7, 6]


@pytest.mark.parametrize(
    ("found", "false", "clears"),
    [
        ({}, False, True),
        (FALSE, True, False),
        (LEFT, False, False),
        ({"claim": "failed"}, False, False),
        ({"claim": "none"}, False, False),
        ({"clear_time_s": 989.75}, False, True),
        ({"clear_time_s": 990.25}, True, False),
    ],
    ids=["clears", "false", "failed", "wrongly failed", "silent", "just in time", "said too early"],
)
def test_a_claim_is_false_when_something_was_left_as_it_was_made(found, false, clears):
    """A run goes on for 10 s behind the claim: here to 1000 s."""
    trial = plan.study(EXTENT).every_team()[0]
    assert (run(trial, **found).is_false, run(trial, **found).clears) == (false, clears)


def test_what_must_never_be_is_counted_in_bold_with_names():
    found = runs(
        {
            ("cave", 1, 6): FALSE,
            ("cave", 1, 7): {"breaches": 2},
            ("cave", 2, 6): {"deaths": ("r3 died: exit code 1 at 5 s: KeyError: 7",)},
            ("cave", 2, 7): {"raster_end_m2": 0.01},
        }
    )
    said = "\n".join(sections.checks(found))
    assert f"**False claims (DONE while an intruder could be there): 1 of {len(found.all)} runs.**" in said
    assert f"**Runs with a breach: 1 of {len(found.all)}.**" in said
    assert "False: cave-start1-n6-seed1" in said and "Breached: cave-start1-n7-seed1" in said
    assert "KeyError: 7 (1 times)" in said
    assert "**They differ in 1: cave-start2-n7-seed1.**" in "\n".join(sections.referees(found))
    cells = sections.of_place(found, found.grounds[0])
    assert "| **7** | 7: done 700 s, **breaches: 2**; 8: done 800 s; 9: done 900 s" in cells
    assert "| **6** | 6: done 600 s, **died: 1**; 7: done 700 s; 8: done 800 s |" in cells
    nowhere = runs({("cave", 1, robots): FALSE for robots in (6, 7, 8)})
    assert "| **none** | 6: **done, but 3.2 m2 left**; 7:" in sections.of_place(nowhere, nowhere.grounds[0])


def words(found: Runs) -> dict[str, tuple[str, str]]:
    """Verdict and what was measured, by the first words of each statement."""
    return {one.claim[:24]: (one.word, one.measured) for one in verdicts(found, found.grounds[0])}


def test_numbers_of_a_plan_that_is_not_public_cannot_be_tested_and_ours_stand_beside_them():
    found = words(runs({("cave", 1, 6): LEFT | {"searches_failed": 1}}))
    assert found["9 robots clear the plan "] == ("not testable", "on cave, by place: 7, 6 robots")
    assert found["8 robots clear it from t"] == ("not testable", "from the best place 6")
    told = "1 runs with one robot fewer than it takes: 1 ended with claim failed"
    assert found["8 robots from there fail"] == ("not testable", told)
    assert found["7 robots from there clea"] == ("not testable", "one run of each kind: see --trials")


def test_what_the_paper_says_of_plans_in_general_is_judged():
    too_few = {("cave", 1, 6): LEFT | {"searches_failed": 1}}
    island = ("rooms2x2-islands1-plan1", 1, 6)
    found = words(runs(too_few | {island: {"graph": {"vertices": 4, "edges": 4, "cycle_edges": 1}}}))
    assert found["how many robots it takes"] == ("reproduced", "by place: 7, 6")
    assert found["with a robot too few an "][0] == "reproduced"
    assert found["who begins again elsewhe"] == ("not reproduced", "with 6 robots from 1 of 2 places")
    assert found["with more robots the exp"][0] == "reproduced"
    assert found["the algorithm can deal w"] == ("reproduced", "1 of 1 plans with islands")
    alike = {
        ("cave", place, robots): {"graph": {"vertices": 3, "edges": 2, "cycle_edges": 0}}
        for place in (1, 2)
        for robots in (6, 7, 8)
    }
    found = words(runs(alike))
    assert found["how many robots it takes"][0] == "not reproduced"
    assert found["with a robot too few an "] == (
        "not testable", "in 0 of 0 runs with one robot fewer than it takes"
    )  # fmt: skip
    assert found["who begins again elsewhe"][0] == "reproduced"
    assert found["with more robots the exp"][0] == "not reproduced"
    assert found["the algorithm can deal w"] == ("not reproduced", "0 of 1 plans with islands")


def test_a_study_in_which_nothing_clears_proves_nothing():
    grounds = plan.study(EXTENT).grounds
    nothing = {
        (one.name, place, robots): LEFT for one in grounds for place in (1, 2) for robots in range(5, 9)
    }
    found = words(runs(nothing))
    judged = {word for claim, (word, _) in found.items() if not claim.startswith("the algorithm")}
    assert judged == {"not testable"}


def test_a_report_of_made_up_runs_renders_and_has_a_row_for_each(tmp_path):
    found = runs({("cave", 1, 6): LEFT, ("rooms2x2-plan1", 1, 6): FALSE})
    main, letter = found.grounds[0], read_literally(1.0, 0.7)
    for one in found.best(main):
        (tmp_path / one.trial.name).mkdir()
        curve = [Instant(0.0, 100.0, 100.2, 0.0, 0), Instant(600.0, 0.0, 0.0, 0.0, 5)]
        np.savez(tmp_path / one.trial.name / "clear.npz", curve=curve)
    figures = [path.name for path in draw(found, main, letter, tmp_path)]
    judged = verdicts(found, main)
    scenario = found.all[0].trial.scenario()
    said = report.write(found, main, scenario, judged, letter, False, figures)
    other = found.all[0]._replace(summary=found.all[0].summary | {"commit": "abd"})
    mixed = report.write(Runs([other, *found.all[1:]]), main, scenario, judged, letter, True, [])
    assert "of several commits" in mixed and "QUICK" in mixed and "of several commits" not in said
    assert "QUICK" not in said and "It takes 6 from the best place and 7 from the worst." in said
    assert "| 6 | 1/2 (50%) | 1 | 0 | 600 | 2 | 1 | 0 | 5 [5..5] |" in said
    assert "### 2 x 2 rooms, an island: 1 plans" in said
    names = ("success", "places", "runs", "plans", "areas", "letter")
    assert sorted(figures) == sorted(f"{name}.png" for name in names)
    assert all(f"![{name}]({name}.png)" in said for name in names)
    assert said.count("| leaks |") == 2 and "**9.82**" in said
    save(found, tmp_path / "runs.parquet")
    rows = parquet.read_table(tmp_path / "runs.parquet").to_pylist()
    assert len(rows) == len(found.all) and rows[0]["islands"] == 0 and rows[-1]["islands"] in (0, 1)
    assert sum(row["false_claim"] for row in rows) == 1 and rows[0]["recontaminated_release_m2"] == 1.0


@pytest.fixture
def tiny(monkeypatch, tmp_path) -> Path:
    """Four robots from two places of the corridor, one of them in its dead end, and no random plans."""
    monkeypatch.setattr(plan, "MAIN", "clear-corridor")
    monkeypatch.setattr(plan, "QUICK", plan.Extent(1, 4, 4, 0, 60.0, 1, (4,), 20.0))
    return tmp_path / "out"


def reproduce(out: Path, *options: str) -> int:
    return carry_out(["reproduce", "pursuit-evasion", "--quick", "--out", str(out), *options])


def stamps(folder: Path) -> dict[str, int]:
    return {one.parent.name: one.stat().st_mtime_ns for one in folder.glob("*/summary.json")}


def test_a_whole_study_and_its_gaps_filled_in(tiny, capfd):
    """Run once; then only what is missing."""
    assert reproduce(tiny) == 0
    folder = tiny / "pursuit-evasion-quick"
    rows = {row["name"]: row for row in parquet.read_table(folder / "runs.parquet").to_pylist()}
    assert set(rows) == {"corridor-start1-n4-seed1", "rooms2x2-plan1-start1-n4-seed1"}
    kept = load_scenario(folder / "corridor-start1-n4-seed1" / "scenario.toml")
    assert kept.sensors.referee == "both" and kept.robots.count == 4
    for name, row in rows.items():
        metrics = json.loads((folder / name / "summary.json").read_text())["metrics"]
        assert row["claim"] == metrics["claim"] and row["unplanned_deaths"] == 0
        assert abs(row["raster_most_m2"]) < 1.0 and not (folder / name / "journal").exists()
    said = (folder / "report.md").read_text()
    assert "THIS IS A QUICK RUN" in said and "## corridor" in said and "**False claims" in said
    for name in re.findall(r"!\[.*?\]\((.*?)\)", said):
        assert (folder / name).read_bytes().startswith(b"\x89PNG"), name
    before = stamps(folder)
    (folder / "corridor-start1-n4-seed1" / "summary.json").unlink()
    assert reproduce(tiny) == 0
    after = stamps(folder)
    assert {name for name in after if after[name] != before[name]} == {"corridor-start1-n4-seed1"}
    assert reproduce(tiny, "--only", "corridor-start1") == 0
    assert "no report" in capfd.readouterr().out and stamps(folder) == after


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--trials", "0"], "--trials: must be a whole number >= 1, got '0'"),
        (["--plans", "-1"], "--plans: must be a whole number >= 0, got '-1'"),
        (["--most", "many"], "--most: must be a whole number >= 1, got 'many'"),
        (["--most", "9"], "--most 9: must be at least 10, the smallest team of the study"),
        (["--only", "no-such"], "--only no-such: no run has this in its name; one is called cave-start1-n10"),
        (["--out", "{file}"], "cannot make a folder there: Not a directory"),
    ],
)
def test_a_mistake_is_one_clear_line(options, words, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert reproduce(tmp_path, *(one.format(file=tmp_path / "file") for one in options)) == 2
    said = capsys.readouterr().err
    assert words in said and said.count("\n") == 1


def test_the_main_plan_is_one_that_ships():
    assert (SHIPPED / f"{plan.MAIN}.toml").is_file() and (SHIPPED / f"{plan.RANDOM}.toml").is_file()
