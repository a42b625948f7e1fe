"""The record of a batch: an SQLite file in the folder of its results that says of each capture how far it is.

A capture is waiting, running, done or failed. The record is a memory of what happened and what it took; whether a
capture is done in truth its folder says (`app.batch.making`). So a batch may end at any moment: what was running is
waiting again when it goes on. One process at a time works on a batch: it holds the lock of the file.
"""

from __future__ import annotations

import contextlib
import json
import sqlite3
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from app.batch.captures import Capture, capture_from
from engine.core.errors import InputError, OutputError
from engine.storage.untrusted import read_bytes

State = Literal["waiting", "running", "done", "failed"]
STATES: tuple[State, ...] = ("waiting", "running", "done", "failed")

#: The file of the record, the number by which it is known as one, and that of its form.
FILE, APPLICATION, FORM = "batch.sqlite", 0x4C425443, 1

_STATEMENTS = (
    "CREATE TABLE capture (name TEXT PRIMARY KEY, row TEXT NOT NULL)",
    "CREATE TABLE choice (name TEXT PRIMARY KEY, value TEXT NOT NULL)",
)

#: Problems and remedies by the codes of SQLite.
_CAUSES = {
    sqlite3.SQLITE_BUSY: ("another run is at work on this batch", "Wait until it has ended, or stop it"),
    sqlite3.SQLITE_FULL: ("the disk is full", "Free some space or choose another disk"),
    sqlite3.SQLITE_READONLY: ("writing here is not permitted", "Choose another folder or change its permissions"),
}


_REMEDY = "Remove it, and name the captures again: those that are done are not made again"


#: The file by which the folder of a capture is known, and the bytes of the largest that is read.
FOLDER_RECORD, _RECORD_LIMIT_BYTES = "capture.json", 1 << 24


@dataclass(frozen=True)
class Row:
    """The state of one capture, and its results.

    Attributes
    ----------
    stamp : of the files and choices that it was made from (`app.batch.run`), '' before that.
    reason : why it failed, in a sentence.
    seconds : that making it took; None where nobody measured it.
    record : figures and files of its folder (`FOLDER_RECORD`).
    """

    capture: Capture
    state: State = "waiting"
    stamp: str = ""
    reason: str = ""
    seconds: float | None = None
    record: dict[str, Any] = field(default_factory=dict)


class Record:
    """An open record, which this process alone may change."""

    def __init__(self, connection: sqlite3.Connection, path: Path) -> None:
        self._connection, self._path = connection, path

    def rows(self) -> list[Row]:
        """All captures, in the order in which they joined."""
        with _explain(self._path):
            found = self._connection.execute("SELECT row FROM capture ORDER BY rowid").fetchall()
            return [_row_from(json.loads(text)) for (text,) in found]

    def put(self, rows: Iterable[Row]) -> None:
        """Write what is known of some captures now, new ones included, whole or not at all.

        It is there after the end of this process; after that of the machine perhaps not the latest.
        """
        values = [(row.capture.name, json.dumps({**vars(row), "capture": row.capture.as_text()})) for row in rows]
        statement = "INSERT INTO capture VALUES (?, ?) ON CONFLICT(name) DO UPDATE SET row = excluded.row"
        with _explain(self._path), self._connection:
            self._connection.executemany(statement, values)

    def choices(self) -> dict[str, Any]:
        """The choices of the latest run."""
        with _explain(self._path):
            rows = self._connection.execute("SELECT name, value FROM choice").fetchall()
            return {str(name): json.loads(value) for name, value in rows}

    def choose(self, choices: dict[str, Any]) -> None:
        """Keep the choices of this run for those that go on with it."""
        with _explain(self._path), self._connection:
            rows = [(name, json.dumps(value)) for name, value in choices.items()]
            self._connection.executemany("INSERT OR REPLACE INTO choice VALUES (?, ?)", rows)


def read_folder(folder: Path) -> dict[str, Any] | None:
    """The record of a capture that was made; None where there is none, or it is damaged."""
    try:
        found = json.loads(read_bytes(folder / FOLDER_RECORD, _RECORD_LIMIT_BYTES))
    except (InputError, ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) and found.get("lightarc_capture") == 1 else None


def read_rows(folder: Path) -> list[Row]:
    """The captures of the batch in `folder`, none where there is no batch; raises as `open_record`."""
    if not (folder / FILE).is_file():
        return []
    with open_record(folder) as record:
        return record.rows()


def _row_from(said: dict[str, Any]) -> Row:
    """The row that was written as `said`; ValueError or TypeError where it is none."""
    row = Row(**{**said, "capture": capture_from(said["capture"])})
    texts = (row.stamp, row.reason)
    is_number = row.seconds is None or isinstance(row.seconds, int | float)
    if row.state not in STATES or not all(isinstance(text, str) for text in texts) or not is_number:
        raise ValueError("a row holds values of other types")
    if not isinstance(row.record, dict):
        raise ValueError("a record is none")
    return row


@contextlib.contextmanager
def open_record(folder: Path) -> Iterator[Record]:
    """The record of the batch in `folder`, a new one where there is none, held by this process within the block.

    Raises InputError where the file is no record or damaged, OutputError where another process holds it or it cannot be
    written.
    """
    path = folder / FILE
    with _explain(path):
        connection = sqlite3.connect(path, timeout=1.0)
    with contextlib.closing(connection):
        with _explain(path):
            connection.execute("PRAGMA locking_mode = EXCLUSIVE")  # so that its log needs no memory that is shared
            connection.execute("PRAGMA trusted_schema = OFF")
            connection.execute("BEGIN EXCLUSIVE")
            about = [connection.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version")]
            if about == [0, 0] and not connection.execute("SELECT 1 FROM sqlite_master").fetchone():
                for statement in _STATEMENTS:
                    connection.execute(statement)
                connection.execute(f"PRAGMA application_id = {APPLICATION}")
                connection.execute(f"PRAGMA user_version = {FORM}")
                about = [APPLICATION, FORM]
            connection.commit()
        if about[0] != APPLICATION:
            raise InputError(path, "is not the record of a batch", "Choose another folder for the results")
        if about[1] != FORM:
            raise InputError(path, "was made by a newer version", "Update Lightarc")
        with _explain(path):
            found = [row[0] for row in connection.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL")]
            if sorted(found) != sorted(_STATEMENTS):
                raise ValueError("it holds tables that no batch has")
            connection.execute("PRAGMA journal_mode = WAL")
            connection.execute("PRAGMA synchronous = NORMAL")
        yield Record(connection, path)


@contextlib.contextmanager
def _explain(path: Path) -> Iterator[None]:
    """Errors of SQLite within the block as those of the file."""
    try:
        yield
    except sqlite3.Error as error:
        code = getattr(error, "sqlite_errorcode", 0) & 0xFF
        if isinstance(error, sqlite3.OperationalError) and code in (
            *_CAUSES,
            sqlite3.SQLITE_CANTOPEN,
            sqlite3.SQLITE_IOERR,
        ):
            said = (f"cannot be read or written ({error})", "Check the disk that it lies on")
            raise OutputError(path, *_CAUSES.get(code, said)) from error
        raise InputError(path, f"is damaged ({error})", _REMEDY) from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        problem = f"is damaged ({' '.join(str(error).split())[:80]})"
        raise InputError(path, problem, _REMEDY) from error
