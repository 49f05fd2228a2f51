"""The world: one tick is act, settle, talk, sense; the only state that is true.

Pure: it is given accepted actions and faults, and answers with percepts and commits. Who talks to the nodes,
and how, is the business of the clock and its swarm.
"""

from collections.abc import Mapping

import numpy as np

from wire import channels, codec
from wire.messages import BEFALLS, Action, Configuration, Facts, Fault, Frame, Percept, Pose, Senses, Sighting
from wire.scenario import Scenario
from world_server import chance, radio
from world_server.cells import Sites
from world_server.motion import Body, first_poses
from world_server.nodes import ALIVE, DEAD, FROZEN, Letter, Node
from world_server.records import Commit, FrameRef, Grant
from world_server.sensing import sightings


class World:
    """All bodies, their inboxes, and the rules between them."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.names = scenario.node_ids
        self.nodes = {name: self._make(name, pose) for name, pose in first_poses(scenario).items()}
        self._rows = list(self.nodes.values())
        self._row_of = {name: row for row, name in enumerate(self.names)}
        self._radio = radio.for_scenario(scenario)
        self._sites = Sites(scenario.field)
        self._refs: dict[str, tuple[FrameRef, ...]] = {}
        self.oversize: dict[str, int] = {}
        """How many frames the radio refused for the byte limit in the last commit, by sender."""
        self._sensor_ranges_m = np.array([node.sensor_range_m for node in self._rows])
        self._measure()

    def poses(self) -> np.ndarray:
        """x_m, y_m, heading_rad of every node: float64, (nodes, 3)."""
        return np.array(
            [(node.body.x_m, node.body.y_m, node.body.heading_rad) for node in self._rows], dtype="<f8"
        )

    def percepts(self, tick: int) -> dict[str, Percept]:
        """Grants for every node that is due at `tick`, in order of their numbers."""
        self._refs = {}
        granted = {}
        for row, node in enumerate(self._rows):
            seen = _names(self._in_sight[row]) if node.watches else None
            why = node.due(tick, seen)
            if why is not None:
                granted[node.name] = self._percept(tick, row, why)
        return granted

    def commit(
        self,
        tick: int,
        percepts: Mapping[str, Percept],
        actions: Mapping[str, Action],
        faults: tuple[Fault, ...],
    ) -> Commit:
        """Settle one tick: act, settle, talk. Who was granted and has no action died unheard."""
        answered = [name for name in percepts if name in actions]
        visits = self._visits()
        for name, _ in visits:
            self.nodes[name].on_patrol = False
        grants = tuple(self._grant(name, percepts[name]) for name in answered)
        for name in answered:
            self.nodes[name].seen = _names(percepts[name].senses.in_sight)
            self.nodes[name].answered(tick, actions[name])
        self._settle()
        outboxes = {self._row_of[name]: actions[name].outbox for name in answered if actions[name].outbox}
        deliveries, tally = self._talk(tick, outboxes)
        reports = tuple((name, actions[name].report) for name in answered if actions[name].report)
        facts = Facts(
            tick,
            self.poses().tobytes(),
            self._goals().tobytes(),
            bytes(node.mode for node in self._rows),
            np.stack([deliveries.senders, deliveries.receivers], axis=1).astype("<u2").tobytes(),
            visits,
            reports,
            faults,
            tally,
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
                node.mode = ALIVE
            case "restart":
                node.rise(fault.tick, fault.memory == "kept")

    def can(self, verb: str, name: str) -> str:
        """Why a fault cannot befall a node now, in words; empty when it can."""
        if name not in self.nodes:
            return f"there is no node {name}; nodes are {', '.join(self.names)}"
        state = ("alive", "frozen", "dead")[self.nodes[name].mode]
        return "" if state in BEFALLS[verb] else f"cannot {verb} {name}: it is {state}"

    def next_tick(self, tick: int) -> int | None:
        """The next tick at which anything can happen, or None when nothing ever will by itself."""
        if not all(node.body.at_rest for node in self._rows):
            return tick + 1
        if any(
            node.watches and _names(self._in_sight[row]) != node.seen for row, node in enumerate(self._rows)
        ):
            return tick + 1
        if self._visits():
            return tick + 1
        due = [one for one in (node.next_due(tick) for node in self._rows) if one is not None]
        newborn = any(node.newborn and node.mode == ALIVE for node in self._rows)
        return tick + 1 if newborn else min(due, default=None)

    def _visits(self) -> tuple[tuple[str, int], ...]:
        """(node, site) of every patrol that is complete on the present positions."""
        on_patrol = {node.name: node.body for node in self._rows if node.mode == ALIVE and node.on_patrol}
        return self._sites.visits(on_patrol)

    def _make(self, name: str, pose: Pose) -> Node:
        scenario, moves = self.scenario, name != self.scenario.tower.id
        speed = scenario.robots.max_speed_m_s if moves else 0.0
        turn = scenario.robots.max_turn_rad_s if moves else 0.0
        sensor_range_m = scenario.robots.sensor_range_m if moves else 0.0
        return Node(name, Body(pose, speed, turn), sensor_range_m, scenario.radio.inbox_frames)

    def _percept(self, tick: int, row: int, why: str) -> Percept:
        node, letters = self._rows[row], self._rows[row].heard(tick)
        senses = Senses(node.body.pose, self._in_sight[row], None, node.refused_frames)
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
            scenario.field,
            0.0 if is_tower else scenario.robots.max_speed_m_s,
        )

    def _grant(self, name: str, percept: Percept) -> Grant:
        """The percept as the journal keeps it: with references in place of payloads."""
        return Grant(
            name, percept.grant, percept.why, percept.senses, self._refs[name], percept.configuration
        )

    def _measure(self) -> None:
        positions_m = self.poses()[:, :2]
        self._apart_m = radio.distances_m(positions_m)
        self._in_sight = sightings(self.names, positions_m, self._apart_m, self._sensor_ranges_m)

    def _settle(self) -> None:
        for node in self._rows:
            arrived = node.body.arrived
            node.body.advance(self.scenario.tick_s)
            if node.body.arrived and not arrived:
                node.arrival_pending = True
        self._measure()

    def _talk(
        self, tick: int, outboxes: Mapping[int, tuple[bytes, ...]]
    ) -> tuple[radio.Deliveries, radio.Tally]:
        """The radio judges on settled positions; the dead neither speak nor hear."""
        deaf = [row for row, node in enumerate(self._rows) if node.mode == DEAD]
        deliveries, refused, tally = self._radio.transmit(tick, outboxes, self._apart_m, deaf)
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
            self._rows[receiver].deliver(letter)
        return deliveries, tally

    def _goals(self) -> np.ndarray:
        """Where each body is heading, NaN for nowhere: float64, (nodes, 2)."""
        goals = [node.body.goal for node in self._rows]
        nowhere = (np.nan, np.nan)
        return np.array([nowhere if one is None else (one.x_m, one.y_m) for one in goals], dtype="<f8")


def _names(seen: tuple[Sighting, ...]) -> tuple[str, ...]:
    return tuple(one.node for one in seen)


def _columns(deliveries: radio.Deliveries) -> tuple[bytes, ...]:
    """The deliveries as Commit keeps them."""
    types = ("<u2", "<u2", "<u2", "<u4")
    return tuple(column.astype(kind).tobytes() for column, kind in zip(deliveries, types, strict=True))
