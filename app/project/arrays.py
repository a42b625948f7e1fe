"""Arrays beside a project file, each a file named by the hash of its content; they can be made again.

A small one is read and checked. A large one is mapped, so that a project opens at once whatever it holds, where its
drive is that of the system or of the person's data: one that is unplugged ends a process which has mapped it. What is
mapped was written whole and is never changed under its name; `lightarc project verify` checks its content. An array
that is still the one of its file keeps the name, and is not hashed again.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from pathlib import Path

import numpy as np

from app.project.values import Absent, Array, array_from, array_parts, name_of
from engine.core.steps import Step, Steps
from engine.storage.atomic import atomic_file, make_folder
from engine.storage.partial_names import is_partial
from engine.storage.scratch import scratch_array

#: Bytes that are read or written at once, so that cancelling and other threads need not wait.
PIECE_BYTES = 1 << 24

#: Largest file of an array that is read, in bytes, and the smallest that is mapped.
MOST_BYTES, MAPPED_BYTES = 4 * 2**30, 1 << 24


class Mapped(mmap.mmap):
    """A file that is mapped, with the hash that names it."""

    name = ""


def folder_of(data: Path) -> Path:
    """The folder of arrays in the data folder of a project."""
    return data / "arrays"


def keep_beside(data: Path, array: Array) -> str:
    """Write an array into the data folder of a project, unless it is there; its name."""
    header, numbers = array_parts(array)
    name = array_name(array)
    path = folder_of(data) / f"{name}.npy"
    if not path.exists():
        make_folder(path.parent)
        with atomic_file(path, len(header) + len(numbers)) as file:
            file.write(header)
            for start in range(0, len(numbers), PIECE_BYTES):
                file.write(numbers[start : start + PIECE_BYTES])
    return name


def array_name(array: Array) -> str:
    """The hash of an array as an .npy file; of one that is mapped that of its file, without reading it."""
    header, numbers = array_parts(array)
    return _known_name(array, header) or name_of(header, numbers)


def _known_name(array: Array, header: bytes) -> str:
    """The name of the file that an array is all of; empty where it is part of one, or of none."""
    owner: object = array
    while isinstance(owner, np.ndarray):
        owner = owner.base
    if not isinstance(owner, Mapped) or not array.flags.c_contiguous:
        return ""
    return owner.name if len(owner) == len(header) + array.nbytes and owner[: len(header)] == header else ""


def find_beside(data: Path, name: str) -> Array:
    """The array of this name in the data folder of a project. Raises Absent where it is gone or damaged."""
    path = folder_of(data) / f"{name}.npy"
    try:
        content = _mapped(path, name) or _read(path)
    except OSError as error:
        raise Absent("data that can be made again") from error
    if not isinstance(content, Mapped) and name_of(content) != name:
        raise Absent("data that can be made again")
    return array_from(content)


def _mapped(path: Path, name: str) -> Mapped | None:
    """A large file on a drive that stays; None for any other."""
    about = path.stat()
    if os.name != "posix" or not MAPPED_BYTES <= about.st_size <= MOST_BYTES or about.st_dev not in _lasting_drives():
        return None
    with path.open("rb") as file:
        mapped = Mapped(file.fileno(), 0, access=mmap.ACCESS_READ)
    mapped.name = name
    return mapped


def _lasting_drives() -> set[int]:
    """Numbers of the drives of temporary files and of the person's home."""
    places = (Path(tempfile.gettempdir()), Path(os.path.expanduser("~")))  # noqa: PTH111 - Path.home raises without one
    return {place.stat().st_dev for place in places if place.is_dir()}


def _read(path: Path) -> memoryview:
    """The content of a file, which no other copy of it is made of; OSError where it is gone, too large or changes."""
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise OSError("too large")
    content = scratch_array((size,), np.uint8).data
    with path.open("rb", buffering=0) as file:
        read = 0
        while part := file.readinto(content[read : read + PIECE_BYTES]):
            read += part
    if read != size:
        raise OSError("it changes")
    return content


def damaged(data: Path) -> Steps[list[str]]:
    """Names of the arrays in the data folder of a project whose content is another than it was; all are read."""
    found, paths = list[str](), sorted(each for each in folder_of(data).glob("*.npy") if not is_partial(each.name))
    for at, path in enumerate(paths):
        yield Step(at / len(paths), f"reading {path.name}")
        try:
            is_whole = name_of(_read(path)) == path.stem
        except OSError:
            is_whole = False
        if not is_whole:
            found.append(path.name)
    return found
