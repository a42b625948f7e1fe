"""The native stack of a crash: frames of libraries written in C, which `faulthandler` of Python before 3.14 leaves out.

A handler of signals may call little, and nothing of Python's. Numba compiles one that calls glibc's `backtrace` and
`backtrace_symbols_fd` alone, which are made for that, and lets the process end then by the same signal. `faulthandler`
runs first, as it is enabled afterwards, and hands the signal on. Cost: some 0.3 s to compile, on whatever thread asks.
"""

from __future__ import annotations

import ctypes
import faulthandler
import logging
import signal
import sys
from typing import IO, Any

from engine.storage import guarded

log = logging.getLogger(__name__)

#: Frames that are written, at most.
MAXIMUM = 128

SIGNALS = tuple(getattr(signal, name) for name in ("SIGSEGV", "SIGBUS", "SIGABRT", "SIGFPE", "SIGILL"))

_kept: list[Any] = []


def make_handler(descriptor: int) -> Any:
    """A handler of signals that writes the native stack to the file `descriptor`; None where there can be none."""
    if not sys.platform.startswith("linux") or sys.version_info >= (3, 14):
        return None
    try:
        return _compile(descriptor)
    except (AttributeError, ImportError, OSError) as error:  # another C library than glibc
        log.info("crashes are reported without their native stack: %s", error)
        return None


def add_native_stack(handler: Any, report: IO[bytes]) -> None:
    """Let crashes write their native stack by a `handler` of `make_handler` behind the Python stack in `report`."""
    faulthandler.disable()
    for number in SIGNALS:
        _libc().signal(number, handler.address)
    faulthandler.enable(report)
    guarded.renew()
    _kept.append(handler)


def remove_native_stack() -> None:
    """Let signals end the process as they do without a handler; `faulthandler` has been disabled before."""
    while _kept:
        for number in SIGNALS:
            _libc().signal(number, 0)
        _kept.pop()


def _libc() -> ctypes.CDLL:
    """The C library of this process, its functions with plain numbers as pointers."""
    libc = ctypes.CDLL(None)
    for name, takes, gives in (
        ("backtrace", (ctypes.c_size_t, ctypes.c_int), ctypes.c_int),
        ("backtrace_symbols_fd", (ctypes.c_size_t, ctypes.c_int, ctypes.c_int), None),
        ("signal", (ctypes.c_int, ctypes.c_size_t), ctypes.c_size_t),
        ("raise", (ctypes.c_int,), ctypes.c_int),
    ):
        function = libc[name]
        function.argtypes, function.restype = takes, gives
        setattr(libc, name, function)
    return libc


def _compile(descriptor: int) -> Any:
    """The handler, which writes to `descriptor`."""
    from numba import cfunc, types

    libc = _libc()
    backtrace, symbols, be_default, again = (
        libc.backtrace,
        libc.backtrace_symbols_fd,
        libc.signal,
        getattr(libc, "raise"),
    )
    frames = (ctypes.c_void_p * MAXIMUM)()
    place = ctypes.addressof(frames)
    backtrace(place, 1)  # its first call loads a library, which no handler of signals may do

    @cfunc(types.void(types.int32))
    def handle(number):  # type: ignore[no-untyped-def]
        symbols(place, backtrace(place, MAXIMUM), descriptor)
        be_default(number, 0)
        again(number)

    _kept.append(frames)
    return handle
