"""Decoder processes that fail: one request of a work, in one way.

The failures come from outside of the process, as they do in life: the system refuses to start it, ends it, gives it no
memory or time, fails the read of the file that it was handed, or its answer is cut short or is no answer. No decoder
knows of the test.
"""

from __future__ import annotations

import contextlib
import errno
import os
import random
import signal
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal, get_args
from unittest import mock

from engine.storage import untrusted

Way = Literal["not started", "dead before", "killed", "crashed", "halted", "no memory", "unreadable", "cut", "nonsense"]
WAYS: tuple[Way, ...] = get_args(Way)

#: Ways that a decoder goes in, or may go in, through the fault of its file.
BLAMES = ("crashed", "cut", "nonsense")

#: Answers that are none.
NONSENSE = (
    b"\n",
    b"[]\n",
    b"{}\n",
    b"5\n",
    b'{"arrays": 5}\n',
    b'{"arrays": []}\n',
    b'{"arrays": [["radiance", "<f4", [1000000, 1000000, 4]]], "offsets": {"radiance": 0}}\n',
    b'{"arrays": [["radiance", "<f4", [-1]]], "offsets": {"radiance": -5}}\n',
    b'{"arrays": [["radiance", "O", [1]]], "offsets": {"radiance": 0}}\n',
    b'{"arrays": [], "protection": 5}\n',
    b"\xff\xfe\0\n",
    b"[" * 100_000 + b"\n",
)

CODES = (errno.EAGAIN, errno.ENOMEM, errno.EMFILE)


class FailingDecoder:
    """Counts what is asked of decoder processes, and lets the request numbered `at` (from 0) fail in one `way`."""

    def __init__(self, at: int = -1, way: Way = "killed", seed: int = 0) -> None:
        self.at, self.way, self.rng = at, way, random.Random(seed)
        self.operations = list[str]()
        self._request: dict[str, Any] | None = None
        self._patches = contextlib.ExitStack()

    def __enter__(self) -> FailingDecoder:
        answer, ask = untrusted._answer, untrusted._Child.ask

        def counted(request: dict[str, Any], *rest: Any) -> dict[str, Any]:
            self.operations.append(self.way)
            if len(self.operations) != self.at + 1:
                return answer(request, *rest)
            self._request = request
            with self._refused_start() if self.way == "not started" else contextlib.nullcontext():
                return answer(request, *rest)

        def asked(child: Any, request: dict[str, Any], contents: list[bytes], files: list[int], results: Any) -> Any:
            if request is not self._request:
                return ask(child, request, contents, files, results)
            return self._ask(child, ask, dict(request), contents, files, results)

        self._patches.enter_context(mock.patch.object(untrusted, "_answer", counted))
        self._patches.enter_context(mock.patch.object(untrusted._Child, "ask", asked))
        return self

    def __exit__(self, *_: object) -> None:
        self._patches.close()

    def _refused_start(self) -> contextlib.AbstractContextManager[Any]:
        code = self.rng.choice(CODES)

        def refuse(*_arguments: Any, **_options: Any) -> None:
            raise OSError(code, os.strerror(code))

        untrusted.stop_children()
        return mock.patch.object(untrusted, "subprocess", SimpleNamespace(Popen=refuse, PIPE=-1, DEVNULL=-3))

    def _ask(self, child: Any, ask: Any, request: dict[str, Any], contents: Any, files: list[int], results: Any) -> Any:
        if self.way == "dead before":
            self._request = None  # the next process lives
            child.process.kill()
            child.process.wait()
        elif self.way == "no memory":
            pages = int(Path(f"/proc/{child.process.pid}/statm").read_text().split()[0])
            request["memory_bytes"] = pages * os.sysconf("SC_PAGE_SIZE") + self.rng.randrange(1 << 22)
        elif self.way == "unreadable" and files:
            broken = [os.open(f"/proc/self/fd/{each}", os.O_WRONLY) for each in files]  # which no read takes
            try:
                return ask(child, request, contents, broken, results)
            finally:
                for each in broken:
                    os.close(each)
        elif self.way != "not started":
            if self.way == "halted":
                request["timeout_s"] = 0.02
            child.process.stdout = _Replies(child.process, self.way, self.rng)
        try:
            return ask(child, request, contents, files, results)
        finally:
            if self.way == "nonsense":  # its own answer still waits, and would be that to the next request
                child.kill()


class _Replies:
    """What comes from a process, with a failure after the line which says that the request has arrived."""

    def __init__(self, process: Any, way: Way, rng: random.Random) -> None:
        self._process, self._stream, self._way, self._rng = process, process.stdout, way, rng
        self._arrived = False

    def readline(self) -> bytes:
        if not self._arrived:
            self._arrived = True
            line: bytes = self._stream.readline()
            if self._way == "halted":
                os.kill(self._process.pid, signal.SIGSTOP)
            return line
        if self._way == "halted":
            self._process.wait()  # for the limit of its time
            return b""
        if self._way in ("killed", "crashed", "unreadable"):
            crashes = (signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE)
            os.kill(self._process.pid, self._rng.choice(crashes) if self._way == "crashed" else signal.SIGKILL)
            self._process.wait()
            return b""
        if self._way == "nonsense":
            return self._rng.choice(NONSENSE)
        line = self._stream.readline()
        return line[: self._rng.randrange(len(line))] if self._way == "cut" else line

    def readinto(self, view: Any) -> int:
        return int(self._stream.readinto(view))

    def close(self) -> None:
        self._stream.close()
