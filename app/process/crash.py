"""Reports of crashes: what was done, with what, and the stacks of all threads when the process ended by a fault.

While the window is open, two files named after its process lie in the user's folder for logs. Into one of them
`faulthandler` writes when a library written in C fails (with `app.process.crash` behind it), and `note` when
Python code does. The other says versions and drivers (`state`), and the latest of what was done and logged (`did`). An
end without a fault removes both. The next start puts what it finds of processes that are gone into one report, so that
each is told of once, and keeps a few. Nothing is ever sent.

The native stack of a crash: frames of libraries written in C, which `faulthandler` of Python before 3.14 leaves out.

A handler of signals may call little, and nothing of Python's. Numba compiles one that calls glibc's `backtrace` and
`backtrace_symbols_fd` alone, which are made for that, and lets the process end then by the same signal. `faulthandler`
runs first, as it is enabled afterwards, and hands the signal on. Cost: some 0.3 s to compile, on whatever thread asks.
"""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import logging
import platform
import signal
import sys
import threading
import time
from collections import deque
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import platformdirs

import engine
from engine.core.errors import OutputError
from engine.storage import guarded
from engine.storage.atomic import make_folder
from engine.storage.writer import is_gone, is_own, writer

if TYPE_CHECKING:
    from numba.core.ccallback import CFunc

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


def add_native_stack(handler: CFunc, report: IO[bytes]) -> None:
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


def _compile(descriptor: int) -> CFunc:
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
    def handle(number: int) -> None:
        symbols(place, backtrace(place, MAXIMUM), descriptor)
        be_default(number, 0)
        again(number)

    _kept.append(frames)
    return handle


log = logging.getLogger(__name__)

#: Prefixes of the names of reports, while their process runs and afterwards.
OPEN, KEPT = "running-", "crash-"

#: Reports that are kept, and bytes of Python tracebacks in one of them.
MAX_REPORTS, MAX_BYTES = 10, 2**18

#: Lines about what was done and logged that a report keeps, characters of each, and bytes until the older ones go.
MAX_LINES, MAX_LENGTH, MAX_TRACE = 200, 500, 2**17

_report: IO[bytes] | None = None
_trace: IO[bytes] | None = None
_states: dict[str, str] = {}
_lines: deque[str] = deque(maxlen=MAX_LINES)
_writing = threading.RLock()


def report_folder() -> Path:
    """The folder of crash reports; it may not exist yet."""
    return Path(platformdirs.user_log_dir("lightarc", appauthor=False))


def begin() -> str:
    """Open this process's report. A sentence about a crash before, empty where there was none."""
    global _report, _trace
    folder = report_folder()
    try:
        make_folder(folder)
        crashed = _list_orphaned_reports(folder)
        path = folder / f"{OPEN}{writer()}.txt"
        _report = path.open("wb", buffering=0)
        path = path.with_suffix(".log")
        _trace = path.open("wb", buffering=0)
    except (OutputError, OSError) as error:
        log.warning("crashes are not recorded: %s", error)
        return ""
    faulthandler.enable(_report)
    state("Lightarc", f"{engine.__version__}, Python {platform.python_version()}, {platform.platform()}")
    if not crashed:
        return ""
    return f"Lightarc crashed the last time; {crashed[-1]} says where; please send it to the developers."


def with_native_stack() -> None:
    """Let a crash report the stacks of libraries written in C as well, which takes a moment to prepare.

    Where the report is closed in that moment, nothing is left to be done.
    """
    with _writing:
        report, descriptor = _report, _report.fileno() if _report is not None else -1
    if report is None:
        return
    handler = make_handler(descriptor)
    with _writing:
        if handler is not None and _report is report:
            add_native_stack(handler, report)


def state(what: str, words: str) -> None:
    """Say what the process runs with: a version or a driver."""
    with _writing:
        if _states.get(what) != words:
            _states[what] = words
            _write_anew()


def read_stated(what: str) -> str:
    """The version or driver that was told of, or nothing."""
    return _states.get(what, "")


def did(words: str) -> None:
    """Add a line about what was done, or logged; the oldest lines go."""
    line = f"{time.strftime('%H:%M:%S')} {words}".replace("\n", " | ")[:MAX_LENGTH]
    with _writing:
        _lines.append(line)
        if _trace is None:
            return
        with contextlib.suppress(OSError):  # a full disk; the report is none of what a user needs now
            if _trace.tell() > MAX_TRACE:
                _write_anew()
            else:
                _trace.write(_code(line))


def _write_anew() -> None:
    if _trace is not None:
        with contextlib.suppress(OSError):
            _trace.seek(0)
            _trace.truncate()
            lines = (*(f"{what}: {words}" for what, words in _states.items()), "", *_lines)
            _trace.write(b"".join(map(_code, lines)))


def _code(line: str) -> bytes:
    return line.encode(errors="backslashreplace") + b"\n"


def note(words: str) -> None:
    """Add a traceback of Python code to the report, as long as there is room in it."""
    if _report is not None and _report.tell() + len(words) < MAX_BYTES:
        _report.write(words.encode(errors="backslashreplace") + b"\n")


def end() -> None:
    """Close the report, and remove it where nothing went wrong."""
    global _report, _trace
    with _writing:
        if _report is None:
            return
        faulthandler.disable()
        remove_native_stack()
        if _trace is not None:
            _trace.close()
            _trace = None
        path, is_empty = Path(str(_report.name)), _report.tell() == 0
        _report.close()
        _report = None
    if is_empty:
        _remove(path)


def _list_orphaned_reports(folder: Path) -> list[Path]:
    """Reports that processes left which are gone, under their last names, the latest last; only a few stay."""
    found = []
    for path in sorted(folder.glob(f"{OPEN}*.txt"), key=lambda path: path.stat().st_mtime):
        if not (is_own(path) or is_gone(path)):
            continue
        if path.stat().st_size == 0:  # killed, or the machine went off
            _remove(path)
            continue
        _join(path)
        when = time.strftime("%Y-%m-%d-%H%M%S", time.localtime(path.stat().st_mtime))
        found.append(path.replace(folder / f"{KEPT}{when}-{path.stem.removeprefix(OPEN)}.txt"))
    for path in sorted(folder.glob(f"{KEPT}*.txt"))[:-MAX_REPORTS]:
        path.unlink()
    return found


def _remove(stacks: Path) -> None:
    for path in (stacks, stacks.with_suffix(".log")):
        path.unlink(missing_ok=True)


def _join(path: Path) -> None:
    """Put what a process did above the stacks that it left."""
    said, found = _start_of(path.with_suffix(".log"), 2 * MAX_TRACE), _start_of(path, 4 * MAX_BYTES)
    with path.open("wb") as report:
        report.write(said + b"\n" + found)
    path = path.with_suffix(".log")
    path.unlink(missing_ok=True)


def _start_of(path: Path, most: int) -> bytes:
    with contextlib.suppress(OSError), path.open("rb") as file:
        return file.read(most)
    return b""
