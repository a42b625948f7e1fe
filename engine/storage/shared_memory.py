"""Arrays from a decoder to its parent without a copy: a file in memory that both map (Linux `memfd_create`).

The parent makes the file and hands its descriptor to the child, which lets it grow and gives up its own mappings before
it answers. The parent then seals the file against every change and maps a private copy of its pages, so that nothing
the child does afterwards can reach an array that has been checked; where the seal is refused, because the child still
maps it, the arrays are read into memory of the parent's own. Mappings keep no descriptor. Where there are no such
files, `make_shared_file` gives None and arrays go through the pipe.
Not `multiprocessing.shared_memory`: that has a name which any process of the user can open, and no seal, so that a
decoder could change what its parent has already checked.

While the memory of the program is limited, the file lies on the disk, and the child gives its pages back while it
fills them. Such a file has no seal: the system copies each array into one that the child does not know.
"""

from __future__ import annotations

import ctypes
import errno
import math
import mmap
import operator
import os
import threading
import weakref
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from engine.storage import scratch

#: How often the child gives pages of a file on the disk back, in s: what it fills meanwhile stays in memory.
_RELEASE_S = 0.02

#: Arrays from so many bytes on lie in files where results lie on the disk.
_IN_FILES_BYTES = 1 << 20


class SharedFile:
    """The parent's side; of a file in the `folder`, None for one in memory."""

    def __init__(self, descriptor: int, folder: Path | None = None) -> None:
        self.descriptor = descriptor
        self.folder = folder

    def array(self, offset: int, dtype: np.dtype[Any], shape: tuple[int, ...]) -> NDArray[Any]:
        """The array that the child has put at `offset`; ValueError if it does not lie in the file, OutputError where
        the disk has no room for it."""
        sealed = self.folder is None and self._seal()
        size_bytes, offset = math.prod(shape) * dtype.itemsize, operator.index(offset)
        if offset < 0 or offset + size_bytes > os.fstat(self.descriptor).st_size:
            raise ValueError(f"decoder announced {size_bytes} bytes at {offset}, which are not there")
        if size_bytes == 0:
            return np.empty(shape, dtype)
        if self.folder is not None and size_bytes >= _IN_FILES_BYTES:
            return self._copy(self.folder, offset, size_bytes).view(dtype).reshape(shape)
        content = self._map(offset, size_bytes) if sealed else self._read(offset, size_bytes)
        return content.view(dtype).reshape(shape)

    def _copy(self, folder: Path, offset: int, size_bytes: int) -> NDArray[np.uint8]:
        """A copy in a file that the child does not know, of which no page is in memory."""
        try:
            with scratch.open_unnamed(folder, size_bytes) as file:
                done = 0
                while done < size_bytes:
                    count = os.sendfile(file.fileno(), self.descriptor, offset + done, size_bytes - done)
                    if count == 0:
                        raise ValueError("decoder took its result away")
                    done += count
                return scratch.map_file(file, (size_bytes,), np.uint8)
        except OSError as error:
            raise scratch.explain_no_room(folder, size_bytes, error) from None

    def _seal(self) -> bool:
        """Refuse every change of the file from now on; False if somebody maps it for writing."""
        import fcntl

        fcntl.fcntl(self.descriptor, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK)
        try:
            fcntl.fcntl(self.descriptor, fcntl.F_ADD_SEALS, fcntl.F_SEAL_GROW | fcntl.F_SEAL_WRITE)
        except OSError as error:
            if error.errno != errno.EBUSY:
                raise
            return False
        return True

    def _map(self, offset: int, size_bytes: int) -> NDArray[np.uint8]:
        """A private mapping without a descriptor, which `mmap.mmap` has from Python 3.13 on (`trackfd`)."""
        libc = ctypes.CDLL(None, use_errno=True)
        libc.mmap.restype = ctypes.c_void_p
        libc.mmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t, *[ctypes.c_int] * 3, ctypes.c_long]
        libc.munmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t]
        rights = mmap.PROT_READ | mmap.PROT_WRITE
        address = libc.mmap(None, size_bytes, rights, mmap.MAP_PRIVATE, self.descriptor, offset)
        if address == ctypes.c_void_p(-1).value:
            if ctypes.get_errno() == errno.ENOMEM:
                raise MemoryError
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
        memory = (ctypes.c_uint8 * size_bytes).from_address(address)
        weakref.finalize(memory, libc.munmap, address, size_bytes).atexit = False  # the process takes it along
        return np.ctypeslib.as_array(memory)

    def _read(self, offset: int, size_bytes: int) -> NDArray[np.uint8]:
        content = np.empty(size_bytes, np.uint8)
        done = 0
        while done < size_bytes:
            count = os.preadv(self.descriptor, [content[done:].data], offset + done)
            if count == 0:
                raise ValueError("decoder took its result away")
            done += count
        return content


@contextmanager
def make_shared_file() -> Iterator[SharedFile | None]:
    """A new file for one reply, or None where there are none; its room is free when the last array is gone."""
    folder = scratch.find_results_folder()
    if folder is not None and hasattr(os, "posix_fallocate") and not _limit():
        with scratch.open_unnamed(folder, 0) as file:
            yield SharedFile(file.fileno(), folder)
        return
    if not hasattr(os, "memfd_create") or _limit():
        yield None
        return
    descriptor = os.memfd_create("lightarc-decoded", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    try:
        yield SharedFile(descriptor)
    finally:
        os.close(descriptor)


def _limit() -> bool:
    """True where this account may write small files only, among which the system counts those in memory."""
    import resource

    return resource.getrlimit(resource.RLIMIT_FSIZE)[0] != resource.RLIM_INFINITY


class _Results:
    """The child's side: arrays one after the other, each from a whole page; `on_disk` their pages are given back."""

    def __init__(self, descriptor: int, on_disk: bool) -> None:
        self._descriptor = descriptor
        self._on_disk = on_disk
        self._end = 0
        self._arrays: list[tuple[int, NDArray[Any]]] = []
        self._mappings: dict[int, mmap.mmap] = {}
        self._answered: set[int] = set()
        self._ended = threading.Event()
        self._releasing = threading.Thread(target=self._release, name="giving pages back", daemon=True)
        if on_disk:
            self._releasing.start()

    def close(self) -> None:
        """Let go of all arrays, so that the file can be sealed as soon as the parent has the answer.

        Those that the answer does not name take no room any more.
        """
        self._ended.set()
        if self._on_disk:
            self._releasing.join()
        for offset, mapping in self._mappings.items():
            if offset not in self._answered:
                with suppress(OSError):  # of a file system without holes
                    mapping.madvise(mmap.MADV_REMOVE)
        self._arrays.clear()
        self._mappings.clear()

    def _release(self) -> None:
        while not self._ended.wait(_RELEASE_S):
            for mapping in tuple(self._mappings.values()):
                mapping.madvise(mmap.MADV_DONTNEED)

    def array(self, shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
        size_bytes = math.prod(shape) * np.dtype(dtype).itemsize
        offset = self._place(size_bytes)
        if size_bytes == 0:
            array = np.zeros(shape, dtype)
        else:
            array = np.frombuffer(self._mapping(offset, size_bytes), dtype).reshape(shape)
        self._arrays.append((offset, array))
        return array

    def _place(self, size_bytes: int) -> int:
        """The offset of the next array."""
        offset = self._end
        self._end += -(-size_bytes // mmap.ALLOCATIONGRANULARITY) * mmap.ALLOCATIONGRANULARITY
        return offset

    def _mapping(self, offset: int, size_bytes: int) -> mmap.mmap:
        if self._on_disk:  # where a page without a place on the disk would end the process
            os.posix_fallocate(self._descriptor, offset, self._end - offset)
        else:
            os.ftruncate(self._descriptor, self._end)
        try:
            mapping = mmap.mmap(self._descriptor, size_bytes, offset=offset)
        except OSError as error:
            if error.errno == errno.ENOMEM:
                raise MemoryError from None
            raise
        self._mappings[offset] = mapping
        return mapping

    def offset(self, array: NDArray[Any]) -> int:
        """Offset of `array`; it is written to a place of its own if it was not made by `result_array`.

        The system then need not clear the pages first, as those that are mapped.
        """
        for offset, known in self._arrays:
            if known.nbytes == array.nbytes > 0 and known.ctypes.data == array.ctypes.data:
                self._answered.add(offset)
                return offset
        offset, left = self._place(array.nbytes), array.reshape(-1).view(np.uint8).data
        os.ftruncate(self._descriptor, self._end)
        while len(left):
            left = left[os.pwrite(self._descriptor, left, offset + array.nbytes - len(left)) :]
        return offset


_results: _Results | None = None


@contextmanager
def results_in(descriptor: int | None, on_disk: bool = False) -> Iterator[_Results | None]:
    """Within the block `result_array` makes arrays in the parent's file, if there is one; it is closed at the end."""
    global _results
    _results = _Results(descriptor, on_disk) if descriptor is not None else None
    try:
        yield _results
    finally:
        if _results is not None:
            _results.close()
        _results = None
        if descriptor is not None:
            os.close(descriptor)


def result_array(shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """An array of zeros in which a decoder puts its result: where the parent reads it, if the decoder is a child."""
    return np.zeros(shape, dtype) if _results is None else _results.array(shape, dtype)
