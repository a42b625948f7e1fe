"""Copies of projects: as they are, and collected, with their photographs inside."""

from __future__ import annotations

import dataclasses
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from app.document.document import Project
from app.project.database import connected
from app.project.places import remove
from app.project.project_file import History, Writer, data_folder, read
from engine.capture.lights.sources import Sources
from engine.core.errors import InputError, OutputError
from engine.core.steps import Step, Steps
from engine.storage.atomic import atomic_file, explaining, make_folder

PHOTOGRAPHS = "photographs"


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


def photographs(project: Project) -> tuple[Path, ...]:
    """All files that the capture of a project was read from, each once."""
    return tuple(dict.fromkeys(_files_of(project.sources))) if project.sources is not None else ()


def _files_of(sources: Sources) -> Iterator[Path]:
    yield from sources.photographs
    for exposures in sources.exposures:
        yield from (exposure.path for exposure in exposures)
    yield from (path for path in (sources.dark, sources.flat, sources.reference) if path is not None)


def _with_photographs_inside(target: Path) -> Steps[None]:
    """Copy the photographs into the data folder, and let the current document find them there."""
    opened = read(target)
    inside = data_folder(target) / PHOTOGRAPHS
    places: dict[Path, Path] = {}
    files = photographs(opened.current)
    for at, path in enumerate(files):
        yield Step(at / len(files), f"copying {path.name}")
        places[path] = inside / f"{at + 1:04d}" / path.name
        _copy_file(path, places[path])
    if files:
        assert opened.current.sources is not None
        current = dataclasses.replace(opened.current, sources=moved(opened.current.sources, places))
        writer = Writer(target)
        writer.write(History(current, opened.steps, opened.position))
        writer.close()
    yield Step(1.0, "collected")


def moved(sources: Sources, places: dict[Path, Path]) -> Sources:
    """The same photographs at other places."""

    def place(path: Path | None) -> Path | None:
        return None if path is None else places.get(path, path)

    return dataclasses.replace(
        sources,
        photographs=tuple(places.get(path, path) for path in sources.photographs),
        exposures=tuple(
            tuple(dataclasses.replace(each, path=places.get(each.path, each.path)) for each in exposures)
            for exposures in sources.exposures
        ),
        dark=place(sources.dark),
        flat=place(sources.flat),
        reference=place(sources.reference),
        control_points={places.get(path, path): points for path, points in sources.control_points.items()},
    )


def _copied_files(source: Path, target: Path, with_derived: bool) -> Steps[None]:
    """The data folder without the marks of windows that have it open."""
    make_folder(target)
    files = [path for path in source.rglob("*") if path.is_file() and not path.name.startswith("open-")]
    if not with_derived:
        files = [path for path in files if path.relative_to(source).parts[0] == PHOTOGRAPHS]
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
        finally:
            copy_.close()
