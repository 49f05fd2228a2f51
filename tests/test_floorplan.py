"""Floor plans from files: what is read, and every reason for which one is refused, in one line."""

import json
import math

import numpy as np
import pytest
import shapely
from PIL import Image

from deploy.mistake import Mistake
from deploy.plan_file import PLANS, load_plan
from world_server.floorplan import PlanError, from_bitmap, from_geojson, from_wkt
from world_server.plan_checks import check_plan, narrowest_island_m, unseen

ROOM = "POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0))"
RING = [[0, 0], [4, 0], [4, 3], [0, 3], [0, 0]]
POLYGON = {"type": "Polygon", "coordinates": [RING]}


def wedge(degrees: float) -> shapely.Polygon:
    """A triangle with a tip of so many degrees at the origin."""
    return shapely.Polygon([(0, 0), (8, 0), (8, 8 * math.tan(math.radians(degrees)))])


def test_the_cave_is_as_measured_and_can_be_cleared():
    cave = load_plan(PLANS / "cave.wkt", None, 0.25, 0.7)
    assert cave.area == pytest.approx(109.43, abs=0.01)
    assert not cave.interiors
    assert unseen(cave, 0.25, 0.7).area == pytest.approx(0.0, abs=1e-6)
    assert unseen(cave, 0.6, 0.7).area == pytest.approx(0.29, abs=0.01)


def test_well_known_text_is_read():
    assert from_wkt(ROOM).equals(shapely.box(0, 0, 4, 3))
    assert from_wkt(f"\n multipolygon ({ROOM[8:]})").equals(shapely.box(0, 0, 4, 3))
    assert not from_wkt("POLYGON Z ((0 0 1, 4 0 1, 4 3 1, 0 0 1))").has_z


@pytest.mark.parametrize(
    "document",
    [
        POLYGON,
        {"type": "MultiPolygon", "coordinates": [[RING]]},
        {"type": "Feature", "properties": {"name": "room"}, "geometry": POLYGON},
        {"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": POLYGON}]},
        {"type": "Polygon", "coordinates": [[[*point, 7.5] for point in RING]]},
    ],
)
def test_geojson_is_read(document):
    assert from_geojson(json.dumps(document)).equals(shapely.box(0, 0, 4, 3))


def test_holes_are_read():
    hole = [[1, 1], [2, 1], [2, 2], [1, 2], [1, 1]]
    plan = from_geojson(json.dumps({"type": "Polygon", "coordinates": [RING, hole]}))
    assert plan.area == 11 and len(plan.interiors) == 1


def test_a_bitmap_is_read_with_the_top_row_north():
    grey = np.zeros((40, 60), dtype=np.uint8)
    grey[5:35, 10:50] = 255
    grey[10:15, 20:30] = 127  # nearly half grey is wall
    plan = from_bitmap(grey, 0.1)
    assert plan.bounds == pytest.approx((1.0, 0.5, 5.0, 3.5))
    assert shapely.Polygon(plan.interiors[0]).bounds == pytest.approx((2.0, 2.5, 3.0, 3.0))


def test_stairs_of_pixels_become_slanted_walls():
    across, down = np.meshgrid(np.arange(200), np.arange(100))
    grey = np.where((down > 10) & (down < 90) & (across > 10) & (across + 2 * down < 250), 255, 0)
    plan = from_bitmap(grey.astype(np.uint8), 0.032)
    assert len(plan.exterior.coords) < 12
    assert plan.area == pytest.approx(np.count_nonzero(grey) * 0.032**2, rel=0.02)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "must begin with POLYGON, got ''"),
        ("POINT (1 2)", "must begin with POLYGON, got 'POINT (1 2)'"),
        ("POLYGON ((0 0, 4 0, 4 x", "must be the text of a polygon, but "),
        ("POLYGON ((0 0, 4 0, 4 3))", "must be the text of a polygon, but "),
        ("POLYGON EMPTY", "must be one polygon, one piece of free space, got none"),
        (
            "MULTIPOLYGON (((0 0, 1 0, 1 1, 0 0)), ((5 5, 9 5, 9 9, 5 5)))",
            "must be one polygon, one piece of free space, got 2 (areas 0.5, 8)",
        ),
        ("POLYGON ((0 0, 4 0, inf 3, 0 0))", "all points must be within 1e+06 m, got [inf, 3]"),
        ("POLYGON ((0 0, 4 0, nan 3, 0 0))", "all points must be within 1e+06 m, got [nan, 3]"),
        ("POLYGON ((0 0, 4 0, 2e6 3, 0 0))", "all points must be within 1e+06 m, got [2e+06, 3]"),
        (shapely.Point(0, 0).buffer(1, quad_segs=6000).wkt, "must have at most 20000 points, got 24001"),
    ],
)
def test_a_wrong_text_is_refused(text, complaint):
    with pytest.raises(PlanError) as refused:
        from_wkt(text)
    assert str(refused.value).startswith(complaint)
    assert len(str(refused.value)) < 200 and "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (b"\xff\xfe", "must be GeoJSON with a polygon, but "),
        ("{", "must be GeoJSON with a polygon, but Input data was truncated"),
        ("[" * 100_000, "must be GeoJSON with a polygon, but "),
        (
            '{"type": "Point", "coordinates": [1, 2]}',
            "must be GeoJSON with a polygon, but Invalid value 'Point'",
        ),
        (
            '{"type": "Polygon", "coordinates": [[["a", 1]]]}',
            "must be GeoJSON with a polygon, but Expected `float`",
        ),
        ('{"type": "Polygon", "coordinates": [[[1, 1], [2, 2]]]}', "must be the rings of a polygon, but "),
        (
            '{"type": "Polygon", "coordinates": [[[1], [2], [3], [1]]]}',
            "must be the rings of a polygon, but ",
        ),
        ('{"type": "Polygon", "coordinates": []}', "must be one polygon, one piece of free space, got none"),
        (
            '{"type": "FeatureCollection", "features": []}',
            "must be one polygon, one piece of free space, got none",
        ),
    ],
)
def test_a_wrong_geojson_is_refused(text, complaint):
    with pytest.raises(PlanError) as refused:
        from_geojson(text)
    assert str(refused.value).startswith(complaint)


def test_a_wrong_bitmap_is_refused():
    with pytest.raises(PlanError, match="must have from 1 to 16777216 grey pixels, got \\[3, 3, 3\\]"):
        from_bitmap(np.zeros((3, 3, 3)), 0.1)
    with pytest.raises(PlanError, match="metres_per_px must be > 0 and <= 1e\\+06, got nan"):
        from_bitmap(np.full((3, 3), 255), math.nan)
    with pytest.raises(PlanError, match="must be one polygon, one piece of free space, got none"):
        from_bitmap(np.zeros((3, 3)), 0.1)
    white_around_a_room = np.full((9, 9), 255)
    white_around_a_room[2:7, 2:7] = 0
    white_around_a_room[3:6, 3:6] = 255
    with pytest.raises(PlanError, match="got 2 \\(areas 56, 9\\)"):
        from_bitmap(white_around_a_room, 0.1)


@pytest.mark.parametrize(
    ("plan", "complaint"),
    [
        (
            shapely.Polygon([(0, 0), (4, 4), (4, 0), (0, 4)]),
            "the polygon must be valid, but: Self-intersection",
        ),
        (
            shapely.box(0, 0, 9, 0.4),
            "there must be a place at least 0.25 m from all walls, but there is none",
        ),
        (
            shapely.union_all([shapely.box(0, 0, 3, 3), shapely.box(3, 1, 5, 1.4), shapely.box(5, 0, 8, 3)]),
            "no passage may be narrower than 0.5 m (robots stay 0.25 m from walls), "
            "but no robot can come from [",
        ),
        (
            wedge(40),
            "no corner may be sharper than 46 degrees (robots 0.25 m from walls must come within 0.64 m "
            "of it), but they come no nearer than 0.731 m to [0, 0]",
        ),
        (
            # A niche 0.3 m wide: robots pass its mouth, and do not see its end.
            shapely.box(0, 0, 5, 3)
            .union(shapely.Point(2, 3.3).buffer(0.2))
            .union(shapely.box(1.85, 3, 2.15, 4)),
            "no corner may be sharper",
        ),
    ],
)
def test_a_plan_that_robots_cannot_clear_is_refused(plan, complaint):
    with pytest.raises(PlanError) as refused:
        check_plan(plan, 0.25, 0.7)
    assert str(refused.value).startswith(complaint)


def test_a_point_near_enough_but_out_of_sight_is_refused():
    """Behind a thin wall with a dead end of its own, as near as robots are on the wall's other side."""
    slit = shapely.box(1, 3.02, 4.5, 3.32).union(shapely.box(4.4, 2.9, 4.5, 3.1))
    plan = shapely.box(0, 0, 5, 3).union(slit)
    with pytest.raises(
        PlanError, match="every point must be seen from within 0.7 m by a robot 0.25 m from walls"
    ):
        check_plan(plan, 0.25, 0.7)


@pytest.mark.parametrize("degrees", [47, 60])
def test_corners_that_robots_see_into_are_served(degrees):
    check_plan(wedge(degrees).intersection(shapely.box(0, 0, 8, 8)), 0.25, 0.7)


def test_a_sharp_but_tiny_notch_is_no_corner():
    notch = shapely.Polygon([(2, 0.01), (2.02, -0.05), (2.04, 0.01)])
    check_plan(shapely.box(0, 0, 4, 3).union(notch), 0.25, 0.7)


def test_the_width_of_islands():
    plan = shapely.box(0, 0, 9, 9).difference(shapely.affinity.rotate(shapely.box(3, 3, 3.2, 6), 30))
    assert narrowest_island_m(plan) == pytest.approx(0.2)
    assert narrowest_island_m(shapely.box(0, 0, 1, 1)) == math.inf


def test_files_are_read_by_their_ending(tmp_path):
    (tmp_path / "room.WKT").write_text(ROOM)
    (tmp_path / "room.geojson").write_text(json.dumps(POLYGON))
    Image.fromarray(np.pad(np.full((30, 40), 255, np.uint8), 5)).save(tmp_path / "room.png")
    for name, scale in (("room.WKT", None), ("room.geojson", None), ("room.png", 0.1)):
        assert load_plan(tmp_path / name, scale, 0.25, 0.7).area == pytest.approx(12)


@pytest.mark.parametrize(
    ("name", "content", "scale", "complaint"),
    [
        ("plan.dxf", b"", None, "plan.dxf: must end in .wkt, .geojson, .json, .png, .pgm, .bmp, got .dxf"),
        ("plan", b"", None, "plan: must end in .wkt, .geojson, .json, .png, .pgm, .bmp, got no ending"),
        ("gone.wkt", None, None, "gone.wkt: cannot be read: No such file or directory"),
        ("gone.png", None, 0.1, "gone.png: cannot be read: No such file or directory"),
        ("a.wkt", ROOM.encode(), 0.1, "a.wkt: metres_per_px is for pictures only, got 0.1"),
        ("a.png", b"", None, "a.png: a picture needs metres_per_px, got none"),
        ("a.png", b"no picture", 0.1, "a.png: must be a picture, but its content is none"),
        ("a.json", b"\xff", None, "a.json: must be GeoJSON with a polygon, but "),
        ("thin.wkt", b"POLYGON ((0 0, 9 0, 9 0.4, 0 0.4, 0 0))", None, "thin.wkt: there must be a place"),
    ],
)
def test_a_wrong_file_is_named(tmp_path, name, content, scale, complaint):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(Mistake) as refused:
        load_plan(tmp_path / name, scale, 0.25, 0.7)
    assert str(refused.value).startswith(complaint)
    assert "\n" not in str(refused.value)


def test_a_picture_that_is_cut_off_is_refused(tmp_path):
    Image.fromarray(np.arange(200 * 200, dtype=np.uint8).reshape(200, 200)).save(tmp_path / "a.png")
    (tmp_path / "b.png").write_bytes((tmp_path / "a.png").read_bytes()[:200])
    with pytest.raises(Mistake, match="b.png: cannot be read: "):
        load_plan(tmp_path / "b.png", 0.1, 0.25, 0.7)
