"""`picket bench`, tiny: what it prints, what it refuses, what it leaves behind. No timing is asserted."""

import os
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

ROOT = Path(__file__).parent.parent
TOKEN = "PICKET_TEST_BENCH"


def bench(*options: str) -> subprocess.CompletedProcess:
    """Run the command and return its output; its processes carry a mark in their environment."""
    environment = os.environ | {TOKEN: str(os.getpid())}
    command = [sys.executable, "-m", "deploy", "bench", *options]
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120)


def left_behind() -> list[psutil.Process]:
    """Living processes that carry the mark."""
    found = []
    for process in psutil.process_iter():
        try:
            if process.environ().get(TOKEN) == str(os.getpid()):
                found.append(process)
        except (psutil.NoSuchProcess, psutil.AccessDenied, psutil.ZombieProcess):
            continue
    return found


def test_prints_floor_and_picket_side_by_side_and_leaves_no_process() -> None:
    """Both sides, their ratio, the world's and the minds' share, and memory; one row for each size."""
    done = bench("--sizes", "1", "3", "--ticks", "5", "--rounds", "2")
    assert done.returncode == 0, done.stderr
    for heading in ("floor", "Picket", "ticks/s", "ratio", "apart", "world", "minds", "RSS", "PSS"):
        assert heading in done.stdout
    rows = [line.split() for line in done.stdout.splitlines() if line.strip()[:1].isdigit()]
    assert [row[0] for row in rows] == ["1", "3"]
    assert all(len(row) == 10 and all(float(number) > 0 for number in row) for row in rows)
    assert "N = 3: processor time per tick" in done.stdout
    assert not left_behind()


@pytest.mark.parametrize(("option", "value"), [("--ticks", "0"), ("--sizes", "0"), ("--rounds", "-1")])
def test_refuses_what_cannot_be_measured(option: str, value: str) -> None:
    """One line that names the option and the value, and exit code 2."""
    done = bench(option, value)
    assert done.returncode == 2
    assert done.stderr.startswith(f"picket: {option}: must be a whole number >= 1, got '{value}'")
