"""The scenario: one TOML file that says everything about a run. Unknown fields are errors; units in names."""

import math
from typing import Annotated, Any, Literal

import msgspec

from wire.channels import number_of
from wire.fields import Field, Number
from wire.messages import Memory, NodeId, Place, Verb

Positive = Annotated[float, msgspec.Meta(gt=0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0)]
Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
Team = Annotated[int, msgspec.Meta(ge=1, le=1000)]


class Section(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base of all parts of a scenario."""


class Fan(Section, tag_field="kind", tag="fan"):
    """Uniform in the quarter disc around the origin. `radius_m` None: 2 sqrt(N), N with the tower.

    Source: Kobayashi et al. 2025, section V-A1; the quarter disc is our reading of "fan-shaped area".
    """

    radius_m: Positive | None = None


class Poses(Section, tag_field="kind", tag="poses"):
    """A given pose for each robot, in order of their ids: [x_m, y_m, heading_rad]."""

    poses: tuple[tuple[float, float, float], ...]


class InQueue(Section, tag_field="kind", tag="queue"):
    """Each robot in its place of the tower's queue."""


class Cluster(Section, tag_field="kind", tag="cluster"):
    """Close together around a point of a floor plan, where the tower stands too unless it is told where."""

    x_m: float
    y_m: float


class Robots(Section):
    """The team. Ids are `r2`, `r3`, ... behind the tower's `r1` unless `ids` names them.

    `spares` are ids with credentials but without a body: the access rules are fixed when a run begins.
    `body_m`: the distance bodies keep from each other; 0 lets them pass freely. `noise_sd`: standard
    deviation of the noise on linear and rotational velocity, as a fraction of full speed, over one second.
    `start`: a list has a site for each robot, and says how many there are where `count` and `ids` do not.
    In mission clear bodies are discs `body_m` wide, and every front is drawn by chance.
    `shared_last_visit`: robots sense when each site was really last visited, by whomever.
    """

    behaviour: str
    count: Team | None = None
    ids: tuple[NodeId, ...] | None = None
    parameters: dict[str, Any] = {}
    start: Fan | Poses | InQueue | Cluster | tuple[Number, ...] = Fan()
    max_speed_m_s: Positive = 1.5
    max_turn_rad_s: Positive = 1.0
    sensor_range_m: NotNegative = 90.0
    body_m: NotNegative = 0.0
    noise_sd: NotNegative = 0.0
    spares: Annotated[int, msgspec.Meta(ge=0, le=100)] = 0
    shared_last_visit: bool = False


class TowerSection(Section):
    """The base station: a node that cannot move."""

    id: NodeId = "r1"
    behaviour: str = "base_station"
    parameters: dict[str, Any] = {}
    x_m: float = 0.0
    y_m: float = 0.0


class BatterySection(Section):
    """Charge in volts. Robots begin full, less the absolute value of a Gaussian of `start_sd_v`.

    Drains are volts per hour: on the line, on the passing lane, and in the queue. A docked robot is given a
    full battery at once, or charged from empty to full within `charge_s`. At `empty_v` it stops, silent.
    The paper gives only 0.33 V/h while patrolling; the other figures are ours.
    """

    full_v: Positive = 9.0
    empty_v: NotNegative = 8.0
    start_sd_v: NotNegative = 0.03
    patrolling_v_h: NotNegative = 0.33
    travelling_v_h: NotNegative = 0.33
    queueing_v_h: NotNegative = 0.10
    charge_s: NotNegative = 0.0


class Sensors(Section):
    """What robots of mission clear sense, and which referee judges them.

    `detect_m`: how far they see, `rays`: in how many directions they measure. Noise is Gaussian: `noise_sd_m`
    on all ranges, `bearing_sd_rad` on bearings, `odometry_sd` on each step, as a fraction of its length.
    """

    detect_m: Positive = 0.7
    rays: Annotated[int, msgspec.Meta(ge=90, le=3600)] = 180
    noise_sd_m: NotNegative = 0.0
    bearing_sd_rad: NotNegative = 0.0
    odometry_sd: NotNegative = 0.0
    referee: Literal["exact", "raster", "both"] = "exact"


class Range(Section, tag_field="kind", tag="range"):
    """A frame reaches receivers at most `range_m` away (unit disc)."""

    range_m: Positive


class Loss(Section, tag_field="kind", tag="loss"):
    """Each frame is lost to each receiver with `probability`, independently (Bernoulli)."""

    probability: Share


class Latency(Section, tag_field="kind", tag="latency"):
    """Frames are heard exactly `ticks` after the tick whose action carried them."""

    ticks: Annotated[int, msgspec.Meta(ge=1, le=100_000)] = 1


class Partition(Section, tag_field="kind", tag="partition"):
    """From `from_s` until `until_s` nothing passes between different groups; the rest is one group."""

    groups: tuple[tuple[NodeId, ...], ...]
    from_s: NotNegative = 0.0
    until_s: NotNegative | None = None


class RadioSection(Section):
    """An ordered list of rules; the first that does not pass a frame on decides about it."""

    rules: tuple[Range | Loss | Latency | Partition, ...] = (Range(180.0),)
    bytes_per_tick: Annotated[int, msgspec.Meta(ge=1, le=1_000_000)] = 65_536
    inbox_frames: Annotated[int, msgspec.Meta(ge=1, le=1_000_000)] = 4096

    @property
    def latency_ticks(self) -> int:
        """How long a frame takes that gets through."""
        return max((rule.ticks for rule in self.rules if isinstance(rule, Latency)), default=1)

    @property
    def loss(self) -> float:
        """The share of frames within range that are lost."""
        return 1 - math.prod(1 - rule.probability for rule in self.rules if isinstance(rule, Loss))


class ClockSection(Section):
    """`lockstep` runs as fast as it goes, `paced` at `rate` simulated seconds per second."""

    kind: Literal["lockstep", "paced"] = "lockstep"
    rate: Positive = 1.0


class Watchdog(Section):
    """A node that has not answered is named at 1, 3 and 10 times `budget_s`; then `policy` applies."""

    budget_s: Positive = 5.0
    policy: Literal["wait", "declare_dead", "abort"] = "wait"


class WireSection(Section):
    """The loopback port of the run's router; 0 takes a free one."""

    port: Annotated[int, msgspec.Meta(ge=0, le=65535)] = 0


class PlannedFault(Section):
    """What befalls some nodes at a time: named in `nodes`, or the highest numbers by their share of the team.

    `highest_ids_share` 0.2 means the 20 % of all nodes (the tower counted) with the largest numbers. In
    mission clear it may happen instead of `at_s` as soon as that share of the plan is clear, and to the
    middle one, by number, of the living robots that last reported this `role` on the main line: while there
    is none, it waits. A slow node is granted only ticks that are multiples of `every`, until it is 1 again.
    """

    at_s: NotNegative | None = None
    verb: Verb | None = None
    nodes: tuple[NodeId, ...] = ()
    highest_ids_share: Share | None = None
    memory: Memory = "lost"
    place: Place = "here"
    every: Annotated[int, msgspec.Meta(ge=1, le=10**6)] = 1
    when_cleared_share: Share | None = None
    role: str = ""


class Scenario(Section):
    """One run, whole.

    `ends_with_visit`: after `duration_s` it goes on to the first tick with a visit, at most as long again.
    """

    mission: Literal["area", "line", "clear"]
    duration_s: Positive
    field: Field
    robots: Robots
    tower: TowerSection = TowerSection()
    tick_s: Positive = 1.0
    seed: Annotated[int, msgspec.Meta(ge=0, le=2**63 - 1)] = 1
    metrics_from_s: NotNegative = 0.0
    ends_with_visit: bool = False
    radio: RadioSection = RadioSection()
    battery: BatterySection | None = None
    sensors: Sensors | None = None
    clock: ClockSection = ClockSection()
    watchdog: Watchdog = Watchdog()
    wire: WireSection = WireSection()
    faults: tuple[PlannedFault, ...] = ()

    @property
    def robot_ids(self) -> tuple[str, ...]:
        """Ids of all robots, in the order of their numbers."""
        if self.robots.ids is not None:
            return tuple(sorted(self.robots.ids, key=number_of))
        start = self.robots.start
        count = self.robots.count or (len(start) if isinstance(start, tuple) else 0)
        return tuple(f"r{number}" for number in self._numbers(count))

    @property
    def node_ids(self) -> tuple[str, ...]:
        """The tower and all robots, in the order of their numbers."""
        return tuple(sorted((self.tower.id, *self.robot_ids), key=number_of))

    @property
    def spare_ids(self) -> tuple[str, ...]:
        """Ids that have credentials and no body."""
        first = max(number_of(node) for node in self.node_ids) + 1
        return tuple(f"r{number}" for number in range(first, first + self.robots.spares))

    @property
    def last_tick(self) -> int:
        """The tick at which the mission ends, or from which on a visit ends it."""
        return self.tick_of(self.duration_s) if self.ends_with_visit else round(self.duration_s / self.tick_s)

    def tick_of(self, time_s: float) -> int:
        """The first tick at or after a time."""
        return math.ceil(round(time_s / self.tick_s, 6))

    def nodes_of(self, fault: PlannedFault) -> tuple[str, ...]:
        """The nodes that a planned fault befalls."""
        if fault.highest_ids_share is None:
            return fault.nodes
        struck = round(fault.highest_ids_share * len(self.node_ids))
        return self.node_ids[len(self.node_ids) - struck :]

    def _numbers(self, count: int) -> list[int]:
        tower = number_of(self.tower.id)
        return [number for number in range(1, count + 2) if number != tower][:count]
