"""The tower's ledger: an append-only history in one SQLite file, safe from a kill of the process."""

import sqlite3
from collections.abc import Sequence
from pathlib import Path

import msgspec

from tower.desk import Entry

_COLUMNS = ("kind", "node", "segment", "battery_v", "number", "text", "tick")
_LAYOUT = """
CREATE TABLE IF NOT EXISTS history (
    "grant" INTEGER NOT NULL, place INTEGER NOT NULL, tick INTEGER NOT NULL, kind TEXT NOT NULL,
    node TEXT NOT NULL, segment INTEGER NOT NULL, battery_v REAL NOT NULL, number INTEGER NOT NULL,
    text TEXT NOT NULL, PRIMARY KEY ("grant", place)
) WITHOUT ROWID;
CREATE VIEW IF NOT EXISTS last_words AS
    SELECT * FROM (SELECT *, row_number() OVER (PARTITION BY node ORDER BY "grant" DESC, place DESC) AS age
    FROM history WHERE kind = 'heard') WHERE age = 1;
CREATE VIEW IF NOT EXISTS assignments AS SELECT node, segment, text AS state, tick FROM last_words;
CREATE VIEW IF NOT EXISTS batteries AS SELECT node, battery_v, tick FROM last_words;
"""


class LedgerError(Exception):
    """A ledger that cannot be read or written; the text names the file and says why."""


class Ledger:
    """Implements swarm_agent.behaviour.Ledger for entries of the line patrol's tower.

    The file appears with the first entry. Views for people: `assignments` has the segment and state, and
    `batteries` the charge that each robot spoke of last.
    """

    def __init__(self, path: str | Path) -> None:
        self._path = Path(path)
        self._base: sqlite3.Connection | None = None

    def read(self, before_grant: int) -> Sequence[Entry]:
        """All entries of grants before this one; those of later grants are removed. Raises LedgerError."""
        if not self._path.exists():
            return ()
        try:
            with self._open() as base:
                base.execute('DELETE FROM history WHERE "grant" >= ?', (before_grant,))
                query = f'SELECT {", ".join(_COLUMNS)} FROM history ORDER BY "grant", place'
                rows = base.execute(query).fetchall()
            return [msgspec.convert(dict(zip(_COLUMNS, row, strict=True)), Entry) for row in rows]
        except (sqlite3.Error, msgspec.ValidationError) as error:
            raise self._trouble(error) from None

    def write(self, grant: int, tick: int, entries: Sequence[Entry]) -> None:
        """Keep the entries of one grant; the same grant again replaces. Raises LedgerError."""
        rows = [
            (grant, place, tick, one.kind, one.node, one.segment, one.battery_v, one.number, one.text)
            for place, one in enumerate(entries)
        ]
        try:
            with self._open() as base:
                base.execute('DELETE FROM history WHERE "grant" = ?', (grant,))
                base.executemany("INSERT OR REPLACE INTO history VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)", rows)
        except sqlite3.Error as error:
            raise self._trouble(error) from None

    def close(self) -> None:
        """Let go of the file; the next use opens it again."""
        if self._base is not None:
            self._base.close()
            self._base = None

    def _open(self) -> sqlite3.Connection:
        """The open file; as a context it is one transaction."""
        if self._base is None:
            base = sqlite3.connect(self._path)
            try:
                base.execute("PRAGMA journal_mode = WAL")
                base.execute("PRAGMA synchronous = NORMAL")
                base.executescript(_LAYOUT)
            except sqlite3.Error:
                base.close()
                raise
            self._base = base
        return self._base

    def _trouble(self, error: Exception) -> LedgerError:
        self.close()
        return LedgerError(f"{self._path}: the tower's ledger cannot be used: {error}")
