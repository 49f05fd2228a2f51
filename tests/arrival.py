"""A behaviour that is wrong on purpose: what it says depends on who answered first."""

import os
import time

import msgspec

from swarm_agent.behaviour import Behaviour, Move, Parameters


class ArrivalParameters(Parameters, frozen=True):
    """`path`: a file that all robots share, which no robot should."""

    path: str


class Place(msgspec.Struct, frozen=True, array_like=True):
    """How many had answered before."""

    number: int


class Arrival(Behaviour):
    """Reports its place in the order of arrival; the lowest number dawdles: not in node order."""

    Parameters = ArrivalParameters

    def step(self, percept, heard) -> Move:
        """Append one byte to the shared file and report its length."""
        if self.configuration.node == "r2":
            time.sleep(0.002)
        with open(self.parameters.path, "ab") as shared:
            shared.write(b".")
            shared.flush()
            return Move(wake_tick=percept.tick + 1, report=Place(os.fstat(shared.fileno()).st_size))
