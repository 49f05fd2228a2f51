"""An independent judge of a run: integrates, delivers and visits anew from what was journalled.

It shares no code with the world's motion, radio, inboxes or visits, and works in plain numbers, one pair of
nodes after the other. Only the draws of the loss rule are taken from the world's generator: a matrix
(frames, nodes) keyed by "loss", the sender's number, the tick and the rule's place in the list; a frame is
lost where its draw is smaller than the probability. Whatever differs is an AssertionError that names the tick
and the node.
"""

import math
import struct
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from wire.channels import number_of
from wire.messages import WAKE_ON_FRAME, Action, Fault, GoTo, Stay
from wire.scenario import Latency, Loss, Partition, Range, Scenario
from world_server.chance import generator
from world_server.journal import read
from world_server.records import Commit, Grant, Header

NEAR = 1e-9
ALIVE, FROZEN, DEAD = 0, 1, 2


class Mail(NamedTuple):
    """A frame on its way, in the order in which it is heard."""

    heard_tick: int
    sent_tick: int
    sender: int
    index: int


class Robot:
    """A node as the oracle knows it."""

    def __init__(self, name: str, pose: tuple[float, float, float]) -> None:
        self.name = name
        self.x, self.y, self.heading = pose
        self.goal: GoTo | None = None
        self.errand: GoTo | None = None
        """The goal it died with, which a mind with its memory kept still has."""
        self.sent = False
        """Was it told to move since its last visit?"""
        self.mode = ALIVE
        self.newborn = True
        self.mail: list[Mail] = []
        self.wake_tick: int | None = None
        self.wake_on = 0

    def due(self, tick: int) -> bool:
        """Must it be granted this tick? Arrivals and sensors, which nobody here waits for, left aside."""
        by_frame = bool(self.wake_on & WAKE_ON_FRAME) and any(one.heard_tick <= tick for one in self.mail)
        by_time = self.wake_tick is not None and self.wake_tick <= tick
        return self.mode == ALIVE and (self.newborn or by_time or by_frame)

    def drive(self, speed: float, turn: float, tick_s: float) -> None:
        """Turn to the goal as far as a tick allows; once it is ahead, go as far as a tick allows."""
        if self.goal is None or speed == 0:
            return
        ahead_x, ahead_y = self.goal.x_m - self.x, self.goal.y_m - self.y
        if (away := math.sqrt(ahead_x * ahead_x + ahead_y * ahead_y)) == 0:
            return
        bearing = math.atan2(ahead_y, ahead_x)
        error = math.remainder(bearing - self.heading, math.tau)
        if abs(error) > turn * tick_s:
            self.heading = math.remainder(self.heading + math.copysign(turn * tick_s, error), math.tau)
            return
        self.heading = bearing
        share = min(1.0, speed * tick_s / away)
        whole = share == 1.0
        self.x = self.goal.x_m if whole else self.x + ahead_x * share
        self.y = self.goal.y_m if whole else self.y + ahead_y * share


class Oracle:
    """Follows a journal, commit by commit. `counts`: what was checked and why frames were not delivered."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.counts: Counter = Counter()
        self._team: list[Robot] = []
        self._tick = -1

    def check(self, journal: Path) -> Counter:
        """Judge a whole run. Raises AssertionError at the first thing that differs."""
        for record in read(journal):
            if isinstance(record, Header):
                poses = struct.iter_unpack("<3d", record.first_poses)
                self._team = [Robot(name, pose) for name, pose in zip(record.nodes, poses, strict=True)]
            elif isinstance(record, Commit):
                self._commit(record)
        return self.counts

    def _commit(self, commit: Commit) -> None:
        tick, facts = commit.tick, commit.facts
        self._check_gap(tick)
        for fault in facts.faults:
            self._befall(fault)
        visits = self._visits()
        self._same(tick, "visits", list(facts.visits), visits)
        for node, _ in visits:
            self._robot(node).sent = False
        self.counts["visits"] += len(visits)
        due = [robot.name for robot in self._team if robot.due(tick)]
        self._same(tick, "who is granted", [grant.node for grant in commit.grants], due)
        for grant, action in zip(commit.grants, commit.actions, strict=True):
            self._check_grant(tick, grant)
            self._take(action, self._robot(grant.node))
        for robot in self._team:
            moves = robot.name != self.scenario.tower.id
            robots = self.scenario.robots
            robot.drive(robots.max_speed_m_s if moves else 0.0, robots.max_turn_rad_s, self.scenario.tick_s)
        self._check_poses(tick, facts.poses)
        self._same(tick, "modes", list(facts.modes), [robot.mode for robot in self._team])
        outboxes = {
            grant.node: action.outbox for grant, action in zip(commit.grants, commit.actions, strict=True)
        }
        self._check_deliveries(commit, self._deliveries(tick, outboxes))
        self._tick = tick

    def _check_gap(self, tick: int) -> None:
        """Ticks without a commit are those in which nobody moved and nobody was due."""
        for missed in range(self._tick + 1, tick):
            resting = all(
                one.goal is None or (one.goal.x_m, one.goal.y_m) == (one.x, one.y) for one in self._team
            )
            nothing = resting and not self._visits() and not any(robot.due(missed) for robot in self._team)
            assert nothing, f"tick {missed} was left out"

    def _befall(self, fault: Fault) -> None:
        robot = self._robot(fault.node)
        robot.mode = {"kill": DEAD, "freeze": FROZEN, "thaw": ALIVE, "restart": ALIVE}[fault.verb]
        if fault.verb == "kill":
            robot.goal, robot.errand = None, robot.goal
            robot.mail, robot.wake_tick, robot.wake_on = [], None, 0
        elif fault.verb == "restart":
            robot.wake_tick, robot.newborn = fault.tick, robot.newborn or fault.memory == "lost"
            robot.goal = robot.errand if fault.memory == "kept" else None
        self.counts[fault.verb] += 1

    def _visits(self) -> list[tuple[str, int]]:
        """Who is for the first time within reach of the site it was sent to; only the living count."""
        sites, within = self.scenario.field.sites_m(), self.scenario.field.visit_within_m
        found = []
        for robot in self._team:
            if robot.mode == ALIVE and robot.goal is not None and robot.sent:
                for site, (x, y) in enumerate(sites):
                    own = (robot.goal.x_m, robot.goal.y_m) == (x, y)
                    if own and math.sqrt((x - robot.x) ** 2 + (y - robot.y) ** 2) <= within:
                        found.append((robot.name, site))
        return found

    def _check_grant(self, tick: int, grant: Grant) -> None:
        robot = self._robot(grant.node)
        pose = grant.senses.pose
        self._near(tick, grant.node, (pose.x_m, pose.y_m, pose.heading_rad), robot)
        heard = sorted(one for one in robot.mail if one.heard_tick <= tick)
        expected = [(self._team[one.sender].name, one.sent_tick, one.index) for one in heard]
        told = [(one.sender, one.sent_tick, one.index) for one in grant.inbox]
        self._same(tick, f"what {grant.node} hears", told, expected)
        robot.mail = [one for one in robot.mail if one.heard_tick > tick]
        assert (grant.configuration is not None) == robot.newborn, f"tick {tick}, {grant.node}: configuration"
        robot.newborn = False
        self.counts["heard"] += len(heard)

    @staticmethod
    def _take(action: Action, robot: Robot) -> None:
        if action.motion is not None:
            robot.goal = None if isinstance(action.motion, Stay) else action.motion
            robot.sent = True
        robot.wake_tick, robot.wake_on = action.wake_tick, action.wake_on

    def _deliveries(
        self, tick: int, outboxes: dict[str, tuple[bytes, ...]]
    ) -> list[tuple[int, int, int, int]]:
        """(sender row, place in the outbox, receiver row, tick at which it is heard), sender by sender."""
        through = []
        for row, sender in enumerate(self._team):
            spent = 0
            for index, frame in enumerate(outboxes.get(sender.name, ())):
                spent += len(frame)
                if spent > self.scenario.radio.bytes_per_tick:
                    self.counts["oversize"] += len(outboxes[sender.name]) - index
                    break
                self.counts["sent"] += 1
                for other, receiver in enumerate(self._team):
                    if other != row and receiver.mode != DEAD:
                        delay = self._delay(tick, index, row, other)
                        through += [(row, index, other, tick + delay)] if delay else []
        for row, index, other, heard_tick in through:
            self._team[other].mail.append(Mail(heard_tick, tick, row, index))
            assert len(self._team[other].mail) <= self.scenario.radio.inbox_frames, (
                "this oracle has no full inboxes"
            )
        return through

    def _delay(self, tick: int, index: int, row: int, other: int) -> int:
        """Ticks until a frame is heard, 0 for never: the first rule that does not let it pass decides."""
        for place, rule in enumerate(self.scenario.radio.rules):
            match rule:
                case Range(range_m=range_m) if self._apart(row, other) > range_m:
                    self.counts["out of range"] += 1
                    return 0
                case Loss(probability=probability):
                    draws = generator(
                        self.scenario.seed, "loss", number_of(self._team[row].name), tick, place
                    )
                    if draws.random((index + 1, len(self._team)))[index, other] < probability:
                        self.counts["lost by chance"] += 1
                        return 0
                case Partition() if self._parted(rule, tick, row, other):
                    self.counts["lost by partition"] += 1
                    return 0
                case Latency(ticks=ticks):
                    return ticks
        return 1

    def _apart(self, row: int, other: int) -> float:
        one, two = self._team[row], self._team[other]
        return math.sqrt((one.x - two.x) ** 2 + (one.y - two.y) ** 2)

    def _parted(self, rule: Partition, tick: int, row: int, other: int) -> bool:
        now = tick * self.scenario.tick_s
        if now < rule.from_s or (rule.until_s is not None and now >= rule.until_s):
            return False
        groups = [
            {number for number, group in enumerate(rule.groups) if self._team[one].name in group}
            for one in (row, other)
        ]
        return groups[0] != groups[1]

    def _check_deliveries(self, commit: Commit, expected: list[tuple[int, int, int, int]]) -> None:
        senders, frames, receivers = (
            [number for (number,) in struct.iter_unpack("<H", column)] for column in commit.deliveries[:3]
        )
        heard = [number for (number,) in struct.iter_unpack("<I", commit.deliveries[3])]
        journalled = list(zip(senders, frames, receivers, heard, strict=True))
        self._same(commit.tick, "deliveries", journalled, expected)
        links = list(struct.iter_unpack("<HH", commit.facts.links))
        self._same(commit.tick, "links", links, [(one[0], one[2]) for one in expected])
        self.counts["delivered"] += len(expected)

    def _check_poses(self, tick: int, poses: bytes) -> None:
        for robot, pose in zip(self._team, struct.iter_unpack("<3d", poses), strict=True):
            self._near(tick, robot.name, pose, robot)

    @staticmethod
    def _near(tick: int, node: str, pose: tuple[float, ...], robot: Robot) -> None:
        off = max(
            abs(pose[0] - robot.x),
            abs(pose[1] - robot.y),
            abs(math.remainder(pose[2] - robot.heading, math.tau)),
        )
        own = (robot.x, robot.y, robot.heading)
        assert off <= NEAR, f"tick {tick}, {node}: the world says {pose}, the oracle {own}"

    @staticmethod
    def _same(tick: int, what: str, journalled: list, expected: list) -> None:
        missing = [one for one in expected if one not in journalled]
        extra = [one for one in journalled if one not in expected]
        assert journalled == expected, f"tick {tick}: {what}: missing {missing}, not due {extra}"

    def _robot(self, node: str) -> Robot:
        return next(robot for robot in self._team if robot.name == node)
