"""A process that makes captures of a batch, one after the other, and ends with the process that asks for them.

Protocol, in both directions: one line of JSON. A request names the function that makes a capture, with its arguments;
replies are steps, and at last the record, or the reason why there is none. What libraries print, and where a fault
ended the process, is in the log of the capture. Where this process and its decoders take more memory than their limit,
it says so and ends; on Linux large arrays lie in files first (`engine.storage.spilling`), and what is beyond the limit
all the same fails (`engine.core.budget.limit_memory`). A process that compiles for this one
(`engine.core.kernels`) does not count: that is done once on a machine, and no capture's need.
"""

from __future__ import annotations

import ctypes
import faulthandler
import importlib
import json
import os
import queue
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import psutil

from app.arguments.common import Log
from app.arguments.usage import OUT_OF_MEMORY
from app.process import ending
from engine.core.budget import limit_memory, limit_threads
from engine.core.errors import LightarcError, UsageError, file_failure, shortage
from engine.core.figure_text import percent, size_text
from engine.core.kernels import list_compiling
from engine.core.steps import Step, drain
from engine.storage.spilling import spill_arrays

#: Seconds between two looks at the memory that is taken, and between two steps that are told.
LOOK_S, TELL_S = 1.0, 0.2

#: What is said where memory is short.
NO_MEMORY = "needs more than {} of memory, the limit of a capture. Give --memory-limit, or fewer --workers"


#: The request to the kernel of Linux to end a process with the thread that has started it (linux/prctl.h).
_END_WITH_PARENT = 1


def main() -> None:
    """Answer requests until the pipe that they come through is closed."""
    _end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is for the process that asks
    requests, replies = os.dup(0), os.dup(1)
    with Path(os.devnull).open("rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)  # what libraries print is no reply
    tell = _Teller(replies)
    asked: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(requests, asked), name="requests", daemon=True).start()
    while True:
        request = asked.get()
        with ExitStack() as held:
            held.enter_context(limit_threads(request["threads"]))
            tell(_answer(request, tell))


def _end_with_parent() -> None:
    """Let Linux end this process together with the one that asks, also where that is killed while a kernel runs here.

    Two processes would write the same folder where the batch goes on at once. Elsewhere the closed pipe ends it.
    """
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(_END_WITH_PARENT, signal.SIGKILL)
        if sys.argv[1:] and os.getppid() != int(sys.argv[1]):
            ending.leave(0)  # it has ended before


class _Teller:
    """Writes replies, each whole, from any thread."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor, self._lock, self._sent_s = descriptor, threading.Lock(), 0.0

    def __call__(self, reply: Mapping[str, Any]) -> None:
        line = memoryview(json.dumps(reply).encode() + b"\n")
        with self._lock, suppress(BrokenPipeError):
            while line:
                line = line[os.write(self._descriptor, line) :]

    def step(self, step: Step) -> None:
        """Tell a step, unless one was told just before."""
        now = time.monotonic()
        if now - self._sent_s >= TELL_S:
            self._sent_s = now
            self({"done": step.done, "note": step.note})


def _read(requests: int, asked: queue.SimpleQueue[dict[str, Any]]) -> None:
    """Hand requests on; end the process where nobody is there to ask any more."""
    with os.fdopen(requests, encoding="utf-8") as lines:
        for line in lines:
            asked.put(json.loads(line))
    ending.leave(0)


def _answer(request: Mapping[str, Any], tell: _Teller) -> dict[str, Any]:
    """The reply to a request: `record`, or `failed` with the reason; `fault` where this is a mistake of the program."""
    log = Log(request["log"], ("batch", request["arguments"][0]))
    assert log.file is not None
    os.dup2(log.file.fileno(), 2)
    os.dup2(2, 1)
    faulthandler.enable(2)
    over = threading.Event()
    threading.Thread(target=_watch_memory, args=(request, tell, log, over), daemon=True).start()
    try:
        reply = _make(request, _show(log, tell))
    finally:
        over.set()
    log.write(reply.get("failed") or "done")
    log.file.close()
    return reply


def _make(request: Mapping[str, Any], show: Callable[[Step], Any]) -> dict[str, Any]:
    limit_bytes = request["memory_bytes"]
    module, _, name = request["function"].partition(":")
    try:
        function = getattr(importlib.import_module(module), name)
        with limit_memory(limit_bytes), spill_arrays(limit_bytes):
            return {"record": drain(function(*request["arguments"]), show)}
    except (LightarcError, OSError, MemoryError) as error:
        lack = shortage(error)
        known = error if isinstance(error, LightarcError) else file_failure(error)
        if lack is not None:
            return {"failed": f"It {NO_MEMORY.format(size_text(limit_bytes))}.", "last": True}
        if known is not None:
            return {"failed": str(known) if not isinstance(known, UsageError) else f"{str(known).rstrip('.')}."}
        return _mistake(error)
    except Exception as error:  # whatever a library makes of a file or of too little memory costs one capture
        if shortage(error) is not None:
            return {"failed": f"It {NO_MEMORY.format(size_text(limit_bytes))}.", "last": True}
        return _mistake(error)


def _mistake(error: Exception) -> dict[str, Any]:
    traceback.print_exception(error, file=sys.stderr)
    sys.stderr.flush()
    words = " ".join(str(error).split())[:200]
    return {
        "failed": f"A mistake of the program ended it ({type(error).__name__}: {words}); its log has all.",
        "last": True,
    }


def _show(log: Log, tell: _Teller) -> Callable[[Step], None]:
    """Write each new note of a step into the log, and tell some steps."""
    noted = ""

    def show(step: Step) -> None:
        nonlocal noted
        if step.note != noted:
            noted = step.note
            log.write(f"{percent(step.done, 2)}  {step.note}")
        tell.step(step)

    return show


def _watch_memory(request: Mapping[str, Any], tell: _Teller, log: Log, over: threading.Event) -> None:
    """End the process where it and its decoders take more memory than the limit."""
    own, limit_bytes = psutil.Process(), request["memory_bytes"]
    while not over.wait(LOOK_S):
        taken = 0
        for each in (own, *own.children(recursive=True)):
            if each.pid not in list_compiling():
                with suppress(psutil.Error):
                    taken += _count_bytes(each, each is own)
        if taken > limit_bytes:
            reason = f"It {NO_MEMORY.format(size_text(limit_bytes))}."
            log.write(reason)
            tell({"failed": reason, "last": True})
            ending.leave(OUT_OF_MEMORY)


def _count_bytes(process: psutil.Process, is_own: bool) -> int:
    """Bytes that are of no file; of others than this process those alone that no two share, since a copy of it that is
    about to start a decoder has all of its pages."""
    if not is_own and sys.platform == "linux":
        return int(process.memory_full_info().uss)
    about = process.memory_info()
    return int(about.rss - getattr(about, "shared", 0))


if __name__ == "__main__":
    main()
