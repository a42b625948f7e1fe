"""Arrays beside a project file, compressed (`engine.storage.packed`) and named by the hash of their content.

A small one is unpacked and checked. A large one, and one that has no room in the project (`app.project.budget`), has a
working copy in the cache of the user (`app.session.cache`) that is mapped, so that a project opens at once whatever it
holds, where the drive is that of the system or of the user's data. The mapping is guarded against a file that is cut
short (`engine.storage.guarded`). What is mapped was written whole and is never changed under its name;
`lightarc project verify` checks it. An array that is still the one of its file keeps the name, and is not hashed again.
Projects of before arrays were compressed hold them as .npy files.
"""

from __future__ import annotations

import contextlib
import logging
import math
import os
import tempfile
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, cast

import numpy as np
from numpy.typing import NDArray

from app.project.values import MAX_HEADER, Absent, Array, array_from, array_parts, header_of, name_of
from app.session import cache
from engine.core.errors import FileError, InputError, UnreadableError
from engine.core.steps import Step, Steps
from engine.storage.atomic import atomic_file, atomic_folder, discard, make_folder
from engine.storage.guarded import GuardedMapping, map_file
from engine.storage.packed import PackedFile, pack
from engine.storage.partial_names import is_partial
from engine.storage.scratch import scratch_array
from engine.storage.untrusted import open_checked

log = logging.getLogger(__name__)

#: Ending of a compressed array.
PACKED = ".packed"

#: Bytes that are read or written at once, so that cancelling and other threads need not wait.
PIECE_BYTES = 1 << 24

#: The file of a working copy, within its entry of the cache.
CONTENT = "content.npy"

#: Largest array that is read, in bytes, the smallest of a project that is mapped, and the smallest mapped copy of one.
MAX_BYTES, MAPPED_BYTES, MAPPED_COPY_BYTES = 4 * 2**30, 1 << 24, 1 << 20


def folder_of(data: Path) -> Path:
    """The folder of arrays in the data folder of a project."""
    return data / "arrays"


def file_of(data: Path, name: str) -> Path:
    """The file of the array of this name in the data folder of a project; it may not exist."""
    old = folder_of(data) / f"{name}.npy"
    return old if old.exists() else folder_of(data) / f"{name}{PACKED}"


def keep_beside(data: Path, array: Array) -> str:
    """Write an array into the data folder of a project, unless it is there; its name."""
    header, numbers = array_parts(array)
    name = array_name(array)
    if not file_of(data, name).exists():
        if len(header) + len(numbers) >= MAPPED_BYTES:
            cache_array(name, header, numbers)
        _write_packed(folder_of(data) / f"{name}{PACKED}", array)
    return name


def compress(data: Path, name: str) -> None:
    """Write an array that lies in the data folder as .npy anew, compressed. Raises Absent where it is damaged."""
    _write_packed(folder_of(data) / f"{name}{PACKED}", find_beside(data, name))
    discard(folder_of(data) / f"{name}.npy")


def _write_packed(path: Path, array: Array) -> None:
    header, numbers = array_parts(array)
    make_folder(path.parent)
    with atomic_file(path) as file:
        deque(pack(file, _pieces(header, numbers), len(header) + len(numbers), array.dtype.itemsize), maxlen=0)


def keep_working_copy(data: Path, array: Array) -> None:
    """Put an array into the cache of the user, or where there is none, into the data folder of a project."""
    name = array_name(array)
    if not cache_array(name, *array_parts(array)):
        keep_beside(data, array)


def _pieces(header: bytes, numbers: memoryview) -> Iterator[bytes | memoryview]:
    yield header
    for start in range(0, len(numbers), PIECE_BYTES):
        yield numbers[start : start + PIECE_BYTES]


def cache_array(name: str, header: bytes, numbers: memoryview) -> bool:
    """Put the working copy of an array into the cache; False where it cannot be written, with a line in the log."""
    place, size = cache.entry(f"array-{name}"), len(header) + len(numbers)
    if place is None:
        return False
    if _size_of(place / CONTENT) == size:
        cache.mark_used(place)
        return True
    try:
        if place.exists():  # a working copy that was cut short
            discard(place)
        with atomic_folder(place, CONTENT, size) as folder, atomic_file(folder / CONTENT) as file:
            for piece in _pieces(header, numbers):
                file.write(piece)
        cache.keep_within()
    except FileError as error:
        log.info("an array is not cached: %s", error)
        return False
    return place.exists()  # one that is larger than the limit of the cache is gone again


def is_cached(name: str) -> bool:
    """True if the cache of the user holds the array of this name."""
    place = cache.entry(f"array-{name}")
    return place is not None and (place / CONTENT).is_file()


def check_cached(name: str) -> None:
    """Read the working copy of an array; one that is damaged is then gone, so that the array is made again."""
    place = cache.entry(f"array-{name}")
    if place is not None and (place / CONTENT).is_file():
        with contextlib.suppress(InputError, UnreadableError, FileNotFoundError):
            _read_cached(place, name)


def _read_cached(place: Path, name: str) -> memoryview:
    """The content of a working copy; InputError where it is damaged, and it is then gone."""
    content = _read(place / CONTENT)
    if name_of(content) != name:
        discard(place)
        raise InputError(place / CONTENT, "is damaged: its content is not the one of its name", "Make it again")
    return content


def array_name(array: Array) -> str:
    """The hash of an array as an .npy file; of one that is mapped that of its file, without reading it."""
    header, numbers = array_parts(array)
    return _find_known_name(array, header) or name_of(header, numbers)


def _find_known_name(array: Array, header: bytes) -> str:
    """The name of the file that an array is all of; empty where it is part of one, or of none."""
    owner: object = array
    while isinstance(owner, np.ndarray):
        owner = owner.base
    if not isinstance(owner, GuardedMapping) or not array.flags.c_contiguous:
        return ""
    return owner.name if len(owner) == len(header) + array.nbytes and owner[: len(header)] == header else ""


def find_beside(data: Path, name: str) -> Array:
    """The array of this name in the data folder of a project, or its working copy.

    Raises Absent where neither is there, or what is there is damaged or cannot be read.
    """
    old, place = folder_of(data) / f"{name}.npy", cache.entry(f"array-{name}")
    try:
        mapped = _map(old, name) if place is None else _map_copy(place, name) or _map(old, name)
        if mapped is not None:
            if place is not None and place.exists():
                cache.mark_used(place)
            return array_from(mapped)
        content = _content(data, name, place)
    except FileNotFoundError as error:
        raise Absent("data that can be made again") from error
    except (OSError, UnreadableError) as error:
        log.warning("%s", error)
        raise Absent(f"data that cannot be read ({cause_of(error)})") from error
    except InputError as error:
        log.warning("%s", error)
        raise Absent("data that can be made again") from error
    array = array_from(content)
    if len(content) < MAPPED_BYTES or place is None or old.exists():
        return array
    if name_of(content) != name:  # other projects will find it by this name
        log.warning("%s is damaged: its content is not the one of its name", file_of(data, name))
        raise Absent("data that can be made again")
    cache_array(name, *array_parts(array))
    mapped = _map_copy(place, name)
    return array_from(mapped) if mapped is not None else array


def _content(data: Path, name: str, place: Path | None) -> memoryview:
    """The content of an array from the project, or from its working copy at `place`, read and checked.

    OSError where it is gone, InputError where it is damaged.
    """
    path = file_of(data, name)
    if path.suffix == PACKED and path.exists():
        return _unpack(path)
    if not path.exists() and place is not None and (place / CONTENT).exists():
        return _read_cached(place, name)
    if not path.exists():
        raise FileNotFoundError(path)
    content = _read(path)
    if name_of(content) != name:
        raise InputError(path, "is damaged: its content is not the one of its name", "Make it again")
    return content


def _unpack(path: Path) -> memoryview:
    """The content of a packed file, its declared size checked against its shape before room is made for it.

    InputError where it is gone or damaged.
    """
    with open_checked(path, MAX_BYTES) as (file, _):
        packed = PackedFile(path, cast("BinaryIO", file), MAX_BYTES)
        content, filled = None, 0
        for chunk in packed.chunks():
            if content is None:
                content = scratch_array((_declare(path, chunk, packed.size_bytes),), np.uint8).data
            content[filled : filled + len(chunk)] = chunk.data
            filled += len(chunk)
    if content is None:
        raise InputError(path, "is damaged: it is empty", "Make it again")
    return content


def _declare(path: Path, beginning: NDArray[np.uint8], size: int) -> int:
    """The size of the array that begins so, which is the `size` that its file declares; InputError else."""
    try:
        shape, dtype, start = header_of(beginning[:MAX_HEADER].data)
    except ValueError as error:
        raise InputError(path, f"is damaged: {error}", "Make it again") from None
    if start + math.prod(shape) * dtype.itemsize != size:
        raise InputError(path, f"is damaged: {shape} of {dtype} are not {size:,} bytes", "Make it again")
    return size


def _map_copy(place: Path, name: str) -> GuardedMapping | None:
    """The working copy at `place`; None where it is small, or does not lie on a drive that stays."""
    return _map(place / CONTENT, name, min(MAPPED_BYTES, MAPPED_COPY_BYTES))


def _map(path: Path, name: str, least_bytes: int | None = None) -> GuardedMapping | None:
    """A large file on a drive that stays; None for any other."""
    least = MAPPED_BYTES if least_bytes is None else least_bytes
    try:
        about = path.stat()
    except FileNotFoundError:
        return None
    if os.name != "posix" or not least <= about.st_size <= MAX_BYTES or about.st_dev not in _lasting_drives():
        return None
    mapped = map_file(path)
    if mapped is None:
        return None
    try:
        _declare(path, np.frombuffer(mapped, np.uint8), len(mapped))
    except InputError as error:  # cut short
        log.warning("%s", error)
        return None
    mapped.name = name
    return mapped


def _size_of(path: Path) -> int:
    """The size of a file in bytes; -1 where it is gone."""
    try:
        return path.stat().st_size
    except OSError:
        return -1


def _lasting_drives() -> set[int]:
    """Numbers of the drives of temporary files and of the user's home."""
    places = (Path(tempfile.gettempdir()), Path(os.path.expanduser("~")))  # noqa: PTH111 - Path.home raises without one
    return {place.stat().st_dev for place in places if place.is_dir()}


def _read(path: Path) -> memoryview:
    """The content of a file, of which no other copy is made; InputError where it is gone, too large or changes."""
    with open_checked(path, MAX_BYTES) as (file, size):
        content, read = scratch_array((size,), np.uint8).data, 0
        while part := file.readinto(content[read : read + PIECE_BYTES]):  # type: ignore[attr-defined]
            read += part
    return content


def cause_of(error: OSError | UnreadableError) -> str:
    """Why the system lets something not be read, in its words."""
    if isinstance(error, OSError):
        return os.strerror(error.errno or 0)
    return error.problem.removeprefix("cannot be read: ")


def find_problems(data: Path) -> Steps[list[str]]:
    """Sentences on the arrays in the data folder of a project that are damaged or cannot be read; all are read."""
    folder = folder_of(data)
    try:
        names = os.listdir(folder) if folder.is_dir() else []  # noqa: PTH208 - Path.iterdir and glob drop failures
    except OSError as error:
        return [f"{folder.name} cannot be read: {cause_of(error)}"]
    there = (folder / name for name in names if name.endswith((".npy", PACKED)) and not is_partial(name))
    found, paths = list[str](), sorted(there)
    for at, path in enumerate(paths):
        yield Step(at / len(paths), f"reading {path.name}")
        try:
            is_whole = name_of(_unpack(path) if path.suffix == PACKED else _read(path)) == path.stem
        except (OSError, UnreadableError) as error:
            found.append(f"{path.name} cannot be read: {cause_of(error)}")
            continue
        except InputError:
            is_whole = False
        if not is_whole:
            found.append(f"{path.name} is damaged, and can be made again")
    return found
