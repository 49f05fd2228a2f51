"""Mission clear in the world: what robots are not told, frames, turned worlds, faults, and the end."""

import math
from itertools import combinations, pairwise

import msgspec
import numpy as np
import pytest
import shapely

from deploy.scenario_file import to_toml
from swarm_agent.node import Mind
from tests.builders import course, events
from tests.clear_builders import (
    BODY_M,
    BOX,
    ELL,
    all_commits,
    all_grants,
    clearing,
    fronts_rad,
    percepts_hash,
    places_m,
)
from tests.live_runs import as_processes, rehearsed, run_hash
from tests.wandering_discs import Hello
from wire import codec
from wire.fields import FloorPlan, Unseen
from wire.messages import Configuration, Frame, Percept, Senses
from wire.scenario import Cluster, PlannedFault, Poses, Sensors
from world_server.nodes import DEAD

# What robots are told


def test_no_robot_is_told_where_it_or_anything_is(tmp_path):
    """Nor is the tower: neither percepts nor configurations have a position, a pose, or the plan."""
    given = clearing(4, start=Cluster(5.0, 1.0))
    run = course(given, tmp_path)
    for grant in all_grants(run.journal):
        senses, told = grant.senses, grant.configuration
        assert senses.pose is None and senses.in_sight == () and senses.blocked_by is None
        assert senses.travelled_m == 0 and senses.shared_last_visit == b""
        if told is not None:
            assert told.field == Unseen(0.7, 180, 2.0) and told.tower_m == (0.0, 0.0)
            assert grant.node == given.tower.id or len(senses.scan) == 180 * 4
    assert all(not grant.senses.scan for grant in all_grants(run.journal) if grant.node == given.tower.id)


def test_a_floor_plan_cannot_even_be_said_to_a_node():
    told = Configuration("r2", 0, "x", b"", (), 0.25, "r1", FloorPlan(rings_m=(ELL,)), 0.2)
    percept = Percept(0, 0, "start", Senses(), (), told)
    with pytest.raises(codec.Malformed):
        codec.decode(Percept, codec.encode(percept))


def test_nothing_in_a_percept_changes_when_the_whole_world_is_moved(tmp_path):
    """So no number in it can be a position: the plan and the start are 5 m farther east and 3 m south."""
    moved = tuple((x_m + 5.0, y_m - 3.0) for x_m, y_m in ELL)
    here = course(clearing(4, start=Cluster(5.0, 1.0)), tmp_path / "here")
    there = course(clearing(4, (moved,), start=Cluster(10.0, -2.0)), tmp_path / "there")
    assert percepts_hash(here.journal) == percepts_hash(there.journal)
    assert here.run_hash != there.run_hash


@pytest.mark.parametrize("turned_rad", [0.5, -2.2])
def test_nothing_in_a_percept_changes_when_the_whole_world_is_turned(tmp_path, turned_rad):
    """Twelve robots that run into walls and into each other: whatever they are told and do is the same."""
    plain = clearing(12, start=Cluster(5.0, 1.0), duration_s=60.0)
    turned = msgspec.structs.replace(plain, field=msgspec.structs.replace(plain.field, turned_rad=turned_rad))
    here, there = course(plain, tmp_path / "here"), course(turned, tmp_path / "there")
    assert percepts_hash(here.journal) == percepts_hash(there.journal)
    cos, sin = math.cos(turned_rad), math.sin(turned_rad)
    turn = np.array([[cos, sin], [-sin, cos]])
    np.testing.assert_allclose(places_m(here.facts[-1]) @ turn, places_m(there.facts[-1]), atol=1e-6)
    for one, other in zip(here.facts, there.facts, strict=True):
        assert one.clearing.contaminated_m2 == pytest.approx(other.clearing.contaminated_m2, abs=1e-6)
        assert one.clearing.lost_m2 == pytest.approx(other.clearing.lost_m2, abs=1e-6)


def test_fronts_are_drawn_for_each_robot_and_run_and_never_change(tmp_path):
    """A pose that the scenario gives has a heading, which does not count."""
    poses = Poses(tuple((0.5 + 0.5 * row, 0.5, 0.0) for row in range(8)))
    runs = [course(clearing(8, start=poses, seed=seed), tmp_path / str(seed), 40) for seed in (1, 2)]
    for run in runs:
        fronts = np.array([np.frombuffer(one.poses).reshape(-1, 3)[:, 2] for one in run.facts])
        assert (fronts == fronts[0]).all()
    drawn = np.concatenate([np.mod(fronts_rad(run)[1:], math.tau) for run in runs])
    assert len(set(drawn.tolist())) == 16
    assert drawn.min() < 1.5 and drawn.max() > 4.5


# Bodies


def test_a_crowd_in_a_run_stays_apart_and_inside_dead_bodies_included(tmp_path):
    kill = PlannedFault(4.0, "kill", ("r3", "r5"))
    run = course(clearing(8, ((BOX),), start=Cluster(0.3, 0.3), faults=(kill,)), tmp_path)
    plan, before = shapely.Polygon(BOX), None
    for facts in run.facts:
        bodies = places_m(facts)[1:]
        assert min(math.dist(*pair) for pair in combinations(bodies, 2)) >= BODY_M - 1e-8
        assert shapely.distance(shapely.points(bodies), plan.boundary).min() >= BODY_M / 2 - 1e-8
        dead = [row for row in (1, 3) if facts.modes[row + 1] == DEAD]
        assert before is None or (before[dead] == bodies[dead]).all() or facts.tick <= 16
        before = bodies


def test_a_cluster_is_packed_around_its_point_in_a_corner_too(tmp_path):
    for point in ((5.0, 1.0), (5.95, 0.05)):
        run = course(
            clearing(7, start=Cluster(*point), parameters={"step_m": 0.0}), tmp_path / str(point[0]), 1
        )
        bodies = places_m(run.facts[0])[1:]
        apart_m = [math.dist(*pair) for pair in combinations(bodies, 2)]
        assert BODY_M < min(apart_m) < BODY_M + 0.03
        away_m = [math.dist(point, body) for body in bodies]
        assert away_m == pytest.approx(sorted(away_m)) and away_m[-1] < 0.9
        assert shapely.distance(shapely.points(bodies), shapely.Polygon(ELL).boundary).min() >= 0.12 - 1e-9


def test_a_robot_that_is_not_asked_finishes_its_step_and_stops(tmp_path):
    """Asked every twentieth tick and told to go 0.15 m, it goes three ticks and rests for seventeen."""
    given = clearing(
        1,
        start=Poses(((3.0, 1.0, 0.0),)),
        faults=(PlannedFault(0.0, "slow", ("r2",), every=20),),
        parameters={"step_m": 0.15, "obstacle_m": 0.0},
    )
    run = course(given, tmp_path, 60)
    assert sorted(run.grants("r2")) == [0, 20, 40, 60]
    way = np.array([places_m(one)[1] for one in run.facts])
    steps_m = {one.tick: math.dist(*pair) for one, pair in zip(run.facts[1:], pairwise(way), strict=True)}
    moving = sorted(tick for tick, step_m in steps_m.items() if step_m > 0.01)
    assert moving == [1, 2, 20, 21, 22, 40, 41, 42, 60]
    told = [one.senses.odometry_m for one in all_grants(run.journal) if one.node == "r2"]
    assert [math.hypot(*one) for one in told] == pytest.approx([0, 0.15, 0.15, 0.15], abs=2e-6)


# Faults


def test_a_slow_robot_hears_all_at_once_and_is_quick_again(tmp_path):
    slow = PlannedFault(1.0, "slow", ("r2",), every=10)
    quick = PlannedFault(9.0, "slow", ("r2",), every=1)
    run = course(clearing(2, faults=(slow, quick)), tmp_path, 50)
    assert sorted(run.grants("r2")) == [0, 1, 2, 3, 10, 20, 30, *range(36, 51)]
    assert sorted(run.grants("r3")) == list(range(51))
    inbox = next(one.inbox for one in all_commits(run.journal)[20].grants if one.node == "r2")
    assert [one.sent_tick for one in inbox if one.sender == "r3"] == list(range(10, 20))
    told = [one for one in events(tmp_path) if one["kind"] == "fault"]
    assert [(one["data"]["verb"], one["data"]["every"], one["tick"]) for one in told] == [
        ("slow", 10, 4),
        ("slow", 1, 36),
    ]


ROLES = {"roles": {"r2": "left", "r3": "centre", "r4": "centre", "r5": "centre", "r6": "right"}}


def killed(run) -> list[tuple[int, str]]:
    return [(fault.tick, fault.node) for one in run.facts for fault in one.faults]


def test_a_fault_for_a_role_befalls_the_middle_one_that_has_it(tmp_path):
    first = PlannedFault(2.0, "kill", role="centre")
    second = PlannedFault(3.0, "kill", role="centre")
    run = course(clearing(5, faults=(first, second), parameters=ROLES), tmp_path, 20)
    assert killed(run) == [(8, "r4"), (12, "r5")], "of two, the later one"


def test_a_fault_for_a_role_that_nobody_has_waits_until_somebody_has(tmp_path):
    """The role is first reported in tick 0, so tick 1 is the first boundary that knows of it."""
    early, never = PlannedFault(0.0, "kill", role="right"), PlannedFault(1.0, "kill", role="emperor")
    run = course(clearing(5, faults=(early, never), parameters=ROLES), tmp_path, 20)
    assert killed(run) == [(1, "r6")]


def test_a_fault_happens_at_the_first_boundary_after_a_share_is_clear(tmp_path):
    kill = PlannedFault(verb="kill", when_cleared_share=0.2, nodes=("r2",))
    run = course(clearing(4, faults=(kill,)), tmp_path)
    whole_m2 = shapely.Polygon(ELL).area
    clear = [1 - one.clearing.contaminated_m2 / whole_m2 for one in run.facts]
    first = next(tick for tick, share in enumerate(clear) if share >= 0.2)
    assert 0 < first < len(clear) - 2, "else this tests nothing"
    assert killed(run) == [(first + 1, "r2")]


# The referee, and the end


def test_the_referee_sees_each_tick_as_it_was(tmp_path):
    """A robot alone in a hall has clear what it sees; killed, nothing; started again, once more."""
    start = Poses(((2.0, 1.5, 0.0),))
    kill, back = PlannedFault(5.0, "kill", ("r2",)), PlannedFault(7.5, "restart", ("r2",))
    given = clearing(1, (BOX,), start=start, faults=(kill, back), parameters={"step_m": 0.0})
    run = course(given, tmp_path, 40)
    seen_m2 = 32 * 0.7**2 * math.sin(math.tau / 64)
    left_m2 = {one.tick: one.clearing.contaminated_m2 for one in run.facts}
    assert left_m2[0] == left_m2[19] == left_m2[30] == left_m2[40] == pytest.approx(12 - seen_m2)
    assert left_m2[20] == pytest.approx(12)
    lost = {one.tick: one.clearing.lost_m2 for one in run.facts if one.clearing.lost_m2}
    assert lost == {20: pytest.approx(seen_m2)}
    assert run.facts[20].clearing.given_up_m2 == pytest.approx(seen_m2)


def test_a_frozen_robot_sees_no_intruder(tmp_path):
    freeze, thaw = PlannedFault(5.0, "freeze", ("r2",)), PlannedFault(7.5, "thaw", ("r2",))
    given = clearing(
        1, (BOX,), start=Poses(((2.0, 1.5, 0.0),)), faults=(freeze, thaw), parameters={"step_m": 0.0}
    )
    left_m2 = {one.tick: one.clearing.contaminated_m2 for one in course(given, tmp_path, 40).facts}
    assert left_m2[19] == left_m2[40] < left_m2[20] == pytest.approx(12)


@pytest.mark.parametrize("referee", ["raster", "both"])
def test_the_raster_referee_agrees_with_the_exact_one_all_along(tmp_path, referee):
    kill = PlannedFault(10.0, "kill", ("r2", "r3"))
    given = clearing(6, faults=(kill,), duration_s=30.0)
    exact = course(given, tmp_path / "exact")
    other = course(msgspec.structs.replace(given, sensors=Sensors(referee=referee)), tmp_path / "other")
    said = [one.clearing for one in other.facts]
    raster_m2 = [one.raster_m2 if referee == "both" else one.contaminated_m2 for one in said]
    exact_m2 = [one.clearing.contaminated_m2 for one in exact.facts]
    assert np.abs(np.subtract(raster_m2, exact_m2)).max() < 0.5
    assert referee == "raster" or [one.contaminated_m2 for one in said] == exact_m2


def test_the_outline_of_what_is_contaminated_comes_once_a_second_if_it_is_new(tmp_path):
    run = course(clearing(2, faults=(PlannedFault(8.0, "kill", ("r2", "r3")),)), tmp_path, 60)
    drawn = {one.tick: one.clearing.outline for one in run.facts if one.clearing.outline}
    assert set(drawn) == {*range(0, 33, 4)}, "and no more when all are dead"
    for tick, outline in drawn.items():
        points = np.frombuffer(outline, "<f4").reshape(-1, 2)
        ends = np.flatnonzero(np.isnan(points[:, 0]))
        rings = [shapely.Polygon(one[~np.isnan(one[:, 0])]) for one in np.split(points, ends) if len(one) > 3]
        area_m2 = rings[0].area - sum(ring.area for ring in rings[1:])
        assert area_m2 == pytest.approx(run.facts[tick].clearing.contaminated_m2, abs=0.1)


def test_ten_seconds_after_a_claim_the_run_is_over_and_complete(tmp_path):
    given = clearing(2, parameters={"claim_tick": 20})
    run = course(given, tmp_path)
    assert run.facts[-1].tick == 60
    end = events(tmp_path)[-1]
    assert end["kind"] == "end" and end["data"]["completed"]


def test_what_is_no_standing_is_ignored(tmp_path):
    run = course(clearing(2, behaviour="tests.diarist:Diarist"), tmp_path, 10)
    assert run.facts[-1].tick == 10


# Sameness


def test_processes_and_rehearsal_give_one_hash_with_a_kill_and_a_slow_robot(tmp_path):
    faults = (
        PlannedFault(2.0, "slow", ("r3",), every=4),
        PlannedFault(verb="kill", when_cleared_share=0.1, role="centre"),
        PlannedFault(10.0, "restart", ("r4",), memory="kept"),
    )
    given = clearing(4, faults=faults, parameters=ROLES, duration_s=15.0)
    path = tmp_path / "small.toml"
    path.write_text(to_toml(given))
    live = as_processes(tmp_path, path, "live")
    assert run_hash(live) == run_hash(rehearsed(tmp_path, path))


def test_a_mind_pairs_each_frame_with_its_bearing_even_when_one_is_not_understood(tmp_path):
    run = course(clearing(2), tmp_path, 1)
    first = next(one for one in all_grants(run.journal) if one.node == "r2")
    mind = Mind("swarm_agent.behaviours")
    mind.answer(codec.encode(Percept(0, 0, "start", first.senses, (), first.configuration)))
    frames = Frame("r3", 0, b"?"), Frame("r3", 0, codec.encode(Hello((0.0, 0.0))))
    bearings = np.array([[1.0, 0.1], [2.0, 0.2]], dtype="<f4").tobytes()
    (heard,) = mind._decode(frames, bearings)
    assert (heard.range_m, heard.bearing_rad) == pytest.approx((2.0, 0.2))
    (deaf,) = mind._decode(frames)
    assert math.isnan(deaf.range_m) and math.isnan(deaf.bearing_rad)
