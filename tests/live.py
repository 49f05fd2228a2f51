"""Real runs for tests: processes over Zenoh, waited for by conditions and never by fixed sleeps."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec

from deploy.recorder import events
from deploy.run_folder import LiveRun as Announcement
from wire import channels, codec
from wire.link import open_client
from wire.messages import Reply, Request

PATIENCE_S = 60.0
LOOK_EVERY_S = 0.02
ROOT = Path(__file__).parents[1]


def wait_until(condition: Callable[[], Any], what: str, patience_s: float = PATIENCE_S) -> Any:
    """The condition's first true value. Fails the test, naming `what`, when there is none in time."""
    limit = time.monotonic() + patience_s
    while not (value := condition()):
        assert time.monotonic() < limit, f"waited {patience_s:.0f} s in vain for {what}"
        time.sleep(LOOK_EVERY_S)
    return value


class LiveRun:
    """`picket run SCENARIO` as a subprocess with its own private directory for what operators need.

    Use as a context manager: at the end of the block nothing of it is left, however the block ended.
    """

    def __init__(self, scenario: Path, out: Path, *options: str) -> None:
        self._out = out
        self._private = out / "private"
        self._command = [sys.executable, "-m", "deploy", "run", str(scenario), "--out", str(out),
                         "--dashboard", "off", "--json", *options]

    def __enter__(self) -> "LiveRun":
        self._private.mkdir(parents=True, mode=0o700)
        environment = os.environ | {"XDG_RUNTIME_DIR": str(self._private)}
        pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        self.process = subprocess.Popen(self._command, cwd=ROOT, env=environment, text=True, **pipes)
        return self

    def __exit__(self, *error: object) -> None:
        if self.process.poll() is None:
            self.process.terminate()
        self._finish()

    @property
    def environment(self) -> dict[str, str]:
        """The environment in which `picket` finds this run."""
        return os.environ | {"XDG_RUNTIME_DIR": str(self._private)}

    @property
    def operator_file(self) -> Path:
        """Where the run says how to reach it, while it lasts."""
        def found() -> Path | None:
            self._check_runs()
            return next(self._private.glob("picket-*/*.json"), None)

        return wait_until(found, "the operator's file")

    @property
    def folder(self) -> Path:
        """The run folder."""
        return Path(self._announcement.folder)

    @property
    def _announcement(self) -> Announcement:
        def read() -> Announcement | None:
            data = self.operator_file.read_bytes()  # it may not be written whole yet
            return msgspec.json.decode(data, type=Announcement) if data.endswith(b"}") else None

        if not hasattr(self, "_known"):
            self._known = wait_until(read, "the operator's ticket")
        return self._known

    def request(self, wanted: Request) -> Reply:
        """Ask the run for something, as the command line does, and return its answer."""
        ticket = self._announcement.ticket
        wait_until(lambda: self._check_runs() or self.events("") is not None, "the world")
        link = open_client(ticket)
        try:
            answer = link.ask(channels.key(ticket.run, channels.CONTROL), codec.encode(wanted), PATIENCE_S)
        finally:
            link.close()
        assert answer is not None, f"no answer to {wanted}"
        return codec.decode(Reply, answer)

    def status(self) -> dict[str, Any]:
        """How the run stands."""
        return self.request(Request("status")).data

    def events(self, kind: str) -> list[dict[str, Any]] | None:
        """Events of a kind so far; None while there is no event log."""
        if not (self.folder / "events.jsonl").exists():
            return None
        return [one for one in events(self.folder) if one["kind"] == kind]

    def wait(self) -> dict[str, Any]:
        """Wait for the end and return the summary; fails the test when the run failed."""
        self._finish()
        assert self.process.returncode in (0, 130), f"exit code {self.process.returncode}: {self.errors}"
        return json.loads(self.output)

    def _finish(self) -> None:
        if not hasattr(self, "output"):
            try:
                self.output, self.errors = self.process.communicate(timeout=PATIENCE_S)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.output, self.errors = self.process.communicate()
                raise

    def _check_runs(self) -> None:
        if self.process.poll() is not None and not list(self._private.glob("picket-*/*.json")):
            self._finish()
            raise AssertionError(f"the run ended with {self.process.returncode}: {self.errors}")
