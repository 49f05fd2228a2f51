"""Death, cold and memory, seen through small rehearsals."""

import numpy as np
import pytest

from swarm_agent.node import Mind, percepts_of
from tests.builders import TALK, course, events, planned, scenario
from wire import codec
from wire.messages import Percept
from wire.scenario import Latency, Loss, PlannedFault, RadioSection, Range
from world_server.journal import commits, memories

# Death, cold and memory


def test_a_killed_robots_body_stays_where_it_fell_mute_and_deaf(tmp_path):
    scripts = {"r2": TALK, "r3": {"every_tick": True, "say_always": "x", "go": {"0": [100, 0, 0]}}}
    run = course(planned(PlannedFault(10, "kill", ("r3",)), scripts=scripts), tmp_path, 30)
    positions = run.positions(2)
    assert positions[9] != positions[8]
    assert set(positions[9:]) == {positions[9]}
    assert max(run.grants("r3")) == 9
    assert max(sent for log in run.logs("r2").values() for _, sent, _ in log.heard) == 9
    assert all("r3" in log.in_sight for log in run.logs("r2").values())
    assert [one.modes[2] for one in run.facts] == [0] * 10 + [2] * 21
    receivers = {
        pair[1] for one in run.facts[10:] for pair in np.frombuffer(one.links, "<u2").reshape(-1, 2).tolist()
    }
    assert 2 not in receivers


def test_what_was_under_way_to_a_dead_robot_is_lost(tmp_path):
    faults = PlannedFault(10, "kill", ("r3",)), PlannedFault(12, "restart", ("r3",))
    run = course(planned(*faults, radio=RadioSection((Latency(5),))), tmp_path, 30)
    assert [run.logs("r3")[tick].heard for tick in range(12, 17)] == [()] * 5
    assert run.logs("r3")[17].heard == (("r2", 12, "hello"),)


def test_a_frozen_robot_is_not_granted_and_its_inbox_fills_to_its_bound(tmp_path):
    faults = PlannedFault(5, "freeze", ("r3",)), PlannedFault(25, "thaw", ("r3",))
    run = course(planned(*faults, radio=RadioSection((Range(50.0),), inbox_frames=8)), tmp_path, 30)
    assert [tick for tick in run.grants("r3")] == [*range(5), *range(25, 31)]
    assert [sent for _, sent, _ in run.logs("r3")[25].heard] == list(range(17, 25))
    assert run.logs("r3")[25].grants == 6
    assert [one.modes[2] for one in run.facts[4:26]] == [0] + [1] * 20 + [0]


def test_a_robot_restarted_without_memory_has_an_empty_mind_and_other_luck(tmp_path):
    faults = PlannedFault(5, "kill", ("r3",)), PlannedFault(9, "restart", ("r3",), memory="lost")
    run = course(planned(*faults), tmp_path, 12)
    logs = run.logs("r3")
    assert [tick for tick in logs] == [0, 1, 2, 3, 4, 9, 10, 11, 12]
    assert (logs[9].why, logs[9].grants) == ("start", 1)
    assert logs[9].draw != logs[0].draw


def test_a_robot_restarted_with_its_memory_goes_on_where_it_was(tmp_path):
    faults = PlannedFault(5, "kill", ("r3",)), PlannedFault(9, "restart", ("r3",), memory="kept")
    run = course(planned(*faults), tmp_path / "a", 12)
    control = course(planned(), tmp_path / "b", 12)
    logs, undisturbed = run.logs("r3"), control.logs("r3")
    assert [logs[tick].grants for tick in (4, 9, 10)] == [5, 6, 7]
    assert [logs[9 + n].draw for n in range(4)] == [undisturbed[5 + n].draw for n in range(4)]


def test_a_rebuilt_lr_pt_mind_is_the_mind_that_died(tmp_path):
    """The journalled percepts of a robot, lived again, give the answers that it gave."""
    plan = scenario(3, duration_s=60.0, radio=RadioSection((Range(180.0), Loss(0.3))))
    run = course(plan, tmp_path)
    told = percepts_of(memories(run.journal, "r3"))
    given_then = [
        codec.encode(action)
        for one in commits(run.journal)
        for grant, action in zip(one.grants, one.actions, strict=True)
        if grant.node == "r3"
    ]
    mind = Mind("swarm_agent.behaviours")
    assert [mind.answer(data) for data in told] == given_then
    assert len(told) == 61


@pytest.mark.parametrize(
    "faults",
    [
        (PlannedFault(0, "kill", ("r3",)), PlannedFault(9, "restart", ("r3",), memory="kept")),
        (PlannedFault(5, "kill", ("r3",)), PlannedFault(5, "restart", ("r3",), memory="kept")),
        (
            PlannedFault(5, "kill", ("r3",)),
            PlannedFault(7, "restart", ("r3",)),
            PlannedFault(7, "kill", ("r3",)),
            PlannedFault(9, "restart", ("r3",), memory="kept"),
        ),
        (
            PlannedFault(5, "freeze", ("r3",)),
            PlannedFault(9, "kill", ("r3",)),
            PlannedFault(12, "restart", ("r3",), memory="kept"),
        ),
    ],
    ids=["before its first grant", "at once", "before its second first grant", "frozen"],
)
def test_a_robot_with_its_memory_comes_back_whenever_it_was_killed(tmp_path, faults):
    run = course(planned(*faults), tmp_path, 20)
    assert not [one for one in events(tmp_path) if one["kind"] == "death"]
    assert max(run.logs("r3")) == 20
    assert run.facts[-1].modes[2] == 0


@pytest.mark.parametrize("latency", [1, 4])
def test_memories_are_the_percepts_that_were_given(tmp_path, monkeypatch, latency):
    lives: dict[Mind, list[bytes]] = {}
    answer = Mind.answer

    def listening(self, data):
        lives.setdefault(self, []).append(data)
        return answer(self, data)

    faults = (
        PlannedFault(5, "freeze", ("r2",)),
        PlannedFault(15, "thaw", ("r2",)),
        PlannedFault(9, "kill", ("r3",)),
        PlannedFault(12, "restart", ("r3",)),
        PlannedFault(20, "kill", ("r2",)),
        PlannedFault(22, "restart", ("r2",), memory="kept"),
    )
    radio = RadioSection((Range(50.0), Loss(0.2), Latency(latency)), inbox_frames=3)
    with monkeypatch.context() as patched:
        patched.setattr(Mind, "answer", listening)
        run = course(planned(*faults, radio=radio), tmp_path, 30)
    for node, grants in (("r2", 31 - 10 - 2), ("r3", 31 - 12)):
        told = percepts_of(memories(run.journal, node))
        assert told in lives.values()
        assert codec.decode(Percept, told[-1]).tick == 30
        assert len(told) == grants


def test_a_behaviour_that_raises_is_a_death_with_its_last_lines(tmp_path):
    run = course(
        planned(scripts={"r2": TALK, "r3": {"every_tick": True, "say_always": "x", "fail_at": 6}}),
        tmp_path,
        12,
    )
    (death,) = [one for one in events(tmp_path) if one["kind"] == "death"]
    assert (death["tick"], death["node"]) == (6, "r3")
    assert "as the script says" in death["data"]["last_lines"]
    assert run.facts[6].modes[2] == 2
    assert [(one.verb, one.node, one.tick) for one in run.facts[6].faults] == [("kill", "r3", 6)]
    assert run.logs("r2")[7].heard == ()


def test_faults_of_one_tick_befall_in_order_of_their_times(tmp_path):
    faults = PlannedFault(5.8, "restart", ("r3",)), PlannedFault(5.2, "kill", ("r3",))
    run = course(planned(*faults), tmp_path, 8)
    assert [one.verb for one in run.facts[6].faults] == ["kill", "restart"]
    assert run.logs("r3")[6].why == "start"


def test_a_share_of_the_highest_numbers_counts_the_tower_among_all():
    """Source: Kobayashi et al. 2025, failure runs: N = 5: r5; N = 10: r9, r10; N = 15: r13, r14, r15."""
    fault = PlannedFault(1, "kill", highest_ids_share=0.2)
    struck = [scenario(count, behaviour="stand_still").nodes_of(fault) for count in (4, 9, 14)]
    assert struck == [("r5",), ("r9", "r10"), ("r13", "r14", "r15")]
