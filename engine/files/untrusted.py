"""The one way in for files that the program did not write itself.

`read_bytes` opens regular files only, looks at the size before it reads, and notices when a file changes meanwhile.
`decode_in_child` hands the bytes to a decoder in another interpreter (`engine.files.decoder_child`), so that a crash,
a hang or a huge allocation in a decoder written in C costs one file and never the program. Decoders get bytes, not
paths: a file name of any spelling works on every system.

Protocol, in both directions: one line of JSON, then the raw bytes it announces. There is no pickle anywhere.
Cost: about 0.3 s for the first file of each child (its start), afterwards one copy of the file and one of the result.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import stat
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np

from engine.errors import InputError

GIBIBYTE = 1 << 30

#: Largest file that is read at all.
FILE_LIMIT_BYTES = 4 * GIBIBYTE

#: Address space of a decoder: enough for 100 megapixels in 16 bits (file, samples, float32 result, temporaries).
DECODER_MEMORY_BYTES = 6 * GIBIBYTE

#: Two photographs may be decoded at once.
CHILDREN = 2

AGAIN = "Copy it again from the camera or card, or export it again from the program that wrote it"


def read_bytes(path: str | os.PathLike[str], limit_bytes: int = FILE_LIMIT_BYTES) -> bytes:
    """The content of a regular file of at most `limit_bytes`, unchanged while it was read; else InputError."""
    try:
        _check_kind(path, os.stat(path), limit_bytes)  # noqa: PTH116 - a Path refuses some odd names
        flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
        with open(os.open(path, flags), "rb") as file:  # noqa: PTH123 - opened by descriptor
            before = os.fstat(file.fileno())
            _check_kind(path, before, limit_bytes)
            content = file.read(before.st_size)
            grown = file.read(1)
            after = os.fstat(file.fileno())
    except ValueError as error:
        raise InputError(path, f"is not a possible file name ({error})", "Rename the file") from None
    except OSError as error:
        raise InputError(path, _reason(error), "Check that the file exists and may be read") from None
    if (
        grown
        or len(content) != before.st_size
        or (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns)
    ):
        raise InputError(path, "changed while it was being read", "Wait until it is complete and try again")
    return content


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
        raise InputError(
            path,
            f"has {status.st_size / 1e6:.0f} MB, more than the limit of {limit_bytes / 1e6:.0f} MB",
            "Make it smaller",
        )


def decode_in_child(
    decoder: str,
    path: str | os.PathLike[str],
    *,
    memory_bytes: int = DECODER_MEMORY_BYTES,
    timeout_s: float = 60.0,
    limit_bytes: int = FILE_LIMIT_BYTES,
    **options: Any,
) -> dict[str, Any]:
    """Run `decoder` on the content of `path` in a child interpreter and return what it returns.

    Parameters
    ----------
    decoder : "package.module:function", called as `function(content: bytes, name: str, **options)`. It returns a dict
        of arrays and JSON values, and raises `InputError(name, problem, remedy)` for what it does not accept.
    memory_bytes : address space of the child; what needs more is refused.
    options : JSON values.

    Raises InputError for a file that cannot be read or decoded, also when the decoder crashes or takes too long.
    """
    return decode_content(
        decoder, path, read_bytes(path, limit_bytes), memory_bytes=memory_bytes, timeout_s=timeout_s, **options
    )


def decode_content(
    decoder: str,
    path: str | os.PathLike[str],
    content: bytes,
    *,
    memory_bytes: int = DECODER_MEMORY_BYTES,
    timeout_s: float = 60.0,
    **options: Any,
) -> dict[str, Any]:
    """As `decode_in_child`, for `content` that has been read already (a member of a bundle); `path` names it."""
    request = {
        "decoder": decoder,
        "name": os.fspath(path),
        "options": options,
        "memory_bytes": memory_bytes,
        "timeout_s": timeout_s,
        "content_bytes": len(content),
    }
    with _child() as child:
        reply = child.ask(request, content, timeout_s)
    if "problem" in reply:
        raise InputError(path, reply["problem"], reply["remedy"])
    return reply


class _Child:
    """One decoder process; `ask` leaves it ready for the next file, or dead."""

    def __init__(self) -> None:
        root = str(Path(__file__).resolve().parents[2])
        known = os.environ.get("PYTHONPATH")
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "engine.files.decoder_child"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": root + (os.pathsep + known if known else "")},
        )
        _running.add(self)

    @property
    def alive(self) -> bool:
        return self.process.poll() is None

    def ask(self, request: dict[str, Any], content: bytes, timeout_s: float) -> dict[str, Any]:
        requests, replies = self.process.stdin, self.process.stdout
        assert requests is not None
        assert replies is not None
        expired = threading.Event()
        watchdog = threading.Timer(timeout_s, self._expire, (expired,))
        watchdog.daemon = True
        watchdog.start()
        try:
            requests.write(json.dumps(request).encode() + b"\n")
            requests.write(content)
            requests.flush()
            reply = _receive(replies, request["memory_bytes"])
        except (BrokenPipeError, EOFError):
            self.kill()
            return self._last_words(timeout_s if expired.is_set() else None)
        finally:
            watchdog.cancel()
        if reply.pop("ends", False):
            self.kill()
        return reply

    def _expire(self, expired: threading.Event) -> None:
        expired.set()
        self.process.kill()

    def _last_words(self, timeout_s: float | None) -> dict[str, Any]:
        if timeout_s is not None:
            return {"problem": f"could not be decoded within {timeout_s:g} s", "remedy": AGAIN}
        code = self.process.returncode
        return {"problem": f"is damaged: its decoder crashed (exit code {code})", "remedy": AGAIN}

    def kill(self) -> None:
        self.process.kill()
        for pipe in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(OSError):
                if pipe is not None:
                    pipe.close()
        self.process.wait()
        _running.discard(self)


def _receive(replies: IO[bytes], limit_bytes: int) -> dict[str, Any]:
    """One reply: a JSON object whose "arrays" list (name, dtype, shape) announces the bytes that follow it."""
    line = replies.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    reply: dict[str, Any] = json.loads(line)
    for name, kind, shape in reply.pop("arrays"):
        dtype = np.dtype(kind)
        if dtype.hasobject or dtype.itemsize * int(np.prod(shape, dtype=object)) > limit_bytes:
            raise ValueError(f"decoder announced an array of {shape} {kind}")
        array = np.empty(shape, dtype)
        view = array.reshape(-1).view(np.uint8).data
        while len(view):
            count = replies.readinto(view)  # type: ignore[attr-defined]
            if not count:
                raise EOFError
            view = view[count:]
        reply[name] = array
    return reply


_slots = threading.BoundedSemaphore(CHILDREN)
_idle: list[_Child] = []
_running: set[_Child] = set()


@contextlib.contextmanager
def _child() -> Iterator[_Child]:
    """An idle child or a new one, for one request; it is kept for the next unless the request killed or left it."""
    with _slots:
        child = _idle.pop() if _idle else _Child()
        if not child.alive:
            child.kill()
            child = _Child()
        try:
            yield child
        except BaseException:
            child.kill()
            raise
        if child.alive:
            _idle.append(child)


@atexit.register
def stop_children() -> None:
    """End all decoder processes, also busy ones; the next file starts a new one."""
    _idle.clear()
    for child in tuple(_running):
        child.kill()
