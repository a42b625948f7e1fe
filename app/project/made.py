"""Results of a project that take long to make: beside its file, under the hash of what it was made from.

It is written whole or not at all and may be removed at any time. What making it took is noted in the file itself
(rows `made NAME` of `meta`), so that the program can say what it costs to make it again.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import logging
import os
import sqlite3
import stat
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import accumulate, islice
from pathlib import Path
from typing import Any

from app.project.arrays import array_name
from app.project.database import connect, explain, reading
from app.project.declared import MAX_NUMBER, can_be_opened
from app.project.project_file import data_folder, finder_of, path_of
from app.project.tidying import is_own, remove_whole
from app.project.values import DAMAGE, Absent, Keeper, decode, encode, is_there, name_of, parse
from engine.core.errors import FileError
from engine.core.figure_text import time_text
from engine.scene.material import Material

log = logging.getLogger(__name__)

_ROW = "made "

#: Files of a result whose sizes are added up, at most.
MAX_FILES = 100_000

#: Words for one result of each kind, and for several.
KINDS = {
    "stack": ("an import of photographs", "imports of photographs"),
    "factors": ("a factor run", "factor runs"),
    "bake": ("a bake", "bakes"),
}


@dataclass(frozen=True)
class Made:
    """One result: its kind, its name in the data folder, what it took to make, its size, and whether it is there.

    `made_with` is what only this kind notes of how it was made.
    """

    kind: str
    name: str
    seconds: float
    size_bytes: int
    present: bool
    made_with: Mapping[str, Any] = field(default_factory=dict)


def key_of(*made_from: object, contents: Mapping[Path, str] | None = None) -> str:
    """The hash of what a result is made from: values of the document, and files, which count by their content.

    `contents` are hashes of the files that values name; these then count by name and content, wherever they lie.
    TypeError for what is not a value of the document, OSError for a file that cannot be read.
    """
    known = contents or {}
    by_content = None if contents is None else lambda path: {"file": path.name, "content": known.get(path, "")}
    keeper = Keeper(lambda text: name_of(text.encode()), lambda array, _: array_name(array), Path(), file=by_content)
    said = [hash_of(each) if isinstance(each, Path) else encode(each, keeper) for each in made_from]
    return name_of(json.dumps(said, sort_keys=True, allow_nan=False).encode())


def hash_of(path: Path) -> str:
    """BLAKE2b of the content of a file, 160 bits; OSError where it cannot be read."""
    if not path.is_file():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
    with path.open("rb") as file:
        return hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=20)).hexdigest()


def find_built_before(project: Path, recipe: tuple[Any, ...], own: Path) -> Material | None:
    """The material that a project was built with by `recipe` (`Project.recipe`), found by the recipe's hash.

    None where no state has it, or its data are gone. What lies in the folder `own` counts as lying in the project's.
    Raises InputError or OutputError where the file cannot be read.
    """
    keeper = Keeper(lambda text: name_of(text.encode()), lambda array, _: array_name(array), data_folder(project), own)
    name = name_of(json.dumps(encode(recipe, keeper), sort_keys=True, allow_nan=False).encode())
    statement = "SELECT parts FROM state WHERE parts LIKE ? ORDER BY rowid DESC"
    with reading(project) as connection, explain(project):
        row = connection.execute(statement, (f'%"built_from":"{name}"%',)).fetchone()
        finder = finder_of(project)
        try:
            found = decode(parse(finder.text(parse(row[0])["material"])), finder) if row is not None else None
        except (Absent, *DAMAGE) as error:
            log.info("a material that was built before is gone: %s", error)
            return None
    return found if isinstance(found, Material) and found.has_map and not finder.gone else None


def note(place: Path, kind: str, seconds: float, made_with: Mapping[str, Any] | None = None) -> None:
    """Note that `place` in a data folder was made, what that took, and what it was made with, as JSON can say it."""
    size = size_of(place)
    said = json.dumps({"kind": kind, "seconds": round(seconds, 3), "bytes": size, "made_with": made_with or {}})
    _write(path_of(place.parent), "INSERT OR REPLACE INTO meta VALUES (?, ?)", [(_ROW + place.name, said)])


def _write(project: Path, statement: str, rows: list[tuple[str, ...]]) -> None:
    """Change rows of a project file. Where it cannot be written that is only logged: the results are there or not."""
    if not project.is_file():
        return
    try:
        with connect(project) as connection, connection:
            connection.execute("BEGIN IMMEDIATE")
            connection.executemany(statement, rows)
    except (FileError, sqlite3.Error) as error:
        log.info("what results took could not be noted: %s", error)


def list_notes(project: Path) -> tuple[Made, ...]:
    """All results that a project file tells of, also those that are no longer there."""
    with connect(project) as connection:
        rows = connection.execute("SELECT name, value FROM meta WHERE name LIKE 'made %' ORDER BY name").fetchall()
    folder = data_folder(project)
    places = ((folder / Path(str(name).removeprefix(_ROW)).name, value) for name, value in rows)
    made = (_make(place, value) for place, value in places if place.parent == folder and can_be_opened(place))
    return tuple(each for each in made if each is not None)


def find_note(place: Path) -> Made | None:
    """One result that the project tells of; None where it tells nothing of it, or cannot be read."""
    project = path_of(place.parent)
    try:
        with connect(project) as connection:
            row = connection.execute("SELECT value FROM meta WHERE name = ?", (_ROW + place.name,)).fetchone()
    except (FileError, sqlite3.Error):
        return None
    return _make(place, row[0]) if row is not None else None


def _make(place: Path, text: str) -> Made | None:
    """One result; None where its row is damaged, since the document does not depend on it."""
    try:
        said = parse(text)
        is_present = is_there(place)
        size, seconds = size_of(place) if is_present else int(said["bytes"]), float(said["seconds"])
        if not (0 <= size <= MAX_NUMBER and 0.0 <= seconds < 1e12):
            return None
        return Made(str(said["kind"])[:40], place.name, seconds, size, is_present, dict(said.get("made_with", {})))
    except DAMAGE:
        return None


def size_of(place: Path) -> int:
    """Bytes of a file, or of all files in a folder, of at most `MAX_FILES`; links are not followed."""
    files = islice(place.rglob("*"), MAX_FILES) if place.is_dir() and not place.is_symlink() else [place]
    return sum(map(_size, files))


def _size(file: Path) -> int:
    try:
        about = file.lstat()
    except OSError:
        return 0
    return about.st_size if stat.S_ISREG(about.st_mode) else 0


def keep_newest(folder: Path, pattern: str, count: int, max_bytes: int = 1 << 62) -> None:
    """Remove results that match `pattern` and forget what they took, those first that were used longest ago.

    `count` of them stay at most, and `max_bytes` together; the last one stays whatever its size.
    """
    if not is_own(folder):
        return
    places = sorted(folder.glob(pattern), key=lambda place: place.stat().st_mtime, reverse=True)
    sizes = accumulate(map(size_of, places))
    kept = [at == 0 or (at < count and total <= max_bytes) for at, total in enumerate(sizes)]
    gone = [place for place, is_kept in zip(places, kept, strict=True) if not is_kept]
    for place in gone:
        remove_whole(place)
    forget(folder, gone)


def forget(folder: Path, gone: Iterable[Path]) -> None:
    """Forget what results took that were removed from the data `folder`."""
    rows: list[tuple[str, ...]] = [(_ROW + place.name,) for place in gone]
    if rows:
        _write(path_of(folder), "DELETE FROM meta WHERE name = ?", rows)


def use(place: Path) -> None:
    """Mark a result as used now, for `keep_newest`."""
    with contextlib.suppress(OSError):
        os.utime(place)


def cost_text(gone: Iterable[Made]) -> str:
    """A sentence on results that were lost and on the time that making them again takes; empty where none was."""
    lost = [each for each in gone if each.kind in KINDS]
    if not lost:
        return ""
    counts = {kind: sum(each.kind == kind for each in lost) for kind in KINDS}
    words = [
        one if counts[kind] == 1 else f"{counts[kind]} {many}" for kind, (one, many) in KINDS.items() if counts[kind]
    ]
    what = " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))
    took = time_text(sum(each.seconds for each in lost))
    return f"Gone from the data folder: {what}. Making that again takes about {took}"
