"""A live run under attack: every kind of rogue, in a process of its own, and what came of it."""

import json
import os
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import psutil

from deploy.launcher import Launcher
from deploy.recorder import events
from tests.live_runs import DEADLINE_S, until
from tests.rogue import Plan
from wire import channels, codec
from wire.credentials import OBSERVERS, OPERATORS, SUPERVISOR, Book, Credential, fresh, hand_over
from wire.link import open_client
from wire.messages import Action, Reply, Request

TICKS = 250
VICTIMS = ("r2", "r3")
SPARE, OTHER_SPARE = "r6", "r7"
LISTENING_TICKS = 10
OVERSIZE = 9 * 1024 * 1024
SCENARIO = f"""
mission = "area"
duration_s = {TICKS}
field = {{ kind = "grid", columns = 8, rows = 8 }}
robots = {{ count = 4, behaviour = "lr_pt", spares = 2 }}
clock = {{ kind = "paced", rate = 5 }}
radio = {{ rules = [{{ kind = "range", range_m = 90 }}] }}
"""


class Process:
    """A rogue process and what it told."""

    def __init__(self, plan: Plan) -> None:
        descriptor = hand_over(msgspec.msgpack.encode(plan))
        command = [sys.executable, "-m", "tests.rogue", str(descriptor)]
        pipe = subprocess.PIPE
        self._popen = subprocess.Popen(command, pass_fds=[descriptor], stdin=pipe, stdout=pipe, text=True)
        os.close(descriptor)
        self.told: dict[str, Any] = {"pid": self._popen.pid}

    def read(self) -> dict[str, Any]:
        """Wait for the next line and take it over; nothing at the end."""
        line = self._popen.stdout.readline()
        self.told |= json.loads(line) if line else {}
        return self.told

    def go_on(self) -> None:
        """Let it attack, or, after that, tell what it heard and end."""
        self._popen.stdin.write("\n")
        self._popen.stdin.flush()

    def end(self) -> None:
        """Nothing is left."""
        self._popen.kill()
        self._popen.communicate()


class Siege(NamedTuple):
    """All that was seen of a run while rogues attacked it."""

    folder: Path
    book: Book
    rogues: dict[str, dict[str, Any]]
    events: list[dict[str, Any]]
    sockets: dict[str, list[Any]]
    public: dict[str, bytes]
    operator_file: tuple[int, int]
    operator_file_left: bool
    alive_after: list[str]

    def heard_by(self, rogue: str) -> set[str]:
        """Keys of everything that a rogue heard or was answered, without the run's prefix."""
        told = self.rogues[rogue]
        prefix = f"picket/{self.book.run}/"
        return {one.replace(prefix, "") for one in told["heard"] + told["replies"]}


def rogues_of(book: Book) -> dict[str, Plan]:
    """Every rogue by name; all of them try everything."""

    def plan(credential: Credential | None, own: str = "", say: tuple[bytes, ...] = ()) -> Plan:
        return Plan(book.run, book.endpoint, credential, VICTIMS, own, say)

    def borrowed(user: str) -> Credential:
        password = book.ticket(user).credential.password
        return Credential(user, password, fresh(user).session)

    return {
        "nobody": plan(None),
        "guesser": plan(fresh("r2")),
        "spare": plan(book.nodes[SPARE], SPARE, garbage()),
        "twin": plan(book.nodes["r2"]),
        "twin of the launcher": plan(book.others[SUPERVISOR]),
        "thief": plan(borrowed("r2")),
        "thief of the launcher": plan(borrowed(SUPERVISOR)),
        "observer": plan(book.others[OBSERVERS[1]]),
        "operator": msgspec.structs.replace(plan(book.others[OPERATORS[0]]), may_ask=True),
    }


def garbage() -> tuple[bytes, ...]:
    """100 messages of every kind that no world should take for an action."""
    stale = codec.encode(Action(0, 0, None, (b"hear me",), 1))
    frames = codec.encode(Action(1, 1, None, (bytes(100_000),) * 3, 2))
    kinds = (b"", b"\x00", b"\xff" * 64, b"\x01\xc1", b"\x02" + stale[1:], stale[:-1], stale, frames)
    return (bytes(OVERSIZE), *(kinds * 13)[:99])


def attack(launcher: Launcher, ticks: list[int], folder: Path) -> dict[str, Any]:
    """Let all rogues loose on a live run; returns what was seen."""
    until(lambda: ticks, "the first tick")
    plans = rogues_of(launcher.book)
    rogues = {name: Process(plan) for name, plan in plans.items()}
    try:
        joined = [one for one in rogues.values() if one.read()["joined"]]
        for one in joined:  # all listen by now, whatever the others will do
            one.go_on()
        for one in joined:
            one.read()
        enough = ticks[-1] + LISTENING_TICKS
        until(lambda: ticks[-1] >= enough, "the run to go on")
        until(lambda: refusals(folder, 100), "the world to have had all of the spare's garbage")
        seen = {"sockets": sockets(launcher), "public": public_files(launcher)}
        for one in joined:
            one.go_on()
            one.read()
    finally:
        for one in rogues.values():
            one.end()
    operator_file = next((folder.parent / "private").glob("picket-*/*.json"))
    modes = tuple(stat.S_IMODE(place.stat().st_mode) for place in (operator_file, operator_file.parent))
    alive = hurry(launcher.book)
    return seen | {
        "rogues": {name: one.told for name, one in rogues.items()},
        "operator_file": modes,
        "alive_after": alive,
    }


def hurry(book: Book) -> list[str]:
    """Let the run go on as fast as it can; returns who is alive."""
    link = open_client(book.ticket(OPERATORS[1]))
    answer = link.ask(channels.key(book.run, channels.CONTROL), codec.encode(Request("speed")), DEADLINE_S)
    link.close()
    return codec.decode(Reply, answer).data["alive"]


def refusals(folder: Path, count: int) -> list[dict[str, Any]]:
    """Events of refused actions of the spare that count so many."""
    return [one for one in events(folder) if one["kind"] == "refused" and one["data"].get("count") == count]


def sockets(launcher: Launcher) -> dict[str, list[Any]]:
    """Every socket of every process of a run, of whatever family."""
    return {
        name: psutil.Process(child.pid).net_connections("all") for name, _, child, _ in launcher.processes
    }


def public_files(launcher: Launcher) -> dict[str, bytes]:
    """What everybody can read of every process: its command line, and its environment."""
    return {
        f"{name} {what}": Path(f"/proc/{child.pid}/{what}").read_bytes()
        for name, _, child, _ in launcher.processes
        for what in ("cmdline", "environ")
    }
