"""The other interpreter of `engine.files.untrusted`: reads requests on stdin, decodes, answers on stdout.

It ends when stdin is closed. An error that decoders are known to raise on damaged data is answered and the next
request awaited; an unforeseen one is answered as well, and then this process ends so that the next file meets a fresh
one. What native libraries print about a file (libjpeg: "Corrupt JPEG data", LibRaw: "unexpected end of file") is
their only way to say that a result is incomplete; `complaints` collects it.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import math
import os
import signal
import struct
import sys
import zlib
from collections.abc import Iterator
from types import TracebackType
from typing import IO, Any

import numpy as np

from engine.errors import InputError
from engine.files.shared import results_in
from engine.files.untrusted import AGAIN

_DAMAGE: tuple[type[Exception], ...] = (
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
    struct.error,
    zlib.error,
)


def main() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    requests, replies = sys.stdin.buffer, _private_stdout()
    sys.excepthook = lambda kind, error, trace: _unforeseen(replies, kind, error, trace)
    while line := requests.readline():
        gc.freeze()  # what stays between files, above all modules, need not be searched for garbage after each
        _serve(json.loads(line), requests, replies)
        gc.collect()  # decoders leave reference cycles that hold the whole file


def _serve(request: dict[str, Any], requests: IO[bytes], replies: IO[bytes]) -> None:
    """Answer one request; the empty line before the answer says that it has arrived whole."""
    content = _content(request, requests)
    replies.write(b"\n")
    replies.flush()
    _limit_memory(request["memory_bytes"])
    _limit_time(request["timeout_s"])
    with results_in(request["results"]) as results:
        _send(replies, _answer(request, content, results))
    _limit_time(0)


def _content(request: dict[str, Any], requests: IO[bytes]) -> bytes:
    """The file to decode; one that shrinks meanwhile comes short, which the parent notices."""
    if request["source"] is None:
        return requests.read(request["content_bytes"])
    with open(request["source"], "rb") as file:  # noqa: PTH123 - a descriptor of the parent
        return file.read(request["content_bytes"])


def _private_stdout() -> IO[bytes]:
    """The pipe to the parent under a descriptor of its own, so that nothing a library prints can get into it."""
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
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


def _limit_time(seconds: float) -> None:
    """A second past the parent's own limit, for a parent that is gone; 0 lifts it."""
    if hasattr(signal, "alarm"):
        signal.alarm(math.ceil(seconds) + 1 if seconds else 0)


def _answer(request: dict[str, Any], content: bytes, results: Any) -> dict[str, Any]:
    """What the decoder returns, its arrays in the parent's file (`offsets`) where there is one, or what went wrong."""
    try:
        module, function = request["decoder"].split(":")
        decode = getattr(importlib.import_module(module), function)
        answer = dict(decode(content, request["name"], **request["options"]))
        arrays = {name: np.ascontiguousarray(value) for name, value in answer.items() if isinstance(value, np.ndarray)}
        offsets = {name: results.offset(array) for name, array in arrays.items()} if results is not None else None
        return {**answer, **arrays, "offsets": offsets}
    except InputError as error:
        return {"problem": error.problem, "remedy": error.remedy}
    except MemoryError:
        limit = request["memory_bytes"] / 2**30
        return {"problem": f"needs more than {limit:.1f} GiB to decode", "remedy": "Make it smaller"}
    except _DAMAGE as error:
        return {"problem": f"is damaged or of an unknown kind ({_one_line(error)})", "remedy": AGAIN}


def _one_line(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:200]


def _unforeseen(
    replies: IO[bytes], kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    _send(replies, {"problem": f"cannot be decoded ({_one_line(error)})", "remedy": AGAIN, "ends": True})
    sys.__excepthook__(kind, error, trace)


def _send(replies: IO[bytes], answer: dict[str, Any]) -> None:
    arrays = {name: value for name, value in answer.items() if isinstance(value, np.ndarray)}
    header = {name: value for name, value in answer.items() if name not in arrays}
    header["arrays"] = [(name, array.dtype.str, array.shape) for name, array in arrays.items()]
    replies.write(json.dumps(header).encode() + b"\n")
    if header.get("offsets") is None:
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


if __name__ == "__main__":
    main()
