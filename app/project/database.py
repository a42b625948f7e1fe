"""The database of a project: opened, checked, and made with its tables where it is new.

meta(name, value)                schema, the number of the current step, and when the document was changed last
step(number, text, gesture, old, new)   the undo history: from state to state
state(name, parts)               a document: the name of the value of each part
value(name, text)                a value (`app.project.values`)
array(name, content)             an array that cannot be made again, as .npy
photograph(place, size, modified, hash, now)   a photograph by its path: its content, and where it was found since
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
import threading
from collections.abc import Iterator
from pathlib import Path

from engine.core.errors import InputError, OutputError
from engine.storage.atomic import atomic_path

SCHEMA = 2

#: 'LARC', as SQLite's application id: `file` and other programs know the kind of the file by it.
APPLICATION = 0x4C415243

#: Seconds that a project waits for another process to end its writing.
LOCK_S = 5.0

_PHOTOGRAPHS = """
CREATE TABLE IF NOT EXISTS photograph(
    place TEXT PRIMARY KEY, size INTEGER, modified INTEGER, hash TEXT, now TEXT);
"""

_TABLES = f"""
CREATE TABLE IF NOT EXISTS meta(name TEXT PRIMARY KEY, value TEXT) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS step(number INTEGER PRIMARY KEY, text TEXT, gesture TEXT, old TEXT, new TEXT);
CREATE TABLE IF NOT EXISTS state(name TEXT PRIMARY KEY, parts TEXT);
CREATE TABLE IF NOT EXISTS value(name TEXT PRIMARY KEY, text TEXT);
CREATE TABLE IF NOT EXISTS array(name TEXT PRIMARY KEY, content BLOB);
{_PHOTOGRAPHS}
"""

#: Statements that bring a file of each older schema to the next one.
_MIGRATIONS = {1: _PHOTOGRAPHS}


@contextlib.contextmanager
def connected(path: Path, *, create: bool = False) -> Iterator[sqlite3.Connection]:
    """The database of a project, closed at the end.

    Raises InputError where it is no project or of a newer version, OutputError where it cannot be written.
    """
    if not create and not path.is_file():
        raise InputError(path, "there is no such project", "Check the name, or open the folder that it was moved to")
    mode = "rwc" if create else "rw" if os.access(path, os.W_OK) else "ro"
    try:
        connection = sqlite3.connect(
            f"{path.absolute().as_uri()}?mode={mode}", uri=True, timeout=LOCK_S, isolation_level=None
        )
    except sqlite3.Error as error:
        said = f"cannot be opened ({error})", "Check the folder's permissions and free space"
        raise OutputError(path, *(_TOO_LONG if _is_too_long(path) else said)) from error
    try:
        with explained(path):
            _check_or_make(connection, path, create)
        yield connection
    finally:
        connection.close()


_lent = threading.local()


@contextlib.contextmanager
def reading(path: Path) -> Iterator[sqlite3.Connection]:
    """As `connected`; whatever reads this project within the block, on the same thread, shares the connection."""
    lent = vars(_lent)
    if str(path) in lent:
        yield lent[str(path)]
        return
    with connected(path) as connection:
        lent[str(path)] = connection
        try:
            yield connection
        finally:
            del lent[str(path)]


def _check_or_make(connection: sqlite3.Connection, path: Path, create: bool) -> None:
    connection.execute("PRAGMA trusted_schema=OFF")
    connection.execute("PRAGMA cell_size_check=ON")
    kind = connection.execute("PRAGMA application_id").fetchone()[0]
    if kind == 0 and create and not connection.execute("SELECT 1 FROM sqlite_master").fetchone():
        connection.execute("PRAGMA auto_vacuum=INCREMENTAL")
        with connection:
            connection.executescript(f"BEGIN; PRAGMA application_id={APPLICATION}; {_TABLES}")
            connection.execute("INSERT INTO meta VALUES ('schema', ?)", (str(SCHEMA),))
        return
    if kind != APPLICATION:
        raise InputError(path, "is no project of Lightarc", "Choose a file that ends in .lap")
    schema_of(connection, path)


def schema_of(connection: sqlite3.Connection, path: Path) -> int:
    """The schema of a project; InputError where it says none, or a newer one."""
    found = dict(connection.execute("SELECT name, value FROM meta WHERE name IN ('schema', 'software')"))
    schema = str(found.get("schema"))
    if not schema.isdigit() or not 0 < int(schema) < 10**6:
        raise InputError(path, "is damaged: it does not say its version", "Open a copy of it")
    if int(schema) > SCHEMA:
        by = f"{str(found.get('software', ''))[:40]}, schema {schema}; this one reads up to {SCHEMA}".lstrip(", ")
        raise InputError(path, f"was made by a newer version ({by})", "Update Lightarc")
    return int(schema)


def migrate(path: Path) -> Path | None:
    """Bring a project of an older schema to this one, on a copy that takes its place when it is whole.

    The original is kept beside it: its path, or None where the project is of this schema. Raises OutputError where
    either cannot be written; the project is then as it was.
    """
    with connected(path) as connection, explained(path):
        schema = schema_of(connection, path)
        if schema == SCHEMA:
            return None
        kept = _free(path, schema)
        with atomic_path(kept) as partial, contextlib.closing(sqlite3.connect(partial)) as copy:
            connection.backup(copy)
        with atomic_path(path) as partial, contextlib.closing(sqlite3.connect(partial)) as copy:
            connection.backup(copy)
            upgrade(copy, path)
    return kept


def upgrade(copy: sqlite3.Connection, path: Path) -> None:
    """Bring a copy of the project at `path` to this schema."""
    with copy:
        for older in range(schema_of(copy, path), SCHEMA):
            copy.executescript(_MIGRATIONS[older])
        copy.execute("UPDATE meta SET value = ? WHERE name = 'schema'", (str(SCHEMA),))


def _free(path: Path, schema: int) -> Path:
    """A path beside that of a project, for its file as it was before its migration."""
    names = (
        f"{path.stem} (schema {schema}{more}){path.suffix}" for more in ("", *(f", {at}" for at in range(2, 1000)))
    )
    return next(other for name in names if not (other := path.with_name(name)).exists())


#: Problems and remedies by the codes of SQLite, without their further details.
_CAUSES = {
    sqlite3.SQLITE_FULL: ("the disk is full", "Free some space or choose another disk"),
    sqlite3.SQLITE_READONLY: ("writing here is not permitted", "Choose another folder or change its permissions"),
    sqlite3.SQLITE_BUSY: ("another program keeps it locked", "Close that program"),
}

_TOO_LONG = ("its path is too long", "Choose a shorter name, or a folder that is nearer to the root")

#: Bytes of the longest path that SQLite opens, less those that it adds for its journal.
LONGEST_PATH_BYTES = 512 - 9


def _is_too_long(path: Path) -> bool:
    return len(os.fsencode(path.absolute())) > LONGEST_PATH_BYTES


@contextlib.contextmanager
def explained(path: Path) -> Iterator[None]:
    try:
        yield
    except sqlite3.DatabaseError as error:
        if isinstance(error, sqlite3.OperationalError):
            said = f"cannot be read or written ({error})", "Check the disk that it lies on"
            known = _CAUSES.get(getattr(error, "sqlite_errorcode", 0) & 0xFF, said)
            raise OutputError(path, *(_TOO_LONG if _is_too_long(path) else known)) from error
        raise InputError(path, f"is damaged or no project ({error})", "Open a copy of it") from error
