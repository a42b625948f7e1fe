"""The writer in the name of a file or folder: its machine, its process there, and when that process started.

By it what a dead process left is told from the work of one that lives, also where the system has given its number to
another process, and where several machines write into one folder.
"""

from __future__ import annotations

import os
import platform
import re
import sys
import time
from functools import cache
from pathlib import Path

#: Age at which what another machine left counts as abandoned; its processes cannot be asked.
ABANDONED_S = 7 * 24 * 3600.0

#: Flag of Linux of a process that is being ended (include/linux/sched.h).
_PF_EXITING = 0x4

#: A writer within a name.
WRITER = r"(?P<host>[A-Za-z0-9_]{1,60})-(?P<process>[0-9]{1,10})-(?P<start>[0-9]{1,20})"
_WRITER = re.compile(rf"(?<![A-Za-z0-9_]){WRITER}(?![0-9])")


def writer() -> str:
    """This process, for the name of what it writes."""
    return f"{_host()}-{os.getpid()}-{start_of(os.getpid()) or 0}"


def is_own(path: Path) -> bool:
    """True for a path whose name says that this process writes it."""
    found = _match_writer(path)
    return found is not None and found["host"] == _host() and int(found["process"]) == os.getpid()


def is_gone(path: Path) -> bool:
    """True if the process that the name of `path` says is gone; of others, if nothing wrote there for a week."""
    found = _match_writer(path)
    if found is None or found["host"] != _host():
        return _count_rested_s(path) > ABANDONED_S
    return not _runs(int(found["process"]), int(found["start"]))


def _match_writer(path: Path) -> re.Match[str] | None:
    """The last writer in the name of `path`: what stands before it may look like one."""
    return max(_WRITER.finditer(path.name), key=re.Match.start, default=None)


@cache
def _host() -> str:
    """This machine and, on Linux, the container in which its processes are numbered."""
    name = re.sub(r"[^A-Za-z0-9]+", "_", platform.node())[:40] or "unnamed"
    numbering = Path("/proc/self/ns/pid")
    return f"{name}_{numbering.stat().st_ino:x}" if numbering.exists() else name


def _runs(process: int, start: int) -> bool:
    """True unless `process` is gone, is ending, or is known to have started at another time."""
    import psutil

    return psutil.pid_exists(process) and not _is_ending(process) and start_of(process) in (start, None)


def _is_ending(process: int) -> bool:
    """True for a process that runs no line of its program any more: it gives back its memory, or nobody asked yet how
    it ended, which a parent may never do."""
    said = _read_stat(process) if sys.platform == "linux" else []
    return bool(said) and (said[0] in b"ZX" or bool(int(said[6]) & _PF_EXITING))


def start_of(process: int) -> int | None:
    """The start of a process of this machine, in the unit of the system; None where that cannot be known."""
    import psutil

    if sys.platform == "linux":  # in ticks since the boot: what psutil says moves with the clock
        said = _read_stat(process)
        return int(said[19]) if said else None
    try:
        return int(1000 * psutil.Process(process).create_time())
    except (OSError, psutil.Error):
        return None


def _read_stat(process: int) -> list[bytes]:
    """The fields of Linux's /proc/PROCESS/stat from the third on, its state; empty where they cannot be read."""
    try:
        return Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()
    except OSError:
        return []


def _count_rested_s(path: Path) -> float:
    """Seconds since anything in `path` was written; 0 where that cannot be known."""
    try:
        return time.time() - max(each.lstat().st_mtime for each in (path, *path.rglob("*")))
    except OSError:
        return 0.0
