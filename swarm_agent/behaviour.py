"""What a behaviour is: a deterministic machine from percepts to moves, apart from any body or clock."""

import importlib
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import msgspec
import numpy as np

from wire.messages import Configuration, Motion, Percept


class BehaviourError(Exception):
    """A behaviour that cannot be found or is not one; the text says which and why."""


class Air(NamedTuple):
    """How frames get through: how long they take, which share is lost, how seldom a slow node is granted."""

    tick_s: float = 1.0
    latency_ticks: int = 1
    loss: float = 0.0
    grant_ticks: int = 1


class Parameters(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base of every behaviour's parameters; a field that does not exist is an error in the scenario."""

    def settled(self, team_size: int) -> Self:
        """These parameters with everything filled in that depends on the team's size, the tower counted.

        Raises ValueError in words an operator understands.
        """
        return self

    def in_air(self, air: Air) -> Self:
        """These parameters with everything filled in that depends on how frames get through.

        Raises ValueError in words an operator understands.
        """
        return self


class Heard(NamedTuple):
    """A frame after decoding; `message` is in the behaviour's own vocabulary.

    `range_m` and `bearing_rad`: where its sender was when it spoke, counter-clockwise from the front of the
    body; not a number where a mission does not measure it.
    """

    sender: str
    sent_tick: int
    message: Any
    range_m: float = math.nan
    bearing_rad: float = math.nan


class Move(msgspec.Struct, frozen=True):
    """What a behaviour wants. No `motion` keeps the present one; no wake at all means sleep for good.

    `wake_on` adds up the WAKE_ON_ flags of wire.messages. `report` is for observers: any Struct, or nothing.
    `record`: entries for the ledger of a node that has one, written before anything of this move is done.
    """

    motion: Motion | None = None
    say: tuple[Any, ...] = ()
    wake_tick: int | None = None
    wake_on: int = 0
    report: Any = None
    record: tuple[Any, ...] = ()


class Ledger(Protocol):
    """What a node writes down and finds again after its process was killed."""

    def read(self, before_grant: int) -> Sequence[Any]:
        """All entries of grants before this one; those of later grants, which never counted, are removed."""

    def write(self, grant: int, tick: int, entries: Sequence[Any]) -> None:
        """Keep the entries of one grant, safe from a kill on return; the same grant again replaces."""

    def close(self) -> None:
        """Nothing more will be written."""


class Behaviour(ABC):
    """The algorithm inside a node.

    Equal configuration, generator and percepts must give equal moves: no clock, no input or output, no
    chance but `generator`.
    """

    Parameters: ClassVar[type[Parameters]] = Parameters
    Radio: ClassVar[Any] = None
    """The type (or tagged union) of the messages that this behaviour says and understands; None: mute."""

    def __init__(self, parameters: Any, configuration: Configuration, generator: np.random.Generator) -> None:
        self.parameters = parameters
        self.configuration = configuration
        self.generator = generator

    def remember(self, entries: Sequence[Any]) -> None:
        """Called once, before the first step, with all entries of the node's ledger, where it has one."""

    @abstractmethod
    def step(self, percept: Percept, heard: Sequence[Heard]) -> Move:
        """Answer one grant. `heard` is the percept's inbox, decoded, in order of tick and node number."""


def find_behaviour(name: str, package: str) -> type[Behaviour]:
    """The behaviour in file `name` of `package`, or the class at `their_package.module:Class`.

    Raises BehaviourError.
    """
    module_name, colon, class_name = name.partition(":")
    try:
        module = importlib.import_module(module_name if colon else f"{package}.{name}")
    except ImportError as error:
        where = "a file of swarm_agent/behaviours or their_package.module:Class"
        raise BehaviourError(f"there is no behaviour {name!r} ({error}); must be {where}") from None
    except Exception as error:  # noqa: BLE001  a name that is none, or whatever their module does when read
        why = f"{type(error).__name__}: {error}"
        raise BehaviourError(f"behaviour {name!r} cannot be imported: {why}") from None
    if colon:
        found = [getattr(module, class_name, None)]
    else:
        found = [
            one for one in vars(module).values() if _is_behaviour(one) and one.__module__ == module.__name__
        ]
    if len(found) != 1 or not _is_behaviour(found[0]):
        raise BehaviourError(
            f"{name!r} does not name exactly one subclass of swarm_agent.behaviour.Behaviour"
        )
    return found[0]


def settled_parameters(
    behaviour: type[Behaviour], given: dict[str, Any], team_size: int, air: Air = Air()
) -> Parameters:
    """The behaviour's complete parameters. Raises msgspec.ValidationError or ValueError."""
    return msgspec.convert(given, behaviour.Parameters).settled(team_size).in_air(air)


def _is_behaviour(thing: Any) -> bool:
    return isinstance(thing, type) and issubclass(thing, Behaviour) and thing is not Behaviour
