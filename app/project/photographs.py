"""Photographs of a project: marks by which each is known again, wherever it was moved and whatever became of it.

A mark is the size, the time of change and the hash of a photograph as it was imported. A file of the same size and
time counts as unchanged; any other is hashed, about a second a gigabyte. Marks lie in the table `photograph` of the
project file under the path that the document names; what a user found elsewhere is noted beside them, so that every
state of the history finds it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import sqlite3
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from app.document.document import Project
from app.document.variation import images_of
from app.project.database import connect, explain
from app.project.project_file import data_folder, places_of
from app.project.values import DAMAGE, encode_path, find_path, in_full, is_there, parse, paths_of
from engine.capture.lights.sources import Sources
from engine.core.errors import InputError
from engine.core.steps import Step, Steps
from engine.storage.untrusted import FILE_LIMIT_BYTES, open_checked

#: Names that a sentence lists; of more it gives the number.
MAX_NAMES = 3

#: Files that a folder may hold in which photographs are looked for, folders within it included.
MAX_FILES = 100_000

#: Photographs that lie within the data folder because they came from an archive, or because all was collected.
INSIDE = "photographs"

_PIECE = 1 << 22


@dataclass(frozen=True)
class Mark:
    """A photograph as it was: bytes, time of change in nanoseconds, and BLAKE2b of its content, 160 bits."""

    size: int
    modified: int
    hash: str


@dataclass(frozen=True)
class Checked:
    """Photographs that are gone, those whose content is another, and marks that are new: of files that had none, or
    whose time has changed."""

    missing: tuple[Path, ...] = ()
    changed: tuple[Path, ...] = ()
    new: Mapping[Path, Mark] = field(default_factory=dict)


def photographs(project: Project) -> tuple[Path, ...]:
    """All files that the capture of a project is read from, each once."""
    if project.sources is None:
        return ()
    choices = (project.import_choices, project.imported_with)
    frames = (
        frame
        for each in choices
        if each is not None
        for frame in (each.dark, each.flat, each.chart, each.lens, each.mask)
    )
    return tuple(dict.fromkeys((*_files_of(project.sources), *(each for each in frames if isinstance(each, Path)))))


def files_of(project: Project) -> tuple[Path, ...]:
    """The files outside a project that it is read from, each once: photographs, and images that the BRDF follows."""
    return tuple(dict.fromkeys((*photographs(project), *images_of(project.variations))))


def _files_of(sources: Sources) -> Iterator[Path]:
    yield from sources.photographs
    for exposures in sources.exposures:
        yield from (exposure.path for exposure in exposures)
    yield from (sources.crossed[path] for path in sources.photographs if path in sources.crossed)
    yield from (path for path in (sources.dark, sources.flat, sources.reference) if path is not None)


def take_marks(files: Iterable[Path]) -> Steps[dict[Path, Mark]]:
    """The marks of `files` as they are now, without those that cannot be read."""
    marks: dict[Path, Mark] = {}
    files = tuple(files)
    for at, path in enumerate(files):
        mark = yield from _mark(path, at / len(files))
        if mark is not None:
            marks[path] = mark
    return marks


def _mark(path: Path, done: float) -> Steps[Mark | None]:
    yield Step(done, f"looking at {path.name}")
    try:
        digest = hashlib.blake2b(digest_size=20)
        with open_checked(path, FILE_LIMIT_BYTES) as (file, left):
            about = os.fstat(file.fileno())
            while left > 0 and (piece := file.read(min(left, _PIECE))):
                digest.update(piece)
                left -= len(piece)
                yield Step(done, f"looking at {path.name}")
    except (OSError, InputError):
        return None
    return Mark(about.st_size, about.st_mtime_ns, digest.hexdigest())


def keep(project: Path, marks: Mapping[Path, Mark]) -> None:
    """Write marks into a project file that is there. Raises OutputError where that cannot be done."""
    _put(project, [(path, mark, None) for path, mark in marks.items()])


def outside_of(project: Path, files: Iterable[Path]) -> tuple[Path, ...]:
    """Those of `files` that lie outside the folder of a project, links followed."""
    folder = os.path.realpath(in_full(project).parent)
    return tuple(each for each in files if not Path(os.path.realpath(each)).is_relative_to(folder))


def relocate(project: Path, places: Mapping[Path, Path]) -> None:
    """Note for photographs where they are now; every state of the history finds them there.

    Raises OutputError where that cannot be written.
    """
    marks = marks_of(project)
    _put(project, [(old, marks.get(in_full(old)), new) for old, new in places.items()])


def _put(project: Path, rows: Iterable[tuple[Path, Mark | None, Path | None]]) -> None:
    folder = data_folder(project)
    if not project.is_file():
        return
    with connect(project) as connection, explain(project), connection:
        connection.execute("BEGIN IMMEDIATE")
        if not _has_marks(connection):
            return
        for path, mark, now in rows:
            about = (mark.size, mark.modified, mark.hash) if mark is not None else (0, 0, "")
            names = {_text(path, folder), *_names_of(connection, folder, path)}
            if now is None:
                statement = "UPDATE photograph SET size = ?, modified = ?, hash = ? WHERE place = ?"
                connection.execute("INSERT OR IGNORE INTO photograph(place) VALUES (?)", (_text(path, folder),))
                connection.executemany(statement, [(*about, name) for name in names])
            else:
                found = [(name, *about, _text(now, folder)) for name in names]
                connection.executemany("INSERT OR REPLACE INTO photograph VALUES (?, ?, ?, ?, ?)", found)


def _text(path: Path, folder: Path) -> str:
    return json.dumps(encode_path(path, folder), sort_keys=True)


def _has_marks(connection: sqlite3.Connection) -> bool:
    return connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'photograph'").fetchone() is not None


def _names_of(connection: sqlite3.Connection, folder: Path, path: Path) -> list[str]:
    """Rows that tell of the photograph at `path`."""
    rows = connection.execute("SELECT place, now FROM photograph").fetchall()
    return [str(place) for place, now in rows if in_full(path) in _paths(place, now, folder)]


def _paths(place: str | None, now: str | None, folder: Path) -> Iterator[Path]:
    """Paths that one row stands for, the least certain first; none where it is damaged."""
    for said in (place, now):
        with contextlib.suppress(*DAMAGE):
            yield from paths_of(parse(said), folder) if said is not None else ()


def copy_places(source: Path, target: Path) -> None:
    """Let the copy of a project find every file where the project finds it, and no other beside itself."""
    there, here = data_folder(source), data_folder(target)
    with connect(target) as connection, explain(target):
        places = places_of(connection, there)
        texts = [text for (text,) in connection.execute("SELECT text FROM value WHERE text LIKE '%\"near\"%'")]
    outside = dict[str, Path]()
    for text in texts:
        with contextlib.suppress(*DAMAGE):
            for said in _paths_in(parse(text)):
                path = find_path(said, there, places)
                if is_there(path) and not path.is_relative_to(there):
                    outside[json.dumps(said, sort_keys=True)] = path
    statement = "INSERT INTO photograph VALUES (?, 0, 0, '', ?) ON CONFLICT(place) DO UPDATE SET now = excluded.now"
    with connect(target) as connection, explain(target), connection:
        connection.execute("BEGIN IMMEDIATE")
        connection.executemany(statement, [(place, _text(path, here)) for place, path in outside.items()])


def _paths_in(said: object) -> Iterator[Mapping[str, Any]]:
    """Paths within a value that are also known as seen from the project."""
    if isinstance(said, Mapping) and isinstance(said.get("near"), str) and isinstance(said.get("path"), str):
        yield said
    elif isinstance(said, list | Mapping):
        for part in said.values() if isinstance(said, Mapping) else said:
            yield from _paths_in(part)


def marks_of(project: Path) -> dict[Path, Mark]:
    """Marks of a project by the paths that its photographs have, had, or have as seen from it."""
    return marks_in(_list_marked_rows(project), data_folder(project))


def _list_marked_rows(project: Path) -> list[tuple[Any, ...]]:
    """Place in the words of the project, place now, size, time of change and hash of each photograph with a mark."""
    with connect(project) as connection, explain(project):
        if not _has_marks(connection):
            return []
        statement = "SELECT place, now, size, modified, hash FROM photograph WHERE hash != ''"
        return connection.execute(statement).fetchall()


def marks_in(rows: Iterable[tuple[Any, ...]], folder: Path) -> dict[Path, Mark]:
    """The marks of rows (place, now, size, modified, hash) of the table, by all paths that they stand for."""
    found: dict[Path, Mark] = {}
    for place, now, size, modified, content in rows:
        if isinstance(size, int) and isinstance(modified, int) and isinstance(content, str):
            found |= dict.fromkeys(_paths(place, now, folder), Mark(size, modified, content))
    return found


def check(project: Path, files: Iterable[Path], *, thorough: bool = False) -> Steps[Checked]:
    """Compare `files` with their marks; `thorough` reads also those whose size and time are as they were.

    One that has its mark by where it was, or as seen from the project, is new at its place: it has to be known by its
    content when the project has moved on alone. One that has no mark gets none, since nobody but the maker of the
    project says that it is a photograph: `collect` copies only what was marked when it was imported, or when a user
    chose its folder (`find_moved`).
    """
    rows, files, folder = _list_marked_rows(project), tuple(files), data_folder(project)
    marks, said = marks_in(rows, folder), {str(row[0]) for row in rows}
    missing, changed, new = list[Path](), list[Path](), dict[Path, Mark]()
    for at, path in enumerate(files):
        yield Step(at / len(files), f"looking at {path.name}")
        known = marks.get(in_full(path))
        try:
            about = path.stat()
        except OSError:
            missing.append(path)
            continue
        is_said = _text(path, folder) in said
        if known is not None and not thorough and (about.st_size, about.st_mtime_ns) == (known.size, known.modified):
            if not is_said:
                new[path] = known
            continue
        mark = yield from _mark(path, at / len(files))
        if mark is None:
            missing.append(path)
        elif known is not None and mark.hash != known.hash:
            changed.append(path)
        elif known is not None and (mark != known or not is_said):
            new[path] = mark
    return Checked(tuple(missing), tuple(changed), new)


def find_moved(project: Path, missing: Iterable[Path], folder: Path) -> Steps[dict[Path, Path]]:
    """The places within `folder` of photographs that are missing, by their content; one without a mark by its name.

    Raises InputError where `folder` cannot be read or holds more than `MAX_FILES`.
    """
    yield Step(0.0, "looking through the folder")
    marks, missing = marks_of(project), tuple(missing)
    wanted = {path: marks.get(in_full(path)) for path in missing}
    sizes = {mark.size for mark in wanted.values() if mark is not None}
    by_name, by_hash = defaultdict[str, list[Path]](list), defaultdict[str, list[Path]](list)
    there = list(_all_files(folder))
    for at, path in enumerate(there):
        by_name[path.name].append(path)
        if _size_of(path) in sizes:
            mark = yield from _mark(path, at / len(there))
            if mark is not None:
                by_hash[mark.hash].append(path)
    places: dict[Path, Path] = {}
    for old, known in wanted.items():
        found = by_hash[known.hash] if known is not None else by_name[old.name]
        same_name = [path for path in found if path.name == old.name]
        if len(found) == 1 or (known is not None and found):
            places[old] = (same_name or found)[0]
    return places


def _all_files(folder: Path) -> Iterator[Path]:
    def refuse(error: OSError) -> None:
        if error.filename == str(folder):
            raise InputError(folder, f"cannot be read ({os.strerror(error.errno or 0)})", "Check its permissions")

    count = 0
    for place, _, names in os.walk(folder, onerror=refuse):
        count += len(names)
        if count > MAX_FILES:
            raise InputError(folder, f"holds more than {MAX_FILES:,} files", "Choose the folder of the photographs")
        yield from (Path(place, name) for name in sorted(names))


def _size_of(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return -1


def name_files(files: Sequence[Path]) -> str:
    """The beginning of a sentence: names of files, or their number, with its verb."""
    if len(files) > MAX_NAMES:
        return f"{len(files)} photographs, {files[0].name} among them, are"
    names = " and ".join(filter(None, (", ".join(each.name for each in files[:-1]), files[-1].name)))
    return f"{names} {'is' if len(files) == 1 else 'are'}"


def describe_changed(files: Sequence[Path]) -> str:
    """A sentence without its full stop: which photographs are not those that were imported."""
    was = "it was when it was" if len(files) == 1 else "they were when they were"
    return f"{name_files(files)} not as {was} imported"
