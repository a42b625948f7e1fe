"""How much of its results a project holds beside its file: at most a multiple of its photographs.

Results beyond that lie in the cache of the user alone (`app.session.cache`), as the pixels of photographs do, because
the photographs give them again, bit for bit. Floats of photographs that were warped hardly compress: the slices of ten
JPEGs take 15 to 25 times as much as these. Once photographs are gone or changed, the project takes in what the cache
has.
"""

from __future__ import annotations

import contextlib
import dataclasses
import logging
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from app.document.document import Project
from app.project.arrays import (
    array_name,
    cache_array,
    check_cached,
    file_of,
    find_beside,
    folder_of,
    is_cached,
    keep_beside,
)
from app.project.database import connect, explain
from app.project.made import size_of
from app.project.photographs import photographs
from app.project.recipes import as_built, list_remakable
from app.project.tidying import names_in
from app.project.values import DAMAGE, Absent, Array, array_parts, is_name, parse
from app.session import cache
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

log = logging.getLogger(__name__)

#: Bytes of arrays beside a project file, at most, for each byte of its photographs.
MAX_TIMES = 12

#: Smaller arrays always lie beside the file, in bytes.
MIN_CACHED_BYTES = 1 << 16


@dataclasses.dataclass(frozen=True, eq=False)
class Beyond:
    """Arrays of a part of a document that lie in the cache alone, and the photographs that they can be made of."""

    arrays: tuple[Array, ...] = ()
    photographs: tuple[Path, ...] = ()

    def __contains__(self, array: Array) -> bool:
        return any(each is array for each in self.arrays)


def find_beyond(project: Project, part: str, folder: Path, own: Iterable[Path | None]) -> Beyond:
    """The arrays of the material or of the surface of `project` that have no room in its data `folder`.

    A map has room with all of its arrays or with none. All have room where the photographs do not give them again. A
    material of an earlier import is where that left it. A stack of the project may also lie in one of the folders
    `own`.
    """
    value = getattr(project, part)
    if part not in ("material", "surface") or value is None:
        return Beyond()
    files, maps = photographs(project), [list(_list_large(each)) for each in _list_maps(value)]
    before = as_built(project) if part == "material" else None
    if before is not None and before.stack is not project.stack:
        return Beyond(tuple(each for arrays in maps for each in arrays if is_cached(array_name(each))))
    taken = _add_sizes(files)
    if not any(maps) or taken is None or part not in list_remakable(project, (folder, *own)):
        return Beyond()
    left, beyond = MAX_TIMES * taken - size_of(folder_of(folder)), list[Array]()
    for arrays in maps:
        size = sum(each.nbytes for each in arrays)
        if size > left:
            beyond += arrays
        else:
            left -= size
    return Beyond(tuple(beyond), files)


def _add_sizes(files: Iterable[Path]) -> int | None:
    """Bytes of all `files`; None where one is gone."""
    try:
        return sum(file.stat().st_size for file in files)
    except OSError:
        return None


def _list_maps(value: DataclassInstance) -> Iterator[Any]:
    """The maps of a material, or of a surface."""
    for part in dataclasses.fields(value):
        each = getattr(value, part.name)
        if dataclasses.is_dataclass(each) and not isinstance(each, type):
            yield each


def _list_large(value: object) -> Iterator[Array]:
    """The arrays of a value and its parts that take room; masks hardly do."""
    if isinstance(value, np.ndarray):
        if value.nbytes >= MIN_CACHED_BYTES and value.dtype != np.bool_:
            yield value
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        for part in dataclasses.fields(value):
            yield from _list_large(getattr(value, part.name))


def keep_in_cache(project: Path, folder: Path, array: Array, files: Sequence[Path]) -> str:
    """Keep an array that the photographs `files` give again in the cache for the `project`, or where that cannot be,
    in its data `folder`; its name. Without `files` the cache knows them already."""
    name = array_name(array)
    if file_of(folder, name).exists():
        return name
    if not cache_array(name, *array_parts(array)):
        return keep_beside(folder, array)
    if files:
        note_origin(project, name, files)
    return name


def note_origin(project: Path, name: str, files: Iterable[Path]) -> None:
    """Let the cache know that a `project` needs this array, and the photographs `files` that it can be made of."""
    place = cache.entry(f"array-{name}")
    if place is not None and place.is_dir():
        cache.note_origin(place, project, files)


def secure_arrays(path: Path, folder: Path, files: Iterable[Path], *, are_gone: bool) -> Steps[None]:
    """Take what a project has in the cache alone into its data `folder` where its photographs `are_gone` or are others
    now; else let the cache know the photographs `files` that it can be made of."""
    files = tuple(files)
    for name in list_cached(path, folder):
        yield Step(0.0, "keeping results")
        if are_gone:
            take_in(folder, name)
        else:
            note_origin(path, name, files)


def take_in(folder: Path, name: str) -> None:
    """Keep an array of the cache in the data `folder` of a project as well, unless it is damaged."""
    try:
        keep_beside(folder, find_beside(folder, name))
    except Absent as error:
        log.info("a result that the cache held is gone: %s", error)


def check_arrays(path: Path, folder: Path) -> Steps[None]:
    """Read what a project has in the cache alone; what is damaged is then gone, and is made again."""
    for name in list_cached(path, folder):
        yield Step(0.0, "reading results")
        check_cached(name)


def list_cached(path: Path, folder: Path) -> list[str]:
    """Names of the arrays of a project that lie in the cache alone."""
    with connect(path) as connection, explain(path):
        inside = {row[0] for row in connection.execute("SELECT name FROM array")}
        texts = [str(row[0]) for row in connection.execute("SELECT text FROM value WHERE text LIKE '%\"array\"%'")]
    named = set[str]()
    for text in texts:
        with contextlib.suppress(*DAMAGE):
            named.update(name for kind, name in names_in(parse(text)) if kind == "array" and is_name(name))
    return [name for name in sorted(named - inside) if not file_of(folder, name).exists() and is_cached(name)]
