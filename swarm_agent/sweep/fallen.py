"""Where the bodies of dead robots lie: in the way of everybody, and seen by nobody, so robots tell each other."""

from swarm_agent.sweep.radio import Body
from swarm_agent.sweep.robot import Robot


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


def told(robot: Robot) -> tuple[Body, ...]:
    """What it tells of them."""
    ways = {number: place - robot.here for number, (_, place) in sorted(robot.bodies.items())}
    return tuple(Body(number, robot.bodies[number][0], way.real, way.imag) for number, way in ways.items())


def _lay(robot: Robot, number: int, tick: int, place: complex) -> None:
    if number not in robot.bodies or robot.bodies[number][0] < tick:
        robot.bodies[number] = (tick, place)
