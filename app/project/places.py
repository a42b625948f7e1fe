"""Places of projects: the user's folder of those without a place of their own, and who has which open.

A window that opens a project puts a file with its writer's name (`engine.storage.writer`) into the data folder. Who
finds the file of a living process opens read-only; who finds that of a dead one knows that it was interrupted.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import platformdirs

from app.project.database import connect, explain, migrate
from app.project.project_file import ENDING, data_folder, settle
from engine.core.errors import FileError, InputError
from engine.storage.atomic import discard, make_folder, write_bytes
from engine.storage.writer import is_gone, is_own, writer

UNTITLED = "Untitled"

#: Letters of a name that is proposed, at most: file systems take 255 bytes.
LONGEST_NAME = 60

_OPEN = "open-"


def projects_folder() -> Path:
    """The folder of projects that have no place of their own yet; it may not exist."""
    return Path(platformdirs.user_data_dir("lightarc", appauthor=False)) / "projects"


def file_name(words: str, instead: str) -> str:
    """A name without ending for a file of what is called `words`, in letters that every system takes, or `instead`."""
    kept = "".join(letter if letter.isalnum() or letter in " -_." else " " for letter in words)
    return " ".join(kept.split()).strip(".")[:LONGEST_NAME] or instead


def new_path(folder: Path) -> Path:
    """A path for a new project in `folder`, named after the time, that nothing has yet."""
    stem = f"{UNTITLED} {time.strftime('%Y-%m-%d %H.%M')}"
    names = (stem if at == 1 else f"{stem} ({at})" for at in range(1, 10_000))
    paths = (folder / f"{name}{ENDING}" for name in names)
    return next(path for path in paths if not path.exists() and not data_folder(path).exists())


def is_untitled(path: Path) -> bool:
    """True for a project that nobody has given a place."""
    return path.parent == projects_folder() and path.name.startswith(UNTITLED)


def claim(path: Path) -> bool:
    """Take a project for this process; False where another one has it. Two that ask at once do not both get it.

    One of an older schema is brought to this one, and the original kept (`app.project.database.migrate`).
    """
    folder = data_folder(path)
    make_folder(folder)
    if path.is_file():
        settle(path)
    with connect(path, create=True) as connection, explain(path), connection:
        connection.execute("BEGIN IMMEDIATE")
        if is_open_elsewhere(path):
            return False
        release(path)
        write_bytes(folder / f"{_OPEN}{writer()}", b"")
    migrate(path)
    return True


def is_open_elsewhere(path: Path) -> bool:
    """True if another process has the project."""
    return any(not is_own(other) and not is_gone(other) for other in _marks(data_folder(path)))


def release(path: Path) -> None:
    """Say that this process, or one that is gone, has the project no longer."""
    for mark in _marks(data_folder(path)):
        if is_own(mark) or is_gone(mark):
            discard(mark)


@contextmanager
def hold(path: Path) -> Iterator[bool]:
    """Keep other processes from opening a project for writing within the block; True where this one has it open.

    Raises InputError where another process has it.
    """
    folder = data_folder(path)
    mark = folder / f"{_OPEN}{writer()}"
    with connect(path) as connection, explain(path), connection:
        connection.execute("BEGIN IMMEDIATE")
        if is_open_elsewhere(path):
            raise InputError(path, "is open in another window", "Close it there")
        is_open_here = mark.exists()
        if not is_open_here:
            write_bytes(make_folder(folder) / mark.name, b"")
    try:
        yield is_open_here
    finally:
        if not is_open_here:
            discard(mark)


def was_interrupted(path: Path) -> bool:
    """True if the process that had the project open ended without closing it."""
    return any(is_gone(mark) and not is_own(mark) for mark in _marks(data_folder(path)))


def interrupt(folder: Path, others: Iterable[Path] = ()) -> list[Path]:
    """Projects in `folder`, and those of `others`, that were open when their process ended, the latest first.

    One in which nothing was done is left out, and removed: a window that ended as it opened has left it.
    """
    there = {*folder.glob(f"*{ENDING}"), *(path for path in others if path.suffix == ENDING and path.is_file())}
    found = [path for path in there if was_interrupted(path)]
    empty = [path for path in found if _is_empty(path)]
    for path in empty:
        remove(path)
    return sorted(set(found) - set(empty), key=lambda path: path.stat().st_mtime, reverse=True)


def _is_empty(path: Path) -> bool:
    """True for a project without a name, a step, a result and a job; what cannot be read is none."""
    if not is_untitled(path) or any(data_folder(path).glob("job-*")):
        return False
    work = "SELECT 1 FROM step UNION ALL SELECT 1 FROM meta WHERE name LIKE 'made %' LIMIT 1"
    try:
        with connect(path) as connection, explain(path):
            return connection.execute(work).fetchone() is None
    except FileError:
        return False


def remove(path: Path) -> None:
    """Remove a project with its data."""
    for each in (path, path.with_name(path.name + "-journal"), data_folder(path)):
        discard(each)


def _marks(folder: Path) -> Iterator[Path]:
    return folder.glob(f"{_OPEN}*")
