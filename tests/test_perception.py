"""What robots of mission clear sense, against the truth worked out by other means."""

import math

import numpy as np
import pytest
import shapely

from tests.builders import course
from tests.clear_builders import BOX, ELL, all_commits, clearing, fronts_rad, places_m
from wire.scenario import Latency, Poses, RadioSection, Range, Sensors
from world_server.deployment import deployed
from world_server.random_plans import random_plan
from world_server.walls import Walls, ranges_m

MILLIONTH = 1e-6
ROUNDED = 0.6e-6  # half a millionth, and what float32 adds


def rays(count: int, front_rad: float) -> np.ndarray:
    angles = front_rad + np.arange(count) * (2 * np.pi / count)
    return np.stack((np.cos(angles), np.sin(angles)), axis=1)


def by_shapely(plan: shapely.Polygon, place, units: np.ndarray, most_m: float) -> np.ndarray:
    """The nearest point of the walls on each ray, found by cutting the ray's line."""
    found = []
    for unit in units:
        hits = shapely.LineString((place, place + most_m * unit)).intersection(plan.boundary)
        points = shapely.get_coordinates(hits)
        found.append(np.linalg.norm(points - place, axis=1).min() if len(points) else np.inf)
    return np.array(found)


@pytest.mark.parametrize("seed", range(4))
def test_a_scan_is_the_nearest_wall_on_each_ray(seed):
    plan, draw = random_plan(seed, (2, 2), seed % 2), np.random.default_rng(seed)
    walls = Walls([shapely.get_coordinates(ring) for ring in shapely.get_rings(plan)], 0.7)
    for place in inside(plan.buffer(-0.1), 25, draw):
        units = rays(90, draw.uniform(0, 2 * np.pi))
        measured = ranges_m(walls.near(*place), tuple(place), units, 0.7)
        np.testing.assert_allclose(measured, by_shapely(plan, place, units, 0.7), atol=1e-9)


def inside(room: shapely.Geometry, count: int, draw: np.random.Generator) -> list[np.ndarray]:
    low, high = np.array(room.bounds).reshape(2, 2)
    places = draw.uniform(low, high, (count * 20, 2))
    return list(places[shapely.intersects_xy(room, *places.T)][:count])


def test_far_from_all_walls_every_ray_is_infinite():
    walls = Walls([np.array([*BOX, BOX[0]], dtype=float)], 0.7)
    assert np.isinf(ranges_m(walls.near(2.0, 1.5), (2.0, 1.5), rays(90, 0.3), 0.7)).all()


def test_through_the_corner_of_two_walls_no_ray_escapes():
    walls = Walls([np.array([*ELL, ELL[0]], dtype=float)], 0.7)
    for corner in ELL[1:]:
        inward = np.array((1.0, 1.0)) - corner
        unit = inward / np.linalg.norm(inward)
        for back_m in (0.1, 0.3, 0.5):
            place = tuple(corner + back_m * unit)
            assert ranges_m(walls.near(*place), place, -unit[None], 0.7)[0] == pytest.approx(back_m)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Three robots that wander about and hear each other, two ticks late."""
    radio = RadioSection((Range(3.0), Latency(2)))
    given = clearing(3, duration_s=15.0, radio=radio)
    return course(given, tmp_path_factory.mktemp("run")), given


def test_in_a_run_scans_are_what_the_walls_are_in_the_robots_frame(run):
    done, given = run
    plan, fronts = shapely.Polygon(ELL), fronts_rad(done)
    for tick in (7, 31, 59):
        for grant in all_commits(done.journal)[tick].grants[1:]:
            row = given.node_ids.index(grant.node)
            place = places_m(done.facts[tick - 1])[row]
            truth = by_shapely(plan, place, rays(180, fronts[row]), 0.7)
            np.testing.assert_allclose(np.frombuffer(grant.senses.scan, "<f4"), truth, atol=ROUNDED)


def test_odometry_adds_up_to_the_way_in_the_robots_frame(run):
    done, given = run
    first_m = [(pose.x_m, pose.y_m) for pose in deployed(given).values()]
    for row, node in enumerate(given.node_ids[1:], start=1):
        come = [
            one.senses.odometry_m for at in all_commits(done.journal) for one in at.grants if one.node == node
        ]
        forward, left = np.sum(come, axis=0)
        moved = places_m(done.facts[-2])[row] - first_m[row]
        cos, sin = math.cos(fronts_rad(done)[row]), math.sin(fronts_rad(done)[row])
        assert (cos * forward - sin * left, sin * forward + cos * left) == pytest.approx(
            tuple(moved), abs=len(come) * MILLIONTH
        )


def test_bearings_are_those_of_the_tick_in_which_the_frame_was_sent(run):
    """They stand in the order of the inbox, and are measured from where the hearer was then."""
    done, given = run
    fronts, measured = fronts_rad(done), 0
    for at in all_commits(done.journal):
        for grant in at.grants:
            bearings = np.frombuffer(grant.senses.bearings, "<f4").reshape(-1, 2)
            assert len(bearings) == len(grant.inbox)
            row = given.node_ids.index(grant.node)
            for heard, (range_m, bearing_rad) in zip(grant.inbox, bearings, strict=True):
                assert heard.sent_tick == at.tick - 2
                settled = places_m(done.facts[heard.sent_tick])
                away = settled[given.node_ids.index(heard.sender)] - settled[row]
                assert range_m == pytest.approx(np.hypot(*away), abs=ROUNDED)
                turned = math.atan2(away[1], away[0]) - fronts[row] - bearing_rad
                assert abs(math.remainder(turned, math.tau)) < ROUNDED
                measured += 1
    assert measured > 200


def noisy(folder, sensors: Sensors, ticks: int = 60):
    """All scans, odometry and bearings of a robot that stands and hears another, with noise and without."""
    start = Poses(((1.0, 0.5, 0.0), (2.0, 0.5, 0.0)))
    given = clearing(2, start=start, sensors=sensors, parameters={"step_m": 0.0})
    done = course(given, folder, ticks)
    told = [one.senses for at in all_commits(done.journal) for one in at.grants if one.node == "r2"]
    scans = np.array([np.frombuffer(one.scan, "<f4") for one in told])
    bearings = np.array([np.frombuffer(one.bearings, "<f4").reshape(-1, 2)[0] for one in told[1:]])
    return scans, bearings, done


def test_noise_has_the_spread_that_the_scenario_says_and_comes_again(tmp_path):
    clean, straight, _ = noisy(tmp_path / "clean", Sensors())
    loud = Sensors(noise_sd_m=0.02, bearing_sd_rad=0.05)
    scans, bearings, done = noisy(tmp_path / "loud", loud)
    hit = np.isfinite(clean)
    assert (np.isfinite(scans) == hit).all()
    assert (scans[hit] - clean[hit]).std() == pytest.approx(0.02, rel=0.1)
    assert (bearings - straight)[:, 0].std() == pytest.approx(0.02, rel=0.4)
    assert (bearings - straight)[:, 1].std() == pytest.approx(0.05, rel=0.4)
    assert noisy(tmp_path / "again", loud)[2].run_hash == done.run_hash


def test_noise_on_odometry_grows_with_the_step(tmp_path):
    given = clearing(1, start=Poses(((2.0, 1.0, 0.0),)), sensors=Sensors(odometry_sd=0.1))
    done = course(given, tmp_path, 150)
    told = [
        one.senses.odometry_m for at in all_commits(done.journal) for one in at.grants if one.node == "r2"
    ]
    moved = np.diff([places_m(one)[1] for one in done.facts], axis=0)
    errors = np.linalg.norm(told[2:], axis=1) - np.linalg.norm(moved[:-1], axis=1)
    assert errors.std() == pytest.approx(0.1 * 0.05, rel=0.25)
