"""The project file: an SQLite database of the states of a document and the steps between them.

Its tables are those of `app.project.database`. SQLite was weighed against a folder of JSON files and a zip: it alone
changes a file in place so that a process or a machine may end at any moment, writes what changed and no more, and stays
one file that can be copied and mailed. It runs with a rollback journal, because the write-ahead log needs shared
memory, which network drives lack.

Names are hashes of contents. Arrays that can be made again lie in `NAME.lap-data/arrays`, as far as they have room
there (`app.project.budget`), stacks of photographs in `NAME.lap-data/stack-HASH`, named by what they were made from;
both may be deleted.
"""

from __future__ import annotations

import contextlib
import datetime
import json
import os
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any, cast
from urllib.parse import unquote_to_bytes

import numpy as np

import engine
from app.document.document import Project, Step
from app.project.arrays import array_name, find_beside, keep_beside
from app.project.database import Damaged, Guarded, connect, explain, reading
from app.project.declared import problem_of
from app.project.tidying import forget_unused
from app.project.values import (
    DAMAGE,
    Absent,
    Array,
    Finder,
    Keeper,
    array_from,
    array_parts,
    decode,
    encode,
    find_path,
    in_full,
    is_name,
    name_of,
    parse,
)
from engine.core.errors import OutputError
from engine.storage.atomic import discard, make_folder, perform
from engine.storage.partial_names import is_partial
from engine.storage.scratch import scratch_array
from engine.storage.text import whole_number

ENDING = ".lap"
_DATA = "-data"

#: The row of `meta` that names the data folder of a project until it has its place.
WAITING = "data folder"

#: Steps of the undo history that a file keeps.
KEPT_STEPS = 200

#: Values that say nothing where they are also the default.
NOTHING = (None, "", "auto", ())

#: Largest number of steps that a file may name.
MAX_POSITION = 10**6

#: Bytes of an array that are written at once.
PIECE_BYTES = 1 << 20

#: Writes until what no state needs any more is removed.
TIDY_EVERY = 200


@dataclass(frozen=True, eq=False)
class History:
    """Content of the file at one moment: the current document, the steps, and how many of them lead to it."""

    current: Project
    steps: tuple[Step, ...] = ()
    position: int = 0

    @property
    def kept(self) -> History:
        """The latest `KEPT_STEPS` steps, those that can be done again included."""
        gone = max(0, len(self.steps) - KEPT_STEPS)
        return History(self.current, self.steps[gone:], max(0, self.position - gone))


def data_folder(path: Path) -> Path:
    """`NAME.lap-data` beside `NAME.lap`, in full: places of photographs are told from it, wherever a process stands."""
    return in_full(path.with_name(path.name + _DATA))


def path_of(folder: Path) -> Path:
    """`NAME.lap` beside its `NAME.lap-data`; another folder is not a project's, and gets a name that nothing has."""
    name = folder.name.removesuffix(_DATA)
    return folder.with_name(name if name.endswith(ENDING) else folder.name + ENDING)


class Writer:
    """Writes histories to one project file; what the file has already is not written again.

    `write` may be interrupted at any moment by the end of the process: the file then holds the history before or after.
    """

    def __init__(self, path: Path, *, seen_from: Path | None = None, own: Path | None = None) -> None:
        """A copy is written as `seen_from` another data folder; what lies in the folder `own` counts as lying there."""
        self.path = path
        self._seen = (seen_from or data_folder(path), own)
        self._opened = contextlib.ExitStack()
        self._connection: Guarded | None = None
        self._inode = self._device = -1
        self._writes = 0
        self._known: dict[int, tuple[Any, str]] = {}

    def write(self, history: History) -> None:
        """Make the file hold `history`. Raises OutputError or InputError where that is impossible; try it again."""
        history = history.kept
        connection = self._ready()
        with explain(self.path), connection:
            connection.execute("BEGIN IMMEDIATE")
            rows = [
                (at, step.text, step.gesture, self._state(connection, step.old), self._state(connection, step.new))
                for at, step in enumerate(history.steps)
            ]
            current = self._state(connection, history.current)
            there = connection.execute("SELECT number, text, gesture, old, new FROM step ORDER BY number").fetchall()
            if there != rows:
                same = next(
                    (at for at, (a, b) in enumerate(zip(there, rows, strict=False)) if a != b),
                    min(len(there), len(rows)),
                )
                connection.execute("DELETE FROM step WHERE number >= ?", (same,))
                connection.executemany("INSERT INTO step VALUES (?, ?, ?, ?, ?)", rows[same:])
            meta = [("position", str(history.position)), ("current", current), ("name", history.current.name)]
            meta.append(("software", f"lightarc {engine.__version__}"))
            was = set(connection.execute("SELECT name, value FROM meta"))
            if there != rows or not was.issuperset(meta[:2]):
                meta.append(("changed", datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")))
            connection.executemany("INSERT OR REPLACE INTO meta VALUES (?, ?)", meta)
        states = [state for step in history.steps for state in (step.old, step.new) if not isinstance(state, str)]
        states.append(history.current)
        self._writes += 1
        if self._writes % TIDY_EVERY == 0:
            forget_unused(connection, data_folder(self.path))
        held = {id(getattr(state, part.name)) for state in states for part in fields(state)} | set(map(id, states))
        self._known = {key: known for key, known in self._known.items() if key in held}

    def close(self) -> None:
        """Forget what no state needs any more, and let go of the file."""
        if self._connection is not None:
            with contextlib.suppress(sqlite3.Error, OSError):  # what is left over is removed the next time
                forget_unused(self._connection, data_folder(self.path), stacks=True)
        self._let_go()

    def _let_go(self) -> None:
        self._opened.close()
        self._connection, self._known = None, {}

    @property
    def is_there(self) -> bool:
        """True unless the file was removed or replaced since it was written."""
        return self._connection is None or self._inode == _inode(self.path)

    def _ready(self) -> Guarded:
        """The connection; a new file where somebody has removed or replaced the one that was there.

        Raises OutputError where its folder went as well: whoever makes that anew hides what comes back.
        """
        if self._connection is None or not self.is_there:
            self._let_go()
            if self._device not in (-1, _device(self.path.parent)):
                raise OutputError(self.path, "its folder is gone", "Bring it back, or save the project elsewhere")
            make_folder(data_folder(self.path))
            self._connection = self._opened.enter_context(connect(self.path, create=True))
            self._inode, self._device = _inode(self.path), _device(self.path.parent)
        return self._connection

    def _state(self, connection: Guarded, state: Project | str) -> str:
        if isinstance(state, str):
            return state
        known = self._known.get(id(state))
        if known is not None:
            return known[1]
        parts = {}
        for part, value in _list_said_parts(state):
            kept = self._known.get(id(value))
            if kept is None:
                kept = (value, _keep_value(value, self._keeper(connection, state, part)))
                self._known[id(value)] = kept
            parts[part] = kept[1]
        text = _text_of(parts)
        name = name_of(text.encode())
        connection.execute("INSERT OR IGNORE INTO state VALUES (?, ?)", (name, text))
        self._known[id(state)] = (state, name)
        return name

    def _keeper(self, connection: Guarded, state: Project, part: str) -> Keeper:
        """Storage for a part of a state: what has no room beside the file goes into the cache."""
        from app.project.budget import find_beyond, keep_in_cache  # it reads projects

        folder, (seen_from, own) = data_folder(self.path), self._seen
        beyond = find_beyond(state, part, folder, self._seen)

        def keep_array(array: Array, derived: bool) -> str:
            if array in beyond:
                return keep_in_cache(path_of(seen_from), folder, array, beyond.photographs)
            return keep_beside(folder, array) if derived else _keep_inside(connection, array)

        return Keeper(partial(_keep_text, connection), keep_array, seen_from, own)


def _inode(path: Path) -> int:
    try:
        return path.stat().st_ino
    except OSError:
        return -1


def _device(folder: Path) -> int:
    """The number of the drive that holds a folder; -2 where it is gone."""
    try:
        return folder.stat().st_dev
    except OSError:
        return -2


def state_name(state: Project, folder: Path) -> str:
    """The name that a state has in a project file whose data lie in `folder`; nothing is written.

    Arrays are hashed, which takes a second a gigabyte or so.
    """
    keeper = Keeper(lambda text: name_of(text.encode()), lambda array, _: array_name(array), folder)
    parts = {name: _keep_value(value, keeper) for name, value in _list_said_parts(state)}
    return name_of(_text_of(parts).encode())


def _list_said_parts(state: Project) -> Iterator[tuple[str, Any]]:
    """The parts of a state that its text names: without those that say nothing, as they are in a new document."""
    for part in fields(state):
        value = getattr(state, part.name)
        if not (part.default in NOTHING and value in NOTHING):
            yield part.name, value


def _text_of(parts: Mapping[str, str]) -> str:
    """A state as text, as short as may be: there is one for each step of a session."""
    return json.dumps(parts, sort_keys=True, separators=(",", ":"))


def _keep_value(value: object, keeper: Keeper) -> str:
    return keeper.text(json.dumps(encode(value, keeper), sort_keys=True, allow_nan=False))


def _keep_text(connection: Guarded, text: str) -> str:
    name = name_of(text.encode())
    connection.execute("INSERT OR IGNORE INTO value VALUES (?, ?)", (name, text))
    return name


def _keep_inside(connection: Guarded, array: Array) -> str:
    header, numbers = array_parts(array)
    name = name_of(header, numbers)
    if connection.execute("SELECT 1 FROM array WHERE name = ?", (name,)).fetchone() is None:
        _insert(connection, name, header, numbers)
    return name


def _insert(connection: Guarded, name: str, header: bytes, numbers: memoryview) -> None:
    """Keep an array in the file, a piece at a time: to copy it whole would hold up the thread of the window."""
    size = len(header) + len(numbers)
    with connection.long_values():
        row = connection.execute("INSERT INTO array VALUES (?, zeroblob(?))", (name, size)).lastrowid or 0
    with connection.blobopen("array", "content", row) as blob:
        blob.write(header)
        for start in range(0, len(numbers), PIECE_BYTES):
            blob.write(numbers[start : start + PIECE_BYTES])


def _blob(connection: Guarded, row: int) -> memoryview:
    """The content of an array in the file, read piece by piece."""
    with connection.blobopen("array", "content", row, readonly=True) as blob:
        content = scratch_array((len(blob),), np.uint8).data
        for start in range(0, len(blob), PIECE_BYTES):
            content[start : start + PIECE_BYTES] = blob.read(PIECE_BYTES)
    return content


def waiting_name(partial: str) -> str:
    """The name of a data folder between its partial name and its own: it is whole, and its file may be in place."""
    return partial.replace(".partial-", ".waiting-")


def is_waiting(name: str) -> bool:
    """True for the names that `waiting_name` gives to data folders."""
    return name.endswith(_DATA) and ".waiting-" in name and is_partial(name.replace(".waiting-", ".partial-"))


def settle(path: Path) -> None:
    """Give a project that took the place of another its data folder, where that was interrupted.

    Raises OutputError where the old folder cannot be removed.
    """
    with connect(path) as connection:
        row = connection.execute("SELECT value FROM meta WHERE name = ?", (WAITING,)).fetchone()
        if row is None:
            return
        folder, waiting = data_folder(path), path.with_name(Path(os.fsdecode(unquote_to_bytes(str(row[0])))).name)
        partial = waiting.name.replace(".waiting-", ".partial-")
        is_own = is_partial(partial.removesuffix(_DATA)) and waiting.name.startswith(f".{path.stem[:16]}")
        if is_own and waiting.name.endswith(_DATA) and waiting.is_dir() and not waiting.is_symlink():
            discard(folder)
            perform("rename", folder, lambda: waiting.rename(folder))
        with explain(path), connection:
            connection.execute("DELETE FROM meta WHERE name = ?", (WAITING,))


@dataclass(frozen=True, eq=False)
class Opened:
    """A project that was read: the current document, a function that reads other states by name, and the steps.

    `missing` are the parts whose data are gone ('mesh', 'shading_map' of the material), with the kind of those; they
    are None in the document.
    """

    current: Project
    state: Callable[[str], Project]
    steps: tuple[Step, ...]
    position: int
    missing: Mapping[str, str]


class DamagedState(Damaged):
    """A document with damaged parts: what is wrong with each of them, and the `sound` values of the others."""

    def __init__(self, path: Path, wrong: Mapping[str, str], sound: Mapping[str, Any]) -> None:
        super().__init__(path, "; ".join(wrong.values()))
        self.wrong, self.sound = wrong, sound


def read(path: Path, *, thorough: bool = False) -> Opened:
    """Open a project file; `thorough` also searches large arrays for numbers that are not finite.

    Raises InputError where it is none, damaged, or of a newer version.
    """
    settle(path)
    with reading(path):
        return _read(path, thorough)


def _read(path: Path, thorough: bool) -> Opened:
    with reading(path) as connection, explain(path):
        meta = dict(connection.execute("SELECT name, value FROM meta WHERE name IN ('current', 'position')"))
        steps = steps_in(connection)
    finder = finder_of(path, thorough=thorough)
    missing: dict[str, str] = {}
    if "current" not in meta:
        if steps:
            raise Damaged(path, "it has a history, and no document")
        return Opened(Project(), lambda name: read_state(path, name, finder, {}), (), 0, {})
    current = read_state(path, meta["current"], finder, missing)
    position = whole_number(meta.get("position", "0"), MAX_POSITION)
    if position is None:
        raise Damaged(path, "its position in the history is not a number")
    missing |= dict.fromkeys(finder.gone, "data that can be made again")
    return Opened(current, lambda name: read_state(path, name, finder, {}), steps, min(position, len(steps)), missing)


def steps_in(connection: Guarded) -> tuple[Step, ...]:
    """The history that a project file keeps, its states by their names."""
    rows = connection.execute("SELECT text, gesture, old, new FROM step ORDER BY number LIMIT ?", (KEPT_STEPS,))
    return tuple(Step(str(text), str(gesture), str(old), str(new)) for text, gesture, old, new in rows)


def read_state(path: Path, name: str, finder: Finder, missing: dict[str, str]) -> Project:
    """The document of one state; parts whose data are gone are as in a new document, and listed in `missing`.

    Raises DamagedState where parts are damaged, and InputError where all of it is gone.
    """
    key = f"state {name}"
    if key in finder.made:
        return cast(Project, finder.made[key])
    with reading(path) as connection, explain(path):
        row = connection.execute("SELECT parts FROM state WHERE name = ?", (name,)).fetchone()
        if row is None:
            raise Damaged(path, "a state of its history is gone")
        parts, wrong = dict[str, Any](), dict[str, str]()
        for part, value in parts_in(str(row[0]), path).items():
            try:
                parts[part] = read_part(part, value, finder)
            except Absent as gone:
                missing[part] = str(gone)
            except DAMAGE as error:
                wrong[part] = describe_problem(part, error)
    if wrong:
        raise DamagedState(path, wrong, parts)
    finder.made[key] = made = Project(**parts)
    return made


def parts_in(text: str, path: Path) -> dict[str, str]:
    """The names of the values of a state, by part; InputError where the text is not a state."""
    try:
        parts = parse(text)
    except (ValueError, RecursionError):
        parts = None
    if not isinstance(parts, dict) or not all(isinstance(value, str) for value in parts.values()):
        raise Damaged(path, "a state of its history is not a list of parts")
    known = {part.name for part in fields(Project)}
    return {part: value for part, value in parts.items() if part in known}


def describe_problem(part: str, error: Exception) -> str:
    """Describe the problem with a part in a few words."""
    said = " ".join(str(error).split())[:160] if isinstance(error, ValueError) else ""
    return said if said.startswith(f"{part} ") else f"{part}: {said or 'no value of a project'}"


def read_part(part: str, value: str, finder: Finder) -> Any:
    """The value of one part of a document, the same object for all states that share it."""
    key = f"part {part} {value}"
    if key not in finder.made:
        finder.work.nodes = finder.work.deepest = 0
        with np.errstate(all="ignore"):
            found = decode(parse(finder.text(value)), finder)
            problem = problem_of(Project, {part: found})
        if problem:
            raise ValueError(problem)
        finder.made[key] = found
    return finder.made[key]


def finder_of(path: Path, *, thorough: bool = False) -> Finder:
    """Read values of a project file; nothing stays open for undo."""
    folder = data_folder(path)

    def find_text(name: str) -> str:
        with reading(path) as connection, explain(path):
            row = connection.execute("SELECT text FROM value WHERE name = ?", (name,)).fetchone()
        if row is None or name_of(str(row[0]).encode()) != name:
            raise ValueError("a value is gone or damaged")
        return str(row[0])

    def find_array(name: str) -> Array:
        if not is_name(name):
            raise ValueError(f"no name of an array: {name!r:.60}")
        with reading(path) as connection, explain(path):
            row = connection.execute("SELECT rowid FROM array WHERE name = ?", (name,)).fetchone()
            content = _blob(connection, row[0]) if row is not None else None
        if content is None:
            return find_beside(folder, name)
        if name_of(content) != name:
            raise Absent("data that can be made again")
        return array_from(content)

    with reading(path) as connection, explain(path):
        return Finder(find_text, find_array, folder, places_of(connection, folder), thorough=thorough)


def places_of(connection: sqlite3.Connection, folder: Path) -> dict[str, Path]:
    """Places of photographs that a user found again (`app.project.photographs`), by the path in the document."""
    places: dict[str, Path] = {}
    if connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'photograph'").fetchone() is not None:
        rows = connection.execute("SELECT place, now FROM photograph WHERE now IS NOT NULL").fetchall()
        for place, now in rows:
            with contextlib.suppress(*DAMAGE):
                places[str(parse(place)["path"])] = find_path(parse(now), folder)
    return places
