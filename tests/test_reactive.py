"""The simple rules, decision by decision, and what they do to a field."""

import msgspec
import numpy as np
import pytest

from swarm_agent.behaviour import Heard
from swarm_agent.behaviours.conscientious_reactive import ConscientiousReactive
from swarm_agent.behaviours.gbs import Arrival, Gbs
from swarm_agent.behaviours.heuristic_conscientious_reactive import HeuristicConscientiousReactive
from swarm_agent.behaviours.random import Random
from swarm_agent.behaviours.sebs import Sebs
from swarm_agent.knowledge import Bulletin, News
from tests.builders import NO_NEWS, configuration, course, entries, percept, scenario
from wire.fields import Grid

FIELD = Grid(3, 3, 30.0)
CENTRE = 4  # of nine cells; its neighbours are all others


def newborn(kind, seed=1, field=FIELD, **parameters):
    """A robot that knows nothing."""
    given = kind.Parameters(**parameters)
    return kind(given, configuration(field=field), np.random.Generator(np.random.Philox(seed)))


def robot(kind, seed=1, field=FIELD):
    """A robot that comes to the centre from beside it."""
    one = newborn(kind, seed, field)
    one.step(percept(0, 45.0, 49.0), [])
    assert one.target == CENTRE
    return one


def next_target(one, tick=1000, **visited):
    for site, at in visited.items():
        one.knowledge.note_visit(int(site[1:]), at)
    one.step(percept(tick, 45.0, 45.0), [])
    return one.target


def test_a_cell_in_a_corner_has_three_neighbours_an_inner_one_eight():
    assert [site for site, _ in FIELD.neighbours(0)] == [1, 3, 4]
    assert [site for site, _ in FIELD.neighbours(CENTRE)] == [0, 1, 2, 3, 5, 6, 7, 8]
    assert dict(FIELD.neighbours(0)) == pytest.approx({1: 30.0, 3: 30.0, 4: 30.0 * 2**0.5})


def test_conscientious_reactive_takes_the_neighbour_not_visited_for_longest():
    """Source: patrolling_sim, CR: the greatest idleness over the neighbours."""
    seen = {f"s{site}": 500 for site in (0, 1, 2, 3, 5, 6, 8)}
    assert next_target(robot(ConscientiousReactive), **seen, s7=499) == 7


def test_heuristic_conscientious_reactive_weighs_the_way():
    """Source: patrolling_sim, HCR. At 1000 s cell 0 (42.4 m) is idle for 900 s, cell 1 (30 m) for 700 s, the
    others for 100 s: 0 + 1 against 0.293 + 0.778 = 1.071.
    """
    seen = {f"s{site}": 900 for site in (2, 3, 5, 6, 7, 8)}
    assert next_target(robot(HeuristicConscientiousReactive), **seen, s0=100, s1=300) == 1
    assert next_target(robot(HeuristicConscientiousReactive), **seen, s0=100, s1=370) == 0, "0.293 + 0.7 < 1"
    assert next_target(robot(ConscientiousReactive), **seen, s0=100, s1=300) == 0


def test_at_the_beginning_all_idleness_is_zero_and_only_the_way_counts():
    """Source: patrolling_sim, HCR: the second term is 0 where the greatest idleness is."""
    one = newborn(HeuristicConscientiousReactive)
    worth = one.worth(np.arange(2), np.zeros(2), np.array([30.0, 60.0]))
    assert worth.tolist() == [0.5, 0.0]


@pytest.mark.parametrize("kind", [Random, ConscientiousReactive])
def test_equal_neighbours_are_equally_likely(kind):
    found = {next_target(robot(kind, seed)) for seed in range(60)}
    assert found == {0, 1, 2, 3, 5, 6, 7, 8}


def test_equal_neighbours_may_be_taken_in_order():
    assert next_target(newborn(ConscientiousReactive, ties="lowest"), s0=500, s1=400, s2=400) == 3
    assert next_target(newborn(Random, ties="lowest")) == 0


def test_who_begins_at_a_site_goes_on_from_there_and_has_not_visited_it():
    """Source: M2Bench: robots begin at nodes and decide at once."""
    one = newborn(ConscientiousReactive, ties="lowest")
    one.step(percept(5, 45.0, 45.0), [])
    assert one.target == 0 and one.knowledge.visited_tick.max() == 0
    beside = newborn(ConscientiousReactive, ties="lowest")
    beside.step(percept(5, 45.0, 48.5), [])
    assert beside.target == CENTRE


def test_all_last_visits_stand_in_for_what_a_robot_knows_itself():
    one = robot(ConscientiousReactive)
    sensed = np.full(9, 900, "<u4")
    sensed[[2, CENTRE]] = 100, 1000
    given = percept(1000, 45.0, 45.0)
    senses = msgspec.structs.replace(given.senses, shared_last_visit=sensed.tobytes())
    one.knowledge.note_visit(2, 999)
    one.step(msgspec.structs.replace(given, senses=senses), [])
    assert one.target == 2
    assert one.knowledge.visited_tick.tolist() == sensed.tolist()


def talker(kind, **parameters):
    """A robot of a rule that talks, and that comes to the centre."""
    given = kind.Parameters(**parameters).settled(4)
    one = kind(given, configuration(field=FIELD), np.random.Generator(np.random.Philox(1)))
    one.step(percept(0, 45.0, 49.0), [])
    return one


def told(sender, tick, site, next_site):
    return Heard(sender, tick, Bulletin(NO_NEWS, (), 0, Arrival(site, next_site)))


def test_gbs_weighs_idleness_per_way():
    """Source: patrolling_sim, GBS: 900 s over 42.4 m are 21.2 s/m, 700 s over 30 m are 23.3 s/m."""
    seen = {f"s{site}": 900 for site in (2, 3, 5, 6, 7, 8)}
    assert next_target(talker(Gbs), **seen, s0=100, s1=300) == 1
    assert next_target(talker(Gbs), **seen, s0=100, s1=370) == 0, "630 / 30 < 900 / 42.4"
    worth = talker(Gbs).worth(np.arange(3), np.array([0.0, 1500.0, 6000.0]), np.full(3, 30.0))
    assert worth == pytest.approx([0.1, 0.1**0.5, 1.0])


def test_gbs_learns_of_others_visits():
    """Source: patrolling_sim, GBS sends [id, 31, current]."""
    one = talker(Gbs)
    one.step(percept(900, 0.0, 0.0), [told("r5", 899, 7, 8)])
    assert one.knowledge.visited_tick[7] == 899 and one.knowledge.visited_tick[8] == 0
    one.step(percept(901, 0.0, 0.0), [told("r6", 500, 7, 8)])
    assert one.knowledge.visited_tick[7] == 899, "an older visit is no news"


def test_gbs_says_where_it_was_and_where_it_goes():
    one = talker(Gbs)
    move = one.step(percept(7, 45.0, 45.0), [])
    assert move.say[0].message == Arrival(CENTRE, one.target)
    assert one.step(percept(8, 45.0, 45.0), []).say == (), "only once"


def test_sebs_shuns_where_others_go():
    """Source: patrolling_sim, SEBS: R = 3; one robot on its way: 2^2 / (2^3 - 1) = 4/7, two: 2/7."""
    one, sites = talker(Sebs), np.array([0, 1, 2])
    assert one.parameters.team == 3
    before = one.worth(sites, np.full(3, 300.0), np.full(3, 30.0))
    one.step(percept(900, 0.0, 0.0), [told("r5", 899, 7, 1), told("r6", 899, 8, 2), told("r4", 899, 6, 2)])
    after = one.worth(sites, np.full(3, 300.0), np.full(3, 30.0))
    assert after / before == pytest.approx([1.0, 4 / 7, 2 / 7])
    one.step(percept(901, 0.0, 0.0), [told("r5", 900, 1, 0)])
    assert one.worth(sites, np.full(3, 300.0), np.full(3, 30.0)) / before == pytest.approx(
        [4 / 7, 1.0, 2 / 7]
    )


def test_a_word_about_a_site_that_is_none_is_no_visit():
    one = talker(Gbs)
    one.step(percept(900, 0.0, 0.0), [told("r5", 899, 9, 0), told("r5", 899, -1, 0)])
    assert one.knowledge.visited_tick.max() == 0


def test_a_field_of_one_cell_is_visited_again_and_again():
    one = newborn(Random, field=Grid(1, 1))
    for tick in range(3):
        one.step(percept(tick, 15.0, 15.0), [])
    assert one.target == 0


def tower_says(tick, visited_tick, since_tick=0):
    news = News(np.array(visited_tick, dtype="<u4").tobytes())
    return Heard("r1", tick - 1, Bulletin(news, (), since_tick))


def test_it_tells_the_tower_what_the_tower_lacks_and_nothing_else():
    """Source: Kobayashi et al. 2025, V-A2: assumed idleness is shared with the base station on connection."""
    one, empty, full = robot(ConscientiousReactive), [0] * 9, [0] * CENTRE + [7] + [0] * 4
    assert one.step(percept(7, 45.0, 45.0), []).say == (), "out of reach"
    (said,) = one.step(percept(8, 45.0, 45.0), [tower_says(8, empty)]).say
    assert {site: tick for site, tick in entries(said.news).items() if tick} == {CENTRE: 7}
    for tick in range(9, 17):
        assert one.step(percept(tick, 45.0, 45.0), [tower_says(tick, empty)]).say == (), "wait for its answer"
    assert one.step(percept(17, 45.0, 45.0), [tower_says(17, empty)]).say, "it must have been lost"
    assert one.step(percept(40, 45.0, 45.0), [tower_says(40, full)]).say == ()
    assert one.step(percept(60, 45.0, 45.0), [tower_says(60, full)]).say == ()
    assert one.step(percept(80, 45.0, 45.0), [tower_says(80, empty, since_tick=70)]).say, "a tower reborn"


@pytest.mark.parametrize("name", ["conscientious_reactive", "heuristic_conscientious_reactive"])
def test_a_conscientious_robot_alone_visits_every_cell(name, tmp_path):
    given = scenario(1, name, poses=[(15.0, 15.0, 0.0)], duration_s=1500.0)
    run = course(given, tmp_path)
    assert {site for _, _, site in run.visits()} == set(range(25))
