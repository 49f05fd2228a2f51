"""The tower's ledger: what was written is there after a kill, and the same grant again replaces."""

import os
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

from tests.test_architecture import ROOT
from tower.desk import Entry
from tower.ledger import Ledger, LedgerError

WRITER = """
import sys
from tower.desk import Entry
from tower.ledger import Ledger
ledger = Ledger(sys.argv[1])
for grant in range(10**9):
    ledger.write(grant, 10 * grant, [Entry("heard", "r2", place, 8.5, grant, "patrol") for place in range(3)])
    print(grant, flush=True)
"""


def heard(node: str, segment: int, battery_v: float = 9.0, text: str = "patrol", tick: int = 0) -> Entry:
    return Entry("heard", node, segment, battery_v, 0, text, tick)


def test_entries_come_back_in_order_with_their_ticks(tmp_path: Path):
    ledger = Ledger(tmp_path / "ledger.sqlite")
    ledger.write(3, 40, [Entry("born"), Entry("order", "r2", 1, number=40000)])
    ledger.write(10, 90, [heard("r2", 1)])
    again = Ledger(tmp_path / "ledger.sqlite")
    kinds = [(one.kind, one.tick) for one in again.read(11)]
    assert kinds == [("born", 40), ("order", 40), ("heard", 90)]
    assert again.read(11)[1] == Entry("order", "r2", 1, number=40000, tick=40)


def test_the_same_grant_again_replaces(tmp_path: Path):
    ledger = Ledger(tmp_path / "ledger.sqlite")
    for _ in range(2):
        ledger.write(1, 5, [heard("r2", 1), heard("r3", 2)])
    ledger.write(2, 6, [heard("r2", 1), heard("r3", 2)])
    ledger.write(2, 6, [heard("r9", 3)])
    assert [(one.node, one.tick) for one in ledger.read(9)] == [("r2", 5), ("r3", 5), ("r9", 6)]


def test_grants_that_never_counted_are_discarded_for_good(tmp_path: Path):
    ledger = Ledger(tmp_path / "ledger.sqlite")
    for grant in range(6):
        ledger.write(grant, grant, [heard("r2", grant)])
    assert [one.segment for one in ledger.read(4)] == [0, 1, 2, 3]
    assert [one.segment for one in ledger.read(100)] == [0, 1, 2, 3]


def test_there_is_no_file_before_the_first_entry(tmp_path: Path):
    ledger = Ledger(tmp_path / "ledger.sqlite")
    assert list(ledger.read(7)) == []
    assert list(tmp_path.iterdir()) == []


def test_people_find_assignments_and_batteries(tmp_path: Path):
    ledger = Ledger(tmp_path / "ledger.sqlite")
    ledger.write(1, 5, [heard("r2", 1, 9.0), heard("r3", 2, 8.9)])
    ledger.write(2, 8, [heard("r2", 0, 8.4, "home low"), Entry("order", "r3", 4, number=8000)])
    with sqlite3.connect(tmp_path / "ledger.sqlite") as base:
        assert base.execute("SELECT * FROM assignments ORDER BY node").fetchall() == [
            ("r2", 0, "home low", 8),
            ("r3", 2, "patrol", 5),
        ]
        assert base.execute("SELECT * FROM batteries ORDER BY node").fetchall() == [
            ("r2", 8.4, 8),
            ("r3", 8.9, 5),
        ]


@pytest.mark.parametrize("damage", [b"this is no database" * 100, b"SQLite format 3\0" + b"\xff" * 5000])
def test_a_damaged_file_is_an_error_that_names_it(tmp_path: Path, damage: bytes):
    path = tmp_path / "ledger.sqlite"
    path.write_bytes(damage)
    with pytest.raises(LedgerError, match=str(path)):
        Ledger(path).read(1)
    with pytest.raises(LedgerError, match=str(path)):
        Ledger(path).write(1, 1, [Entry("born")])


def test_a_folder_that_is_gone_is_an_error_that_names_the_file(tmp_path: Path):
    with pytest.raises(LedgerError, match="gone/ledger.sqlite"):
        Ledger(tmp_path / "gone" / "ledger.sqlite").write(1, 1, [Entry("born")])


@pytest.mark.parametrize("lines", [1, 50, 400])
def test_everything_written_before_a_kill_is_there(tmp_path: Path, lines: int):
    path = tmp_path / "ledger.sqlite"
    child = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path)], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    with child.stdout:
        for _ in range(lines):
            last = int(child.stdout.readline())
        os.kill(child.pid, signal.SIGKILL)
        last = max([last, *(int(line) for line in child.stdout.read().split("\n")[:-1])])
    child.wait()
    found = [(one.number, one.segment) for one in Ledger(path).read(10**9)]
    wanted = [(grant, place) for grant in range(last + 1) for place in range(3)]
    assert found[: len(wanted)] == wanted
    assert len(found) % 3 == 0, "a grant is there as a whole or not at all"
    assert len(found) <= len(wanted) + 3
