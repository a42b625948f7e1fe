"""Files that are mapped into memory, read-only, and may be cut short or lose their disk while they are.

The system then ends a process that reads what is gone, with SIGBUS. Here a handler of that signal puts zeros in the
place of what is gone, from the page that was read to the end of the mapping, and notes it: `check` raises InputError
from then on, as long as the mapping is in use. Whoever writes a result or ends a job asks it, so that nothing that was
computed from the zeros is kept. Where the main thread mapped first and has read zeros, as in verbs and scripts, it
raises the error itself at once, as it raises KeyboardInterrupt: a program that asks nobody must not go on either. A
SIGBUS elsewhere ends the process as it did before.

The handler is machine code (numba) that calls `mmap` and `PyErr_SetInterruptEx` alone, which is made for handlers: it
runs on whatever thread has read, with or without the interpreter. It exists on Linux; elsewhere `is_possible` is False,
and files are read instead of mapped.
Cost: some 0.5 s for the first mapping of a process, for the compiler.
"""

from __future__ import annotations

import ctypes
import mmap
import platform
import signal
import sys
import threading
import weakref
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from llvmlite.ir import Value
    from numba.core.base import BaseContext
    from numba.core.ccallback import CFunc
    from numba.core.types import Type
    from numba.core.typing import Context, Signature

#: Mappings of one process at a time.
MAX_MAPPINGS = 4096

_COLUMNS = 3  # beginning and end of a mapping as addresses, and where it was cut short the thread that has read
_SIGINFO, _ON_STACK = 0x4, 0x08000000
_REMEDY = "Check the disk that it lies on, and open it again"

_lock = threading.Lock()
_table = (ctypes.c_uint64 * (MAX_MAPPINGS * _COLUMNS))()
_paths: dict[int, Path] = {}
_kept: list[Any] = []


class GuardedMapping(mmap.mmap):
    """A file mapped into memory, with the hash that names its content."""

    name = ""


class _Action(ctypes.Structure):
    """struct sigaction of Linux's C libraries on 64-bit machines."""

    _fields_ = (
        ("handler", ctypes.c_void_p),
        ("mask", ctypes.c_uint64 * 16),
        ("flags", ctypes.c_int),
        ("restorer", ctypes.c_void_p),
    )


def is_possible() -> bool:
    """True where this system lets a mapping be guarded."""
    return sys.platform == "linux" and platform.machine() in ("x86_64", "aarch64")


def map_file(path: Path) -> GuardedMapping | None:
    """The whole file, mapped; None where it cannot be guarded. OSError where it cannot be read, ValueError if empty."""
    if not is_possible():
        return None
    with _lock:
        if not _kept:
            _install()
        row = next((at for at in range(MAX_MAPPINGS) if at not in _paths), None)
        if row is None:
            return None
        with path.open("rb") as file:
            mapped = GuardedMapping(file.fileno(), 0, access=mmap.ACCESS_READ)
        beginning = _address(mapped)
        _paths[row] = path
        _table[_COLUMNS * row + 1] = beginning + -(-len(mapped) // mmap.PAGESIZE) * mmap.PAGESIZE
        _table[_COLUMNS * row] = beginning
    weakref.finalize(mapped, _forget, row)
    return mapped


def renew() -> None:
    """Put the handler in its place again, where another one for SIGBUS took it; that is asked for other faults."""
    if not _kept:
        return
    libc, before, handler = _kept
    now = _Action()
    libc.sigaction(signal.SIGBUS, 0, ctypes.addressof(now))
    if now.handler != handler.address:
        ctypes.memmove(ctypes.addressof(before), ctypes.addressof(now), ctypes.sizeof(before))
        _set_handler(libc, handler)


def check() -> None:
    """InputError where a file that is mapped now was cut short since."""
    if not _paths:
        return
    cut = next((path for row, path in list(_paths.items()) if _table[_COLUMNS * row + 2]), None)
    if cut is not None:
        raise InputError(cut, "was cut short while it was open", _REMEDY)


def _forget(row: int) -> None:
    # No lock: a garbage collection may end a mapping while this thread holds it.
    for column in range(_COLUMNS):
        _table[_COLUMNS * row + column] = 0
    _paths.pop(row, None)


def _address(mapped: mmap.mmap) -> int:
    import numpy as np

    return int(np.frombuffer(mapped, np.uint8).__array_interface__["data"][0])


def _install() -> None:
    libc = ctypes.CDLL(None, use_errno=True)
    libc.sigaction.argtypes = (ctypes.c_int, ctypes.c_size_t, ctypes.c_size_t)
    before = _Action()
    libc.sigaction(signal.SIGBUS, 0, ctypes.addressof(before))
    handler = _compile(libc, ctypes.addressof(before))
    if threading.current_thread() is threading.main_thread():  # Python takes handlers from there alone
        signal.signal(signal.SIGBUS, _raise_for_main_thread)
    _kept.extend((libc, before, handler))
    _set_handler(libc, handler)


def _set_handler(libc: ctypes.CDLL, handler: CFunc) -> None:
    action = _Action()
    action.handler, action.flags = handler.address, _SIGINFO | _ON_STACK
    libc.sigaction(signal.SIGBUS, ctypes.addressof(action), 0)


def _raise_for_main_thread(_number: int, _frame: object) -> None:
    """Handler of Python's, which runs on the main thread soon after a page was gone."""
    main = threading.main_thread().ident
    if any(_table[_COLUMNS * row + 2] == main for row in list(_paths)):
        check()


def _compile(libc: ctypes.CDLL, before: int) -> CFunc:
    """The handler, which restores the action `before` for what is not a mapping of ours."""
    from llvmlite import ir
    from numba import cfunc, types
    from numba.extending import intrinsic

    place = libc.mmap
    place.restype = ctypes.c_size_t
    place.argtypes = (ctypes.c_size_t, ctypes.c_size_t, *(ctypes.c_int,) * 4)
    restore = libc.sigaction
    interrupt, thread = ctypes.pythonapi.PyErr_SetInterruptEx, ctypes.pythonapi.PyThread_get_thread_ident
    interrupt.argtypes, interrupt.restype = (ctypes.c_int,), ctypes.c_int
    thread.argtypes, thread.restype = (), ctypes.c_size_t
    table, rows, columns = ctypes.addressof(_table), MAX_MAPPINGS, _COLUMNS
    page, number = mmap.PAGESIZE, signal.SIGBUS.value
    flags = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | 0x10  # MAP_FIXED
    readable = mmap.PROT_READ

    @intrinsic
    def at(_context: Context, _address: Type) -> tuple[Signature, Callable[..., Value]]:
        def generate(_: BaseContext, builder: ir.IRBuilder, __: Signature, arguments: Sequence[Value]) -> Value:
            return builder.inttoptr(arguments[0], ir.IntType(64).as_pointer())

        return types.CPointer(types.uint64)(types.uint64), generate

    @cfunc(types.void(types.int32, types.CPointer(types.uint64), types.uint64))
    def handle(_number: int, about: Sequence[int], _context: int) -> None:
        address, entries = about[2], at(types.uint64(table))
        for row in range(rows):
            beginning, end = entries[columns * row], entries[columns * row + 1]
            if beginning != 0 and beginning <= address and address < end:
                start = address // types.uint64(page) * types.uint64(page)
                if place(start, end - start, readable, flags, -1, 0) == start:
                    entries[columns * row + 2] = thread()
                    interrupt(number)
                    return
        restore(number, before, 0)

    return handle
