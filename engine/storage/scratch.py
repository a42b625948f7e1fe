"""Arrays too large for memory: they lie in an unnamed file that vanishes with the process, mapped into memory.

Nothing a user keeps goes through here; results are written by `engine.storage.atomic`.
"""

from __future__ import annotations

import mmap
import os
import shutil
import tempfile
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from engine.core.errors import OutputError
from engine.core.figure_text import size_text
from engine.storage.file_array import FileArray

#: Larger arrays go to a file.
IN_MEMORY_BYTES = 512 * 2**20


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
    place = Path(tempfile.gettempdir())
    try:
        if folder is not None and shutil.disk_usage(place).free < 2 * size_bytes and os.access(folder, os.W_OK):
            return folder
    except OSError as error:
        raise _no_room(place, size_bytes, error) from None
    return place


def array_in(place: Path | None, shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """An array of zeros in an unnamed file in the folder `place`, or in memory where that is None.

    The file goes when the last view of the array does. Raises OutputError where the disk is full.
    """
    if place is None:
        return np.zeros(shape, dtype)
    size_bytes = _size_bytes(shape, dtype)
    try:
        with tempfile.TemporaryFile(dir=place) as file:
            _reserve(file, size_bytes)
            return np.memmap(file, dtype=dtype, mode="r+", shape=shape)
    except OSError as error:
        raise _no_room(place, size_bytes, error) from None


def release(array: NDArray[Any] | FileArray) -> None:
    """Let the system reclaim the memory of a mapped array; its content stays. Other arrays are left alone."""
    mapping = getattr(array, "_mmap", None)
    if mapping is not None and hasattr(mmap, "MADV_DONTNEED"):
        mapping.madvise(mmap.MADV_DONTNEED)


def _size_bytes(shape: tuple[int, ...], dtype: DTypeLike) -> int:
    return int(np.prod(shape, dtype=np.int64)) * np.dtype(dtype).itemsize


def _no_room(place: Path, size_bytes: int, error: OSError) -> OutputError:
    problem = f"there is no room for {size_text(size_bytes)} of intermediate results ({error.strerror})"
    return OutputError(place, problem, "Free some space or reduce the resolution")


def _reserve(file: IO[bytes], size_bytes: int) -> None:
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file.fileno(), 0, size_bytes)
        return
    zeros = bytes(2**24)
    for start in range(0, size_bytes, len(zeros)):
        file.write(zeros[: size_bytes - start])
    file.flush()
