"""The database of a project: opened, checked, and made with its tables where it is new.

meta(name, value)                schema, the number of the current step, and when the document was changed last
step(number, text, gesture, old, new)   the undo history: from state to state
state(name, parts)               a document: the name of the value of each part
value(name, text)                a value (`app.project.values`)
array(name, content)             an array that cannot be made again, as .npy
photograph(place, size, modified, hash, now)   a photograph by its path: its content, and where it was found since

A project may come from anybody. Before a row is read, the file has to be a database with a rollback journal of its own
(`_check_file`), with exactly the tables that this program makes and no view, trigger, index or virtual table beside
them (`_check_kind`), with values of the declared types and lengths in all columns (`_check_rows`), and, where it is
opened for the first time in this process and no larger than `CHECKED_BYTES`, with sound pages (`PRAGMA quick_check`,
about 0.3 s for 64 MB). From its opening on, SQLite's limits bound lengths and statements, an authorizer permits only
what this module's callers do, and each statement may take a number of steps that depends on the size of the file
alone (`Guarded`).
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
import stat
import threading
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from engine.core.errors import InputError, OutputError, UnreadableError
from engine.storage.atomic import as_named, atomic_path
from engine.storage.text import whole_number

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

#: Longest text of one value, and largest array within the file, in bytes.
MAX_TEXT_BYTES, MAX_ARRAY_BYTES = 64 * 2**20, 10**9

#: Types of each column as SQLite names them, and the bytes of its longest value; None where SQLite's own limit holds.
_COLUMNS: Mapping[str, Mapping[str, tuple[tuple[str, ...], int | None]]] = MappingProxyType(
    {
        "meta": {"name": (("text",), 4096), "value": (("text",), 1 << 20)},
        "step": {
            "number": (("integer",), None),
            "text": (("text",), 1 << 16),
            "gesture": (("text",), 1 << 16),
            "old": (("text",), 64),
            "new": (("text",), 64),
        },
        "state": {"name": (("text",), 64), "parts": (("text",), 1 << 16)},
        "value": {"name": (("text",), 64), "text": (("text",), None)},
        "array": {"name": (("text",), 64), "content": (("blob",), MAX_ARRAY_BYTES)},
        "photograph": {
            "place": (("text",), 1 << 16),
            "size": (("integer", "null"), None),
            "modified": (("integer", "null"), None),
            "hash": (("text", "null"), 64),
            "now": (("text", "null"), 1 << 16),
        },
    }
)

#: Limits of a connection to a project. A text that is longer than the first is refused when a statement meets it.
_LIMITS = {
    sqlite3.SQLITE_LIMIT_LENGTH: MAX_TEXT_BYTES,
    sqlite3.SQLITE_LIMIT_SQL_LENGTH: 1 << 16,
    sqlite3.SQLITE_LIMIT_COLUMN: 32,
    sqlite3.SQLITE_LIMIT_EXPR_DEPTH: 32,
    sqlite3.SQLITE_LIMIT_COMPOUND_SELECT: 8,
    sqlite3.SQLITE_LIMIT_VDBE_OP: 1 << 16,
    sqlite3.SQLITE_LIMIT_FUNCTION_ARG: 8,
    sqlite3.SQLITE_LIMIT_ATTACHED: 0,
    sqlite3.SQLITE_LIMIT_LIKE_PATTERN_LENGTH: 256,
    sqlite3.SQLITE_LIMIT_TRIGGER_DEPTH: 1,
    sqlite3.SQLITE_LIMIT_WORKER_THREADS: 0,
}

_FUNCTIONS = frozenset({"count", "length", "like", "typeof", "zeroblob"})
_PRAGMAS = frozenset({"application_id", "encoding", "incremental_vacuum", "integrity_check", "quick_check"})

#: Steps of SQLite's machine that one statement may take: so many, and so many for each byte of the file.
BASE_STEPS, STEPS_PER_BYTE = 20_000_000, 8

#: Steps between two looks at the budget.
_STEPS_PER_LOOK = 10_000

#: Pages of larger files are checked by `lightarc project verify` alone.
CHECKED_BYTES = 64 * 2**20

#: Bytes of a rollback journal beyond twice those of its project, which may have been larger before the transaction.
MAX_MORE_JOURNAL = 1 << 28

#: Bytes at the end of a rollback journal that names a super-journal, which SQLite would delete after the rollback.
_JOURNAL_MAGIC = bytes.fromhex("d9d505f920a163d7")

_NO_PROJECT = "Choose a project that Lightarc has written (.lap)"


class Damaged(InputError):
    """A project with something in it that this program does not write; what is sound can be recovered."""

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(
            path, f"is damaged ({problem})", "`lightarc project recover` saves what is sound in a new project"
        )


def unreadable(path: Path, error: OSError) -> UnreadableError:
    """The error for data that the system refused to read, with the reason."""
    cause = os.strerror(error.errno or 0)
    return UnreadableError(
        as_named(path), f"cannot be read ({cause})", "Check its permissions and the disk that it lies on"
    )


class Guarded(sqlite3.Connection):
    """A connection whose statements have a budget of work, and that permits only what a project needs.

    A statement that exceeds its budget fails with SQLITE_INTERRUPT; one that is not permitted with SQLITE_AUTH.
    """

    _left = 0
    _budget = BASE_STEPS

    def guard(self, size_bytes: int) -> None:
        """Set the limits for a file of this size, before anything of it is read."""
        for category, limit in _LIMITS.items():
            self.setlimit(category, limit)
        self._budget = BASE_STEPS + STEPS_PER_BYTE * size_bytes
        self._left = self._budget
        self.set_progress_handler(self._spend, _STEPS_PER_LOOK)
        for statement in ("trusted_schema=OFF", "cell_size_check=ON", "mmap_size=0"):
            super().execute(f"PRAGMA {statement}").fetchall()
        self.set_authorizer(_permit)

    def execute(self, *arguments: Any) -> sqlite3.Cursor:
        self._left = self._budget
        return super().execute(*arguments)

    def executemany(self, *arguments: Any) -> sqlite3.Cursor:
        self._left = self._budget
        return super().executemany(*arguments)

    @contextlib.contextmanager
    def long_values(self) -> Iterator[None]:
        """Permit values of the length of an array within the block."""
        self.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_ARRAY_BYTES)
        try:
            yield
        finally:
            self.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_TEXT_BYTES)

    def _spend(self) -> int:
        self._left -= _STEPS_PER_LOOK
        return int(self._left < 0)


def _permit(action: int, first: str | None, second: str | None, _: str | None, __: str | None) -> int:
    """The authorizer: selects, inserts, updates and deletions in the tables of a project, and transactions."""
    is_permitted = (
        action in (sqlite3.SQLITE_SELECT, sqlite3.SQLITE_TRANSACTION)
        or (action == sqlite3.SQLITE_READ and (first in _COLUMNS or first == "sqlite_master"))
        or (action in (sqlite3.SQLITE_INSERT, sqlite3.SQLITE_UPDATE, sqlite3.SQLITE_DELETE) and first in _COLUMNS)
        or (action == sqlite3.SQLITE_FUNCTION and second in _FUNCTIONS)
        or (action == sqlite3.SQLITE_PRAGMA and first in _PRAGMAS)
    )
    return sqlite3.SQLITE_OK if is_permitted else sqlite3.SQLITE_DENY


@contextlib.contextmanager
def connect(path: Path, *, create: bool = False) -> Iterator[Guarded]:
    """The database of a project, checked and guarded as the head of this module says, closed at the end.

    Raises InputError where it is not a project, is damaged or of a newer version, and OutputError where it cannot be
    written.
    """
    with _open(path, create=create) as connection:
        with explain(path):
            if create and _is_new(connection):
                _make(connection)
            else:
                _check(connection, path)
        yield connection


@contextlib.contextmanager
def salvage(path: Path) -> Iterator[tuple[Guarded, list[str]]]:
    """The database of a damaged project, to read what is sound, and the names of its tables that can be read at all.

    It is guarded as that of `connected`, and nothing but these tables is read. Columns may hold values of any type.
    Within the block `reading` gives this connection.
    Raises InputError where it is not a project at all.
    """
    with _open(path, create=False) as connection, explain(path):
        _check_kind(connection, path)
        known, found = _tables_of(SCHEMA), _objects(connection, path)
        whole = [name for kind, name in known if kind == "table" and found.get((kind, name)) == known[kind, name]]
        with _lending(path, connection):
            yield connection, whole


@contextlib.contextmanager
def _open(path: Path, *, create: bool) -> Iterator[Guarded]:
    """A guarded connection to a file that is not yet known to be a project."""
    try:
        is_there = path.is_file()
    except OSError as error:
        raise unreadable(path, error) from None
    if not create and not is_there:
        raise InputError(path, "there is no such project", "Check the name, or open the folder that it was moved to")
    size_bytes = _check_file(path)
    mode = "rwc" if create else "rw" if os.access(path, os.W_OK) else "ro"
    uri = f"{path.absolute().as_uri()}?mode={mode}"
    try:
        connection = sqlite3.connect(uri, uri=True, timeout=LOCK_S, isolation_level=None, factory=Guarded)
    except sqlite3.Error as error:
        said = f"cannot be opened ({error})", "Check the folder's permissions and free space"
        raise OutputError(path, *(_TOO_LONG if _is_too_long(path) else said)) from error
    with contextlib.closing(connection):
        with explain(path):
            connection.guard(size_bytes)
        yield connection


_lent = threading.local()


@contextlib.contextmanager
def reading(path: Path) -> Iterator[Guarded]:
    """As `connected`; whatever reads this project within the block, on the same thread, shares the connection."""
    lent = vars(_lent)
    if str(path) in lent:
        yield lent[str(path)]
        return
    with connect(path) as connection, _lending(path, connection):
        yield connection


@contextlib.contextmanager
def _lending(path: Path, connection: Guarded) -> Iterator[None]:
    vars(_lent)[str(path)] = connection
    try:
        yield
    finally:
        del vars(_lent)[str(path)]


def _check_file(path: Path) -> int:
    """The bytes of a database file, 0 for one that is not there or empty.

    Raises InputError where it is not a database with a rollback journal of its own: one with a write-ahead log would
    map a file beside it into memory, a journal that names a super-journal makes SQLite delete the file of that name,
    and one that is a device is read without an end.
    """
    try:
        with path.open("rb") as file:
            head, size_bytes = file.read(100), os.fstat(file.fileno()).st_size
    except FileNotFoundError:
        return 0
    except OSError as error:
        raise unreadable(path, error) from None
    if head and (not head.startswith(b"SQLite format 3\0") or head[68:72] != APPLICATION.to_bytes(4, "big")):
        raise InputError(path, "is not a Lightarc project", _NO_PROJECT)
    if head and head[18:20] != b"\1\1":
        raise Damaged(path, "it needs a write-ahead log, which no project has")
    for ending in ("-wal", "-shm"):  # which SQLite reads where they are there, whatever the file says of itself
        _refuse_foreign(path.with_name(path.name + ending), None)
    _refuse_foreign(path.with_name(path.name + "-journal"), 2 * size_bytes + MAX_MORE_JOURNAL)
    return size_bytes


def _refuse_foreign(beside: Path, max_bytes: int | None) -> None:
    """Raise InputError for a file beside a database that this program does not write; None: it writes no such file.

    SQLite would read it, whatever it is: without an end, a device, or a pipe for which it waits.
    """
    try:
        about = beside.lstat()
        own = max_bytes is not None and stat.S_ISREG(about.st_mode) and about.st_size <= max_bytes
        if own and about.st_size > len(_JOURNAL_MAGIC):
            with beside.open("rb") as file:
                file.seek(-len(_JOURNAL_MAGIC), os.SEEK_END)
                own = file.read() != _JOURNAL_MAGIC
    except FileNotFoundError:
        return
    except OSError as error:
        raise unreadable(beside, error) from None
    if not own:
        raise InputError(beside, "is not a Lightarc journal", "Remove it; it did not come from this program")


def _is_new(connection: sqlite3.Connection) -> bool:
    kind = connection.execute("PRAGMA application_id").fetchone()[0]
    return kind == 0 and not connection.execute("SELECT 1 FROM sqlite_master").fetchone()


def _make(connection: Guarded) -> None:
    connection.set_authorizer(None)
    connection.execute("PRAGMA auto_vacuum=INCREMENTAL")
    with connection:
        connection.executescript(f"BEGIN; PRAGMA application_id={APPLICATION}; {_TABLES}")
        connection.execute("INSERT INTO meta VALUES ('schema', ?)", (str(SCHEMA),))
    connection.set_authorizer(_permit)


#: Files whose pages were found sound in this process, by device and number.
_sound: set[tuple[int, int]] = set()


def _check(connection: Guarded, path: Path) -> None:
    """InputError for whatever is not exactly a project as this program writes it."""
    _check_kind(connection, path)
    found = _objects(connection, path)
    if ("table", "meta") not in found:
        raise Damaged(path, "it has no table meta")
    _check_rows(connection, path, "meta")
    known = _tables_of(schema_of(connection, path))
    strange = next(((kind, name) for (kind, name), sql in found.items() if known.get((kind, name), "") != sql), None)
    if strange is not None:
        raise Damaged(path, f"it holds the {strange[0]} {strange[1]!r:.60}, which no project has")
    if len(found) != len(known):
        lacking = next(name for kind, name in known if (kind, name) not in found)
        raise Damaged(path, f"it has no table {lacking}")
    for kind, table in known:
        if kind == "table":
            _check_rows(connection, path, table)
    about = path.stat()
    if about.st_size <= CHECKED_BYTES and (about.st_dev, about.st_ino) not in _sound:
        problems = page_problems(connection, "quick_check")
        if problems:
            raise Damaged(path, f"{problems[0]}")
        _sound.add((about.st_dev, about.st_ino))


def page_problems(connection: sqlite3.Connection, pragma: str = "integrity_check") -> list[str]:
    """Problems of pages and indices, as SQLite describes them, at most ten; empty for a sound file."""
    rows = connection.execute(f"PRAGMA {pragma}(10)").fetchall()
    return [" ".join(str(row[0]).split())[:120] for row in rows if row[0] != "ok"]


def _check_kind(connection: sqlite3.Connection, path: Path) -> None:
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION:
        raise InputError(path, "is not a Lightarc project", _NO_PROJECT)
    if connection.execute("PRAGMA encoding").fetchone()[0] != "UTF-8":
        raise Damaged(path, "its texts are not in UTF-8")


def _objects(connection: sqlite3.Connection, path: Path) -> dict[tuple[str, str], str]:
    """The statements that made tables and all else in the file, by kind and name; InputError where they are many."""
    statement = "SELECT type, name, tbl_name, sql FROM sqlite_master WHERE length(sql) < 1000 OR sql IS NULL LIMIT 100"
    rows = connection.execute(statement).fetchall()
    count = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
    if count != len(rows):
        raise Damaged(path, "it holds tables that no project has")
    return {(str(kind), str(name)): " ".join(f"{table} {sql}".split()) for kind, name, table, sql in rows}


@cache
def _tables_of(schema: int) -> Mapping[tuple[str, str], str]:
    """What `_objects` finds in a project of this schema, made new or brought to it from one before."""
    with contextlib.closing(sqlite3.connect(":memory:")) as connection:
        connection.executescript(_TABLES)
        if schema < 2:
            connection.execute("DROP TABLE photograph")
        return MappingProxyType(_objects(connection, Path()))


def _check_rows(connection: sqlite3.Connection, path: Path, table: str) -> None:
    """InputError for a table with a value of another type than its column has, or a longer one."""
    wrong = []
    for column, (kinds, longest) in _COLUMNS[table].items():
        named = ", ".join(f"'{kind}'" for kind in kinds)
        wrong.append(f"typeof({column}) NOT IN ({named})")
        if longest is not None:
            wrong.append(f"length({column}) > {longest}")
    if connection.execute(f"SELECT 1 FROM {table} WHERE {' OR '.join(wrong)} LIMIT 1").fetchone() is not None:
        raise Damaged(path, f"its table {table} holds values of other types or lengths")


def schema_of(connection: sqlite3.Connection, path: Path) -> int:
    """The schema of a project; InputError where it says none, or a newer one."""
    found = dict(connection.execute("SELECT name, value FROM meta WHERE name IN ('schema', 'software')"))
    schema = whole_number(found.get("schema"), 10**6)
    if not schema:
        raise Damaged(path, "it does not say its version")
    if schema > SCHEMA:
        by = f"{str(found.get('software', ''))[:40]}, schema {schema}; this one reads up to {SCHEMA}".lstrip(", ")
        raise InputError(path, f"was made by a newer version ({by})", "Update Lightarc")
    return schema


def migrate(path: Path) -> Path | None:
    """Bring a project of an older schema to this one, on a copy that takes its place when it is whole.

    The original is kept beside it: its path, or None where the project is of this schema. Raises OutputError where
    either cannot be written; the project is then as it was.
    """
    with connect(path) as connection, explain(path):
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
def explain(path: Path) -> Iterator[None]:
    try:
        yield
    except UnicodeDecodeError as error:  # of a message of SQLite's that quotes the file
        raise Damaged(path, "a text is not in UTF-8") from error
    except sqlite3.DatabaseError as error:
        code = getattr(error, "sqlite_errorcode", 0) & 0xFF
        if code == sqlite3.SQLITE_INTERRUPT:
            raise Damaged(path, "reading it takes more work than a file of its size can need") from error
        is_text = "could not decode to utf-8" in str(error).lower()
        if isinstance(error, sqlite3.OperationalError) and code != sqlite3.SQLITE_TOOBIG and not is_text:
            said = f"cannot be read or written ({error})", "Check the disk that it lies on"
            cause = _TOO_LONG if _is_too_long(path) else _CAUSES.get(code, said)
            raise OutputError(as_named(path), *cause) from error
        problem = "a text is not in UTF-8" if is_text else str(error)
        raise Damaged(path, f"{problem}") from error
