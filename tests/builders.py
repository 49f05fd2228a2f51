"""Builders that tests share: small scenarios, percepts, facts, and rehearsals whose course is kept."""

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np

from deploy.rehearsal import rehearse
from deploy.scenario_file import to_toml
from swarm_agent.behaviour import Heard, find_behaviour, settled_parameters
from swarm_agent.behaviours.lr_pt import Duty, LrPt, LrPtParameters
from swarm_agent.knowledge import Bulletin, News
from tests.scripted import Log
from wire import codec
from wire.fields import Grid, Polyline
from wire.messages import Configuration, Facts, Frame, Percept, Pose, Senses, Sighting
from wire.scenario import InQueue, PlannedFault, Poses, RadioSection, Range, Robots, Scenario, TowerSection
from world_server.journal import commits

NO_NEWS = News(b"")
TALK = {"every_tick": True, "say_always": "hello"}
STILL = "swarm_agent.behaviours.stand_still:StandStill"
AWAKE = {"every_tick": True}


def table(**visited: int) -> News:
    """News of some sites: table(s3=17) says that site 3 was visited at tick 17."""
    sites = np.array([int(name[1:]) for name in visited], dtype="<u2")
    return News(np.array(list(visited.values()), dtype="<u4").tobytes(), sites.tobytes())


def entries(news: News) -> dict[int, int]:
    """Site to tick of what a frame carries."""
    times = np.frombuffer(news.visited_tick, "<u4").tolist()
    sites = np.frombuffer(news.sites, "<u2").tolist() if news.sites else range(len(times))
    return dict(zip(sites, times, strict=True))


def configuration(
    node: str = "r2", behaviour: str = "lr_pt", parameters: Any = None, **fields: Any
) -> Configuration:
    """What a node is told of itself, on the paper's field unless `field` says otherwise."""
    told = {
        "incarnation": 0,
        "generator_key": (1, 2),
        "tick_s": 1.0,
        "tower": "r1",
        "field": Grid(),
        "max_speed_m_s": 1.5,
    } | fields
    return Configuration(node=node, behaviour=behaviour, parameters=codec.encode(parameters or {}), **told)


def robot(
    node: str = "r2",
    team_size: int = 10,
    tower: str = "r1",
    field: Grid | None = None,
    seed: int = 1,
    **parameters: Any,
) -> LrPt:
    """A newborn LR-PT robot."""
    settled = LrPtParameters(**parameters).settled(team_size)
    told = configuration(node, "lr_pt", tower=tower, field=field or Grid())
    return LrPt(settled, told, np.random.Generator(np.random.Philox(seed)))


def percept(
    tick: int,
    x_m: float = 0.0,
    y_m: float = 0.0,
    grant: int | None = None,
    in_sight: Iterable[Sighting] = (),
    inbox: Iterable[Frame] = (),
    why: str = "wake",
    configuration: Configuration | None = None,
) -> Percept:
    """A grant at a place."""
    senses = Senses(Pose(x_m, y_m, 0.0), tuple(in_sight))
    return Percept(tick, tick if grant is None else grant, why, senses, tuple(inbox), configuration)


def from_robot(
    sender: str,
    sent_tick: int,
    priority_s: float = 0.0,
    contact_tick: int = 0,
    goal: int = -1,
    target: int = -1,
    news: News = NO_NEWS,
) -> Heard:
    """A robot's bulletin as it is heard."""
    return Heard(sender, sent_tick, Bulletin(news, (), 0, Duty(priority_s, contact_tick, goal, target)))


def from_tower(sent_tick: int, news: News = NO_NEWS, tower: str = "r1") -> Heard:
    """The tower's bulletin as it is heard."""
    return Heard(tower, sent_tick, Bulletin(news, (), 0))


def scenario(
    robots: Robots | int = 2,
    behaviour: str = "lr_pt",
    parameters: dict[str, Any] | None = None,
    poses: Iterable[tuple[float, float, float]] | None = None,
    range_m: float = 180.0,
    **fields: Any,
) -> Scenario:
    """A complete small scenario; more robots than the paper tuned for get its values for ten nodes."""
    if isinstance(robots, int):
        robots = Robots(behaviour, robots)
    if poses is not None:
        robots = msgspec.structs.replace(robots, start=Poses(tuple(poses)))
    if robots.behaviour == "lr_pt":
        known = {"takeover_discount": 0.4, "report_priority_max_s": 703.0, "spread_m": 304.0}
        parameters = known | (parameters or {})
    kind = find_behaviour(robots.behaviour, "swarm_agent.behaviours")
    settled = msgspec.to_builtins(settled_parameters(kind, parameters or {}, 10))
    radio = RadioSection((Range(range_m),))
    told = {"mission": "area", "duration_s": 40.0, "field": Grid(5, 5), "radio": radio} | fields
    return Scenario(robots=msgspec.structs.replace(robots, parameters=settled), **told)


def scripted(
    scripts: dict[str, dict[str, Any]], poses: Iterable[tuple[float, float]], **fields: Any
) -> Scenario:
    """A scenario of scripted robots r2, r3, ... at these positions, with a tower that is mute."""
    places = tuple((float(x_m), float(y_m), 0.0) for x_m, y_m in poses)
    robots = fields.pop("robots", Robots("tests.scripted:Scripted", len(places)))
    mute = TowerSection(behaviour=STILL)
    told = {"parameters": {"scripts": scripts}, "poses": places, "tower": mute} | fields
    return scenario(robots, **told)


class Course(NamedTuple):
    """A rehearsed run: its facts, its hash, and where its journal is."""

    facts: list[Facts]
    run_hash: str
    journal: Path

    def logs(self, node: str) -> dict[int, Log]:
        """What a scripted robot reported, by tick."""
        return {
            one.tick: codec.decode(Log, report)
            for one in self.facts
            for name, report in one.reports
            if name == node
        }

    def grants(self, node: str) -> dict[int, str]:
        """Tick and reason of every grant of a node."""
        granted = ((one.tick, grant) for one in commits(self.journal) for grant in one.grants)
        return {tick: grant.why for tick, grant in granted if grant.node == node}

    def visits(self) -> list[tuple[int, str, int]]:
        """Tick, node and site of every visit."""
        return [(one.tick, *visit) for one in self.facts for visit in one.visits]

    def positions(self, row: int) -> list[tuple[float, float]]:
        """Where the node in `row` was at the end of each tick."""
        poses = [np.frombuffer(one.poses).reshape(-1, 3)[row, :2].tolist() for one in self.facts]
        return [(x_m, y_m) for x_m, y_m in poses]


def planned(
    *faults: PlannedFault, scripts: Any = None, poses: Any = ((0, 0), (5, 0)), **fields: Any
) -> Scenario:
    """A scripted scenario with faults; unless told otherwise r2 and r3 talk all the time."""
    given = {"r2": TALK, "r3": TALK} if scripts is None else scripts
    return scripted(given, poses, faults=faults, **fields)


def course(given: Scenario, folder: Path, last_tick: int | None = None) -> Course:
    """Rehearse a scenario in `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    facts: list[Facts] = []
    last = given.last_tick if last_tick is None else last_tick
    run_hash = rehearse(
        given, to_toml(given), folder, last, lambda one, swarm: facts.append(one.facts)
    ).run_hash
    return Course(facts, run_hash, folder / "journal")


def events(folder: Path) -> list[dict[str, Any]]:
    """What the event log of a rehearsal says."""
    return [msgspec.json.decode(line) for line in (folder / "events.jsonl").read_text().splitlines()]


def facts(
    tick: int, visits: Iterable[tuple[str, int]] = (), reports: Iterable[tuple[str, bytes]] = ()
) -> Facts:
    """Facts of a tick in which nothing happened but what is given."""
    return Facts(tick, b"", b"", b"", b"", tuple(visits), tuple(reports), (), (0, 0, 0, 0, 0, 0))


CENTRE_0 = (15.0, 15.0)


def visited(one: LrPt, **sites: int) -> None:
    """Let a robot know of visits: visited(one, s3=17) says that site 3 was visited at tick 17."""
    one.knowledge.merge(table(**sites))


def chosen(one: LrPt, tick=1000, at=CENTRE_0, heard=(), completed=0, in_sight=()) -> tuple[int, int]:
    """Let a robot choose at a place and a tick; returns its goal and its target."""
    one.choose_target(percept(tick, *at, in_sight=in_sight), list(heard), completed)
    return one.goal, one.target


STRAIGHT = Polyline(((0.0, 0.0), (40.0, 0.0)), 4)
"""Four segments of 10 m along the x axis."""


def on_line(
    scripts: dict[str, dict[str, Any]],
    poses: Iterable[tuple[float, float]] | int,
    field: Polyline = STRAIGHT,
    tower_m: tuple[float, float] = (20.0, 0.0),
    robots: dict[str, Any] | None = None,
    **fields: Any,
) -> Scenario:
    """A scenario of mission "line" with scripted robots r2, r3, ... at these places, or so many in the queue.

    They go 1 m/s, turn half round in a second, and keep no distance, unless told otherwise.
    """
    places = () if isinstance(poses, int) else tuple((float(x_m), float(y_m), 0.0) for x_m, y_m in poses)
    start = Poses(places) if places else InQueue()
    body = {"max_speed_m_s": 1.0, "max_turn_rad_s": math.pi, "sensor_range_m": 1.0} | (robots or {})
    team = Robots("tests.scripted:Scripted", len(places) or poses, start=start, **body)
    still = TowerSection(behaviour=STILL, x_m=tower_m[0], y_m=tower_m[1])
    told = {"parameters": {"scripts": scripts}, "tower": still} | fields
    return msgspec.structs.replace(scenario(team, field=field, **told), mission="line")
