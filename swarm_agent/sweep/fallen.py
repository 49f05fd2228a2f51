"""Where the bodies of dead robots lie, in the way of everybody, seen by nobody; so robots tell each other.

Of who died unnoticed nobody can tell: whoever is held up on its way where it knows of nothing has met a body.
"""

from swarm_agent.sweep.geometry import unit
from swarm_agent.sweep.radio import Body
from swarm_agent.sweep.robot import Robot

LEAST_M, HELD_UP = 0.02, 0.5
NEAR_M = 0.3
REMEMBERED_TICKS = 1000


def see(robot: Robot) -> None:
    """Take over where the dead were when anybody last heard them; who is heard again is not dead."""
    known = robot.peers.known
    for number in robot.dead & robot.peers.lost.keys():
        lost = robot.peers.lost[number]
        _lay(robot, number, lost.tick, lost.here)
    for peer in known.values():
        for body in peer.beacon.bodies:
            if body.number in robot.dead:
                _lay(robot, body.number, body.tick, peer.place(complex(body.x_m, body.y_m)))
    for number in robot.bodies.keys() & known.keys():
        del robot.bodies[number]


def bump(robot: Robot, wanted: complex, moved: complex) -> None:
    """Remember a body where a robot is held up on its way, and knows of nobody and no wall there."""
    robot.bumps = [one for one in robot.bumps if robot.tick - one[0] <= REMEMBERED_TICKS]
    if abs(wanted) < LEAST_M or (moved / unit(wanted)).real > HELD_UP * abs(wanted):
        return
    place = robot.here + robot.body_m * unit(wanted)
    bodies = [peer.here for peer in robot.peers.known.values()] + robot.fallen
    at_wall = len(robot.hits) and float(abs(robot.hits - place).min()) < robot.body_m / 2
    if not at_wall and all(abs(body - place) > NEAR_M for body in bodies):
        robot.bumps.append((robot.tick, place))


def told(robot: Robot) -> tuple[Body, ...]:
    """What it tells of them."""
    ways = {number: place - robot.here for number, (_, place) in sorted(robot.bodies.items())}
    return tuple(Body(number, robot.bodies[number][0], way.real, way.imag) for number, way in ways.items())


def _lay(robot: Robot, number: int, tick: int, place: complex) -> None:
    if number not in robot.bodies or robot.bodies[number][0] < tick:
        robot.bodies[number] = (tick, place)
