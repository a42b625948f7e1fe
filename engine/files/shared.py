"""Arrays from a decoder to its parent without a copy: a file in memory that both map (Linux `memfd_create`).

The parent makes the file, the child opens it by its name under /proc and lets it grow; before the parent maps it, it is
sealed against shrinking, so that nothing the child does afterwards can take pages away from under the parent. Where
there are no such files, `shared_file` gives None and arrays go through the pipe.
"""

from __future__ import annotations

import errno
import math
import mmap
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


class SharedFile:
    """The parent's side."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self.name = f"/proc/{os.getpid()}/fd/{descriptor}"

    def array(self, offset: int, dtype: np.dtype[Any], shape: tuple[int, ...]) -> NDArray[Any]:
        """The array that the child has put at `offset`; ValueError if it does not lie in the file."""
        import fcntl

        fcntl.fcntl(self._descriptor, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK)
        size_bytes = math.prod(shape) * dtype.itemsize
        if offset < 0 or offset + size_bytes > os.fstat(self._descriptor).st_size:
            raise ValueError(f"decoder announced {size_bytes} bytes at {offset}, which are not there")
        if size_bytes == 0:
            return np.empty(shape, dtype)
        mapping = mmap.mmap(self._descriptor, size_bytes, offset=offset)
        return np.frombuffer(mapping, dtype).reshape(shape)


@contextmanager
def shared_file() -> Iterator[SharedFile | None]:
    """A new file for one reply, or None where there are none; its memory is free when the last array is gone."""
    if not hasattr(os, "memfd_create"):
        yield None
        return
    descriptor = os.memfd_create("lightarc-decoded", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    try:
        file = SharedFile(descriptor)
        yield file if Path(file.name).exists() else None
    finally:
        os.close(descriptor)


class _Results:
    """The child's side: arrays one after the other, each from a whole page."""

    def __init__(self, name: str) -> None:
        self._descriptor = os.open(name, os.O_RDWR)
        self._end = 0
        self._arrays: list[tuple[int, NDArray[Any]]] = []

    def array(self, shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
        size_bytes = math.prod(shape) * np.dtype(dtype).itemsize
        offset = self._end
        self._end += -(-size_bytes // mmap.ALLOCATIONGRANULARITY) * mmap.ALLOCATIONGRANULARITY
        if size_bytes == 0:
            array = np.zeros(shape, dtype)
        else:
            array = np.frombuffer(self._mapping(offset, size_bytes), dtype).reshape(shape)
        self._arrays.append((offset, array))
        return array

    def _mapping(self, offset: int, size_bytes: int) -> mmap.mmap:
        os.ftruncate(self._descriptor, self._end)
        try:
            return mmap.mmap(self._descriptor, size_bytes, offset=offset)
        except OSError as error:
            if error.errno == errno.ENOMEM:
                raise MemoryError from None
            raise

    def offset(self, array: NDArray[Any]) -> int:
        """Where `array` lies; it is copied to a place of its own if it was not made by `result_array`."""
        for offset, known in self._arrays:
            if known is array:
                return offset
        place = self.array(array.shape, array.dtype)
        place[...] = array
        return self._arrays[-1][0]

    def close(self) -> None:
        self._arrays.clear()
        os.close(self._descriptor)


_results: _Results | None = None


@contextmanager
def results_in(name: str | None) -> Iterator[_Results | None]:
    """Within the block `result_array` makes arrays in the parent's file `name`, if there is one."""
    global _results
    _results = _Results(name) if name is not None else None
    try:
        yield _results
    finally:
        if _results is not None:
            _results.close()
        _results = None


def result_array(shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """An array of zeros in which a decoder puts its result: where the parent reads it, if the decoder is a child."""
    return np.zeros(shape, dtype) if _results is None else _results.array(shape, dtype)
