"""The base station: Algorithm 1 at a node without a target."""

import msgspec
import numpy as np
import pytest

from swarm_agent.behaviour import Heard
from swarm_agent.knowledge import Bulletin, News
from tests.builders import configuration, entries, from_robot, percept, table
from tower.base_station import BaseStation, BaseStationParameters
from wire import codec
from wire.fields import Grid
from wire.messages import Stay


def station(items: int | None = None, field: Grid | None = None) -> BaseStation:
    told = configuration("r1", "base_station", field=field or Grid(3, 3))
    return BaseStation(BaseStationParameters(items), told, np.random.Generator(np.random.Philox(1)))


def test_it_never_moves_and_acts_every_tick():
    """Source: section IV-A: r_1 does not patrol."""
    one = station()
    for tick in range(4):
        move = one.step(percept(tick), [from_robot("r2", tick - 1, news=table(s1=tick))] if tick else [])
        assert move.motion == Stay()
        assert move.wake_tick == tick + 1
        assert len(move.say) == 1


def test_its_frame_says_what_it_knew_before_it_heard():
    """Source: Algorithm 1: lines 8-11 come before 13-18."""
    one = station()
    first = one.step(percept(5), [from_robot("r2", 4, news=table(s3=4))])
    second = one.step(percept(6), [])
    assert entries(first.say[0].news)[3] == 0
    assert entries(second.say[0].news)[3] == 4


def test_it_takes_over_only_what_is_strictly_newer():
    """Source: Algorithm 1, lines 13-18."""
    one = station()
    one.step(percept(5), [from_robot("r2", 4, news=table(s1=3, s2=3))])
    one.step(percept(6), [from_robot("r2", 5, news=table(s1=2, s2=4)), from_robot("r3", 5, news=table(s2=1))])
    assert one.knowledge.visited_tick[:4].tolist() == [0, 3, 4, 0]


def test_it_reports_its_whole_table_once_and_then_what_changed():
    """Source: none; observers fold the reports."""
    one = station()
    first = one.step(percept(0), []).report
    assert first.whole
    assert entries(first.news) == dict.fromkeys(range(9), 0)
    assert one.step(percept(1), []).report is None
    change = one.step(percept(2), [from_robot("r2", 1, news=table(s7=1, s8=0))]).report
    assert (change.whole, entries(change.news)) == (False, {7: 1})
    assert one.step(percept(3), [from_robot("r2", 2, news=table(s7=1))]).report is None


def test_the_first_report_holds_what_the_first_inbox_brought():
    """Source: none; a restarted tower may hear in its first tick."""
    report = station().step(percept(9), [from_robot("r2", 8, news=table(s2=7))]).report
    assert report.whole
    assert entries(report.news)[2] == 7


@pytest.mark.parametrize("items", [None, 3])
def test_it_acknowledges_every_frame_it_heard(items):
    """Source: our option items; acknowledged entries need not be said again."""
    one = station(items)
    heard = [from_robot("r2", 8), from_robot("r3", 7), from_robot("r3", 8)]
    assert one.step(percept(9), heard).say[0].heard == (("r2", 8), ("r3", 7), ("r3", 8))


def test_its_frame_tells_when_its_mind_began():
    """Source: none; others notice by it that a restarted tower knows nothing."""
    one = station()
    assert [one.step(percept(tick), []).say[0].since_tick for tick in (4, 5, 6)] == [4, 4, 4]


def test_scarce_items_go_to_what_its_neighbours_lack():
    """Source: our option items."""
    one = station(items=2)
    one.step(percept(1), [from_robot("r2", 0, news=table(s0=1, s1=2, s2=3, s3=4))])
    known_to_r3 = Heard("r3", 1, Bulletin(table(s3=4, s2=3), (), 0, None))
    assert entries(one.step(percept(2), [known_to_r3]).say[0].news) == {0: 1, 1: 2}


@pytest.mark.parametrize("news", [News(b"\1\0\0\0" * 400), table(s9=5), table(s0=3, s400=3)])
def test_news_of_a_field_of_another_size_is_ignored(news):
    """Source: none; nobody crashes on a message."""
    one = station()
    one.step(percept(5), [from_robot("r2", 4, news=news)])
    assert not one.knowledge.visited_tick.any()


@pytest.mark.parametrize("items", [0, -1])
def test_a_number_of_items_below_one_is_refused(items):
    """Source: none; -1 would leave out the oldest entry, 0 would mean all."""
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert({"items_per_tick": items}, BaseStationParameters)


def test_it_understands_any_behaviour_that_carries_its_news_in_a_bulletin():
    """Source: none; the third part of a bulletin is the behaviour's own affair."""
    payload = codec.encode(Bulletin(table(s1=5), (), 0, {"whatever": [1, 2.5, None]}))
    one = station()
    one.step(percept(6), [Heard("r2", 5, codec.decode(BaseStation.Radio, payload))])
    assert one.knowledge.visited_tick[1] == 5
