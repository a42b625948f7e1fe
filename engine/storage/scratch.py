"""Arrays too large for memory: they lie in an unnamed file that vanishes with the process, mapped into memory.

Nothing a person keeps goes through here; results are written by `engine.storage.atomic`.
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

    The file lies in the system's folder for temporary files where half of the room there is enough, else in `folder`
    where that can be written: it is mapped, and a mapped file on a disk that is unplugged ends the process. Its blocks
    are reserved at once, so a full disk is reported here (OutputError) and not by a crash at some later assignment.
    """
    size_bytes = int(np.prod(shape, dtype=np.int64)) * np.dtype(dtype).itemsize
    if size_bytes <= IN_MEMORY_BYTES:
        return np.zeros(shape, dtype)
    place = Path(tempfile.gettempdir())
    try:
        if folder is not None and shutil.disk_usage(place).free < 2 * size_bytes and os.access(folder, os.W_OK):
            place = folder
        with tempfile.TemporaryFile(dir=place) as file:
            _reserve(file, size_bytes)
            return np.memmap(file, dtype=dtype, mode="r+", shape=shape)
    except OSError as error:
        problem = f"there is no room for {size_text(size_bytes)} of intermediate results ({error.strerror})"
        raise OutputError(place, problem, "Free some space or reduce the resolution") from None


def release(array: NDArray[Any] | FileArray) -> None:
    """Let the system reclaim the memory of a mapped array; its content stays. Other arrays are left alone."""
    mapping = getattr(array, "_mmap", None)
    if mapping is not None and hasattr(mmap, "MADV_DONTNEED"):
        mapping.madvise(mmap.MADV_DONTNEED)


def _reserve(file: IO[bytes], size_bytes: int) -> None:
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file.fileno(), 0, size_bytes)
        return
    zeros = bytes(2**24)
    for start in range(0, size_bytes, len(zeros)):
        file.write(zeros[: size_bytes - start])
    file.flush()
