"""The captain of the main line, its right leader: what to do when the line cannot go on.

First the line steps back until one robot is free, and bends forward at one robot after the other in search of
an obstacle. If there is none, it stands, and another line takes over; if none can, all that is clear is given
up and the team begins again elsewhere. A line that is to split, and has nobody to come beside its pivot,
steps back so that its own robots can.
"""

from swarm_agent.sweep.events import strike_out
from swarm_agent.sweep.radio import BARRIER, GO_BACK, GO_HOME, GO_ON, WALL
from swarm_agent.sweep.robot import Robot

FIRST_PLACE = 2
SLOWLY_TICKS, YIELD_TICKS, ORDER_TICKS, PUSH_TICKS, HOME_TICKS = 30, 100, 400, 200, 1500
ROUNDS, HITS = 2, 3  # so often a search is begun again, with nothing found, or without a split that follows


class Captain:
    """What it has ordered, and when."""

    def __init__(self) -> None:
        self._order_tick = self._main_tick = self._complete_tick = self._rounds = 0
        self._robots = self._hits = self._since = 0
        self._has_yielded = False
        """Has the line stepped back for its pivot?"""

    def command(self, robot: Robot) -> str:
        """Order what is to be done. Returns why the team must begin again, or nothing."""
        if not robot.is_main or not robot.is_whole or robot.beside["left"] == WALL:
            robot.order, self._main_tick = GO_ON, robot.tick
            return ""
        if robot.since != self._since:
            self._begin(robot)
        self._measure(robot)
        told = robot.told["left"]
        if robot.order == GO_ON:
            return self._search(robot) if self._is_stuck(robot) else ""
        for_ticks = robot.tick - self._order_tick
        still = min(robot.tick - robot.last_moved(), for_ticks) > self._settled(robot)
        if told.pinned and robot.order == GO_BACK and not told.halt:
            return self._fail(robot) if still or for_ticks > ORDER_TICKS else ""
        if told.pinned or told.halt:
            self._order_tick = robot.tick
            if told.pinned and robot.order >= FIRST_PLACE:
                self._rounds = 0
                self._hits += 1
                self._give(robot, GO_ON)
            return ""
        if robot.order == GO_HOME:
            return self._come_home(robot, for_ticks)
        if robot.order == GO_BACK:
            if self._has_slack(robot) or for_ticks > ORDER_TICKS:
                self._give(robot, FIRST_PLACE)
            elif still:
                return self._fail(robot)
        elif told.taut == robot.order or for_ticks > PUSH_TICKS:
            if robot.order < robot.count - 1:
                self._give(robot, robot.order + 1)
            else:
                return self._search(robot)
        return ""

    def _begin(self, robot: Robot) -> None:
        """Of a line that has just split or merged: what it had ordered before is no more."""
        self._since, self._hits, self._has_yielded = robot.since, 0, False
        self._main_tick = robot.tick
        if robot.order == GO_BACK:
            self._give(robot, GO_ON)

    def _give(self, robot: Robot, order: int) -> None:
        robot.order, self._order_tick = order, robot.tick

    def _measure(self, robot: Robot) -> None:
        """Tell the graph how many robots the line has, once that has been so for a while.

        Not while somebody else of the line is about to write into it: of two at once one would be lost.
        """
        if robot.told["left"].pinned or robot.told["left"].meets:
            return
        strike_out(robot)
        if robot.count != self._robots and robot.is_quiet:
            self._robots = robot.count
            robot.graph.measure(robot.count)

    def _settled(self, robot: Robot) -> int:
        return (2 * robot.count + SLOWLY_TICKS) * robot.parameters.hop_ticks

    def _is_stuck(self, robot: Robot) -> bool:
        """Has nobody moved for so long that nobody will: sooner where nobody else is to come?"""
        if not robot.is_quiet:
            return False
        told = robot.told["left"]
        spare = told.spare + robot.flows["right"].spare if robot.flows["right"] else told.spare
        others = sum(edge.robots for edge in robot.graph.lines().values())
        coming = robot.team - robot.count - spare - others
        self._complete_tick = 0 if coming > 0 else self._complete_tick or robot.tick
        wait = self._settled(robot)
        if spare:
            wait += 2 * ORDER_TICKS
        elif told.pinned:
            wait += YIELD_TICKS
        if coming > 0:
            wait = robot.parameters.patience_ticks
        return robot.tick - max(robot.last_moved(), self._main_tick, self._complete_tick) > wait

    def _has_slack(self, robot: Robot) -> bool:
        """Could the robot beside the captain leave the line?"""
        beside = robot.neighbour("left")
        beyond = robot.peer(beside.beacon.left) if beside else None
        least_m = robot.parameters.follow_m - robot.parameters.slack_m / 2
        return beyond is not None and abs(beyond.here - robot.here) <= least_m

    def _search(self, robot: Robot) -> str:
        """Begin a round of searching, if there is anybody to search with and no round too many."""
        if robot.told["left"].pinned and not self._has_yielded:
            self._has_yielded = True
            self._give(robot, GO_BACK)
            return ""
        vain = self._rounds >= ROUNDS or self._hits > HITS
        if vain or robot.count < FIRST_PLACE + 1 or robot.told["left"].pinned:
            return self._fail(robot)
        self._rounds += 1
        if self._rounds == 1:
            robot.events.append("search")
        self._give(robot, GO_BACK)
        return ""

    def _fail(self, robot: Robot) -> str:
        """Nothing was found: back to where the line was shortest."""
        if self._rounds:
            robot.events.append("search_failed")
        self._rounds = 0
        self._give(robot, GO_HOME)
        return ""

    def _come_home(self, robot: Robot, for_ticks: int) -> str:
        """Once there, another line is to go on, or the team begins again, or gives up."""
        shortest = robot.graph.held(robot.graph.main.vertex)
        settled = robot.tick - robot.last_moved() > self._settled(robot)
        if robot.count > shortest and for_ticks < HOME_TICKS and not (settled and for_ticks > ORDER_TICKS):
            return ""
        self._give(robot, GO_ON)
        self._main_tick = robot.tick
        following = self._following(robot)
        if following is not None:
            held = sum(edge.robots for edge in robot.graph.lines().values())
            if lines := robot.graph.park(robot.team - held):
                robot.graph.activate(following)
                robot.line, robot.since = lines[0], robot.tick
                return ""
        if robot.epoch < robot.parameters.beginnings:
            return "no line can go on"
        robot.claim = "failed"
        return ""

    def _following(self, robot: Robot) -> int | None:
        """The newest standing line that would have as many robots as it is known to need.

        Who stood there in vain needs more than there were then: so each is tried once with so many. Without a
        robot to tell it, it must hear the captain.
        """
        near = {peer.beacon.line for peer in robot.peers.known.values() if peer.beacon.role in BARRIER}
        lines = robot.graph.lines()
        free = robot.team - robot.count - sum(edge.robots for edge in lines.values())
        for line in sorted(lines, reverse=True):
            robots = lines[line].robots + free
            told = free > 0 or line in near
            if told and robots >= robot.graph.vertex(robot.graph.ahead_of(line)).robots:
                return line
        return None
