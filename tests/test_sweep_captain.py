"""What the captain of a line that cannot go on orders, and for how long it waits before."""

from swarm_agent.sweep.captain import Captain
from swarm_agent.sweep.radio import GO_BACK, GO_HOME, GO_ON, WALL
from swarm_agent.sweep.robot import Robot
from tests.sweep_builders import a_robot, flow, meets, stands

PATIENCE_TICKS, AT_LAST_TICKS = 1000, 5000


def a_captain(team: int = 4, count: int = 2) -> Robot:
    """The right leader of a main line of so many robots, the others of its team not in sight."""
    robot = a_robot(number=9, team=team, patience_ticks=PATIENCE_TICKS)
    stands(robot, "leader", 8, WALL)
    meets(robot, 8, 1j, "centre" if count > 2 else "leader", right=9, left=7)
    if count > 2:
        meets(robot, 7, 1.1j, "leader", right=8)
    robot.told["left"] = flow(count=count - 1)
    robot.tick = 10
    return robot


def commands(robot: Robot, captain: Captain, ticks: int, **told) -> tuple[int, str]:
    """Let so many ticks go by with such news, until it says that the team must begin again: when, and why."""
    for _ in range(ticks):
        robot.tick += 1
        for peer in robot.peers.known.values():
            peer.tick = robot.tick - 1
        robot.told["left"] = flow(**({"count": robot.told["left"].count, "since": robot.tick - 2} | told))
        if trouble := captain.command(robot):
            return robot.tick, trouble
    return robot.tick, ""


def test_a_line_that_stands_waits_for_robots_that_are_still_to_come():
    robot, captain = a_captain(), Captain()
    _, trouble = commands(robot, captain, PATIENCE_TICKS - 20)
    assert not trouble and robot.order == 0
    _, trouble = commands(robot, captain, AT_LAST_TICKS)
    assert trouble


def test_a_line_that_waited_for_long_does_not_give_up_when_the_first_robots_come():
    """They have had no time yet to come in."""
    robot, captain = a_captain(), Captain()
    commands(robot, captain, PATIENCE_TICKS // 2)
    _, trouble = commands(robot, captain, 60, spare=2)
    assert not trouble and robot.order == 0
    _, trouble = commands(robot, captain, AT_LAST_TICKS, spare=2)
    assert trouble


def test_nothing_is_ordered_while_somebody_moves():
    robot, captain = a_captain(team=2), Captain()
    _, trouble = commands(robot, captain, 500, moved=2000)
    assert not trouble and robot.order == 0


def test_a_line_of_three_that_cannot_go_on_searches_first():
    """Source: specs of mission clear, 3.10: RETREAT, PROBE place after place, SEARCH_FAIL."""
    robot, captain = a_captain(team=3, count=3), Captain()
    orders: list[int] = []
    for _ in range(AT_LAST_TICKS):
        if robot.order < 0:
            meets(robot, 7, 0.9j, "leader", right=8)  # back so far that two would do
        _, trouble = commands(robot, captain, 1, taut=max(0, robot.order))
        if not orders or robot.order != orders[-1]:
            orders.append(robot.order)
        if trouble:
            break
    assert orders[:3] == [0, -1, 2], "back until one robot is free, then the one in the middle goes forward"
    assert "search" in robot.events and "search_failed" in robot.events
    assert trouble


def test_a_line_of_two_has_nobody_to_search_with():
    robot, captain = a_captain(team=2), Captain()
    _, trouble = commands(robot, captain, AT_LAST_TICKS)
    assert trouble and robot.events == []


def test_who_has_begun_again_often_enough_says_that_the_team_has_failed():
    """Source: specs of mission clear, 3.10: terminate FAILED when restarts have served."""
    robot, captain = a_captain(team=2), Captain()
    robot.epoch = robot.parameters.beginnings
    _, trouble = commands(robot, captain, AT_LAST_TICKS)
    assert not trouble and robot.claim == "failed"


def orders_of(robot: Robot, captain: Captain, **told) -> list[int]:
    """All that is ordered, one after the other, until the team must begin again."""
    orders: list[int] = []
    for _ in range(AT_LAST_TICKS):
        _, trouble = commands(robot, captain, 1, **told)
        if not orders or robot.order != orders[-1]:
            orders.append(robot.order)
        if trouble:
            break
    return orders


def test_a_line_that_is_to_split_steps_back_for_its_pivot_before_it_gives_up():
    """Nobody is to come: only the slack of the line itself can bring a second robot beside the pivot."""
    robot = a_captain(team=3, count=3)
    assert orders_of(robot, Captain(), pinned=True, pivot=True)[:3] == [GO_ON, GO_BACK, GO_HOME]


def test_a_line_that_has_split_goes_on_whatever_was_ordered_before():
    robot, captain = a_captain(team=3, count=3), Captain()
    while robot.order != GO_BACK:
        commands(robot, captain, 1, pinned=True, pivot=True)
    robot.since = robot.tick
    commands(robot, captain, 1)
    assert robot.order == GO_ON


def test_the_captain_writes_nothing_while_another_of_its_line_merges():
    """Both would write the same version; a merge was lost so, and a line stood in the graph that is none."""
    robot, captain = a_captain(count=3), Captain()
    commands(robot, captain, 50, meets=True)
    before = robot.graph.version
    commands(robot, captain, 50)
    assert before.events < robot.graph.version.events, "else it had nothing to write"
    assert robot.graph.main.widest == 3
