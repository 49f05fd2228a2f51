"""Algorithm 1 of the paper read to the letter: how far apart robots then stand, and what the referee says.

As printed, a line goes on until its length exceeds r_all r_follow. But so many robots have one gap less than
they are, so by then they stand r_all / (r_all - 1) r_follow apart: twice r_follow with two robots, 1.5 times
with three. Where that is more than 2 r_detect, whoever is ahead passes between them, however well they stand.
Our reading is (r_all - 1) r_follow.

The trial of it is a team abreast in a room that widens evenly, the most favourable there is: equal gaps, and
no turn. It goes on until the length of its line is what the letter allows.
"""

from typing import NamedTuple

import numpy as np
import shapely

from world_server.referee import Referee

NARROW_M, WIDER_PER_M = 0.8, 0.5  # the room's width at its end, and how much wider it gets
OFF_WALLS_M = 0.25
BEGINS_M, BEYOND_M = 0.1, 2.5
TEAMS = (2, 3, 4, 5)


def longest_line_m(robots: int, follow_m: float, literal: bool) -> float:
    """The length beyond which a line of so many robots asks for a search, as printed or as we read it."""
    return (robots if literal else robots - 1) * follow_m


def gap_m(robots: int, follow_m: float, literal: bool) -> float:
    """How far apart neighbours stand then."""
    return longest_line_m(robots, follow_m, literal) / (robots - 1)


def leaks(robots: int, follow_m: float, detect_m: float, literal: bool) -> bool:
    """Is there no point between two neighbours that either of them sees?"""
    return gap_m(robots, follow_m, literal) > 2 * detect_m


class Widening(NamedTuple):
    """A team in the widening room, step by step: the length of its line and what is contaminated.

    `lost_m2`: what became contaminated again in the step. All arrays (steps,).
    """

    robots: int
    length_m: np.ndarray
    contaminated_m2: np.ndarray
    lost_m2: np.ndarray

    @property
    def gap_m(self) -> np.ndarray:
        """Between neighbours."""
        return self.length_m / (self.robots - 1)

    def at(self, length_m: float) -> int:
        """The last step at which the line was no longer than this."""
        return int(np.flatnonzero(self.length_m <= length_m + 1e-9)[-1])


class Letter(NamedTuple):
    """Teams of several sizes in such rooms, with the distances that the algorithm goes by."""

    follow_m: float
    detect_m: float
    teams: tuple[Widening, ...]


def read_literally(follow_m: float, detect_m: float) -> Letter:
    """Every team until its line is as long as the letter allows."""
    return Letter(follow_m, detect_m, tuple(widening(robots, follow_m, detect_m) for robots in TEAMS))


def widening(robots: int, follow_m: float, detect_m: float, step_m: float = 0.05) -> Widening:
    """Drive a team of two or more through the room, under the exact referee, in steps of `step_m`."""
    longest_m = longest_line_m(robots, follow_m, literal=True)
    xs_m = np.arange(BEGINS_M, _x_m(longest_m) + step_m, step_m)
    places_m = [_abreast(x_m, robots) for x_m in xs_m]
    alive = [True] * robots
    referee = Referee(room(longest_m), detect_m, places_m[0], alive)
    verdicts = [referee.verdict]
    for before_m, after_m in zip(places_m, places_m[1:], strict=False):
        verdicts.append(referee.step(before_m, after_m, alive, alive))
    return Widening(
        robots,
        _width_m(xs_m) - 2 * OFF_WALLS_M,
        np.array([one.contaminated_m2 for one in verdicts]),
        np.array([one.recontaminated_m2 for one in verdicts]),
    )


def room(longest_m: float) -> shapely.Polygon:
    """A room that widens along x, some way beyond where a line across it is so long."""
    end_m = _x_m(longest_m) + BEYOND_M
    half_m = _width_m(np.array([0.0, end_m])) / 2
    return shapely.Polygon([(0, -half_m[0]), (end_m, -half_m[1]), (end_m, half_m[1]), (0, half_m[0])])


def _width_m(x_m: np.ndarray | float) -> np.ndarray | float:
    return NARROW_M + WIDER_PER_M * x_m


def _x_m(length_m: float) -> float:
    """Where a line across the room is so long."""
    return (length_m + 2 * OFF_WALLS_M - NARROW_M) / WIDER_PER_M


def _abreast(x_m: float, robots: int) -> list[tuple[float, float]]:
    half_m = _width_m(x_m) / 2 - OFF_WALLS_M
    return [(float(x_m), float(y_m)) for y_m in np.linspace(-half_m, half_m, robots)]
