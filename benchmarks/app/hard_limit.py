"""A limit of memory that the system itself holds for a command and all its processes (Linux).

It is a control group, of version 1 or 2, which only a user may make whom the system lets. Pages of files, also of those
that are mapped, are taken back when there are more than the limit; where other pages are more, a process is ended. A
command that ends well has therefore needed no more at any moment, whatever its counters say.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from engine.core.errors import MissingCapability

#: Where control groups lie: of version 1 those of memory, of version 2 all.
_FIRST, _SECOND = Path("/sys/fs/cgroup/memory"), Path("/sys/fs/cgroup")

#: Seconds in which the processes of a group that are killed have to end.
ENDING_S = 10.0


@contextmanager
def hold_memory(limit_bytes: int) -> Iterator[tuple[list[str], Callable[[], int]]]:
    """Words that run the command after them within `limit_bytes`, and a function that tells how many processes had to
    be ended for it. MissingCapability where the system has no such limit for this user."""
    is_first = (_FIRST / "memory.limit_in_bytes").is_file()
    group = (_FIRST if is_first else _SECOND) / f"lightarc-{os.getpid()}"
    limits = {"memory.limit_in_bytes": limit_bytes} if is_first else {"memory.max": limit_bytes, "memory.swap.max": 0}
    try:
        group.mkdir()
    except OSError as error:
        raise _explain(error) from None
    try:
        for name, value in limits.items():
            (group / name).write_text(str(value))
        events = group / ("memory.oom_control" if is_first else "memory.events")
        events.read_text()
    except OSError as error:
        group.rmdir()
        raise _explain(error) from None

    def count_ended() -> int:
        lines = (line.split() for line in events.read_text().splitlines())
        return sum(int(value) for name, value in lines if name == "oom_kill")

    try:
        yield ["sh", "-c", 'echo $$ > "$0" && exec "$@"', str(group / "cgroup.procs")], count_ended
    finally:
        _end(group)


def _end(group: Path) -> None:
    """Remove a group, and end what is still in it: decoders outlive a command that was ended by a moment."""
    until_s = time.monotonic() + ENDING_S
    while time.monotonic() < until_s:
        for process in (group / "cgroup.procs").read_text().split():
            with suppress(ProcessLookupError):
                os.kill(int(process), signal.SIGKILL)
        with suppress(OSError):  # processes that are ending count until they have
            group.rmdir()
            return
        time.sleep(0.05)
    group.rmdir()


def _explain(error: OSError) -> MissingCapability:
    problem = f"The system holds no limit of memory for a command of this user: {error.strerror}"
    return MissingCapability(problem, "Run it on Linux as a user who may make control groups, or without --hard-limit")
