"""The world and its clock, seen through small rehearsals with scripted robots."""

import numpy as np

from tests.builders import AWAKE, TALK, course, scenario, scripted
from wire.messages import WAKE_ON_ARRIVAL, WAKE_ON_FRAME, WAKE_ON_SENSOR
from wire.scenario import Latency, RadioSection, Range, Robots, TowerSection
from world_server.journal import commits

# One tick: act, settle, talk, sense


def test_a_frame_is_heard_in_the_next_tick(tmp_path):
    run = course(
        scripted({"r2": {"every_tick": True, "say": {"3": ["hi"]}}, "r3": AWAKE}, [(0, 0), (50, 0)]), tmp_path
    )
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
    run = course(
        scripted({"r2": {"say": {"0": ["x"]}}, "r3": AWAKE}, [(0, 0), (5, 0)], radio=radio), tmp_path, 12
    )
    assert [tick for tick, log in run.logs("r3").items() if log.heard] == [7]


def test_frames_under_way_do_not_crowd_the_inbox(tmp_path):
    radio = RadioSection((Latency(20),), inbox_frames=4)
    run = course(scripted({"r2": TALK, "r3": AWAKE}, [(0, 0), (5, 0)], radio=radio), tmp_path, 30)
    assert [tick for tick, log in run.logs("r3").items() if log.heard] == list(range(20, 31))


def test_a_frame_beyond_the_byte_limit_is_an_error_to_the_sender_once(tmp_path):
    radio = RadioSection((Range(50.0),), bytes_per_tick=20)
    scripts = {
        "r2": {"every_tick": True, "say": {"2": ["short", "much too long for that", "x"]}},
        "r3": AWAKE,
    }
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
    run = course(
        scenario(
            3,
            behaviour="stand_still",
            tower=TowerSection(behaviour="swarm_agent.behaviours.stand_still:StandStill"),
            duration_s=100_000.0,
        ),
        tmp_path,
    )
    assert [one.tick for one in run.facts] == [0, 100_000]
    assert all(run.grants(node) == {0: "start"} for node in ("r1", "r2", "r3", "r4"))


def test_a_node_wakes_at_the_tick_it_named(tmp_path):
    run = course(scripted({"r2": {"wake_ticks": [7, 23]}}, [(0, 0)]), tmp_path)
    assert run.grants("r2") == {0: "start", 7: "wake", 23: "wake"}


def test_a_frame_wakes_who_wants_to_be_woken_by_it(tmp_path):
    scripts = {
        "r2": {"wake_ticks": [5], "say": {"5": ["up"]}},
        "r3": {"wake_on": WAKE_ON_FRAME},
        "r4": {"wake_on": WAKE_ON_ARRIVAL | WAKE_ON_SENSOR},
    }
    run = course(scripted(scripts, [(0, 0), (5, 0), (6, 0)]), tmp_path)
    assert run.grants("r3") == {0: "start", 6: "frame"}
    assert run.grants("r4") == {0: "start"}
    assert run.logs("r3")[6].heard == (("r2", 5, "up"),)


def test_a_late_frame_wakes_when_it_arrives(tmp_path):
    radio = RadioSection((Latency(9),))
    scripts = {"r2": {"say": {"0": ["up"]}}, "r3": {"wake_on": WAKE_ON_FRAME}}
    run = course(scripted(scripts, [(0, 0), (5, 0)], radio=radio), tmp_path)
    assert run.grants("r3") == {0: "start", 9: "frame"}


def test_frames_that_do_not_wake_wait_in_the_inbox(tmp_path):
    scripts = {
        "r2": {"wake_ticks": [1, 2], "say": {"0": ["a"], "1": ["b"], "2": ["c"]}},
        "r3": {"wake_ticks": [9]},
    }
    run = course(scripted(scripts, [(0, 0), (5, 0)]), tmp_path)
    assert run.logs("r3")[9].heard == (("r2", 0, "a"), ("r2", 1, "b"), ("r2", 2, "c"))


def test_a_full_inbox_keeps_the_newest(tmp_path):
    radio = RadioSection((Range(50.0),), inbox_frames=3)
    run = course(
        scripted({"r2": TALK, "r3": {"wake_ticks": [20]}}, [(0, 0), (5, 0)], radio=radio), tmp_path, 20
    )
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
    assert run.grants("r2") == {0: "start", 4: "arrival"}
    assert run.logs("r2")[4].x_m == 6.0
    assert run.grants("r3") == {0: "start"}


def test_who_is_already_there_arrives_at_once_and_once(tmp_path):
    run = course(scripted({"r2": {"go": {"0": [1, 0, 3]}, "wake_on": WAKE_ON_ARRIVAL}}, [(0, 0)]), tmp_path)
    assert run.grants("r2") == {0: "start", 1: "arrival"}


def test_a_body_coming_into_sight_and_leaving_it_wakes_who_watches(tmp_path):
    scripts = {"r2": {"wake_on": WAKE_ON_SENSOR}, "r3": {"go": {"0": [-30, 0, 0]}}}
    robots = Robots("tests.scripted:Scripted", 2, sensor_range_m=10.0)
    tower = TowerSection(behaviour="swarm_agent.behaviours.stand_still:StandStill", x_m=500.0)
    given_scenario = scripted(scripts, [(0, 0), (30, 0)], robots=robots, tower=tower, duration_s=60.0)
    run = course(given_scenario, tmp_path)
    woken = run.logs("r2")
    assert [log.in_sight for log in woken.values()] == [(), ("r3",), ()]
    seen_at = {tick: abs(run.positions(2)[tick - 1][0]) for tick in list(woken)[1:]}
    first, last = seen_at
    assert seen_at[first] <= 10 < abs(run.positions(2)[first - 2][0])
    assert seen_at[last] > 10 >= abs(run.positions(2)[last - 2][0])


def test_a_body_that_comes_to_rest_in_sight_is_seen_at_once(tmp_path):
    scripts = {"r2": {"wake_on": WAKE_ON_SENSOR}, "r3": {"go": {"0": [9, 0, 0]}}}
    robots = Robots("tests.scripted:Scripted", 2, sensor_range_m=10.0, max_speed_m_s=30.0, max_turn_rad_s=4.0)
    tower = TowerSection(behaviour="swarm_agent.behaviours.stand_still:StandStill", x_m=500.0)
    run = course(scripted(scripts, [(0, 0), (30, 0)], robots=robots, tower=tower), tmp_path)
    assert run.grants("r2") == {0: "start", 1: "sensor"}
