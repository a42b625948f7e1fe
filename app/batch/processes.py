"""A process that makes captures, as the one that asks it sees it: started when needed, limited, and replaced."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.batch.captures import Capture
from engine.core.budget import VARIABLES, free_bytes
from engine.core.errors import OutOfMemory
from engine.core.figure_text import time_text

#: Folder of the logs, one for each capture.
LOGS = "logs"

#: Captures that a process makes before it is replaced, whatever libraries leave behind in it.
PER_PROCESS = 100

#: Processes that a capture may end before it has failed: one that was ended from outside is tried again.
TRIES = 3

#: The least memory of a capture where nobody limits it, in bytes.
MIN_BYTES = 1 << 30

#: Seconds in which a process that is to end removes what is half-written.
TIDYING_S = 3.0

#: Receives events of a capture: steps with how much is `done`.
Tell = Callable[[dict[str, Any]], None]

#: Makes a capture; its end, which holds the `record`, the sentence why it `failed`, or an `error` that ends the batch.
CarryOut = Callable[[Capture, Tell], dict[str, Any]]


@dataclass(frozen=True)
class Order:
    """The way in which captures are made, as values that any process understands.

    Attributes
    ----------
    function : 'module:name' of the function that makes one, of the text of the capture and of output, template and
        targets as JSON values.
    output, template : folder of results, and the project in it whose choices hold, if there is one.
    targets : of exports; None for those of the template.
    time_limit_s, memory_limit_bytes : of one capture; None for an even share of the memory that is free.
    """

    function: str
    output: str
    template: str | None
    targets: tuple[str, ...] | None
    time_limit_s: float
    memory_limit_bytes: int | None


class MakingProcess:
    """A process for one capture after the other, of which `share` run beside each other on this machine."""

    def __init__(self, order: Order, share: int) -> None:
        self._order, self._made, self._stopped = order, 0, False
        self._process: subprocess.Popen[bytes] | None = None
        self._memory_bytes = order.memory_limit_bytes or max(MIN_BYTES, free_bytes() // share)

    def carry_out(self, capture: Capture, tell: Tell) -> dict[str, Any]:
        """Make a capture (`CarryOut`)."""
        ending = ""
        for _ in range(TRIES):
            if self._stopped:
                return {"failed": "It was stopped."}
            try:
                process = self._start()
            except OSError as error:
                return {"failed": str(OutOfMemory(f"No further process can be started ({error.strerror})"))}
            reply, is_late = self._ask_in_time(process, capture, tell)
            if reply is None or reply.pop("last", False) or "failed" in reply or self._made >= PER_PROCESS:
                self.end()
            if reply is not None:
                return reply
            if is_late:
                limit = time_text(self._order.time_limit_s)
                return {"failed": f"It took longer than {limit}, the limit of a capture. Give --time-limit."}
            ending = _describe_end(process)
        return {"failed": f"Its process ended {TRIES} times ({ending}); its log says where."}

    def close(self) -> None:
        """Let the process end soon, whatever it is doing; nothing more can be asked."""
        self._stopped = True
        if self._process is not None:
            _hang_up(self._process)

    def end(self) -> None:
        """Let the process end, which it does when nobody can ask it any more, and wait for that."""
        process, self._process = self._process, None
        if process is None:
            return
        _hang_up(process)
        try:
            process.wait(TIDYING_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _ask_in_time(
        self, process: subprocess.Popen[bytes], capture: Capture, tell: Tell
    ) -> tuple[dict[str, Any] | None, bool]:
        """As `_ask`, by a process that is killed when it takes too long, and whether it was."""
        late = threading.Event()

        def end_late() -> None:
            late.set()
            process.kill()

        timer = threading.Timer(self._order.time_limit_s, end_late)
        timer.daemon = True
        timer.start()
        try:
            return self._ask(process, capture, tell), late.is_set()
        finally:
            timer.cancel()

    def _ask(self, process: subprocess.Popen[bytes], capture: Capture, tell: Tell) -> dict[str, Any] | None:
        """The last reply to a request; None where the process ended before that."""
        order = self._order
        request = {
            "function": order.function,
            "arguments": [
                capture.as_text(),
                {"output": order.output, "template": order.template, "targets": order.targets},
            ],
            "log": os.fspath(Path(order.output) / LOGS / f"{capture.name}.log"),
            "memory_bytes": self._memory_bytes,
            "threads": 1,
        }
        assert process.stdin is not None
        assert process.stdout is not None
        self._made += 1
        with contextlib.suppress(OSError, ValueError):
            process.stdin.write(json.dumps(request).encode() + b"\n")
            process.stdin.flush()
            for line in process.stdout:
                reply = json.loads(line)
                if "done" not in reply:
                    return dict(reply)
                tell(reply)
        return None

    def _start(self) -> subprocess.Popen[bytes]:
        """The process, a new one where there is none that lives."""
        if self._process is None or self._process.poll() is not None:
            self.end()
            threads = dict.fromkeys(VARIABLES, "1")
            path = os.pathsep.join(filter(None, sys.path))
            self._process = subprocess.Popen(
                [sys.executable, "-m", "app.batch.worker", str(os.getpid())],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={**os.environ, **threads, "PYTHONPATH": path, "PYTHONSAFEPATH": "1"},
                start_new_session=sys.platform != "win32",
            )
            self._made = 0
            if self._stopped:
                self._process.kill()
        return self._process


def _hang_up(process: subprocess.Popen[bytes]) -> None:
    assert process.stdin is not None
    with contextlib.suppress(OSError):
        process.stdin.close()


def _describe_end(process: subprocess.Popen[bytes]) -> str:
    """The signal or the code with which a process ended."""
    code = process.wait()
    if code < 0:
        with contextlib.suppress(ValueError):
            return f"signal {signal.Signals(-code).name}"
    return f"exit code {code}"
