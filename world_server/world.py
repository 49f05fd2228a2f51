"""The world: one tick is act, settle, talk, sense; the only state that is true.

Pure: it is given accepted actions and faults, and answers with percepts and commits. Who talks to the nodes,
and how, is the business of the clock and its swarm.
"""

from collections.abc import Mapping

import numpy as np

from wire import channels, codec
from wire.messages import (
    BEFALLS,
    Action,
    Configuration,
    Facts,
    Fault,
    Frame,
    Percept,
    Pose,
    Senses,
    Sighting,
    Why,
)
from wire.scenario import Scenario
from world_server import chance, radio
from world_server.area import Area
from world_server.mission import Mission
from world_server.nodes import ALIVE, FROZEN, STATES, Letter, Node
from world_server.polyline import LinePatrol
from world_server.records import Commit, FrameRef, Grant
from world_server.sensing import sightings


class World:
    """All bodies, their inboxes, and the rules between them."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.names = scenario.node_ids
        self._mission = _mission(scenario)
        poses = self._mission.first_poses()
        self.nodes = {name: self._make(name, pose) for name, pose in poses.items()}
        self._rows = list(self.nodes.values())
        self._row_of = {name: row for row, name in enumerate(self.names)}
        self._radio = radio.for_scenario(scenario)
        self._refs: dict[str, tuple[FrameRef, ...]] = {}
        self.oversize: dict[str, int] = {}
        """How many frames the radio refused for the byte limit in the last commit, by sender."""
        self._sensor_ranges_m = np.array([node.sensor_range_m for node in self._rows])
        self._poses: np.ndarray | None = None
        self._apart_m: np.ndarray | None = None
        self._mission.begin(self._rows)

    def poses(self) -> np.ndarray:
        """x_m, y_m, heading_rad of every node: float64, (nodes, 3)."""
        if self._poses is None:
            bodies = [node.body for node in self._rows]
            self._poses = np.array([(one.x_m, one.y_m, one.heading_rad) for one in bodies], dtype="<f8")
        return self._poses

    def percepts(self, tick: int) -> dict[str, Percept]:
        """Grants for every node that is due at `tick`, in order of their numbers."""
        self._refs = {}
        watched = self._watched()
        reasons: dict[int, Why] = {}
        for row, node in enumerate(self._rows):
            if (why := node.due(tick, watched.get(row))) is not None:
                reasons[row] = why
        in_sight, shared = self._in_sight(list(reasons)), self._mission.last_visits(tick)
        return {
            self.names[row]: self._percept(tick, row, why, in_sight[row], shared)
            for row, why in reasons.items()
        }

    def commit(
        self,
        tick: int,
        percepts: Mapping[str, Percept],
        actions: Mapping[str, Action],
        faults: tuple[Fault, ...],
    ) -> Commit:
        """Settle one tick: act, settle, talk. Who was granted and has no action died unheard."""
        answered = [name for name in percepts if name in actions]
        visits = self._mission.visits(tick)
        grants = tuple([self._grant(name, percepts[name]) for name in answered])
        for name in answered:
            node, action = self.nodes[name], actions[name]
            node.seen = _names(percepts[name].senses.in_sight)
            node.answered(tick, action)
            self._mission.acted(self._row_of[name], action)
        more_visits, incidents = self._mission.settle(tick)
        self._poses = self._apart_m = None
        outboxes = {self._row_of[name]: actions[name].outbox for name in answered if actions[name].outbox}
        deliveries, tally = self._talk(tick, outboxes)
        facts = Facts(
            tick,
            self.poses().tobytes(),
            self._goals().tobytes(),
            bytes([node.mode for node in self._rows]),
            _links(deliveries),
            visits + more_visits,
            tuple([(name, actions[name].report) for name in answered if actions[name].report]),
            faults,
            tally,
            self._mission.volts(),
            incidents,
            self._mission.judged(tick),
        )
        return Commit(tick, grants, tuple(actions[name] for name in answered), _columns(deliveries), facts)

    def apply(self, fault: Fault) -> None:
        """A fault that has really happened to a node's process happens to the node."""
        node = self.nodes[fault.node]
        match fault.verb:
            case "kill":
                node.die()
            case "freeze":
                node.mode = FROZEN
            case "thaw":
                node.thaw()
            case "slow":
                node.every = fault.every
            case "restart":
                node.rise(fault.tick, fault.memory == "kept")
                self._mission.restarted(self._row_of[fault.node], fault.place == "queue")
                self._poses = self._apart_m = None

    def can(self, fault: Fault) -> str:
        """Why a fault cannot befall a node now, in words; empty when it can."""
        verb, name = fault.verb, fault.node
        if name not in self.nodes:
            return f"there is no node {name}; nodes are {', '.join(self.names)}"
        state = STATES[self.nodes[name].mode]
        if state not in BEFALLS[verb]:
            return f"cannot {verb} {name}: it is {state}"
        if fault.place == "queue" and (self.scenario.mission != "line" or name == self.scenario.tower.id):
            return f"cannot {verb} {name} in the queue: only robots of a line patrol have a place there"
        return ""

    @property
    def ends_tick(self) -> int | None:
        """The tick at which the mission ends, where it ends before its time."""
        return self._mission.ends_tick

    @property
    def cleared_share(self) -> float:
        """How much of a floor plan is clear, in the eyes of the referee."""
        return self._mission.cleared_share

    def middle_in_role(self, role: str) -> str | None:
        """Of the living robots of the main line that last reported this role, the middle one by number."""
        found = self._mission.in_role(role)
        return found[len(found) // 2] if found else None

    def next_tick(self, tick: int) -> int | None:
        """The next tick at which anything can happen, or None when nothing ever will by itself."""
        if self._mission.restless or not all(node.body.at_rest for node in self._rows):
            return tick + 1
        if any(seen != self._rows[row].seen for row, seen in self._watched().items()):
            return tick + 1
        due = [one for one in (node.next_due(tick) for node in self._rows) if one is not None]
        newborn = any(node.newborn and node.mode == ALIVE for node in self._rows)
        return tick + 1 if newborn else min(due, default=None)

    def _make(self, name: str, pose: Pose) -> Node:
        sensor_range_m = self._mission.sensor_range_m if name != self.scenario.tower.id else 0.0
        return Node(name, self._mission.body(name, pose), sensor_range_m, self.scenario.radio.inbox_frames)

    def _percept(
        self, tick: int, row: int, why: Why, in_sight: tuple[Sighting, ...], shared: bytes
    ) -> Percept:
        node, letters = self._rows[row], self._rows[row].heard(tick)
        body, volts = node.body, self._mission.battery_v(row)
        senses = Senses(
            body.pose,
            in_sight,
            volts,
            node.refused_frames,
            body.arrived,
            body.travelled_m,
            node.blocked_by,
            b"" if node.name == self.scenario.tower.id else shared,
        )
        senses = self._mission.sensed(tick, row, senses, letters)
        self._refs[node.name] = tuple([letter.reference for letter in letters])
        inbox = tuple([letter.frame for letter in letters])
        configuration = self._configuration(node) if why == "start" else None
        return Percept(tick, node.grants, why, senses, inbox, configuration)

    def _configuration(self, node: Node) -> Configuration:
        scenario = self.scenario
        is_tower = node.name == scenario.tower.id
        section = scenario.tower if is_tower else scenario.robots
        key = chance.key_of(scenario.seed, "node", channels.number_of(node.name), node.incarnation)
        return Configuration(
            node.name,
            node.incarnation,
            section.behaviour,
            codec.encode(section.parameters),
            key,
            scenario.tick_s,
            scenario.tower.id,
            self._mission.told,
            0.0 if is_tower else scenario.robots.max_speed_m_s,
            self._mission.tower_m,
            0 if is_tower else scenario.robot_ids.index(node.name),
            scenario.robots.body_m,
        )

    def _grant(self, name: str, percept: Percept) -> Grant:
        """The percept as the journal keeps it: with references in place of payloads."""
        return Grant(
            name, percept.grant, percept.why, percept.senses, self._refs[name], percept.configuration
        )

    def _watched(self) -> dict[int, tuple[str, ...]]:
        """What is in sight of those who want to be woken when it changes, by row."""
        watching = [row for row, node in enumerate(self._rows) if node.watches]
        return {row: _names(seen) for row, seen in self._in_sight(watching).items()}

    def _in_sight(self, rows: list[int]) -> dict[int, tuple[Sighting, ...]]:
        """The bodies in sight of the nodes in these rows."""
        if not rows:
            return {}
        return sightings(self.names, self.poses()[:, :2], self._distances_m(), self._sensor_ranges_m, rows)

    def _distances_m(self) -> np.ndarray:
        """All distances between bodies, (nodes, nodes), measured when they are first asked for in a tick."""
        if self._apart_m is None:
            self._apart_m = radio.distances_m(self.poses()[:, :2])
        return self._apart_m

    def _talk(
        self, tick: int, outboxes: dict[int, tuple[bytes, ...]]
    ) -> tuple[radio.Deliveries, radio.Tally]:
        """The radio judges on settled positions; who is dead or without charge neither speaks nor hears."""
        silent = [row for row, node in enumerate(self._rows) if node.silent]
        for row in silent:
            outboxes.pop(row, None)
        self.oversize = {}
        if not outboxes:
            return radio.NOTHING
        deliveries, refused, tally = self._radio.transmit(tick, outboxes, self._distances_m(), silent)
        for row, count in refused.items():
            self._rows[row].refused_frames = count
        self.oversize = {self.names[row]: count for row, count in refused.items()}
        letters: dict[tuple[int, int, int], Letter] = {}
        columns = zip(*(column.tolist() for column in deliveries), strict=True)
        for sender, index, receiver, heard_tick in columns:
            letter = letters.get((sender, index, heard_tick))
            if letter is None:
                name, payload = self.names[sender], outboxes[sender][index]
                frame, reference = Frame(name, tick, payload), FrameRef(name, tick, index)
                letter = Letter(heard_tick, tick, sender, index, frame, reference)
                letters[sender, index, heard_tick] = letter
            self._rows[receiver].deliver(self._mission.addressed(letter, receiver))
        return deliveries, tally

    def _goals(self) -> np.ndarray:
        """Where each body is heading, NaN for nowhere: float64, (nodes, 2)."""
        goals = [node.body.goal for node in self._rows]
        nowhere = (np.nan, np.nan)
        return np.array([nowhere if one is None else (one.x_m, one.y_m) for one in goals], dtype="<f8")


def _mission(scenario: Scenario) -> Mission:
    if scenario.mission == "clear":
        from world_server.clear import Clear  # polygons take a while to import, and others do without

        return Clear(scenario)
    return LinePatrol(scenario) if scenario.mission == "line" else Area(scenario)


def _names(seen: tuple[Sighting, ...]) -> tuple[str, ...]:
    return tuple(one.node for one in seen)


def _links(deliveries: radio.Deliveries) -> bytes:
    """The deliveries as Facts keep them."""
    if not len(deliveries.senders):
        return b""
    return np.stack([deliveries.senders, deliveries.receivers], axis=1).astype("<u2").tobytes()


def _columns(deliveries: radio.Deliveries) -> tuple[bytes, ...]:
    """The deliveries as Commit keeps them."""
    if not len(deliveries.senders):
        return (b"",) * 4
    types = ("<u2", "<u2", "<u2", "<u4")
    return tuple(column.astype(kind).tobytes() for column, kind in zip(deliveries, types, strict=True))
