"""Run folders: where everything of a run is kept, and how a run is found by its id.

What an operator needs to reach a live run, its password included, is not in the run folder, which people
share, but in a private directory of the user's, and only while the run lasts.
"""

import contextlib
import json
import os
import tempfile
from datetime import datetime
from pathlib import Path

import msgspec

from wire.credentials import Ticket

RUNS = Path("runs")
LEDGER = "ledger.sqlite"
"""In a run folder: what its tower wrote down, where its behaviour does."""


class RunError(Exception):
    """A run that cannot be found or reached; the text says which and what to do."""


class LiveRun(msgspec.Struct, frozen=True):
    """What an operator needs to reach a live run."""

    folder: str
    tickets: tuple[Ticket, ...]
    launcher_pid: int


def new_folder(scenario: str, parent: Path | None) -> Path:
    """A new run folder; its name is the run's id and sorts by time."""
    moment = datetime.now().strftime("%Y%m%d-%H%M%S")
    parent = parent or RUNS
    for attempt in range(100):
        suffix = f"-{attempt}" if attempt else ""
        folder = parent / f"{moment}-{scenario}{suffix}"
        try:
            (folder / "logs").mkdir(parents=True)
        except FileExistsError:
            if not parent.is_dir():
                raise RunError(f"--out {parent}: is not a directory") from None
            continue
        except OSError as error:
            raise RunError(f"--out {parent}: cannot make a run folder there: {error.strerror}") from None
        return folder
    raise RunError(f"{parent}: too many runs in one second")


def find_folder(run: str) -> Path:
    """The folder of a run given by path or id. Raises RunError."""
    for folder in (Path(run), RUNS / run):
        with contextlib.suppress(OSError):  # a name that no folder can have
            if (folder / "journal").is_file():
                return folder
    for live in live_runs():
        if Path(live.folder).name == run:
            return Path(live.folder)
    raise RunError(f"{run}: no such run; give a run folder, or the id of one in {RUNS}/")


def announce_live(live: LiveRun) -> Path:
    """Write down how to reach a live run, readable by this user only; the caller removes it at the end."""
    place = _private() / f"{Path(live.folder).name}.json"
    with os.fdopen(os.open(place, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as stream:
        stream.write(msgspec.json.encode(live))
    return place


def live_runs() -> list[LiveRun]:
    """All live runs of this user; what was left behind by launchers that were killed is removed."""
    found = []
    for place in sorted(_private().glob("*.json")):
        try:
            live = msgspec.json.decode(place.read_bytes(), type=LiveRun)
        except (msgspec.DecodeError, FileNotFoundError):
            continue
        if Path(f"/proc/{live.launcher_pid}").exists():
            found.append(live)
        else:
            place.unlink(missing_ok=True)
    return found


def find_live(run: str) -> LiveRun:
    """The live run with this id or folder. Raises RunError."""
    folder = find_folder(run).resolve()
    for live in live_runs():
        if Path(live.folder) == folder:
            return live
    raise RunError(f"{run}: is not running")


def summary_of(folder: Path) -> dict | None:
    """A finished run's summary, or None. Raises RunError when it is damaged."""
    place = folder / "summary.json"
    try:
        return json.loads(place.read_text("utf-8")) if place.is_file() else None
    except ValueError as error:
        raise RunError(f"{place}: is damaged: {error}") from None


def _private() -> Path:
    """The user's own directory for live runs. Raises RunError when somebody else owns it."""
    base = os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir()
    place = Path(base) / f"picket-{os.getuid()}"
    place.mkdir(mode=0o700, exist_ok=True)
    status = place.lstat()
    if status.st_uid != os.getuid() or status.st_mode & 0o077 or not place.is_dir():
        raise RunError(
            f"{place}: must be a directory that only you can read; remove it or set XDG_RUNTIME_DIR"
        )
    return place
