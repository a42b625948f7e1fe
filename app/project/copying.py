"""Copies of projects: as they are, and collected, with their photographs inside."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from app.project.database import connected, upgrade
from app.project.photographs import INSIDE, copy_places, photographs, relocate
from app.project.places import remove
from app.project.project_file import data_folder, read
from engine.core.errors import InputError, OutputError
from engine.core.steps import Step, Steps
from engine.storage.atomic import atomic_file, explaining, make_folder


def copy(source: Path, target: Path, *, with_derived: bool = True) -> Steps[Path]:
    """Copy the project `source`, its history and its data to `target`; its file comes last.

    Raises OutputError where `target` exists or cannot be written; then nothing of it stays.
    """
    folder = data_folder(target)
    if target.exists() or folder.exists():
        raise OutputError(target, "exists already", "Choose another name, or remove it first")
    with _whole_or_not_at_all(target):
        yield from _copied_files(data_folder(source), folder, with_derived)
        _copy_database(source, target)
        copy_places(source, target)
    return target


def collect(source: Path, target: Path, with_derived: bool = True) -> Steps[Path]:
    """Copy `source` to `target` with its photographs inside, so that it opens on another machine.

    Photographs that are missing are an InputError that names the first. Raises OutputError as `copy` does.
    """
    gone = [path for path in photographs(read(source).current) if not path.is_file()]
    if gone:
        raise InputError(gone[0], f"is missing ({len(gone)} of the photographs)", "Say where they are now, or copy")
    yield from copy(source, target, with_derived=with_derived)
    with _whole_or_not_at_all(target):
        yield from _with_photographs_inside(target)
    return target


@contextmanager
def _whole_or_not_at_all(target: Path) -> Iterator[None]:
    """Remove what was written of `target` unless the block ends well."""
    is_whole = False
    try:
        with explaining(target):
            yield
        is_whole = True
    finally:
        if not is_whole:
            remove(target)


def _with_photographs_inside(target: Path) -> Steps[None]:
    """Copy the photographs into the data folder, and note that they are there, for every state of the history."""
    inside = data_folder(target) / INSIDE
    files = [path for path in photographs(read(target).current) if not path.is_relative_to(inside)]
    places = {path: inside / f"{at + 1:04d}" / path.name for at, path in enumerate(files)}
    for at, (path, place) in enumerate(places.items()):
        yield Step(at / len(places), f"copying {path.name}")
        _copy_file(path, place)
    relocate(target, places)
    yield Step(1.0, "collected")


def _copied_files(source: Path, target: Path, with_derived: bool) -> Steps[None]:
    """The data folder without the marks of windows that have it open."""
    make_folder(target)
    files = [path for path in source.rglob("*") if path.is_file() and not path.name.startswith(("open-", "job-"))]
    if not with_derived:
        files = [path for path in files if path.relative_to(source).parts[0] == INSIDE]
    for at, path in enumerate(files):
        yield Step(at / len(files), f"copying {path.name}")
        _copy_file(path, target / path.relative_to(source))


def _copy_file(source: Path, target: Path) -> None:
    make_folder(target.parent)
    with source.open("rb") as there, atomic_file(target, source.stat().st_size) as here:
        shutil.copyfileobj(there, here, 1 << 22)


def _copy_database(source: Path, target: Path) -> None:
    with connected(source) as there:
        copy_ = sqlite3.connect(target)
        try:
            there.backup(copy_)
            upgrade(copy_, target)
        finally:
            copy_.close()
