"""Chain connected: its rules by hand, whole rehearsals, relays that die, graphs. The patrol is ours."""

import math
from collections import Counter

import numpy as np
import pytest

from deploy.metrics.area import AreaMetrics
from swarm_agent.behaviour import Heard
from swarm_agent.behaviours.chain_connected import Place
from swarm_agent.company import CUT_OFF, Word
from swarm_agent.knowledge import Bulletin
from tests.builders import NO_NEWS, course, from_tower, percept, scenario
from tests.chain_course import Course, cut_off, newborn, ring
from tests.test_chain_links import graph
from wire import codec
from wire.fields import Grid
from wire.messages import GoTo
from wire.scenario import Loss, PlannedFault, RadioSection, Range, Robots


def said(
    sender: str, tick: int, at: int, next: int, goal: int | None = None, layer: int = 1, **more
) -> Heard:
    """A robot's word as it is heard, said in the middle of cell `at`."""
    x_m, y_m = Grid().sites_m()[at]
    word = Word(x_m, y_m, next, next if goal is None else goal, layer, tick - 1, **{"parent": "r1"} | more)
    return Heard(sender, tick, Bulletin(NO_NEWS, (), 0, word))


def standing(one, site: int, *heard: Heard, tick: int = 100):
    """The robot arrives at a site and decides; what it heard before. Returns its move."""
    one.next = site
    return one.step(percept(tick, *one.points_m[site]), list(heard))


def cell(column: int, row: int) -> int:
    return 20 * column + row


# The rules


def test_a_robot_may_go_where_its_link_holds_from_both_ends_places_and_next_sites():
    """170 m from (0, 0): cell (5, 0) at (165, 15) is 165.7 m away, (5, 1) 171.0 m."""
    one = newborn("r2")
    standing(one, cell(3, 0), from_tower(99))
    _, fit, _ = one._limits(100, one._superiors(one.points_m[cell(3, 0)]))
    assert fit[cell(5, 0)] and not fit[cell(5, 1)]
    assert np.flatnonzero(fit).tolist() == np.flatnonzero(one.plan.links == 1).tolist()


def test_a_parent_that_moves_lends_only_what_is_within_reach_all_its_way():
    """r3 at (7, 0), on r2, which goes from (3, 0) to (2, 0): (8, 0) is 150 m from its place, 180 m from its
    next cell; (7, 4) is 169.7 m from its place, 192.1 m from its next cell; (7, 3) is 150 m and 174.9 m."""
    one = newborn("r3")
    superiors = [said("r2", 99, cell(3, 0), cell(2, 0))]
    standing(one, cell(7, 0), *superiors)
    above, _, _ = one._limits(100, one._superiors(one.points_m[cell(7, 0)]))
    assert above[cell(7, 0)] and above[cell(7, 2)]
    assert not above[cell(8, 0)] and not above[cell(7, 4)] and not above[cell(7, 3)]
    assert one.parent == "r2"


def test_the_parent_leads_and_the_child_stays_within_reach_of_its_goal_too():
    """r2 waits at (3, 0) and wants to (3, 3): (7, 0) is 150 m from that goal, 120 m from where it stands;
    (8, 0) is 174.9 m and 150 m. r3, at (8, 0), comes nearer, or r2 could never leave."""
    one = newborn("r3")
    standing(one, cell(8, 0), said("r2", 99, cell(3, 0), cell(3, 0), goal=cell(3, 3)))
    above, fit, _ = one._limits(100, one._superiors(one.points_m[cell(8, 0)]))
    assert above[cell(8, 0)] and above[cell(7, 0)] and fit[cell(7, 0)] and not fit[cell(8, 0)]
    assert fit[one.goal] and one.next != cell(8, 0)


def test_a_robot_with_a_child_goes_only_where_the_child_can_follow_its_own_plan():
    """r2 at (3, 0) with r3 on its way from (7, 0) to (8, 0), at (255, 15): nothing left of (3, 0)."""
    one = newborn("r2")
    child = said("r3", 99, cell(7, 0), cell(8, 0), parent="r2", layer=2)
    standing(one, cell(3, 0), from_tower(99), child)
    _, fit, sound = one._limits(100, one._superiors(one.points_m[cell(3, 0)]))
    assert fit[cell(2, 0)] and not sound[cell(2, 0)] and sound[cell(4, 0)] and sound[cell(5, 0)]


def test_nobody_hangs_on_a_higher_number_nor_on_one_that_is_cut_off():
    one = newborn("r3")
    higher, lost = said("r4", 99, 0, 0), said("r2", 99, 0, 0, layer=CUT_OFF)
    standing(one, 0, higher, lost)
    assert one._superiors(one.points_m[0]) == [] and one.parent is None
    standing(one, 0, higher, said("r2", 109, 0, 0), tick=110)
    assert one.parent == "r2"


def test_of_several_parents_the_one_nearest_to_the_tower_is_taken():
    one = newborn("r5")
    standing(one, cell(3, 3), said("r2", 99, cell(3, 2), cell(3, 2), layer=2), said("r4", 99, 21, 21))
    assert one.parent == "r4"
    standing(one, one.next, from_tower(109), said("r4", 109, 21, 21), tick=110)
    assert one.parent == "r1"


def test_the_lowest_numbers_form_the_chain_and_the_others_are_free():
    """Three robots present can reach cells of three links; the oldest is (9, 9) at 403 m, over two posts."""
    present = {name: 99 for name in ("r2", "r5", "r7")}
    for name, place in (("r2", 0), ("r5", 1), ("r7", 2), ("r9", -1)):
        one = newborn(name)
        one.knowledge.visited_tick[:] = 90
        one.knowledge.visited_tick[cell(9, 9)], one.knowledge.visited_tick[399] = 20, 10
        roll = tuple((other, tick) for other, tick in present.items() if other != name)
        standing(one, 0, from_tower(99), said("r2" if name != "r2" else "r5", 99, 21, 21, roll=roll))
        posts = one.posts(100)
        assert one.place == place and posts[-1] == cell(9, 9) and len(posts) == 3
        if place == 0:
            assert one.goal == posts[0] or one.plan.around(posts, 0)[one.goal]


def test_others_choose_by_utility_and_leave_alone_what_somebody_goes_to():
    """U = (i + way / v) / (way / v); 20 s to a straight neighbour, 20 sqrt(2) s to a diagonal one."""
    one = newborn("r9")
    one.knowledge.visited_tick[:] = 90
    one.knowledge.visited_tick[[22, 41]] = 40, 70
    ways = one.roads.ways(21, np.ones(400, dtype=bool))
    worth = one.utilities(100, ways.far_m)
    assert worth[22] == (60 + 20) / 20 and worth[41] == (30 + 20) / 20 and worth[1] == (10 + 20) / 20
    assert worth[21] == -math.inf and worth[0] == pytest.approx(1 + 10 / (20 * math.sqrt(2)))
    one.company.listen(100, [said("r8", 99, 0, 1, goal=22)])
    left = one.utilities(100, ways.far_m)
    assert left[22] == left[1] == -math.inf and int(np.argmax(left)) == 41


def test_two_that_arrive_together_do_not_choose_alike():
    """The higher number lets the lower one choose first, and then hears where it goes."""
    later = newborn("r9")
    standing(later, 21, from_tower(99), said("r8", 99, 21, 21))
    assert later.next == 21
    later.step(percept(101, *later.points_m[21]), [from_tower(100), said("r8", 100, 21, 22)])
    assert later.next not in (21, 22)


def test_a_robot_on_its_way_whose_parent_goes_elsewhere_turns_back():
    """r3 goes from (7, 0) to (8, 0) on r2 at (4, 0), 120 m behind; then r2 goes to (3, 0), 150 m; to (2, 0):
    180 m from where r3 goes, 150 m from where it comes from."""
    one = newborn("r3")
    one.next, one.at, one.parent = cell(8, 0), cell(7, 0), "r2"
    for tick, behind, expected in ((100, 4, 8), (101, 3, 8), (102, 2, 7)):
        one.step(percept(tick, 240.0, 15.0), [said("r2", tick - 1, cell(4, 0), cell(behind, 0))])
        assert one.next == cell(expected, 0) and one.parent == "r2"


def test_a_robot_that_hears_nobody_makes_for_the_tower():
    one = newborn("r3")
    place = cell(10, 10)
    one.next = one.at = place
    for tick in range(100, 2000):
        x_m, y_m = one.points_m[one.next]
        one.step(percept(tick, x_m, y_m), [])
    assert one.parent is None and one.company.layer == CUT_OFF and one.next == 0


def test_who_waits_visits_once_and_goes_on_to_the_very_place():
    one = newborn("r3")
    one.next = 0
    first = one.step(percept(100, 13.0, 15.0), [])
    assert first.motion is None and one.knowledge.visited_tick[0] == 100
    one.step(percept(103, 15.0, 15.0), [])
    assert one.knowledge.visited_tick[0] == 100
    moving = one.step(percept(106, 15.0, 15.0), [from_tower(105)])
    assert moving.motion == GoTo(*one.points_m[one.next], 3.0) and one.next != 0


# Whole runs


def places(run) -> list[dict[str, Place]]:
    """What the robots said of themselves, tick by tick."""
    return [
        {name: codec.decode(Place, raw) for name, raw in one.reports if name != "r1"} for one in run.facts
    ]


@pytest.mark.parametrize("team", [5, 10, 15])
def test_everybody_stays_connected_and_all_patrol(team, tmp_path):
    """Facts of the world at every tick: within 180 m of each other over any number of hops to the tower."""
    run = course(scenario(Robots("chain_connected", team - 1), field=Grid(), duration_s=900.0), tmp_path)
    assert all(not cut_off(one) for one in run.facts)
    visits = Counter(node for _, node, _ in run.visits())
    assert len(visits) == team - 1 and min(visits.values()) > 20
    assert not any(ring({name: one.parent for name, one in here.items()}) for here in places(run))
    assert max(one.layer for here in places(run)[10:] for one in here.values()) >= 3


def test_cells_are_visited_where_the_team_can_reach_and_nowhere_else(tmp_path):
    """Two robots with links of 90 m, on 8 x 8 cells: 43 of 64 within two links, known to the tower."""
    given = scenario(
        Robots("chain_connected", 2),
        None,
        {"range_m": 100.0},
        range_m=100.0,
        field=Grid(8, 8),
        duration_s=4000.0,
    )
    run, metrics = course(given, tmp_path), AreaMetrics(given)
    for one in run.facts:
        metrics.feed(one)
    reachable = newborn("r2", Grid(8, 8), range_m=100.0).plan.links <= 2
    assert {site for _, _, site in run.visits()} == set(np.flatnonzero(reachable).tolist())
    assert 0 < reachable.sum() < 64 and all(not cut_off(one, 100.0) for one in run.facts)
    assert ((metrics.known_tick > 0) == reachable).all()


def test_who_hung_on_relays_that_are_killed_is_connected_again_and_the_chain_closes(tmp_path):
    killed = ("r2", "r4")
    given = scenario(
        Robots("chain_connected", 9),
        field=Grid(),
        duration_s=1500.0,
        faults=(PlannedFault(600.0, "kill", killed),),
    )
    run = course(given, tmp_path)
    said_then = places(run)
    orphans = {name for name, one in said_then[599].items() if one.parent in killed and name not in killed}
    assert orphans and max(one.layer for one in said_then[599].values()) >= 3
    broken = [one.tick for one in run.facts if cut_off(one)]
    assert broken[0] == 600 and broken[-1] < 800
    after = said_then[900:]
    assert not any(one.parent in killed for here in after for one in here.values())
    assert all(here[name].parent is not None for here in after for name in orphans)
    assert {one.chain_place for here in after for name, one in here.items() if name == "r3"} == {0}
    assert max(one.layer for here in after for one in here.values()) >= 4


def test_with_lost_frames_the_share_connected_stays_high(tmp_path):
    radio = RadioSection((Range(180.0), Loss(0.2)))
    given = scenario(Robots("chain_connected", 9), field=Grid(), duration_s=500.0, radio=radio)
    run = course(given, tmp_path)
    assert sum(len(cut_off(one)) for one in run.facts) < 0.02 * 9 * len(run.facts)


def test_equal_scenarios_run_alike_and_nothing_depends_on_chance(tmp_path):
    given = scenario(Robots("chain_connected", 5), field=Grid(12, 12), duration_s=300.0)
    first, second = course(given, tmp_path / "a"), course(given, tmp_path / "b")
    assert first.run_hash == second.run_hash and len(first.visits()) > 40


# Graphs


def test_a_chain_goes_round_corners_of_a_graph():
    """A street of 8 houses with two lanes of 4, 40 m apart: five links of 90 m to the end of the last."""
    street = [(40.0 * one, 0.0) for one in range(8)]
    lanes = [(40.0 * at, 40.0 * one) for at in (3, 7) for one in range(1, 5)]
    edges = [(one, one + 1) for one in range(7)] + [(3, 8), (7, 12)]
    edges += [(one, one + 1) for one in range(8, 11)] + [(one, one + 1) for one in range(12, 15)]
    run = Course(graph(street + lanes, *edges), 6, 100.0)
    broken = run.advance(2500)
    assert broken == 0 and (run.known.visited_tick > 0).all()
    assert run.robots["r2"].plan.links[15] == 5


def test_a_chain_that_reaches_for_one_site_too_long_begins_again_from_the_tower():
    """Nothing is visited here: strict after the patience, home after twice, strict again from there."""
    one = newborn("r3", patience_s=50.0)
    one.at, seen = 399, []
    for tick in range(0, 200, 10):
        seen.append(one._impatience(tick, [0, 1]))
        one.at = one.home if tick == 150 else 399
    assert seen == [0] * 5 + [1] * 5 + [2] * 6 + [1] * 4
    assert one._impatience(200, [0, 2]) == 0
