"""Child processes and signals: the only file that starts, stops or kills anything.

Every child is a fresh interpreter in a session of its own, so that Ctrl-C reaches only the launcher, and it
asks the kernel to die with its parent. Exits are seen through pidfds, not guessed from signals sent.
"""

import asyncio
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from subprocess import Popen

INTERRUPT, TERMINATE, KILL, STOP, CONTINUE = (
    signal.SIGINT,
    signal.SIGTERM,
    signal.SIGKILL,
    signal.SIGSTOP,
    signal.SIGCONT,
)
LADDER = ((INTERRUPT, 2.0), (TERMINATE, 2.0), (KILL, 5.0))
LAST_LINES = 12


class Child:
    """One running or ended child. `status` is None while it runs, else its exit code or minus its signal."""

    def __init__(
        self, name: str, module: str, arguments: Sequence[str], log: Path, descriptors: Sequence[int] = ()
    ) -> None:
        self.name = name
        self.log = log
        self.status: int | None = None
        self.expected = False
        """Did we order its end?"""
        self.frozen = False
        environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, "-m", module, *arguments, "--parent-pid", str(os.getpid())]
        with log.open("ab") as output:
            self._popen = Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                pass_fds=tuple(descriptors),
                env=environment,
                start_new_session=True,
            )
        for descriptor in descriptors:
            os.close(descriptor)
        self.pid = self._popen.pid
        self.ended = asyncio.Event()
        self._pidfd = os.pidfd_open(self.pid)

    def watch(self, on_exit: Callable[["Child"], None]) -> None:
        """Call `on_exit` once, from the event loop, when the process has ended."""
        asyncio.get_running_loop().add_reader(self._pidfd, self._reap, on_exit)

    def send(self, number: int) -> None:
        """Send a signal; nothing happens when the process is gone."""
        if self.status is None:
            self.frozen = number == STOP or (self.frozen and number != CONTINUE)
            signal.pidfd_send_signal(self._pidfd, number)

    async def stopped(self) -> None:
        """Wait until the kernel says that the process has stopped or ended."""
        await self._changed(os.WSTOPPED)

    async def continued(self) -> None:
        """Wait until the kernel says that the process has been continued or has ended."""
        await self._changed(os.WCONTINUED)

    async def end(self) -> None:
        """Ask, then insist, then kill; continue it first, since a stopped process hears nothing."""
        self.expected = True
        self.send(CONTINUE)
        for number, patience_s in LADDER:
            if self.status is not None:
                return
            self.send(number)
            await self.wait(patience_s)

    async def wait(self, at_most_s: float) -> bool:
        """Wait for the end. False when it did not come in time."""
        try:
            await asyncio.wait_for(self.ended.wait(), at_most_s)
        except TimeoutError:
            return False
        return True

    def last_lines(self) -> str:
        """The end of what the process wrote."""
        lines = self.log.read_text("utf-8", errors="replace").splitlines() if self.log.exists() else []
        return "\n".join(lines[-LAST_LINES:])

    async def _changed(self, what: int) -> None:
        wait = what | os.WEXITED | os.WNOWAIT
        await asyncio.get_running_loop().run_in_executor(None, os.waitid, os.P_PID, self.pid, wait)

    def _reap(self, on_exit: Callable[["Child"], None]) -> None:
        asyncio.get_running_loop().remove_reader(self._pidfd)
        self.status = self._popen.wait()
        os.close(self._pidfd)
        self.ended.set()
        on_exit(self)


def on_interrupt(handler: Callable[[], None]) -> None:
    """Call `handler` from the event loop on Ctrl-C and on a request to terminate."""
    loop = asyncio.get_running_loop()
    for number in (INTERRUPT, TERMINATE):
        loop.add_signal_handler(number, handler)


def on_interrupt_now() -> Callable[[], bool]:
    """For code without an event loop: returns a function that says whether Ctrl-C was pressed since."""
    pressed: list[int] = []
    for number in (INTERRUPT, TERMINATE):
        signal.signal(number, lambda number, frame: pressed.append(number))
    return lambda: bool(pressed)


# A viewer is not our program: it is made to end with its parent before it becomes the viewer.
_WRAPPER = (
    "import os, sys; from wire.credentials import die_with_parent; "
    "die_with_parent(int(sys.argv[1])); os.execv(sys.argv[2], sys.argv[2:])"
)


def start_viewer(command: list[str], log: Path, environment: dict[str, str]) -> "Popen[bytes]":
    """Start another program so that it ends with this process; what it prints goes to `log`.

    Call it on the main thread: the kernel takes the thread that starts a child for its parent.
    """
    wrapped = [sys.executable, "-c", _WRAPPER, str(os.getpid()), *command]
    log.parent.mkdir(exist_ok=True)
    with log.open("wb") as output:
        return Popen(
            wrapped,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
            env=os.environ | environment,
            start_new_session=True,
        )


def commit() -> str | None:
    """The commit of this source tree, with a + where files differ from it; None where git knows none."""
    answers = []
    for question in (["rev-parse", "--short", "HEAD"], ["status", "--porcelain", "--untracked-files=no"]):
        try:
            asked = ["git", *question]
            here = Path(__file__).parent
            answers.append(subprocess.run(asked, cwd=here, capture_output=True, text=True, check=True).stdout)
        except (OSError, subprocess.CalledProcessError):
            return None
    return answers[0].strip() + "+" * bool(answers[1])
