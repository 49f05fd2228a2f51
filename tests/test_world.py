"""The world and its clock, seen through small rehearsals with scripted robots."""

import io
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deploy.scenario_file import to_toml
from swarm_agent.node import Mind, percepts_of
from tests.builders import Course, course, events, scenario, scripted
from wire import codec
from wire.fields import Grid
from wire.messages import WAKE_ON_ARRIVAL, WAKE_ON_FRAME, WAKE_ON_SENSOR, Action, Percept
from wire.scenario import Latency, Loss, PlannedFault, RadioSection, Range, Robots, Scenario, TowerSection
from world_server.clock import Clock
from world_server.journal import Journal, JournalError, commits, memories, read
from world_server.records import Commit, End, Header
from world_server.world import World

TALK = {"every_tick": True, "say_always": "hello"}
AWAKE = {"every_tick": True}


def grants_of(run: Course, node: str) -> dict[int, str]:
    """Tick and reason of every grant of a node."""
    return {one.tick: grant.why for one in commits(run.journal) for grant in one.grants if grant.node == node}


def visits_of(run: Course) -> list[tuple[int, str, int]]:
    return [(one.tick, *visit) for one in run.facts for visit in one.visits]


def poses_of(run: Course, row: int) -> list[tuple[float, float]]:
    return [tuple(np.frombuffer(one.poses).reshape(-1, 3)[row, :2].tolist()) for one in run.facts]


# One tick: act, settle, talk, sense


def test_a_frame_is_heard_in_the_next_tick(tmp_path):
    run = course(scripted({"r2": {"every_tick": True, "say": {"3": ["hi"]}}, "r3": AWAKE}, [(0, 0), (50, 0)]), tmp_path)
    heard = {tick: log.heard for tick, log in run.logs("r3").items() if log.heard}
    assert heard == {4: (("r2", 3, "hi"),)}


def test_the_radio_judges_on_the_positions_settled_in_the_tick_that_carried_the_frame(tmp_path):
    leaving = {"every_tick": True, "go": {"0": [100, 0, 0]}, "say_always": "x"}
    run = course(scripted({"r2": leaving, "r3": AWAKE}, [(0, 0), (-8, 0)], range_m=10.0), tmp_path, 6)
    spoken = [sent for log in run.logs("r3").values() for _, sent, _ in log.heard]
    assert spoken == [0]  # settled 1.5 m further it was at 9.5 m in tick 0, and at 11 m in tick 1


def test_what_is_sensed_is_what_was_settled_before(tmp_path):
    run = course(scripted({"r2": {"every_tick": True, "go": {"0": [100, 0, 0]}}}, [(0, 0)]), tmp_path, 5)
    assert [log.x_m for log in run.logs("r2").values()] == [0.0, 1.5, 3.0, 4.5, 6.0, 7.5]


def test_all_act_on_the_same_snapshot(tmp_path):
    scripts = {"r2": TALK, "r3": TALK}
    run = course(scripted(scripts, [(0, 0), (5, 0)]), tmp_path, 3)
    for tick in (1, 2, 3):
        assert run.logs("r2")[tick].heard == (("r3", tick - 1, "hello"),)
        assert run.logs("r3")[tick].heard == (("r2", tick - 1, "hello"),)


def test_nodes_stand_in_order_of_their_numbers(tmp_path):
    robots = Robots("tests.scripted:Scripted", ids=("r10", "r2", "r100", "r9"))
    given_scenario = scripted(dict.fromkeys(("r2", "r9", "r10", "r100"), TALK), [(0, 0)] * 4, robots=robots)
    run = course(given_scenario, tmp_path, 2)
    (last,) = [one for one in commits(run.journal) if one.tick == 2]
    assert [grant.node for grant in last.grants] == ["r2", "r9", "r10", "r100"]
    assert [sender for sender, _, _ in run.logs("r9")[2].heard] == ["r2", "r10", "r100"]


def test_several_frames_of_one_sender_arrive_in_the_order_they_were_said(tmp_path):
    scripts = {"r2": {"say": {"0": ["a", "b", "c"]}}, "r3": AWAKE}
    run = course(scripted(scripts, [(0, 0), (5, 0)]), tmp_path, 2)
    assert [text for _, _, text in run.logs("r3")[1].heard] == ["a", "b", "c"]


def test_latency_delays_by_exactly_its_ticks(tmp_path):
    radio = RadioSection((Range(50.0), Latency(7)))
    run = course(scripted({"r2": {"say": {"0": ["x"]}}, "r3": AWAKE}, [(0, 0), (5, 0)], radio=radio), tmp_path, 12)
    assert [tick for tick, log in run.logs("r3").items() if log.heard] == [7]


def test_frames_under_way_do_not_crowd_the_inbox(tmp_path):
    radio = RadioSection((Latency(20),), inbox_frames=4)
    run = course(scripted({"r2": TALK, "r3": AWAKE}, [(0, 0), (5, 0)], radio=radio), tmp_path, 30)
    assert [tick for tick, log in run.logs("r3").items() if log.heard] == list(range(20, 31))


def test_a_frame_beyond_the_byte_limit_is_an_error_to_the_sender_once(tmp_path):
    radio = RadioSection((Range(50.0),), bytes_per_tick=20)
    scripts = {"r2": {"every_tick": True, "say": {"2": ["short", "much too long for that", "x"]}}, "r3": AWAKE}
    run = course(scripted(scripts, [(0, 0), (5, 0)], radio=radio), tmp_path, 6)
    assert {tick: log.refused_frames for tick, log in run.logs("r2").items() if log.refused_frames} == {3: 2}
    assert run.logs("r3")[3].heard == (("r2", 2, "short"),)
    assert [one.radio[4] for one in run.facts] == [0, 0, 2, 0, 0, 0, 0]


def test_links_are_the_pairs_of_the_tick(tmp_path):
    run = course(scripted({"r2": {"say": {"0": ["x"]}}}, [(0, 0), (5, 0)]), tmp_path, 2)
    links = [np.frombuffer(one.links, "<u2").reshape(-1, 2).tolist() for one in run.facts]
    assert links[0] == [[1, 0], [1, 2]]
    assert run.facts[0].radio[:4] == (1, 2, 0, 0)


# Sleep and waking


def test_a_sleeping_swarm_costs_nothing(tmp_path):
    run = course(scenario(3, behaviour="stand_still", tower=TowerSection(
        behaviour="swarm_agent.behaviours.stand_still:StandStill"), duration_s=100_000.0), tmp_path)
    assert [one.tick for one in run.facts] == [0, 100_000]
    assert all(grants_of(run, node) == {0: "start"} for node in ("r1", "r2", "r3", "r4"))


def test_a_node_wakes_at_the_tick_it_named(tmp_path):
    run = course(scripted({"r2": {"wake_ticks": [7, 23]}}, [(0, 0)]), tmp_path)
    assert grants_of(run, "r2") == {0: "start", 7: "wake", 23: "wake"}


def test_a_frame_wakes_who_wants_to_be_woken_by_it(tmp_path):
    scripts = {
        "r2": {"wake_ticks": [5], "say": {"5": ["up"]}},
        "r3": {"wake_on": WAKE_ON_FRAME},
        "r4": {"wake_on": WAKE_ON_ARRIVAL | WAKE_ON_SENSOR},
    }
    run = course(scripted(scripts, [(0, 0), (5, 0), (6, 0)]), tmp_path)
    assert grants_of(run, "r3") == {0: "start", 6: "frame"}
    assert grants_of(run, "r4") == {0: "start"}
    assert run.logs("r3")[6].heard == (("r2", 5, "up"),)


def test_a_late_frame_wakes_when_it_arrives(tmp_path):
    radio = RadioSection((Latency(9),))
    scripts = {"r2": {"say": {"0": ["up"]}}, "r3": {"wake_on": WAKE_ON_FRAME}}
    run = course(scripted(scripts, [(0, 0), (5, 0)], radio=radio), tmp_path)
    assert grants_of(run, "r3") == {0: "start", 9: "frame"}


def test_frames_that_do_not_wake_wait_in_the_inbox(tmp_path):
    scripts = {"r2": {"wake_ticks": [1, 2], "say": {"0": ["a"], "1": ["b"], "2": ["c"]}}, "r3": {"wake_ticks": [9]}}
    run = course(scripted(scripts, [(0, 0), (5, 0)]), tmp_path)
    assert run.logs("r3")[9].heard == (("r2", 0, "a"), ("r2", 1, "b"), ("r2", 2, "c"))


def test_a_full_inbox_keeps_the_newest(tmp_path):
    radio = RadioSection((Range(50.0),), inbox_frames=3)
    run = course(scripted({"r2": TALK, "r3": {"wake_ticks": [20]}}, [(0, 0), (5, 0)], radio=radio), tmp_path, 20)
    assert [sent for _, sent, _ in run.logs("r3")[20].heard] == [17, 18, 19]


def test_an_inbox_never_outgrows_what_a_message_may_hold(tmp_path):
    words = "x" * 60_000
    scripts = {"r2": {"every_tick": True, "say_always": words}, "r3": {"wake_ticks": [200]}}
    run = course(scripted(scripts, [(0, 0), (5, 0)]), tmp_path, 200)
    heard = [sent for _, sent, _ in run.logs("r3")[200].heard]
    assert heard == list(range(heard[0], 200))
    assert len(heard) > 30


def test_arrival_wakes_who_wants_to_be_woken_by_it(tmp_path):
    scripts = {"r2": {"go": {"0": [9, 0, 3]}, "wake_on": WAKE_ON_ARRIVAL}, "r3": {"go": {"0": [9, 0, 3]}}}
    run = course(scripted(scripts, [(0, 0), (0, 0)]), tmp_path)
    assert grants_of(run, "r2") == {0: "start", 4: "arrival"}
    assert run.logs("r2")[4].x_m == 6.0
    assert grants_of(run, "r3") == {0: "start"}


def test_who_is_already_there_arrives_at_once_and_once(tmp_path):
    run = course(scripted({"r2": {"go": {"0": [1, 0, 3]}, "wake_on": WAKE_ON_ARRIVAL}}, [(0, 0)]), tmp_path)
    assert grants_of(run, "r2") == {0: "start", 1: "arrival"}


def test_a_body_coming_into_sight_and_leaving_it_wakes_who_watches(tmp_path):
    scripts = {"r2": {"wake_on": WAKE_ON_SENSOR}, "r3": {"go": {"0": [-30, 0, 0]}}}
    robots = Robots("tests.scripted:Scripted", 2, sensor_range_m=10.0)
    tower = TowerSection(behaviour="swarm_agent.behaviours.stand_still:StandStill", x_m=500.0)
    given_scenario = scripted(scripts, [(0, 0), (30, 0)], robots=robots, tower=tower, duration_s=60.0)
    run = course(given_scenario, tmp_path)
    woken = run.logs("r2")
    assert [log.in_sight for log in woken.values()] == [(), ("r3",), ()]
    seen_at = {tick: abs(poses_of(run, 2)[tick - 1][0]) for tick in list(woken)[1:]}
    first, last = seen_at
    assert seen_at[first] <= 10 < abs(poses_of(run, 2)[first - 2][0])
    assert seen_at[last] > 10 >= abs(poses_of(run, 2)[last - 2][0])


def test_a_body_that_comes_to_rest_in_sight_is_seen_at_once(tmp_path):
    scripts = {"r2": {"wake_on": WAKE_ON_SENSOR}, "r3": {"go": {"0": [9, 0, 0]}}}
    robots = Robots("tests.scripted:Scripted", 2, sensor_range_m=10.0, max_speed_m_s=30.0, max_turn_rad_s=4.0)
    tower = TowerSection(behaviour="swarm_agent.behaviours.stand_still:StandStill", x_m=500.0)
    run = course(scripted(scripts, [(0, 0), (30, 0)], robots=robots, tower=tower), tmp_path)
    assert grants_of(run, "r2") == {0: "start", 1: "sensor"}


# Death, cold and memory


def planned(*faults: PlannedFault, scripts=None, poses=((0, 0), (5, 0)), **fields) -> Scenario:
    given_scripts = {"r2": TALK, "r3": TALK} if scripts is None else scripts
    return scripted(given_scripts, poses, faults=faults, **fields)


def test_a_killed_robots_body_stays_where_it_fell_mute_and_deaf(tmp_path):
    scripts = {"r2": TALK, "r3": {"every_tick": True, "say_always": "x", "go": {"0": [100, 0, 0]}}}
    run = course(planned(PlannedFault(10, "kill", ("r3",)), scripts=scripts), tmp_path, 30)
    positions = poses_of(run, 2)
    assert positions[9] != positions[8]
    assert set(positions[9:]) == {positions[9]}
    assert max(grants_of(run, "r3")) == 9
    assert max(sent for log in run.logs("r2").values() for _, sent, _ in log.heard) == 9
    assert all("r3" in log.in_sight for log in run.logs("r2").values())
    assert [one.modes[2] for one in run.facts] == [0] * 10 + [2] * 21
    receivers = {pair[1] for one in run.facts[10:] for pair in np.frombuffer(one.links, "<u2").reshape(-1, 2).tolist()}
    assert 2 not in receivers


def test_what_was_under_way_to_a_dead_robot_is_lost(tmp_path):
    faults = PlannedFault(10, "kill", ("r3",)), PlannedFault(12, "restart", ("r3",))
    run = course(planned(*faults, radio=RadioSection((Latency(5),))), tmp_path, 30)
    assert [run.logs("r3")[tick].heard for tick in range(12, 17)] == [()] * 5
    assert run.logs("r3")[17].heard == (("r2", 12, "hello"),)


def test_a_frozen_robot_is_not_granted_and_its_inbox_fills_to_its_bound(tmp_path):
    faults = PlannedFault(5, "freeze", ("r3",)), PlannedFault(25, "thaw", ("r3",))
    run = course(planned(*faults, radio=RadioSection((Range(50.0),), inbox_frames=8)), tmp_path, 30)
    assert [tick for tick in grants_of(run, "r3")] == [*range(5), *range(25, 31)]
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


@pytest.mark.parametrize("faults", [
    (PlannedFault(0, "kill", ("r3",)), PlannedFault(9, "restart", ("r3",), memory="kept")),
    (PlannedFault(5, "kill", ("r3",)), PlannedFault(5, "restart", ("r3",), memory="kept")),
    (PlannedFault(5, "kill", ("r3",)), PlannedFault(7, "restart", ("r3",)), PlannedFault(7, "kill", ("r3",)),
     PlannedFault(9, "restart", ("r3",), memory="kept")),
    (PlannedFault(5, "freeze", ("r3",)), PlannedFault(9, "kill", ("r3",)),
     PlannedFault(12, "restart", ("r3",), memory="kept")),
], ids=["before its first grant", "at once", "before its second first grant", "frozen"])
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
        PlannedFault(5, "freeze", ("r2",)), PlannedFault(15, "thaw", ("r2",)),
        PlannedFault(9, "kill", ("r3",)), PlannedFault(12, "restart", ("r3",)),
        PlannedFault(20, "kill", ("r2",)), PlannedFault(22, "restart", ("r2",), memory="kept"),
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
    run = course(planned(scripts={"r2": TALK, "r3": {"every_tick": True, "say_always": "x", "fail_at": 6}}), tmp_path, 12)
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


# Visits


def test_a_visit_is_the_robots_own_goal_reached(tmp_path):
    """Source: Kobayashi et al. 2025, section III-A. Sites at 15 m and 45 m; the second is only passed."""
    field = Grid(3, 1)
    scripts = {"r2": {"go": {"0": [75, 15, 3]}}, "r3": {"go": {"0": [14, 15, 3]}}}
    run = course(scripted(scripts, [(45, 15), (0, 15)], field=field), tmp_path)
    assert {(node, site) for _, node, site in visits_of(run)} == {("r2", 2)}
    assert visits_of(run)[0][0] == 18  # 27 m at 1.5 m/s


def test_a_visit_is_within_reach_of_the_field_whatever_the_robot_calls_arrival(tmp_path):
    scripts = {"r2": {"go": {"0": [45, 15, 30]}}, "r3": {"go": {"0": [45, 15, 0]}}}
    run = course(scripted(scripts, [(15, 15), (15, 15)], field=Grid(2, 1)), tmp_path)
    assert {tick for tick, _, _ in visits_of(run) if tick < 19} == {18}
    assert {node for tick, node, _ in visits_of(run) if tick == 18} == {"r2", "r3"}


def test_the_dead_and_the_frozen_visit_nothing(tmp_path):
    go = {"go": {"0": [45, 15, 3]}}
    faults = PlannedFault(17, "kill", ("r2",)), PlannedFault(17, "freeze", ("r3",)), PlannedFault(30, "thaw", ("r3",))
    run = course(planned(*faults, scripts={"r2": go, "r3": go, "r4": AWAKE}, poses=[(15, 15)] * 3, field=Grid(2, 1)), tmp_path)
    assert visits_of(run)[0][:2] == (30, "r3")
    assert {node for _, node, _ in visits_of(run)} == {"r3"}


@pytest.mark.parametrize("others", [{}, {"r3": AWAKE}], ids=["alone", "with somebody awake"])
@pytest.mark.parametrize("speed", [1.5, 40.0])
def test_what_others_do_does_not_change_when_a_sleeping_robot_visits(tmp_path, others, speed):
    robots = Robots("tests.scripted:Scripted", 2, max_speed_m_s=speed, max_turn_rad_s=4.0)
    scripts = {"r2": {"go": {"0": [45, 15, 0]}}} | others
    run = course(scripted(scripts, [(15, 15), (0, 0)], field=Grid(2, 1), robots=robots), tmp_path)
    assert visits_of(run) == [(18 if speed == 1.5 else 1, "r2", 1)]


def test_staying_at_a_site_is_one_visit_and_coming_again_another(tmp_path):
    go = {"0": [45, 15, 3], "22": [75, 15, 3], "23": [45, 15, 3]}
    run = course(scripted({"r2": {"every_tick": True, "go": go}}, [(43, 15)], field=Grid(3, 1)), tmp_path)
    assert visits_of(run) == [(1, "r2", 1), (24, "r2", 1)]


def test_going_again_to_where_it_stands_is_another_visit(tmp_path):
    """The mind completes its target again, so the world must, or the tower would know of more than happened."""
    go = {"0": [45, 15, 3], "20": [45, 15, 3]}
    run = course(scripted({"r2": {"every_tick": True, "go": go}}, [(43, 15)], field=Grid(3, 1)), tmp_path)
    assert visits_of(run) == [(1, "r2", 1), (21, "r2", 1)]


# Sameness


def test_the_same_scenario_and_seed_give_the_same_hash_and_facts(tmp_path):
    plan = scenario(4, radio=RadioSection((Range(180.0), Loss(0.3))))
    once, again = course(plan, tmp_path / "a"), course(plan, tmp_path / "b")
    assert once.run_hash == again.run_hash
    assert once.facts == again.facts
    assert once.journal.read_bytes() == again.journal.read_bytes()


def test_another_seed_other_faults_or_a_shorter_run_give_another_hash(tmp_path):
    fault = PlannedFault(20, "kill", ("r3",))
    plans = {
        "plain": scenario(3), "seed": scenario(3, seed=2), "fault": scenario(3, faults=(fault,)),
        "range": scenario(3, range_m=5.0), "parameter": scenario(3, parameters={"lock_breaker": "none"}),
    }
    hashes = {name: course(plan, tmp_path / name).run_hash for name, plan in plans.items()}
    hashes["shorter"] = course(plans["plain"], tmp_path / "shorter", 39).run_hash
    assert len(set(hashes.values())) == 6, hashes


def test_the_pace_and_the_port_are_no_part_of_the_hash(tmp_path):
    plain = scenario(2)
    other = msgspec.convert(msgspec.to_builtins(plain) | {"clock": {"kind": "paced"}, "wire": {"port": 7}}, Scenario)
    assert course(plain, tmp_path / "a").run_hash == course(other, tmp_path / "b").run_hash


# The journal


def records_of(path: Path) -> list[Header | Commit | End]:
    return list(read(path))


@pytest.fixture(scope="module")
def sound(tmp_path_factory) -> Course:
    """A run with loss and a death, whose journal tests damage."""
    plan = scenario(3, duration_s=12.0, radio=RadioSection((Range(180.0), Loss(0.3))),
                    faults=(PlannedFault(5, "kill", ("r3",)),))
    return course(plan, tmp_path_factory.mktemp("sound"))


def test_what_was_committed_is_read_back(tmp_path, monkeypatch):
    written: list[Commit] = []
    append = Journal.append
    monkeypatch.setattr(Journal, "append", lambda self, commit: (written.append(commit), append(self, commit)))
    run = course(scenario(2), tmp_path)
    header, *middle, end = records_of(run.journal)
    assert middle == written
    assert [one.facts for one in middle] == run.facts
    assert isinstance(header, Header) and header.nodes == ("r1", "r2", "r3")
    assert end == End(40, True, run.run_hash)


@given(st.data())
def test_a_journal_cut_anywhere_yields_only_whole_records(sound, tmp_path, data):
    whole, everything = sound.journal.read_bytes(), records_of(sound.journal)
    cut = data.draw(st.integers(0, len(whole)))
    (tmp_path / "cut").write_bytes(whole[:cut])
    found = records_of(tmp_path / "cut")
    assert found == everything[: len(found)]
    assert cut < len(whole) or found == everything


def test_a_journal_is_readable_up_to_the_last_commit_while_it_is_written(tmp_path):
    plan, stream = scenario(2), io.BytesIO()
    journal = Journal(stream, plan, to_toml(plan), b"")
    run = course(plan, tmp_path / "a", 8)
    for count, commit in enumerate(commits(run.journal), start=1):
        journal.append(commit)
        (tmp_path / "half").write_bytes(stream.getvalue())
        assert len(records_of(tmp_path / "half")) == count + 1


@settings(max_examples=300)
@given(st.data())
def test_a_flipped_bit_is_an_error_or_ends_the_journal_but_never_changes_a_record(sound, tmp_path, data):
    damaged, everything = bytearray(sound.journal.read_bytes()), records_of(sound.journal)
    place = data.draw(st.integers(0, len(damaged) - 1))
    damaged[place] ^= 1 << data.draw(st.integers(0, 7))
    (tmp_path / "damaged").write_bytes(damaged)
    try:
        found = records_of(tmp_path / "damaged")
    except JournalError as error:
        assert "damaged" in str(error)
    else:
        assert found == everything[: len(found)]


@pytest.mark.parametrize("what", ["toml", "poses", "end", "commit", "kind"])
def test_a_changed_record_is_detected(sound, tmp_path, what):
    damaged = _rewritten(sound.journal, what)
    (tmp_path / "damaged").write_bytes(damaged)
    with pytest.raises(JournalError, match="damaged"):
        records_of(tmp_path / "damaged")


def _rewritten(path: Path, what: str) -> bytes:
    """The journal with one byte of one record's content flipped, compressed anew."""
    import zstandard

    plain = bytearray(zstandard.ZstdDecompressor().decompressobj().decompress(path.read_bytes()))
    header, *_, end = records_of(path)
    place = {
        "toml": plain.find(b"duration_s"),
        "poses": plain.find(header.first_poses) + 30,
        "end": plain.rfind(codec.encode(end)) + 2,
        "commit": plain.find(b"lr_pt", plain.find(header.first_poses)),
        "kind": plain.rfind(codec.encode(end)) - 21,
    }[what]
    plain[place] ^= 1
    return zstandard.ZstdCompressor().compress(bytes(plain))


def test_a_file_that_is_no_journal_is_an_error_that_names_it(tmp_path):
    (tmp_path / "other").write_text("something else entirely, and long enough to be sure")
    with pytest.raises(JournalError, match="other"):
        records_of(tmp_path / "other")


def test_a_payload_is_stored_once_however_many_hear_it(tmp_path):
    letters = np.random.Generator(np.random.Philox(1)).integers(97, 123, 20_000)
    words = "".join(map(chr, letters))
    crowd = {f"r{number}": AWAKE for number in range(3, 12)}
    sizes = {}
    for name, listeners in (("many", 10), ("one", 2)):
        scripts = {"r2": {"say": {"0": [words]}}} | crowd
        sizes[name] = course(scripted(scripts, [(0, 0)] * listeners), tmp_path / name, 10).journal.stat().st_size
    assert sizes["many"] - sizes["one"] < 6_000
    assert sizes["one"] > 10_000


def test_the_clock_jumps_to_a_planned_fault_while_all_sleep(tmp_path):
    run = course(planned(PlannedFault(25, "kill", ("r2",)), scripts={}), tmp_path)
    assert [one.tick for one in run.facts] == [0, 25, 40]


def test_a_run_that_is_finished_early_ends_at_a_tick_boundary(tmp_path):
    plan = scenario(2)
    stream = io.BytesIO()

    class Finishing:
        finishing = False

        def exchange(self, tick, percepts):
            return {node: Action(tick, one.grant, wake_tick=tick + 1) for node, one in percepts.items()}

        def boundary(self, tick):
            return ()

        def show(self, facts):
            self.finishing = facts.tick == 7

    journal = Journal(stream, plan, "", b"")
    assert Clock(World(plan), Finishing(), journal, 40).run() == (7, False)
    (tmp_path / "journal").write_bytes(stream.getvalue())
    assert records_of(tmp_path / "journal")[-1] == End(7, False, journal.run_hash)
