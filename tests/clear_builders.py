"""Builders for tests of mission clear: small plans, and scenarios of robots that wander about in them."""

import hashlib
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from swarm_agent.behaviour import settled_parameters
from swarm_agent.behaviours.sweep_line import SweepLine
from tests.builders import STILL, Course
from wire import codec
from wire.fields import FloorPlan, Point
from wire.messages import Facts
from wire.scenario import Cluster, Poses, RadioSection, Range, Robots, Scenario, Sensors, TowerSection
from world_server.journal import commits
from world_server.records import Commit, Grant

WANDERING = "tests.wandering_discs:Wandering"
BODY_M = 0.2
ELL: tuple[Point, ...] = ((0, 0), (6, 0), (6, 2), (2, 2), (2, 6), (0, 6))
"""Two corridors 2 m wide, at a right angle."""
BOX: tuple[Point, ...] = ((0, 0), (4, 0), (4, 3), (0, 3))


def clearing(
    robots: int = 4,
    rings_m: tuple[tuple[Point, ...], ...] = (ELL,),
    start: Cluster | Poses = Cluster(5.0, 1.0),
    behaviour: str = WANDERING,
    parameters: dict[str, Any] | None = None,
    turned_rad: float = 0.0,
    range_m: float = 2.0,
    **fields: Any,
) -> Scenario:
    """A complete scenario of mission clear, with a mute tower."""
    team = Robots(behaviour, robots, start=start, max_speed_m_s=0.2, body_m=BODY_M)
    told = {
        "duration_s": 40.0,
        "tick_s": 0.25,
        "tower": TowerSection(behaviour=STILL),
        "radio": RadioSection((Range(range_m),)),
        "sensors": Sensors(),
    } | fields
    field = FloorPlan(rings_m=rings_m, turned_rad=turned_rad)
    team = msgspec.structs.replace(team, parameters=parameters or {})
    return Scenario(mission="clear", field=field, robots=team, **told)


def sweeping(robots: int = 4, parameters: dict[str, Any] | None = None, **fields: Any) -> Scenario:
    """A scenario in which a sweep team clears a plan: from the dead end of ELL, unless told otherwise."""
    settled = settled_parameters(SweepLine, parameters or {}, robots + 1)
    told = {"start": Cluster(5.6, 0.4), "duration_s": 600.0} | fields
    return clearing(robots, behaviour="sweep_line", parameters=msgspec.to_builtins(settled), **told)


def percepts_hash(journal: Path) -> str:
    """A hash of all that robots were ever told."""
    told = hashlib.sha256()
    for grant in all_grants(journal):
        told.update(codec.encode((grant.node, grant.senses, grant.inbox, grant.configuration)))
    return told.hexdigest()


def all_grants(journal: Path) -> list[Grant]:
    """Every grant of a run, in order."""
    return [grant for one in commits(journal) for grant in one.grants]


def places_m(facts: Facts) -> np.ndarray:
    """Where nodes are at the end of a tick: float64, (nodes, 2)."""
    return np.frombuffer(facts.poses).reshape(-1, 3)[:, :2]


def fronts_rad(run: Course) -> np.ndarray:
    """The headings of all nodes at the end of a run."""
    return np.frombuffer(run.facts[-1].poses).reshape(-1, 3)[:, 2]


def all_commits(journal: Path) -> list[Commit]:
    """Every commit of a run."""
    return list(commits(journal))
