"""The one way in for files that the program did not write itself.

`read_bytes` opens regular files only, looks at the size before it reads, and notices when a file changes meanwhile.
`decode_in_child` hands the file to a decoder in another interpreter (`engine.storage.decoder_child`), so that a crash,
a hang or a huge allocation in a decoder written in C costs one file and never the program. Decoders get bytes, not
paths: a file name of any spelling works on every system. The child reads them from the file that the parent opened and
checked, whose descriptor it is handed through a socket, or from the pipe. It can open nothing else, as far as the
system can see to that (`engine.storage.sandbox`); its environment is empty but for where libraries lie.

Protocol, in both directions: one line of JSON, then the raw bytes it announces; an empty line before a reply says
that the request has arrived. Arrays come through memory that both share (`engine.storage.shared_memory`) where the
system has it. There is no pickle anywhere.
Cost: 0.3 s for the start of a child, 1 s where its decoders compile kernels; afterwards next to nothing.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import math
import os
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent import futures
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError, UnreadableError
from engine.core.figure_text import size_text
from engine.storage import readers
from engine.storage.sandbox import Protection
from engine.storage.shared_memory import SharedFile, make_shared_file

GIBIBYTE = 1 << 30

#: Largest file that is read at all.
FILE_LIMIT_BYTES = 4 * GIBIBYTE

#: Address space of a decoder: enough for 100 megapixels in 16 bits (file, samples, float32 result, temporaries).
DECODER_MEMORY_BYTES = 6 * GIBIBYTE

#: Seconds of CPU time that a decoder which has started gets for the smallest files and at most; in between by size.
SMALLEST_LIMIT_S, LARGEST_LIMIT_S = 30.0, 300.0
_BYTES_PER_S = 1_000_000

#: A decoder that has used less CPU time than its limit, because other programs have it, may take so many times the
#: limit by the clock.
PATIENCE = 4.0

#: Seconds in which a decoder process has to start, which on a fresh machine includes compiling its kernels.
START_LIMIT_S = 300.0

#: Files that may be decoded at once: one for each core, two where there is one core, and no more than eight.
CHILDREN = min(max(2, os.cpu_count() or 1), 8)

#: Processes that wait for another file, at most: those of photographs, and one of what is written of them, which a
#: batch of captures needs in turn.
IDLE = CHILDREN + 1

#: True where a process can hand open files to another.
HANDS_DESCRIPTORS = hasattr(socket, "send_fds")

#: The environment of a child: where libraries and compiled kernels lie, and no threads before it is confined.
_KEPT = ("LD_LIBRARY_PATH", "NUMBA_CACHE_DIR", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "SYSTEMROOT")
_ONE_THREAD = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "PXR_WORK_THREAD_LIMIT": "1",
}

#: Memory of decoders in large pages (glibc), as numpy has it: the system clears all that it gives, small pages slowly.
_LARGE_PAGES = {"GLIBC_TUNABLES": "glibc.malloc.hugetlb=1"}

#: The beginning of a child; its arguments are the number of its socket, its module of decoders, the readers of other
#: packages, the folder that it may read, and where modules lie.
_START = """
import sys
sys.path[:] = sys.argv[5:]
from engine.storage.decoder_child import main
main(int(sys.argv[1]) if sys.argv[1] != "-1" else None, *sys.argv[2:5])
"""

_handed: dict[str, bytes] = {}

#: The folder in which Python finds this module by its name.
_PROJECT = Path(__file__).resolve().parents[__name__.count(".")]

#: Remedies for a file that is damaged, and for one that the system does not let be read.
UNREADABLE = "Check that the file exists and may be read"
AGAIN = "Copy or download it again, or export it again from the program that wrote it"

Result = TypeVar("Result")

#: What is said of a reply that is none.
_INVALID = {"problem": "is damaged: its decoder returned an invalid response", "remedy": AGAIN}


def read_bytes(path: str | os.PathLike[str], limit_bytes: int = FILE_LIMIT_BYTES) -> bytes:
    """The content of a regular file of at most `limit_bytes`, unchanged while it was read; else InputError.

    In a decoder it is that of a file that the child was `handed`, which can open none.
    """
    if (known := _handed.get(os.fspath(path))) is not None:
        if len(known) > limit_bytes:
            raise _too_large(path, len(known), limit_bytes)
        _refuse_pointer(path, known)
        return known
    with open_checked(path, limit_bytes) as (file, size_bytes):
        content = _content(path, file, size_bytes)
    _refuse_pointer(path, content)
    return content


def is_at_hand(path: str | os.PathLike[str]) -> bool:
    """True for a path that `read_bytes` can read: in a decoder, which sees no other file, one that was handed."""
    return os.fspath(path) in _handed or Path(path).is_file()


@contextlib.contextmanager
def hand(contents: Mapping[str, bytes]) -> Iterator[None]:
    """Within the block `read_bytes` gives these contents for these names: decoders that read several files use it."""
    _handed.update(contents)
    try:
        yield
    finally:
        _handed.clear()


def read_head(path: str | os.PathLike[str], max_bytes: int) -> tuple[bytes, int]:
    """The first bytes of a regular file, at most `max_bytes`, and the size of the whole; else InputError."""
    with open_checked(path, FILE_LIMIT_BYTES) as (file, size_bytes):
        try:
            head = file.read(max_bytes)
        except OSError as error:
            raise _unreadable(path, error) from None
    _refuse_pointer(path, head)
    return head, size_bytes


def _content(path: str | os.PathLike[str], file: IO[bytes], size_bytes: int) -> bytes:
    try:
        content = file.read(size_bytes)
        grown = file.read(1)
    except OSError as error:
        raise _unreadable(path, error) from None
    if grown or len(content) != size_bytes:
        raise _change(path)
    return content


@contextlib.contextmanager
def open_checked(path: str | os.PathLike[str], limit_bytes: int) -> Iterator[tuple[IO[bytes], int]]:
    """The regular file `path` and its size; InputError if it has changed when the block ends."""
    try:
        _check_kind(path, os.stat(path), limit_bytes)  # noqa: PTH116 - a Path refuses some odd names
        flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
        file = open(os.open(path, flags), "rb")  # noqa: PTH123, SIM115 - opened by descriptor, closed below
    except ValueError as error:
        raise InputError(path, f"is not a possible file name ({error})", "Rename the file") from None
    except OSError as error:
        raise _unreadable(path, error) from None
    with file:
        before = os.fstat(file.fileno())
        _check_kind(path, before, limit_bytes)
        try:
            yield file, before.st_size
        finally:
            after = os.fstat(file.fileno())
            if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns):
                raise _change(path)


def _refuse_pointer(path: str | os.PathLike[str], head: bytes) -> None:
    """Repositories with large files hold, under their names, a few lines of text until the files are fetched."""
    if head.startswith(b"version https://git-lfs.github.com/spec/"):
        raise InputError(path, "is a git-lfs pointer, not the data", "Fetch the data with `git lfs pull`")


def _change(path: str | os.PathLike[str]) -> InputError:
    return InputError(path, "changed while it was being read", "Wait until it is complete and try again")


def _unreadable(path: str | os.PathLike[str], error: OSError) -> UnreadableError:
    return UnreadableError(path, _reason(error), UNREADABLE)


def _reason(error: OSError) -> str:
    if isinstance(error, FileNotFoundError):
        return "does not exist"
    return f"cannot be read: {os.strerror(error.errno) if error.errno else error}"


_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def _check_kind(path: str | os.PathLike[str], status: os.stat_result, limit_bytes: int) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = _KINDS.get(stat.S_IFMT(status.st_mode), "something else")
        raise InputError(path, f"is {kind}, not a regular file", "Give a file")
    if status.st_size == 0:
        raise InputError(path, "is empty (0 bytes)", AGAIN)
    if status.st_size > limit_bytes:
        raise _too_large(path, status.st_size, limit_bytes)


def _too_large(path: str | os.PathLike[str], size_bytes: int, limit_bytes: int) -> InputError:
    problem = f"has {size_text(size_bytes)}, more than the limit of {size_text(limit_bytes)}"
    return InputError(path, problem, "Make it smaller")


class Cancellation:
    """Ends a decoding from another thread by killing the child that is at it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._child: _Child | None = None
        self._cancelled = False

    def cancel(self) -> None:
        with self._lock:
            self._cancelled = True
            if self._child is not None:
                self._child.process.kill()

    @contextlib.contextmanager
    def watching(self, child: _Child) -> Iterator[None]:
        with self._lock:
            self._child = child
            if self._cancelled:
                child.process.kill()
        try:
            yield
        finally:
            with self._lock:
                self._child = None


def decode_in_child(
    decoder: str,
    path: str | os.PathLike[str],
    *,
    memory_bytes: int = DECODER_MEMORY_BYTES,
    timeout_s: float | None = None,
    limit_bytes: int = FILE_LIMIT_BYTES,
    cancellation: Cancellation | None = None,
    beside: Mapping[str, Path] = MappingProxyType({}),
    process: str = "",
    as_file: bool = False,
    copies: str = "",
    scratch: IO[bytes] | None = None,
    **options: Any,
) -> dict[str, Any]:
    """Run `decoder` on the content of `path` in a child interpreter and return what it returns.

    Parameters
    ----------
    decoder : "package.module:function", called as `function(content: bytes, name: str, **options)`. It returns a dict
        of arrays and JSON values, and raises `InputError(name, problem, remedy)` for what it does not accept.
    memory_bytes : address space of the child; what needs more is refused.
    timeout_s : what is not decoded by then is refused; None is `time_limit_s`.
    process : the module whose child is asked, where one that serves other files at the time can serve this one; '' is
        that of the decoder.
    beside : further files by the names that the decoder knows them by; it gets their contents as the keyword `beside`.
    as_file : the decoder gets a binary file, of which it reads what it needs, in the place of the content.
    copies : a folder with copies of files, for libraries that open files by their paths; '' for none. The decoder gets
        it as the keyword `copies`, in a process that may read it and ends with this request.
    scratch : an empty file, open for writing, that the decoder fills as the keyword `scratch`.
    options : JSON values.

    Raises InputError for a file that cannot be read or decoded, also when the decoder crashes or takes too long.
    """
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(open_checked(each, limit_bytes)) for each in (path, *beside.values())]
        sizes = [size_bytes for _, size_bytes in files]
        limits = {"memory_bytes": memory_bytes, "timeout_s": timeout_s or time_limit_s(sum(sizes))}
        request = _request(decoder, path, options, limits, sizes, beside)
        request |= {"process": process or request["process"], "as_file": as_file, "scratch": scratch is not None}
        if copies:
            request |= {"copies": copies, "options": {**options, "copies": copies}}
        if HANDS_DESCRIPTORS:
            handed = [file.fileno() for file, _ in files] + ([] if scratch is None else [scratch.fileno()])
            return _decode(request, [], handed, cancellation)
        contents = [_content(each, *file) for each, file in zip((path, *beside.values()), files, strict=True)]
    reply = _decode(request, contents, [], cancellation)
    if scratch is not None:
        scratch.write(reply.pop("scratch").data)
    return reply


def decode_content(
    decoder: str,
    path: str | os.PathLike[str],
    content: bytes,
    *,
    memory_bytes: int = DECODER_MEMORY_BYTES,
    timeout_s: float | None = None,
    process: str = "",
    **options: Any,
) -> dict[str, Any]:
    """As `decode_in_child`, for `content` that has been read already (a member of a bundle); `path` names it."""
    limits: dict[str, Any] = {"memory_bytes": memory_bytes, "timeout_s": timeout_s or time_limit_s(len(content))}
    request = _request(decoder, path, options, limits, [len(content)])
    request["process"] = process or request["process"]
    return _decode(request, [content], [], None)


def time_limit_s(size_bytes: int) -> float:
    """Seconds of CPU time in which a file of this size is decoded on a slow machine, or never."""
    return min(LARGEST_LIMIT_S, SMALLEST_LIMIT_S + size_bytes // _BYTES_PER_S)


def _request(
    decoder: str,
    path: str | os.PathLike[str],
    options: dict[str, Any],
    limits: dict[str, Any],
    sizes_bytes: list[int],
    beside: Mapping[str, Path] = MappingProxyType({}),
) -> dict[str, Any]:
    """Request to the child; the contents come as descriptors of files of `sizes_bytes`, or after it."""
    known = {"decoder": decoder, "name": os.fspath(path), "options": options, **limits}
    module = decoder.partition(":")[0]
    more = {"as_file": False, "scratch": False, "origin": _origin(path), "copies": ""}
    return {**known, **more, "contents": sizes_bytes, "beside": list(beside), "process": module}


def _origin(path: str | os.PathLike[str]) -> str:
    """The folder or the archive that a file lies in: who can write one file of it is taken to have written all."""
    return os.path.dirname(os.fspath(path))  # noqa: PTH120 - a Path refuses some odd names


def _decode(
    request: dict[str, Any], contents: list[bytes], files: list[int], cancellation: Cancellation | None
) -> dict[str, Any]:
    global _protection
    reply = _answer(request, contents, files, cancellation or Cancellation())
    if "protection" in reply:
        found = reply.pop("protection")
        _protection = _protection if found == _protection else found
    if "problem" in reply:
        path = reply["path"] if reply.get("path") in request["beside"] else request["name"]
        kind = UnreadableError if reply.get("unreadable") else InputError
        raise kind(path, reply["problem"], reply["remedy"])
    return _Reply(request["name"], reply)


class _Reply(dict[str, Any]):
    """The results of a decoder by name; InputError for one that is asked for and missing."""

    def __init__(self, path: str, results: dict[str, Any]) -> None:
        super().__init__(results)
        self._path = path

    def __missing__(self, _name: str) -> Any:
        raise InputError(self._path, *_INVALID.values())


def build(make: Callable[..., Result], path: str | os.PathLike[str], fields: Mapping[str, Any]) -> Result:
    """`make(**fields)` of what a decoder answered about `path`; InputError where these are not the fields it takes."""
    try:
        return make(**fields)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        raise InputError(path, *_INVALID.values()) from None


def protection() -> Protection | None:
    """The confinement of the child that answered last; None before the first."""
    return _protection


class Decoding:
    """`decode_in_child` while its caller does other things, as is what `finish` makes of its result."""

    def __init__(
        self,
        decoder: str,
        path: str | os.PathLike[str],
        *,
        finish: Callable[[dict[str, Any]], Any] = lambda reply: reply,
        **options: Any,
    ) -> None:
        self._cancellation = Cancellation()
        options["cancellation"] = self._cancellation
        self._future = _ahead.submit(lambda: finish(decode_in_child(decoder, path, **options)))

    def wait(self, timeout_s: float) -> bool:
        """Wait for at most `timeout_s`; True if there is a result."""
        futures.wait([self._future], timeout_s)
        return self._future.done()

    def result(self) -> Any:
        """The result, waited for; raises the error of its decoder."""
        return self._future.result()

    def cancel(self) -> None:
        """End it at once, whatever the child is doing."""
        self._future.cancel()
        self._cancellation.cancel()
        futures.wait([self._future], 1.0)


def _answer(
    request: dict[str, Any], contents: list[bytes], files: list[int], cancellation: Cancellation
) -> dict[str, Any]:
    """The reply of a child; a child that died before the request reached it, as idle ones may, is replaced once."""
    for _ in range(2):
        with (
            _child(request["process"], request["origin"], request["copies"]) as child,
            cancellation.watching(child),
            make_shared_file() as results,
        ):
            reply = child.ask(request, contents, files, results if child.socket is not None else None)
            if reply is not None and "problem" in reply:
                child.suspect = request["origin"]
        if reply is not None:
            return reply
    return {"problem": "cannot be decoded: the decoder process ends at once", "remedy": "Start the program again"}


class _Child:
    """One process for the decoders of `module`; `ask` leaves it ready for the next file, or dead.

    `suspect` is the origin of a file that it refused, None where there was none: what a damaged file may have done to
    the process must not reach files of another origin. `folder` is one that it may read, '' for none.
    """

    def __init__(self, module: str, folder: str = "") -> None:
        self.module = module
        self.readers = readers.outside()
        self.suspect: str | None = None
        own, other = socket.socketpair() if HANDS_DESCRIPTORS else (None, None)
        handed = -1 if other is None else other.fileno()
        path = [os.path.abspath(place) for place in (str(_PROJECT), *sys.path)]  # noqa: PTH100 - keeps names as they are
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-I", "-c", _START, str(handed), module, self.readers, folder, *path],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={**{name: os.environ[name] for name in _KEPT if name in os.environ}, **_ONE_THREAD, **_LARGE_PAGES},
                pass_fds=() if other is None else (handed,),
            )
        except BaseException:
            if own is not None:
                own.close()
            raise
        finally:
            if other is not None:
                other.close()
        self.socket = own
        _running.add(self)

    @property
    def alive(self) -> bool:
        return self.process.poll() is None

    def ask(
        self, request: dict[str, Any], contents: list[bytes], files: list[int], results: SharedFile | None
    ) -> dict[str, Any] | None:
        """The child's reply, or what became of the child; None if it died before the request reached it."""
        requests, replies = self.process.stdin, self.process.stdout
        assert requests is not None
        assert replies is not None
        arrived, expired = False, threading.Event()
        watchdog = self._watchdog(START_LIMIT_S, expired)
        try:
            handed = files if results is None else [*files, results.descriptor]
            if self.socket is not None and handed:
                socket.send_fds(self.socket, [b"\n"], handed)
            limits = {"patience_s": PATIENCE * request["timeout_s"]}
            on_disk = results is not None and results.folder is not None
            shared = {"shared": results is not None, "on_disk": on_disk}
            line = json.dumps({**request, **limits, **shared, "descriptors": len(handed)})
            requests.write(line.encode() + b"\n")
            requests.writelines(contents)
            requests.flush()
            arrived = replies.readline() == b"\n"
            watchdog.cancel()
            watchdog = self._watchdog(request["timeout_s"], expired)
            reply = _receive(replies, results, request["memory_bytes"])
        except (OSError, EOFError):
            self.kill()
            return self._last_words(request, arrived, expired.is_set()) if arrived or expired.is_set() else None
        except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError):
            self.kill()
            return dict(_INVALID)
        finally:
            watchdog.cancel()
        if reply.pop("ends", False):
            self.kill()
        return reply

    def _watchdog(self, limit_s: float, expired: threading.Event) -> _Watchdog:
        """Kill the child when it has had `limit_s` of CPU time, unless that is cancelled before."""

        def expire() -> None:
            expired.set()
            self.process.kill()

        watchdog = _Watchdog(self.process.pid, limit_s, expire)
        watchdog.start()
        return watchdog

    def _last_words(self, request: dict[str, Any], arrived: bool, is_expired: bool) -> dict[str, Any]:
        if is_expired and not arrived:
            problem = f"could not be decoded, because the decoder process did not start within {START_LIMIT_S:g} s"
            return {"problem": problem, "remedy": "Try again when other programs leave this machine more time"}
        if is_expired:
            return {"problem": f"could not be decoded within {request['timeout_s']:g} s", "remedy": AGAIN}
        code = self.process.returncode
        if code == -getattr(signal, "SIGKILL", 0):
            problem = "could not be decoded, because the system ended the decoder process, as it does without memory"
            return {"problem": problem, "remedy": "Close other programs and try again"}
        return {"problem": f"is damaged: its decoder crashed (exit code {code})", "remedy": AGAIN}

    def kill(self) -> None:
        self.process.kill()
        for pipe in (self.process.stdin, self.process.stdout, self.socket):
            with contextlib.suppress(OSError):
                if pipe is not None:
                    pipe.close()
        self.process.wait()
        _running.discard(self)


class _Watchdog(threading.Thread):
    """Calls `expire` when a process has had `limit_s` by the clock, and of CPU time or `PATIENCE` times that."""

    def __init__(self, process: int, limit_s: float, expire: Callable[[], object]) -> None:
        super().__init__(name="decoder limit", daemon=True)
        self._process, self._limit_s, self._expire = process, limit_s, expire
        self._is_over = threading.Event()

    def cancel(self) -> None:
        self._is_over.set()

    def run(self) -> None:
        begun_s, spent_s = time.monotonic(), _cpu_s(self._process)
        wait_s = self._limit_s
        while not self._is_over.wait(wait_s):
            left_s = begun_s + PATIENCE * self._limit_s - time.monotonic()
            wait_s = min(self._limit_s - (_cpu_s(self._process) - spent_s), left_s)
            if not wait_s > 0.0:  # also where it is not a number, because the process was gone from the beginning
                self._expire()
                return


def _cpu_s(process: int) -> float:
    """Seconds of CPU time that a process has used; infinite where the system does not tell, or it is gone."""
    import psutil

    try:
        times = psutil.Process(process).cpu_times()
    except psutil.Error:
        return math.inf
    return float(times.user + times.system)


def _receive(replies: IO[bytes], results: SharedFile | None, limit_bytes: int) -> dict[str, Any]:
    """One reply: a JSON object whose "arrays" list (name, dtype, shape) announces arrays.

    They lie at the "offsets" of the shared file, or their bytes follow on the pipe.
    """
    line = replies.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    reply: dict[str, Any] = json.loads(line)
    if "protection" in reply:
        reply["protection"] = Protection(**reply["protection"])
    if "problem" in reply and not isinstance(reply["problem"] + reply["remedy"], str):
        raise TypeError("decoder announced a problem without words")
    offsets = reply.pop("offsets", None)
    for name, kind, shape in reply.pop("arrays"):
        dtype = np.dtype(kind)
        if dtype.hasobject or dtype.itemsize * int(np.prod(shape, dtype=object)) > limit_bytes:
            raise ValueError(f"decoder announced an array of {shape} {kind}")
        if results is not None and offsets is not None:
            reply[name] = results.array(offsets[name], dtype, tuple(shape))
        else:
            reply[name] = _pipe(replies, dtype, tuple(shape))
    return reply


def _pipe(replies: IO[bytes], dtype: np.dtype[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    array = np.empty(shape, dtype)
    view = array.reshape(-1).view(np.uint8).data
    while len(view):
        count = replies.readinto(view)  # type: ignore[attr-defined]
        if not count:
            raise EOFError
        view = view[count:]
    return array


_protection: Protection | None = None
_ahead = futures.ThreadPoolExecutor(CHILDREN, thread_name_prefix="decoding")
_slots = threading.BoundedSemaphore(CHILDREN)
_idle: list[_Child] = []
_idle_lock = threading.Lock()
_running: set[_Child] = set()


@contextlib.contextmanager
def _child(module: str, origin: str, folder: str) -> Iterator[_Child]:
    """An idle child or a new one, for one request; it is kept for the next unless the request killed or left it.

    One that may read a `folder` is new, and ends after the request.
    """
    with _slots:
        child = None if folder else _take(module, origin)
        child = child or _Child(module, folder)
        try:
            yield child
        except BaseException:
            child.kill()
            raise
        if folder:
            child.kill()
        elif child.alive:
            _keep(child)


def list_processes() -> list[int]:
    """The numbers of all decoder processes, busy or idle."""
    return [child.process.pid for child in tuple(_running)]


def expect(decoder: str, niceness: int = 0) -> None:
    """Start the process of a `decoder` that will soon be asked, where there is none: it loads what it needs meanwhile.

    It yields to others by so much more `niceness` (Linux). Where none can be started now, whoever asks it is told why.
    """
    module = decoder.partition(":")[0]
    if not any(child.module == module and child.alive for child in tuple(_running)):
        with contextlib.suppress(OSError):
            child = _Child(module)
            _keep(child)
            if niceness and sys.platform == "linux":
                os.setpriority(os.PRIO_PROCESS, child.process.pid, niceness)


def _keep(child: _Child) -> None:
    """Count a child among the idle ones, of which the oldest goes where they are too many."""
    with _idle_lock:
        _idle.append(child)
        oldest = _idle.pop(0) if len(_idle) > IDLE else None
    if oldest is not None:
        oldest.kill()


def _take(module: str, origin: str) -> _Child | None:
    """An idle child for `module` that is alive and may read files of `origin`, which is idle no more."""
    with _idle_lock:
        found = [idle for idle in _idle if idle.module == module and idle.readers == readers.outside()]
        child = next((idle for idle in found if idle.suspect in (None, origin)), found[0] if found else None)
        if child is None:
            return None
        _idle.remove(child)
    if child.alive and child.suspect in (None, origin):
        return child
    child.kill()
    return None


@atexit.register
def stop_children() -> None:
    """End all decoder processes, also busy ones; the next file starts a new one."""
    _idle.clear()
    for child in tuple(_running):
        child.kill()
