"""Rerun's viewer as a process of ours: native where there is a display, else for a browser."""

import os
import socket
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Literal, NamedTuple
from urllib.parse import quote

from deploy.process import Popen, start_viewer

Mode = Literal["native", "web", "file"]
START_WITHIN_S = 30.0
LOOPBACK = "127.0.0.1"


class ViewerError(Exception):
    """The viewer did not start; the text says what to look at."""


class Viewer(NamedTuple):
    """A viewer's process, where to send data to, and what a person opens to see it."""

    process: Popen
    url: str
    address: str
    ports: tuple[int, ...]
    log: Path

    def wait_until_open(self) -> None:
        """Wait until all its ports answer. Raises ViewerError."""
        until = time.monotonic() + START_WITHIN_S
        for port in self.ports:
            while not _answers(port):
                if self.process.poll() is not None or time.monotonic() > until:
                    raise ViewerError(f"the viewer did not start; {self.log} says why")
                time.sleep(0.05)

    def explain_end(self) -> int:
        """0 when a person closed it. Raises ViewerError when it ended otherwise."""
        status = self.process.wait()
        if status != 0:
            raise ViewerError(f"the viewer ended with status {status}; {self.log} says why")
        return 0


def choose_mode(wanted: str) -> Mode:
    """`auto` is native where there is a display, else web; any other mode is what it is."""
    if wanted != "auto":
        return wanted
    return "native" if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") else "web"


def launch(mode: Mode, log: Path, *options: str, **environment: str) -> Viewer:
    """Start a viewer that ends with this process. `options`: recordings to open, or flags of `rerun`."""
    grpc, web = _free_ports()
    command = [_executable(), "--bind", LOOPBACK, "--port", str(grpc), "--memory-limit", "1GB"]
    url = f"rerun+http://{LOOPBACK}:{grpc}/proxy"
    if mode == "web":
        command += ["--serve-web", "--web-viewer-port", str(web), "--server-memory-limit", "256MB", *options]
        address = f"http://{LOOPBACK}:{web}/?url={quote(url, safe='')}"
        return Viewer(start_viewer(command, log, environment), url, address, (grpc, web), log)
    command += ["--hide-welcome-screen", *options]
    return Viewer(start_viewer(command, log, environment), url, url, (grpc,), log)


def open_recording(path: Path, mode: Mode, say: Callable[[str], None] = print) -> int:
    """Show a recording until the viewer ends, or Ctrl-C; tells `say` where. Returns the exit status."""
    viewer = launch(mode, path.parent / "logs" / "viewer.log", str(path))
    try:
        viewer.wait_until_open()
        say(viewer.address if mode == "web" else f"the viewer shows {path}; close it, or press Ctrl-C")
        return viewer.process.wait()
    except KeyboardInterrupt:
        return 0
    finally:
        viewer.process.kill()


def _executable() -> str:
    """The viewer itself: `rerun` on the path is a Python program around it, with a process id of its own."""
    package = find_spec("rerun_cli")
    if package is None:
        raise ViewerError("there is no viewer here: install rerun-sdk")
    return str(Path(package.origin).parent / "rerun")


def _free_ports() -> list[int]:
    """Two ports that are free now."""
    with socket.socket() as first, socket.socket() as second:
        for one in (first, second):
            one.bind((LOOPBACK, 0))
        return [one.getsockname()[1] for one in (first, second)]


def _answers(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex((LOOPBACK, port)) == 0
