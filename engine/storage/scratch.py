"""Arrays too large for memory: they lie in an unnamed file that vanishes with the process, mapped into memory.

Nothing a user keeps goes through here; results are written by `engine.storage.atomic`.
"""

from __future__ import annotations

import mmap
import os
import shutil
import tempfile
import weakref
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from engine.core.errors import OutputError
from engine.core.figure_text import size_text
from engine.storage.file_array import FileArray, Plane

#: Bytes of a content that are read at once.
PIECE_BYTES = 1 << 22

#: Larger arrays go to a file.
IN_MEMORY_BYTES = 512 * 2**20

#: File systems that lie in memory, and the folder whose files outlast a start of the machine, and so lie on a disk.
_MEMORY_KINDS, _ON_DISK = ("tmpfs", "ramfs"), Path("/var/tmp")

_mapped: weakref.WeakSet[mmap.mmap] = weakref.WeakSet()
_of_results: Path | None = None


@contextmanager
def keep_in_memory(size_bytes: int) -> Iterator[None]:
    """Within the block arrays of more than so many bytes go to a file, if not smaller ones do, and so do those that
    decoders answer with, of any size."""
    global IN_MEMORY_BYTES, _of_results
    before = IN_MEMORY_BYTES, _of_results
    IN_MEMORY_BYTES, _of_results = min(size_bytes, IN_MEMORY_BYTES), temporary_folder()
    try:
        yield
    finally:
        IN_MEMORY_BYTES, _of_results = before


def find_results_folder() -> Path | None:
    """The folder for arrays that decoders answer with; None where memory holds them."""
    return _of_results


def temporary_folder() -> Path:
    """The system's folder for temporary files, or that of long-lived ones where the first lies in memory."""
    place = Path(tempfile.gettempdir())
    if not os.access(_ON_DISK, os.W_OK):
        return place
    try:
        mounts = [line.split() for line in Path("/proc/mounts").read_text(errors="replace").splitlines()]
    except OSError:  # another system than Linux
        return place
    holding = [(len(at), kind) for _, at, kind, *_ in mounts if place.resolve().is_relative_to(at)]
    return _ON_DISK if holding and max(holding)[1] in _MEMORY_KINDS else place


def scratch_array(shape: tuple[int, ...], dtype: DTypeLike, folder: Path | None = None) -> NDArray[Any]:
    """An array of zeros, in memory up to `IN_MEMORY_BYTES` and beyond in an unnamed file.

    The file's blocks are reserved at once, so a full disk is reported here (OutputError) and not by a crash at some
    later assignment.
    """
    return array_in(scratch_place(_size_bytes(shape, dtype), folder), shape, dtype)


def scratch_place(size_bytes: int, folder: Path | None = None) -> Path | None:
    """The folder for unnamed files of `size_bytes` altogether; None where memory can hold them.

    That is the system's folder for temporary files where half of the room there is enough, else `folder` where that
    can be written: files are mapped, and a mapped file on a disk that is unplugged ends the process.
    """
    if size_bytes <= IN_MEMORY_BYTES:
        return None
    place = temporary_folder()
    try:
        if folder is not None and shutil.disk_usage(place).free < 2 * size_bytes and os.access(folder, os.W_OK):
            return folder
    except OSError as error:
        raise explain_no_room(place, size_bytes, error) from None
    return place


def array_in(place: Path | None, shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """An array of zeros in an unnamed file in the folder `place`, or in memory where that is None.

    The file goes when the last view of the array does. Raises OutputError where the disk is full.
    """
    if place is None:
        return np.zeros(shape, dtype)
    size_bytes = _size_bytes(shape, dtype)
    try:
        with open_unnamed(place, size_bytes) as file:
            return map_file(file, shape, dtype)
    except OSError as error:
        raise explain_no_room(place, size_bytes, error) from None


def map_file(file: IO[bytes], shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """An array of the content of an unnamed `file`, which may be closed."""
    array = np.memmap(file, dtype=dtype, mode="r+", shape=shape)
    _mapped.add(getattr(array, "_mmap"))  # noqa: B009 - numpy does not declare it
    return array


@contextmanager
def open_unnamed(place: Path, size_bytes: int) -> Iterator[IO[bytes]]:
    """A file of zeros without a name in the folder `place`, which vanishes with its last mapping; OSError for no room.

    Its blocks are reserved.
    """
    with tempfile.TemporaryFile(dir=place) as file:
        _reserve(file, size_bytes)
        yield file


def release(array: NDArray[Any] | FileArray | Plane) -> None:
    """Let the system reclaim the memory of a mapped array; its content stays. Other arrays are left alone."""
    release_mapping(getattr(array, "_mmap", None))


def release_mapping(mapping: mmap.mmap | None) -> None:
    """The same of a file that is mapped."""
    if mapping is not None and hasattr(mmap, "MADV_DONTNEED"):
        mapping.madvise(mmap.MADV_DONTNEED)


def list_mapped() -> list[mmap.mmap]:
    """The mapped files of all arrays that `array_in` has made and that are in use."""
    return list(_mapped)


class ScratchFiles(Mapping[str, bytes]):
    """Contents by their names, together in memory up to `IN_MEMORY_BYTES` and beyond in an unnamed file.

    OutputError where the disk has no room.
    """

    def __init__(self) -> None:
        self._contents = _Contents()
        self._places: dict[str, tuple[int, int]] = {}

    def put(self, name: str, content: bytes) -> None:
        """Add a content, or put it in the place of another of its name."""
        self._places[name] = self._contents.append(content), len(content)

    def __getitem__(self, name: str) -> bytes:
        return self._contents.read(*self._places[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def size_bytes(self, name: str) -> int:
        """Bytes of a content, which is not read."""
        return self._places[name][1]


class ScratchPieces:
    """Content of a file that is made piece by piece (`engine.storage.atomic.Pieces`): together in memory up to
    `IN_MEMORY_BYTES` and beyond in an unnamed file, from which it is read again.

    OutputError where the disk has no room.
    """

    def __init__(self, pieces: Iterable[bytes]) -> None:
        self._contents, self._size_bytes = _Contents(), 0
        for piece in pieces:
            self._contents.append(piece)
            self._size_bytes += len(piece)

    def __len__(self) -> int:
        return self._size_bytes

    def __iter__(self) -> Iterator[bytes]:
        for start in range(0, self._size_bytes, PIECE_BYTES):
            yield self._contents.read(start, min(PIECE_BYTES, self._size_bytes - start))


class ScratchRows(Mapping[int, bytes]):
    """The same by numbers below `count`: 16 bytes for each beside its content, of which there may be millions."""

    def __init__(self, count: int) -> None:
        self._contents = _Contents()
        self._start, self._size = np.zeros(count, np.int64), np.full(count, -1, np.int64)

    def put(self, number: int, content: bytes) -> None:
        """Add a content, or put it in the place of another of its number."""
        self._start[number], self._size[number] = self._contents.append(content), len(content)

    def __getitem__(self, number: int) -> bytes:
        if not 0 <= number < len(self._size) or self._size[number] < 0:
            raise KeyError(number)
        return self._contents.read(int(self._start[number]), int(self._size[number]))

    def __iter__(self) -> Iterator[int]:
        return iter(np.flatnonzero(self._size >= 0).tolist())

    def __len__(self) -> int:
        return int(np.count_nonzero(self._size >= 0))


class _Contents:
    """Bytes one after the other."""

    def __init__(self) -> None:
        self._folder = temporary_folder()
        self._file = tempfile.SpooledTemporaryFile(max(IN_MEMORY_BYTES, 1), dir=str(self._folder))  # noqa: SIM115 - ends with this

    def append(self, content: bytes) -> int:
        """The place of a content that is added."""
        try:
            start = self._file.seek(0, os.SEEK_END)
            self._file.write(content)
        except OSError as error:
            raise explain_no_room(self._folder, len(content), error) from None
        return start

    def read(self, start: int, size_bytes: int) -> bytes:
        self._file.seek(start)
        return self._file.read(size_bytes)


def _size_bytes(shape: tuple[int, ...], dtype: DTypeLike) -> int:
    return int(np.prod(shape, dtype=np.int64)) * np.dtype(dtype).itemsize


def explain_no_room(place: Path, size_bytes: int, error: OSError) -> OutputError:
    """The failure that no room was found for a file of so many bytes in the folder `place`."""
    try:
        free = f", {size_text(shutil.disk_usage(place).free)} are free"
    except OSError:
        free = ""
    problem = f"there is no room for {size_text(size_bytes)} of intermediate results ({error.strerror}{free})"
    return OutputError(place, problem, "Free some space or reduce the resolution")


def _reserve(file: IO[bytes], size_bytes: int) -> None:
    if size_bytes and hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file.fileno(), 0, size_bytes)
        return
    zeros = bytes(2**24)
    for start in range(0, size_bytes, len(zeros)):
        file.write(zeros[: size_bytes - start])
    file.flush()
