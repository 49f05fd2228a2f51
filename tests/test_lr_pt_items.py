"""LR-PT: what frames carry when room is scarce, and the parameters."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_agent.behaviour import Heard
from swarm_agent.behaviours.lr_pt import PUBLISHED, LrPtParameters
from swarm_agent.knowledge import Bulletin
from tests.builders import NO_NEWS, percept, robot, visited
from wire.fields import Grid


def exchange(speaker, listener, ticks, gets_through=lambda tick: True, start=100):
    """Two robots far from everything talk, one tick of delay each way."""
    to_listener, to_speaker = [], []
    for tick in range(start, start + ticks):
        said = speaker.step(percept(tick, 300.0, 300.0), to_speaker).say[0]
        reply = listener.step(percept(tick, 300.0, 310.0), to_listener).say[0]
        to_listener = [Heard("r2", tick, said)] if gets_through(tick) else []
        to_speaker = [Heard("r3", tick, reply)] if gets_through(-tick) else []


def knowing(name: str, items: str, count: int = 40):
    one = robot(name, items=items, items_per_tick=8, seed=5)
    visited(one, **{f"s{site}": site + 1 for site in range(count)})
    return one


def test_the_newest_entries_alone_never_carry_what_dropped_out_of_the_newest_eight():
    """Source: Algorithm 1, lines 8-11 with s = 8, as printed."""
    speaker, listener = knowing("r2", "newest"), robot("r3", items="newest", items_per_tick=8)
    exchange(speaker, listener, 60)
    assert np.flatnonzero(listener.knowledge.visited_tick[:40]).tolist() == list(range(32, 40))


def test_unsent_entries_carry_everything_in_as_few_steps_as_the_answer_allows():
    """Source: our option items."""
    speaker, listener = knowing("r2", "unsent"), robot("r3", items_per_tick=8)
    exchange(speaker, listener, 20)
    assert listener.knowledge.visited_tick[:40].tolist() == list(range(1, 41))


@given(st.integers(0, 2**32 - 1))
def test_unsent_entries_carry_everything_through_heavy_loss(seed):
    """Source: our option items; what was lost is not acknowledged, so it is said again."""
    lucky = np.random.Generator(np.random.Philox(seed))
    luck = {tick: lucky.random() > 0.5 for tick in range(-400, 400)}
    speaker, listener = knowing("r2", "unsent"), robot("r3", items_per_tick=8)
    exchange(speaker, listener, 150, luck.get)
    assert listener.knowledge.visited_tick[:40].tolist() == list(range(1, 41))


def test_unsent_entries_are_said_again_to_a_neighbour_that_lost_its_memory():
    """Source: our option items; a younger mind behind a known name knows nothing."""
    speaker = knowing("r2", "unsent")
    exchange(speaker, robot("r3", items_per_tick=8), 30)
    reborn = robot("r3", items_per_tick=8)
    exchange(speaker, reborn, 30, start=200)
    assert reborn.knowledge.visited_tick[:40].tolist() == list(range(1, 41))


def test_unsent_says_nothing_old_once_every_neighbour_has_everything():
    """Source: our option items: scarce items are not spent on what is known."""
    speaker, listener = knowing("r2", "unsent"), robot("r3", items_per_tick=8)
    exchange(speaker, listener, 30)
    reply = Heard("r3", 129, listener._bulletin(129, []))
    speaker.memory.listen([reply])
    assert not speaker.memory.unknown_to(["r3"], speaker.knowledge.visited_tick).any()


def test_what_is_acknowledged_to_another_is_not_taken_for_ours():
    """Source: our option items; two robots speak in the same tick, and only the other was heard."""
    speaker = knowing("r2", "unsent")
    speaker.step(percept(100), [])
    answer = Bulletin(NO_NEWS, (("r4", 100),), 0, None)
    speaker.memory.listen([Heard("r3", 101, answer)])
    assert speaker.memory.unknown_to(["r3"], speaker.knowledge.visited_tick).sum() == 40


def test_unsent_is_newest_when_there_is_room_for_all():
    """Source: our option items: equal for s >= K."""
    one, other = robot(items="newest"), robot(items="unsent")
    for each in (one, other):
        visited(each, s3=7)
    assert one.step(percept(9), []).say[0].news == other.step(percept(9), []).say[0].news


# Parameters


@pytest.mark.parametrize("team_size", [5, 10, 15])
def test_the_published_parameters_belong_to_the_size_of_the_team(team_size):
    """Source: Table I."""
    settled = LrPtParameters().settled(team_size)
    found = settled.takeover_discount, settled.report_priority_max_s, settled.spread_m
    assert found == PUBLISHED[team_size]
    table_1 = {5: (0.55, 1088, 356), 10: (0.40, 703, 304), 15: (0.50, 425, 525)}
    assert found == table_1[team_size]


def test_for_another_team_the_error_names_what_must_be_given():
    """Source: Table I has no other sizes, and says nothing of how to scale."""
    with pytest.raises(ValueError, match="takeover_discount, spread_m must be given.*5, 10, 15.*has 7"):
        LrPtParameters(report_priority_max_s=500.0).settled(7)


def test_what_is_given_replaces_the_published_value():
    """Source: none."""
    settled = LrPtParameters(spread_m=100.0).settled(10)
    assert (settled.takeover_discount, settled.spread_m) == (0.4, 100.0)
    assert LrPtParameters(takeover_discount=0.0, report_priority_max_s=1.0, spread_m=1.0).settled(7)


@pytest.mark.parametrize(
    ("offset", "first", "last"), [(None, 15.0, 585.0), (0.0, 0.0, 570.0), (7.5, 7.5, 577.5)]
)
def test_the_centre_offset_moves_all_centres(offset, first, last):
    """Source: the paper leaves the first centre open; k = 20 * column + row."""
    centres = robot(field=Grid(centre_offset_m=offset)).centres_m
    assert centres[0].tolist() == [first, first]
    assert centres[-1].tolist() == [last, last]
    assert centres[1].tolist() == [first, first + 30.0]
    assert centres[20].tolist() == [first + 30.0, first]
