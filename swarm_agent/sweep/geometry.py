"""Plane geometry of what a robot sees around itself. Places and ways are complex numbers, in metres."""

import cmath
import math

import numpy as np

TURNS = 72  # directions a robot considers on its way along a wall
ROLLED = {
    hand: np.exp(sign * 1j * math.tau / TURNS * np.arange(TURNS))
    for hand, sign in (("left", -1), ("right", 1))
}
JOINED_M = 0.12  # ends of neighbouring rays that are no farther apart are one wall
NOTHING = np.empty(0, dtype=complex)


def clearance_m(points: np.ndarray, start: complex, end: complex) -> float:
    """How near the nearest of some points is to the straight way from `start` to `end`; inf without any."""
    if not len(points):
        return math.inf
    way, away = end - start, points - start
    length2 = way.real**2 + way.imag**2
    if length2 == 0:
        return float(np.abs(away).min())
    share = np.clip((away * way.conjugate()).real / length2, 0.0, 1.0)
    return float(np.abs(away - share * way).min())


def nearest(points: np.ndarray, place: complex) -> complex | None:
    """The nearest of some points; None without any."""
    return complex(points[np.abs(points - place).argmin()]) if len(points) else None


def ray_ends(here: complex, ranges_m: np.ndarray, units: np.ndarray) -> np.ndarray:
    """Where the rays of a scan end, NaN where at no wall."""
    seen = np.isfinite(ranges_m)
    return np.where(seen, here + np.where(seen, ranges_m, 0.0) * units, np.nan)


def one_wall(ends: np.ndarray, near: int) -> list[int]:
    """The rays that end at the same wall as one of them: it, then those on both sides up to a jump."""
    wall = [near]
    for step in (1, -1):
        ray = near
        for _ in range(len(ends)):
            following = (ray + step) % len(ends)
            if not abs(ends[following] - ends[ray]) <= JOINED_M:
                break
            wall.append(following)
            ray = following
    return wall


def turn_rad(first: complex, last: complex, hand: str) -> float:
    """The angle from one direction to another in [0, 2 pi): counter-clockwise for "left", else clockwise."""
    return cmath.phase(last / first if hand == "left" else first / last) % math.tau


def crosses(start: complex, end: complex, other_start: complex, other_end: complex) -> bool:
    """Do two straight ways cross?"""

    def beside(place: complex, begin: complex, to: complex) -> bool:
        return ((place - begin) * (to - begin).conjugate()).imag > 0

    return beside(start, other_start, other_end) != beside(end, other_start, other_end) and beside(
        other_start, start, end
    ) != beside(other_end, start, end)


def crossed(start: complex, ends: np.ndarray, other_start: complex, other_end: complex) -> np.ndarray:
    """Which straight ways from `start` to some ends cross another one?"""
    other = other_end - other_start
    before, after = (((one - other_start) * other.conjugate()).imag for one in (start, ends))
    ways = ends - start
    first, last = ((ways.conjugate() * (one - start)).imag for one in (other_start, other_end))
    return (before * after < 0) & (first * last < 0)


def unit(way: complex) -> complex:
    """The direction of a way; 1 of none."""
    return way / abs(way) if way else 1 + 0j


def shortened(way: complex, most_m: float) -> complex:
    """The way, but no longer than `most_m`."""
    return way if abs(way) <= most_m else way * (most_m / abs(way))


def roll(
    here: complex, walls: np.ndarray, contact: complex, hand: str, keep_m: float, step_m: float
) -> tuple[complex, complex]:
    """One step of a disc of radius `keep_m` that rolls along walls, which stay on the `hand` side.

    `contact`: the place of the wall it touches. Returns the way to go and the place that it touches then.
    """
    near = walls[np.abs(walls - here) <= keep_m + 2 * step_m]
    outward = unit(contact - here)
    if not len(near):
        return step_m * outward, contact
    ways = step_m * outward * ROLLED[hand]
    gaps = np.abs(near[None, :] - (here + ways)[:, None])
    least = gaps.min(axis=1)
    now = float(np.abs(near - here).min())
    enough = min(keep_m, now + 0.3 * step_m) - 1e-3
    free = np.flatnonzero(least >= enough)
    if not len(free):
        best = int(least.argmax())
        return complex(ways[best]), contact
    first = int(free[0])
    if first:
        contact = complex(near[gaps[first - 1].argmin()])
    return complex(ways[first]), contact
