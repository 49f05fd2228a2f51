"""LR-PT: local reactive patrol with emergent partition and situation awareness of the base station.

Source: Kobayashi, Kobayashi, Ueno, Higuchi 2025, Algorithms 1 and 2, equations 10 and 11. Where the paper is
silent or, read literally, does not work, an option of `LrPtParameters` says what was chosen.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Literal, Self

import msgspec
import numpy as np

from swarm_agent.behaviour import Behaviour, Heard, Move, Parameters
from swarm_agent.knowledge import AssumedIdleness, Bulletin, NeighbourMemory
from swarm_agent.ways import ways_of
from wire.channels import number_of
from wire.fields import Grid
from wire.messages import Configuration, GoTo, Percept, Pose

Positive = Annotated[float, msgspec.Meta(gt=0)]

PUBLISHED = {5: (0.55, 1088.0, 356.0), 10: (0.40, 703.0, 304.0), 15: (0.50, 425.0, 525.0)}
"""Takeover discount, largest priority and spread by team size, the tower counted (Table I)."""


class LrPtParameters(Parameters, frozen=True):
    """Table I, and the options that the paper leaves open. None: the published value for the team's size.

    `items`: which entries a frame carries: the `newest`, as printed, which never reports what has dropped out
    of the newest few; or the newest `unsent`, those that some neighbour is not known to have.
    `lock_breaker`: what keeps two robots with equal tables from choosing alike for ever. `none` as printed;
    `excl` skips goals that neighbours announced, `exclnext` skips their next cells, `rank` takes the (q+1)-th
    best step with q lower-numbered robots within `rank_range_m`. Neighbours that complete one cell in the
    same tick cannot have heard each other: `excl` and `exclnext` let them part in order of their numbers.
    All but `none` deviate from the paper.
    `contact_reading`: `printed` compares contact times as they arrive; `compensated` makes up for the one
    tick a message takes and lets the lower number take the duty between equals.
    """

    takeover_discount: Annotated[float, msgspec.Meta(ge=0, le=1)] | None = None
    report_priority_max_s: Positive | None = None
    spread_m: Positive | None = None
    search_radius_m: Positive = 180.0
    items_per_tick: Annotated[int, msgspec.Meta(ge=1)] = 400
    items: Literal["newest", "unsent"] = "unsent"
    lock_breaker: Literal["none", "excl", "exclnext", "rank"] = "excl"
    contact_reading: Literal["printed", "compensated"] = "printed"
    rank_range_m: Positive = 30.0

    def settled(self, team_size: int) -> Self:
        """Fill in the published values. Raises ValueError for a team the paper did not tune for."""
        names = ("takeover_discount", "report_priority_max_s", "spread_m")
        missing = [name for name in names if getattr(self, name) is None]
        if missing and team_size not in PUBLISHED:
            sizes = ", ".join(map(str, PUBLISHED))
            raise ValueError(
                f"{', '.join(missing)} must be given: the paper tuned them only for {sizes} "
                f"nodes, this team has {team_size}"
            )
        published = dict(zip(names, PUBLISHED.get(team_size, ()), strict=False))
        return msgspec.structs.replace(self, **{name: published[name] for name in missing})


class Duty(msgspec.Struct, frozen=True, array_like=True):
    """What LR-PT adds to the news: report priority, last contact with the tower, and where the robot goes."""

    priority_s: Annotated[float, msgspec.Meta(ge=0)]  # which also refuses NaN
    contact_tick: int
    goal: int
    target: int


class Intent(msgspec.Struct, frozen=True, array_like=True):
    """What observers are told: the far goal, the next cell, and the report priority."""

    goal: int
    target: int
    priority_s: float


class LrPt(Behaviour):
    """One patrolling robot."""

    Parameters = LrPtParameters
    Radio = Bulletin[Duty]

    def __init__(
        self, parameters: LrPtParameters, configuration: Configuration, generator: np.random.Generator
    ) -> None:
        super().__init__(parameters, configuration, generator)
        field = configuration.field
        self.centres_m = np.array(field.sites_m())
        self.knowledge = AssumedIdleness(len(self.centres_m))
        self.memory = NeighbourMemory(configuration.node, len(self.centres_m))
        self.priority_s = 0.0
        self.contact_tick = 0
        self.goal = self.target = -1
        self.since_tick = -1

    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """One timestep: Algorithm 2, then Algorithm 1, then the motion towards the temporary target."""
        tick, pose = percept.tick, percept.senses.pose
        present = _present(heard)
        self.update_priority(tick, present)
        if self.target < 0:
            self.since_tick = tick
            self.choose_target(percept, present, completed=None)
        elif self._distance_m(pose, self.target) <= self.configuration.field.visit_within_m:
            self.knowledge.note_visit(self.target, tick)
            self.choose_target(percept, present, completed=self.target)
        say = self._bulletin(tick, heard)
        self.knowledge.merge(*[one.message.news for one in heard])
        x_m, y_m = self.centres_m[self.target].tolist()
        motion = GoTo(x_m, y_m, self.configuration.field.visit_within_m)
        return Move(motion, (say,), tick + 1, report=Intent(self.goal, self.target, self.priority_s))

    def update_priority(self, tick: int, heard: Sequence[Heard]) -> None:
        """Algorithm 2, lines 1-17, clipped to the largest priority also where it is taken over.

        Without that clip two robots in range of the tower multiply each other's priority every second.
        """
        most = self.parameters.report_priority_max_s
        tower = self.configuration.tower
        if any(one.sender == tower for one in heard):
            self.contact_tick = tick  # before the loop: the tower comes first, whatever its number
        else:
            self.priority_s = min(most, self.priority_s + self.configuration.tick_s)
        taken_over = False
        for sender, sent_tick, bulletin, *_ in heard:
            duty = bulletin.message
            if sender == tower or duty is None:
                continue
            if self._contact_is_older(tick, sender, sent_tick, duty):
                theirs, own = duty.priority_s, self.priority_s
                raised = max(own, theirs) + self.parameters.takeover_discount * min(own, theirs)
                self.priority_s = min(most, raised)
                taken_over = True
        if heard and not taken_over:
            self.priority_s = 0.0

    def _contact_is_older(self, tick: int, sender: str, sent_tick: int, duty: Duty) -> bool:
        """Line 9: was the neighbour's last contact with the tower before ours?"""
        if self.parameters.contact_reading == "printed":
            return duty.contact_tick < self.contact_tick
        in_contact = duty.contact_tick == sent_tick
        theirs = tick if in_contact else duty.contact_tick
        if theirs == self.contact_tick:
            return number_of(self.configuration.node) < number_of(sender)
        return theirs < self.contact_tick

    def utilities(self, tick: int, pose: Pose) -> np.ndarray:
        """Equation 11 for every cell, minus infinity outside the search radius: (cells,)."""
        given = self.parameters
        distance_m = np.hypot(self.centres_m[:, 0] - pose.x_m, self.centres_m[:, 1] - pose.y_m)
        travel_s = np.maximum(distance_m / self.configuration.max_speed_m_s, 1e-9)
        idle_s = self.knowledge.idle_ticks(tick) * self.configuration.tick_s
        preferred_m = given.report_priority_max_s - self.priority_s
        away_m = self.centres_m.max(axis=1) - preferred_m
        alpha = np.exp(-(away_m**2) / (2 * given.spread_m**2))
        utility = alpha * (idle_s + travel_s) / travel_s
        return np.where(distance_m <= given.search_radius_m, utility, -np.inf)

    def choose_target(self, percept: Percept, heard: Sequence[Heard], completed: int | None) -> None:
        """Equation 10 and the adjacent cell on the way to the goal, past what the lock breaker forbids."""
        pose = percept.senses.pose
        utility = self.utilities(percept.tick, pose)
        here = self._nearest(pose) if completed is None else completed
        if completed is not None:
            utility[completed] = -np.inf
        if not np.isfinite(utility).any():  # alone in a field larger than the radius: go to what is nearest
            utility = -np.hypot(*(self.centres_m - (pose.x_m, pose.y_m)).T)
            utility[here] = -np.inf
        duties = {one.sender: one.message.message for one in heard if one.message.message is not None}
        match self.parameters.lock_breaker:
            case "none":
                goal = self._best(utility)
            case "excl":
                left = _without(utility, {duty.goal for duty in duties.values()})
                goal = self._best_step(here, left, set(), self._ties(completed, duties))
            case "exclnext":
                taken = {duty.target for duty in duties.values()}
                goal = self._best_step(here, utility, taken, self._ties(completed, duties))
            case "rank":
                goal = self._best_step(here, utility, set(), self._lower_ranks(percept))
        self.goal, self.target = goal, self.on_the_way(here, goal)

    def on_the_way(self, here: int, goal: int) -> int:
        """The neighbour of `here` in the direction of `goal`, rounded to 45 degrees; the goal if adjacent.

        On other fields than a grid without holes, where that may not exist: the first of the cheapest way.
        """
        field = self.configuration.field
        if not isinstance(field, Grid) or field.holes:
            return int(ways_of(field).next_site[here, goal])
        rows = field.rows
        columns_off, rows_off = goal // rows - here // rows, goal % rows - here % rows
        if max(abs(columns_off), abs(rows_off)) <= 1:
            return goal
        eighth = round(math.atan2(rows_off, columns_off) / (math.pi / 4)) * (math.pi / 4)
        return here + round(math.cos(eighth)) * rows + round(math.sin(eighth))

    def _best(self, utility: np.ndarray) -> int:
        """The cell of largest utility; one of the best at random where several are equal."""
        best = np.flatnonzero(utility == utility.max())
        return int(best[0] if len(best) == 1 else self.generator.choice(best))

    def _best_step(self, here: int, utility: np.ndarray, taken: set[int], skip: int) -> int:
        """The best goal whose next cell is the (skip + 1)-th distinct one that is not taken."""
        steps: list[int] = []
        first = self._best(utility)
        for goal in [first, *np.argsort(-utility, kind="stable").tolist()]:
            if not np.isfinite(utility[goal]):
                break
            step = self.on_the_way(here, goal)
            if step not in taken and step not in steps:
                steps.append(step)
                if len(steps) > skip:
                    return goal
        return first

    def _ties(self, completed: int | None, duties: Mapping[str, Duty]) -> int:
        """How many lower-numbered neighbours were heading for the cell that was just completed.

        One that arrives in the same tick decides in the same tick, on an equal table, and neither has heard
        what the other announces: without an order between them such a pair stays locked for ever.
        """
        own = number_of(self.configuration.node)
        return sum(number_of(name) < own and duty.target == completed for name, duty in duties.items())

    def _lower_ranks(self, percept: Percept) -> int:
        own, pose = number_of(self.configuration.node), percept.senses.pose
        return sum(
            number_of(one.node) < own
            and one.node != self.configuration.tower
            and math.hypot(one.x_m - pose.x_m, one.y_m - pose.y_m) <= self.parameters.rank_range_m
            for one in percept.senses.in_sight
        )

    def _bulletin(self, tick: int, heard: Sequence[Heard]) -> Bulletin:
        """Algorithm 1, lines 9-12, and Algorithm 2, line 18, in one frame for all in range."""
        items = self.parameters.items_per_tick
        duty = Duty(self.priority_s, self.contact_tick, self.goal, self.target)
        if self.parameters.items == "newest" or items >= len(self.centres_m):
            return Bulletin(self.knowledge.newest(items), (), self.since_tick, duty)
        self.memory.listen(heard)
        scarce = self.memory.unknown_to([one.sender for one in heard], self.knowledge.visited_tick)
        news = self.knowledge.newest(items, scarce)
        self.memory.remember_sent(tick, news)
        return Bulletin(news, tuple((one.sender, one.sent_tick) for one in heard), self.since_tick, duty)

    def _nearest(self, pose: Pose) -> int:
        return int(np.argmin(np.hypot(self.centres_m[:, 0] - pose.x_m, self.centres_m[:, 1] - pose.y_m)))

    def _distance_m(self, pose: Pose, site: int) -> float:
        return math.hypot(self.centres_m[site, 0] - pose.x_m, self.centres_m[site, 1] - pose.y_m)


def _present(heard: Sequence[Heard]) -> list[Heard]:
    """The frames of those who are neighbours now: A_n(t-1). A robot that was frozen finds older ones too,
    whose news still counts, but whose senders may be far away by now.
    """
    newest = max((one.sent_tick for one in heard), default=0)
    return [one for one in heard if one.sent_tick == newest]


def _without(utility: np.ndarray, announced: set[int]) -> np.ndarray:
    """`utility` without the announced goals, unless nothing would remain."""
    left = utility.copy()
    left[[goal for goal in announced if 0 <= goal < len(left)]] = -np.inf
    return left if np.isfinite(left).any() else utility
