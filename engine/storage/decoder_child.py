"""The other interpreter of `engine.storage.untrusted`: reads requests on stdin, decodes, answers on stdout.

It serves the decoders of one module, whose `prepare`, where there is one, compiles what could not be kept on the disk
later; then it gives up what decoders do not need (`engine.storage.sandbox`), and reaches the descriptors that it is
handed and Python's modules, before it sees the first file.
It ends when stdin is closed. An error that decoders are known to raise on damaged data is answered and the next
request awaited; an unforeseen one is answered as well, and then this process ends so that the next file meets a fresh
one. What native libraries print about a file (libjpeg: "Corrupt JPEG data", LibRaw: "unexpected end of file") is
their only way to say that a result is incomplete; `complaints` collects it.
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import gc
import importlib
import io
import json
import math
import os
import select
import signal
import socket
import struct
import sys
import zlib
from collections.abc import Iterator
from dataclasses import asdict
from types import TracebackType
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError, shortage
from engine.storage import readers
from engine.storage.sandbox import Protection, confine
from engine.storage.shared_memory import results_in
from engine.storage.untrusted import AGAIN, UNREADABLE

_DAMAGE: tuple[type[Exception], ...] = (
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
    struct.error,
    zlib.error,
)

#: Errors of disks, networks and limits: no decoder raises them of what a file holds.
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_OF_THE_SYSTEM = (*_NO_ROOM, errno.EIO, errno.ENXIO, errno.EBADF, errno.ESTALE, errno.ETIMEDOUT)

#: Seconds for which the memory of one file is kept for the next, and numbers of glibc's `mallopt`.
_WAIT_S, _TRIM_THRESHOLD, _MMAP_MAX = 3.0, -1, -4


def main(handed: int | None, module: str, outside: str, folder: str) -> None:
    """Serve decoders of `module` until stdin is closed; `handed` is the socket for descriptors, if there is one.

    `outside` are the readers of other packages (`engine.storage.readers.outside`), `folder` one that decoders may read,
    '' for none.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    requests, replies = sys.stdin.buffer, _private_stdout()
    sys.excepthook = lambda kind, error, trace: _unforeseen(replies, kind, error, trace)
    descriptors = None if handed is None else socket.socket(fileno=handed)
    readers.adopt(outside)
    decoders = importlib.import_module(module)
    if hasattr(decoders, "prepare"):
        decoders.prepare()
    sys.dont_write_bytecode = True
    protection = confine(folder=folder)
    while line := _next_request(requests):
        gc.freeze()  # what stays between files, above all modules, need not be searched for garbage after each
        _serve(json.loads(line), requests, replies, descriptors, protection)


def _next_request(requests: IO[bytes]) -> bytes:
    """The line of the next request, waited for; the system has the memory of the last one back where none follows."""
    if sys.platform == "linux" and not select.select([requests], [], [], _WAIT_S)[0]:
        _trim_memory()
    return requests.readline()


def _keep_memory(kept: bool) -> None:
    """Whether the C library keeps memory that was large arrays (glibc); what the system gives anew it has to clear."""
    with contextlib.suppress(AttributeError):
        libc = ctypes.CDLL(None)
        libc.mallopt(_MMAP_MAX, 0 if kept else 1 << 16)
        libc.mallopt(_TRIM_THRESHOLD, (1 << 31) - 1 if kept else 1 << 17)


def _trim_memory() -> None:
    """Give back what the C library keeps (glibc)."""
    with contextlib.suppress(AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


def _serve(
    request: dict[str, Any],
    requests: IO[bytes],
    replies: IO[bytes],
    descriptors: socket.socket | None,
    protection: Protection,
) -> None:
    """Answer one request; the empty line before the answer says that it has arrived whole."""
    _keep_memory(not request["on_disk"])
    count = request["descriptors"]
    handed = socket.recv_fds(descriptors, 1, count)[1] if descriptors is not None and count else []
    results_file = handed.pop() if request["shared"] else None
    with contextlib.ExitStack() as files:
        scratch = files.enter_context(_scratch(handed)) if request["scratch"] else None
        contents: list[Any] = []
        unreadable: OSError | None = None
        try:
            for size_bytes in request["contents"]:
                if request["as_file"]:
                    contents.append(files.enter_context(_file(size_bytes, handed, requests)))
                else:
                    contents.append(_content(size_bytes, handed, requests))
        except OSError as error:
            unreadable = error
        replies.write(b"\n")
        replies.flush()
        _limit_memory(request["memory_bytes"])
        _limit_time(request["patience_s"])
        with results_in(results_file, request["on_disk"]) as results:
            answer = _refusal(unreadable) if unreadable else _answer(request, contents, results, scratch)
    del contents, scratch
    gc.collect()  # decoders leave reference cycles that hold the whole file, and arrays that the parent waits for
    _send(replies, {**answer, "protection": asdict(protection)})
    _limit_time(0)


def _content(size_bytes: int, handed: list[int], requests: IO[bytes]) -> bytes:
    """The next file, from its descriptor or the pipe; one that shrinks meanwhile comes short, as the parent notices."""
    if not handed:
        return requests.read(size_bytes)
    with os.fdopen(handed.pop(0), "rb") as file:
        file.seek(0)
        return file.read(size_bytes)


def _file(size_bytes: int, handed: list[int], requests: IO[bytes]) -> IO[bytes]:
    """The next file itself, to be closed."""
    return os.fdopen(handed.pop(0), "rb") if handed else io.BytesIO(requests.read(size_bytes))


def _scratch(handed: list[int]) -> IO[bytes]:
    """The parent's file for what the decoder writes, to be closed; or memory, whose content becomes an array."""
    return os.fdopen(handed.pop(), "r+b") if handed else io.BytesIO()


def _private_stdout() -> IO[bytes]:
    """The pipe to the parent under a descriptor of its own, so that nothing a library prints can get into it."""
    replies = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    return replies


def _limit_memory(memory_bytes: int) -> None:
    if sys.platform == "win32":
        return
    import resource

    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    soft = memory_bytes if hard == resource.RLIM_INFINITY else min(memory_bytes, hard)
    with contextlib.suppress(ValueError, OSError):  # macOS refuses limits below what is mapped already
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))


def _limit_of_data(memory_bytes: int) -> int:
    """`memory_bytes`, or the memory that the parent was told to take at most, which holds for this process as well."""
    if sys.platform != "linux":
        return memory_bytes
    import resource

    soft = resource.getrlimit(resource.RLIMIT_DATA)[0]
    return memory_bytes if soft == resource.RLIM_INFINITY else min(memory_bytes, soft)


def _limit_time(seconds: float) -> None:
    """A second past the parent's own limit, for a parent that is gone; 0 lifts it."""
    if hasattr(signal, "alarm"):
        signal.alarm(math.ceil(seconds) + 1 if seconds else 0)


def _answer(
    request: dict[str, Any], contents: list[Any], results: Any, scratch: IO[bytes] | None = None
) -> dict[str, Any]:
    """Results of the decoder, its arrays in the parent's file (`offsets`) if there is one, or the failure."""
    more: dict[str, Any] = {} if scratch is None else {"scratch": scratch}
    if request["beside"]:
        more["beside"] = dict(zip(request["beside"], contents[1:], strict=True))
    try:
        decode = readers.load(request["decoder"])
        answer = dict(decode(contents[0], request["name"], **more, **request["options"]))
        if isinstance(scratch, io.BytesIO):
            answer["scratch"] = np.frombuffer(scratch.getvalue(), np.uint8)
        arrays = {name: np.ascontiguousarray(value) for name, value in answer.items() if isinstance(value, np.ndarray)}
        if results is None:
            return {**answer, **arrays}
        values = {name: value for name, value in answer.items() if name not in arrays}
        offsets = {name: results.offset(array) for name, array in arrays.items()}
        return {**values, "arrays": _announce(arrays), "offsets": offsets}
    except InputError as error:
        return {"problem": error.problem, "remedy": error.remedy, "path": os.fspath(error.path)}
    except _DAMAGE as error:
        if shortage(error) is not None:
            limit = _limit_of_data(request["memory_bytes"]) / 2**30
            return {"problem": f"needs more than {limit:.1f} GiB to decode", "remedy": "Make it smaller"}
        if isinstance(error, OSError) and error.errno in _OF_THE_SYSTEM:
            return _refusal(error)
        return {"problem": f"is damaged or of an unknown kind{_quote_reader(error)}", "remedy": AGAIN}


def _refusal(error: OSError) -> dict[str, Any]:
    """The answer where the system refuses to read a file, or to keep what comes of it."""
    if error.errno in _NO_ROOM:
        problem = f"cannot be unpacked: {os.strerror(error.errno)}"
        return {"problem": problem, "remedy": "Free some space on the disk of temporary files", "unreadable": True}
    cause = os.strerror(error.errno) if error.errno else str(error)
    return {"problem": f"cannot be read: {cause}", "remedy": UNREADABLE, "unreadable": True}


def _quote_reader(error: Exception) -> str:
    """The words of a reader in brackets; nothing where they are Python's own, of its lists and types."""
    words = " ".join(str(error).split())[:200]
    return f" ({words})" if words and not isinstance(error, (LookupError, TypeError, AttributeError)) else ""


def _one_line(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:200]


def _unforeseen(
    replies: IO[bytes], kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    _send(replies, {"problem": f"cannot be decoded ({_one_line(error)})", "remedy": AGAIN, "ends": True})
    sys.__excepthook__(kind, error, trace)


def _announce(arrays: dict[str, NDArray[Any]]) -> list[tuple[str, str, tuple[int, ...]]]:
    return [(name, array.dtype.str, array.shape) for name, array in arrays.items()]


def _send(replies: IO[bytes], answer: dict[str, Any]) -> None:
    arrays = {name: value for name, value in answer.items() if isinstance(value, np.ndarray)}
    header = {name: value for name, value in answer.items() if name not in arrays}
    replies.write(json.dumps({"arrays": _announce(arrays), **header}).encode() + b"\n")
    for array in arrays.values():
        replies.write(array.reshape(-1).view(np.uint8).data)
    replies.flush()


@contextlib.contextmanager
def complaints() -> Iterator[list[str]]:
    """Collect the lines that native code prints on stderr; the list is filled when the block ends."""
    lines: list[str] = []
    sys.stderr.flush()
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    kept = os.dup(2)
    os.dup2(writer, 2)
    os.close(writer)
    try:
        yield lines
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        with os.fdopen(reader, "rb") as pipe:
            lines += pipe.read().decode("utf-8", "replace").splitlines()
