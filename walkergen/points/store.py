"""Store of the records of evaluated points in the user's cache: an SQLite table that survives a killed process.

Points are found by their keys, so that jobs share them, and one that was stopped goes on.
"""

import json
import math
import sqlite3
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from walkergen.core import caches
from walkergen.core.errors import OutputError
from walkergen.points.point import Record

WAIT_S = 60.0
"""Maximum wait of a store for another program to write, s."""


class Store:
    """Records by the keys of their points. Every call raises OutputError if it cannot go on."""

    def __init__(self, path: Path | None = None) -> None:
        self.path = caches.folder("points") / "points.sqlite" if path is None else path
        try:
            self._base = sqlite3.connect(self.path, timeout=WAIT_S, isolation_level=None)
            # Kills lose nothing all the same; what a power failure tears can be computed again
            self._base.execute("PRAGMA synchronous = OFF")
            self._base.execute(
                "CREATE TABLE IF NOT EXISTS points (key TEXT PRIMARY KEY, record TEXT NOT NULL) WITHOUT ROWID"
            )
        except sqlite3.Error as error:
            raise self._storage_error(error) from None

    def get(self, keys: Sequence[str]) -> dict[str, Record]:
        """Return the stored records by key. Missing keys are left out."""
        marks = ",".join("?" * len(keys))
        try:
            rows = self._base.execute(f"SELECT key, record FROM points WHERE key IN ({marks})", keys).fetchall()
        except sqlite3.Error as error:
            raise self._storage_error(error) from None
        records = ((key, _parse_record(text)) for key, text in rows)
        return {key: record for key, record in records if record is not None}

    def save(self, rows: Iterable[tuple[str, Record]]) -> None:
        """Save pairs of key and record in one transaction: all of them or none."""
        texts = [(key, json.dumps(record, allow_nan=False)) for key, record in rows]
        if not texts:
            return
        try:
            self._base.execute("BEGIN IMMEDIATE")
            try:
                self._base.executemany("INSERT OR REPLACE INTO points VALUES (?, ?)", texts)
            except BaseException:
                if self._base.in_transaction:  # SQLite has ended it itself when the disk is full
                    self._base.execute("ROLLBACK")
                raise
            self._base.execute("COMMIT")
        except sqlite3.Error as error:
            raise self._storage_error(error) from None

    def close(self) -> None:
        """Close the file."""
        self._base.close()

    def _storage_error(self, error: Exception) -> OutputError:
        """Return an OutputError, with advice, to raise instead of an error of SQLite."""
        return OutputError(
            f"{self.path}: the store of points cannot be used: {error}. Make room, or delete the "
            "file; its points are then computed again"
        )


def _parse_record(text: Any) -> Record | None:
    """Parse a record from JSON text; None if the text is damaged or not a record."""
    try:
        record = json.loads(text)
    except (ValueError, TypeError, RecursionError):
        return None
    return record if isinstance(record, dict) and record and _is_plain(record.values()) else None


def _is_plain(values: Iterable[Any]) -> bool:
    """Return whether each value is a finite number, text or None."""
    return all(
        value is None or isinstance(value, (str, int)) or (isinstance(value, float) and math.isfinite(value))
        for value in values
    )
