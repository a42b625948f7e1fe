"""Large arrays of numpy in unnamed files while memory is limited, so that work on images needs disk instead of memory.

Within `spill_arrays` numpy asks here for the memory of each array that the thread makes (NEP 49, a table of functions
in C). Small ones come from where they came before, and large ones from memory as long as there is plenty. Others are
files without a name that are mapped, whose pages the system writes back and takes as it needs them. Numbers are the
same in all, so that results are. What libraries keep beside arrays of numpy stays in memory.

A new file takes ten times as long as the work that fills it: its blocks are reserved, and each of its pages is found.
Files of arrays that are gone are therefore kept for the next arrays of their size, up to `SPARE_PART` of the limit, as
long as the block lasts; expressions of numpy, which make arrays of one size after another, take as long as in memory.

Pages of such files that were touched count as memory of the process although the system may take them. While the
process, its decoders and what compiles for it have more than the limit, a thread gives them back: their content stays,
in the system's cache or on the disk.

The functions in C are machine code (numba), which calls the C library alone: numpy asks for memory and frees it also
while an exception is raised, of which Python would lose sight. They run while their thread holds the lock of the
interpreter, as does what gives pages back. Linux has what this needs; elsewhere, and on file systems without unnamed
files (O_TMPFILE), arrays stay in memory.
Cost: 0.5 s for the compiler at the first block of a process. Work that is bound by memory takes up to twice the time
in files.
"""

from __future__ import annotations

import ctypes
import errno
import importlib
import mmap
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.core.budget import count_bytes, follow_untouched
from engine.core.kernels import list_compiling
from engine.storage import scratch
from engine.storage.atomic import free_bytes
from engine.storage.untrusted import list_processes

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from llvmlite.ir import Value
    from numba.core.base import BaseContext
    from numba.core.types import Type
    from numba.core.typing import Context, Signature

#: Arrays are large from this part of the limit on, and from so many bytes; and they lie in memory as long as the
#: processes take less than the other part of it, since libraries and small arrays need some as well.
LARGE_PART, MIN_BYTES, IN_MEMORY_PART = 1 / 256, 1 << 20, 0.6

#: Part of the limit from which pages are given back, and how often the process is looked at, in s: a look takes 70 µs,
#: and work touches 1 to 2 GB/s.
RELEASE_PART, LOOK_S = 0.8, 0.005

#: Bytes of files that are kept for other arrays, as a part of the limit.
SPARE_PART = 0.5

#: Large arrays at a time, and what is noted of each: address, bytes, and 1 for a file, `_SPARE` for one that is kept.
#: The first row notes the bytes that large arrays may still take in memory, and size and cause of the last that the
#: disk had no room for; the second the bytes that are free on the disk, those of files that are kept, and their most.
MAX_ARRAYS, _COLUMNS, _NOTES, _SPARE = 1 << 14, 3, 2, 2

#: Places of functions in numpy's table for C (numpy/__multiarray_api.h), which keeps them from version to version.
SET_HANDLER, GET_HANDLER = 304, 305

_kept: list[Any] = []
_table = (ctypes.c_uint64 * (_COLUMNS * (_NOTES + MAX_ARRAYS)))()


class Handler(ctypes.Structure):
    """PyDataMem_Handler of numpy/ndarraytypes.h, version 1."""

    _fields_ = (
        ("name", ctypes.c_char * 127),
        ("version", ctypes.c_uint8),
        ("context", ctypes.c_void_p),
        ("malloc", ctypes.c_void_p),
        ("calloc", ctypes.c_void_p),
        ("realloc", ctypes.c_void_p),
        ("free", ctypes.c_void_p),
    )


def is_possible(folder: Path) -> bool:
    """True where arrays can lie in files in a folder."""
    if sys.platform != "linux" or sys.maxsize < 2**32:
        return False
    try:
        os.close(os.open(folder, os.O_TMPFILE | os.O_RDWR, 0o600))
    except OSError:
        return False
    return True


@contextmanager
def spill_arrays(limit_bytes: int) -> Iterator[None]:
    """Within the block large arrays that this thread makes lie in files, and the process is kept at `limit_bytes`.

    Arrays outlive the block. Raises OutputError where the disk has no room for one; its maker gets a MemoryError.
    """
    folder = scratch.temporary_folder()
    if not is_possible(folder):
        yield
        return
    large_bytes = max(MIN_BYTES, round(LARGE_PART * limit_bytes))
    set_handler, handler, release_all, drop_spare = _make_handler(folder, large_bytes)
    with ExitStack() as held:
        held.enter_context(scratch.keep_in_memory(large_bytes))
        held.callback(set_handler, set_handler(handler))
        _note_room(limit_bytes, folder)
        ended = threading.Event()
        looking = (limit_bytes, folder, release_all, ended)
        keeping = threading.Thread(target=_keep, args=looking, name="giving pages back", daemon=True)
        keeping.start()
        held.callback(keeping.join)
        held.callback(ended.set)
        held.callback(drop_spare)
        held.callback(_table.__setitem__, _COLUMNS + 2, _table[_COLUMNS + 2])
        _table[1], _table[_COLUMNS + 2] = 0, round(SPARE_PART * limit_bytes)
        try:
            yield
        except MemoryError:
            size_bytes, code = _table[1:_COLUMNS]
            if size_bytes:
                raise scratch.explain_no_room(folder, size_bytes, OSError(code, os.strerror(code))) from None
            raise


def count_spilled_bytes() -> int:
    """Bytes of the arrays of this process that lie in files."""
    rows = np.ctypeslib.as_array(_table).reshape(-1, _COLUMNS)[_NOTES:]
    return int(rows[(rows[:, 0] != 0) & (rows[:, 2] == 1), 1].sum())


def _keep(limit_bytes: int, folder: Path, release_all: Callable[[], None], ended: threading.Event) -> None:
    """Give pages of files back whenever the processes have more than the limit, until the event is set."""
    while not ended.wait(LOOK_S):
        _note_room(limit_bytes, folder)
        if sum(map(_count_resident, (os.getpid(), *list_processes(), *list_compiling()))) > RELEASE_PART * limit_bytes:
            release_all()
            for mapping in scratch.list_mapped():
                scratch.release_mapping(mapping)


def _note_room(limit_bytes: int, folder: Path) -> None:
    """Note how many bytes large arrays may still take in memory and on the disk."""
    follow_untouched()
    others = sum(_count_resident(process, is_private=True) for process in (*list_processes(), *list_compiling()))
    _table[0] = max(0, round(IN_MEMORY_PART * limit_bytes) - count_bytes() - others)
    with suppress(OSError):
        _table[_COLUMNS] = free_bytes(folder)


def _count_resident(process: int, *, is_private: bool = False) -> int:
    """Bytes that a process has in memory, or those of no file (proc_pid_statm(5)); 0 for one that has ended."""
    try:
        _, resident, of_files, *_ = map(int, Path(f"/proc/{process}/statm").read_bytes().split())
    except (OSError, ValueError):  # it has ended; its file is then gone, or empty
        return 0
    return (resident - of_files if is_private else resident) * mmap.PAGESIZE


@cache
def _make_handler(folder: Path, large_bytes: int) -> tuple[Any, Any, Callable[[], None], Callable[[], None]]:
    """Function that sets a handler and gives the one before; the handler of arrays from `large_bytes` on; one that
    gives the pages of all files back; and one that drops the files that are kept."""
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, (ctypes.py_object, ctypes.c_char_p)
    capsule = importlib.import_module("numpy._core._multiarray_umath")._ARRAY_API
    table = ctypes.cast(pointer(capsule, None), ctypes.POINTER(ctypes.c_void_p))
    set_handler = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.py_object)(table[SET_HANDLER])
    usual = ctypes.PYFUNCTYPE(ctypes.py_object)(table[GET_HANDLER])()
    *functions, release, drop = _compile(Handler.from_address(pointer(usual, b"mem_handler")), folder, large_bytes)
    made = Handler(b"lightarc_files", 1, None, *(function.address for function in functions))
    new = ctypes.pythonapi.PyCapsule_New
    new.restype, new.argtypes = ctypes.py_object, (ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)
    _kept.append((usual, functions, release, drop, made))  # arrays need them as long as they live
    handler = new(ctypes.addressof(made), b"mem_handler", None)
    return set_handler, handler, *(ctypes.PYFUNCTYPE(None)(each.address) for each in (release, drop))


def _compile(usual: Handler, folder: Path, large_bytes: int) -> tuple[Any, ...]:
    """malloc, calloc, realloc and free, which ask the `usual` ones for what is small; what gives pages back, and what
    drops the files that are kept.

    Large arrays begin with a page, which others do by chance alone, and are looked up in the table.
    """
    from llvmlite import ir
    from numba import carray, cfunc, njit, types
    from numba.extending import intrinsic

    size, number = ctypes.c_size_t, ctypes.c_int
    malloc = ctypes.CFUNCTYPE(size, size, size)(usual.malloc)
    calloc = ctypes.CFUNCTYPE(size, size, size, size)(usual.calloc)
    realloc = ctypes.CFUNCTYPE(size, size, size, size)(usual.realloc)
    free = ctypes.CFUNCTYPE(None, size, size, size)(usual.free)
    libc = ctypes.CDLL(None)
    place, unmap, advise, copy, fill = libc.mmap, libc.munmap, libc.madvise, libc.memmove, libc.memset
    begin, reserve, close, identify = libc.open, libc.posix_fallocate, libc.close, libc.getpid
    identify.restype, identify.argtypes = number, ()
    place.restype, place.argtypes = size, (size, size, number, number, number, size)
    unmap.restype, unmap.argtypes = number, (size, size)
    advise.restype, advise.argtypes = number, (size, size, number)
    copy.restype, copy.argtypes = size, (size, size, size)
    fill.restype, fill.argtypes = size, (size, number, size)
    begin.restype, begin.argtypes = number, (size, number, number)
    reserve.restype, reserve.argtypes = number, (number, size, size)
    close.restype, close.argtypes = number, (number,)
    path = ctypes.create_string_buffer(os.fsencode(folder))
    where, context, table = ctypes.addressof(path), usual.context or 0, ctypes.addressof(_table)
    notes, rows, columns, page, failed = _NOTES, _NOTES + MAX_ARRAYS, _COLUMNS, mmap.PAGESIZE, 2**64 - 1
    owner = os.getpid()
    none, full, spare = mmap.MADV_DONTNEED, errno.ENOSPC, _SPARE
    private, unnamed = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, os.O_TMPFILE | os.O_RDWR | os.O_CLOEXEC
    shared, rights, whole = mmap.MAP_SHARED, mmap.PROT_READ | mmap.PROT_WRITE, types.uint64

    @intrinsic
    def to_pointer(_context: Context, _address: Type) -> tuple[Signature, Callable[..., Value]]:
        def generate(_: BaseContext, builder: ir.IRBuilder, __: Signature, arguments: Sequence[Value]) -> Value:
            return builder.inttoptr(arguments[0], ir.IntType(64).as_pointer())

        return types.CPointer(types.uint64)(types.uint64), generate

    @njit
    def find(address: int) -> int:
        """The row of a large array, 0 of any other."""
        if address % page == 0:
            entries = carray(to_pointer(whole(table)), (rows, columns))
            for row in range(notes, rows):
                if entries[row, 0] == address:
                    return row
        return 0

    @cfunc(types.void())
    def drop_spare() -> None:
        """Give the files back that are kept."""
        entries = carray(to_pointer(whole(table)), (rows, columns))
        if entries[1, 1] == 0:
            return
        for row in range(notes, rows):
            if entries[row, 0] != 0 and entries[row, 2] == spare:
                unmap(entries[row, 0], entries[row, 1])
                entries[row, 0] = 0
        entries[1, 1] = 0

    drop = ctypes.CFUNCTYPE(None)(drop_spare.address)  # called by address, so that it is compiled once

    @njit
    def take_spare(size_bytes: int) -> int:
        """The row of a file of that size that is kept, for a new array; 0 where there is none.

        A copy of the process has the same files, and leaves them to it.
        """
        entries = carray(to_pointer(whole(table)), (rows, columns))
        if entries[1, 1] >= size_bytes and identify() == owner:
            for row in range(notes, rows):
                if entries[row, 0] != 0 and entries[row, 2] == spare and entries[row, 1] == size_bytes:
                    entries[row, 2] = 1
                    entries[1, 1] -= size_bytes
                    return row
        return 0

    @cfunc(whole(whole, whole))
    def take_large(size_bytes: int, wants_zeros: int) -> int:
        """An address in memory, in a file that is kept or in a new file; 0 where there is no room."""
        entries = carray(to_pointer(whole(table)), (rows, columns))
        address, in_file = whole(failed), 0
        if size_bytes <= entries[0, 0]:
            address = whole(place(0, size_bytes, rights, private, -1, 0))
        if address == failed:
            row = take_spare(size_bytes)
            if row != 0:
                if wants_zeros:
                    fill(entries[row, 0], 0, size_bytes)
                return entries[row, 0]
        row = notes
        while row < rows and entries[row, 0] != 0:
            row += 1
        if row == rows:
            return whole(0)
        if address != failed:
            entries[0, 0] -= size_bytes
        else:
            if size_bytes > entries[1, 0]:
                entries[1, 0] += entries[1, 1]
                drop()
            file = begin(where, unnamed, 0o600)
            if file < 0:
                return whole(0)
            in_file, code = 1, full if size_bytes > entries[1, 0] else reserve(file, 0, size_bytes)
            if code == 0:
                entries[1, 0] -= size_bytes
                address = whole(place(0, size_bytes, rights, shared, file, 0))
            else:
                entries[0, 1], entries[0, 2] = size_bytes, code
            close(file)
            if address == failed:
                return whole(0)
        entries[row, 0], entries[row, 1], entries[row, 2] = address, size_bytes, in_file
        return address

    take = ctypes.CFUNCTYPE(size, size, size)(take_large.address)

    @njit
    def give_back(row: int) -> None:
        """Keep the file of an array for the next one of its size, or unmap what it has."""
        entries = carray(to_pointer(whole(table)), (rows, columns))
        address, size_bytes = entries[row, 0], entries[row, 1]
        if entries[row, 2] == 1 and size_bytes <= entries[1, 2]:
            if entries[1, 1] + size_bytes > entries[1, 2]:
                drop()  # of sizes that nobody asks for any more
            entries[row, 2] = spare
            entries[1, 1] += size_bytes
            return
        entries[row, 0] = 0
        unmap(address, size_bytes)

    @cfunc(whole(whole, whole))
    def malloc_large(_context: int, size_bytes: int) -> int:
        return take(size_bytes, 0) if size_bytes >= large_bytes else malloc(context, size_bytes)

    @cfunc(whole(whole, whole, whole))
    def calloc_large(_context: int, count: int, each_bytes: int) -> int:
        size_bytes = count * each_bytes
        return take(size_bytes, 1) if size_bytes >= large_bytes else calloc(context, count, each_bytes)

    @cfunc(whole(whole, whole, whole))
    def realloc_large(_context: int, before: int, size_bytes: int) -> int:
        row = find(before) if before != 0 else 0
        if row == 0:
            return realloc(context, before, size_bytes)
        found = take(size_bytes, 0)
        if found != 0:
            entries = carray(to_pointer(whole(table)), (rows, columns))
            copy(found, before, min(size_bytes, entries[row, 1]))
            give_back(row)
        return found

    @cfunc(types.void(whole, whole, whole))
    def free_large(_context: int, before: int, size_bytes: int) -> None:
        row = find(before) if before != 0 else 0
        if row == 0:
            free(context, before, size_bytes)
        else:
            give_back(row)

    @cfunc(types.void())
    def release_all() -> None:
        entries = carray(to_pointer(whole(table)), (rows, columns))
        for row in range(notes, rows):
            if entries[row, 0] != 0 and entries[row, 2] != 0:
                advise(entries[row, 0], entries[row, 1], none)

    _kept.append((malloc, calloc, realloc, free, libc, path, take_large, take, drop))
    return malloc_large, calloc_large, realloc_large, free_large, release_all, drop_spare
