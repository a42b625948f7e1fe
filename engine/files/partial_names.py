"""Names of what is being written, which say by whom: the machine, the process there, and when that process started.

By them a leftover of a process that died is told from the work of one that lives, also where the system has given its
number to another process, and where several machines write into one folder.
"""

from __future__ import annotations

import os
import platform
import re
import secrets
import sys
import time
from functools import cache
from pathlib import Path

LONGEST_NAME_BYTES = 255

#: What another machine left is abandoned when nothing in it was written for so long; its processes cannot be asked.
ABANDONED_S = 7 * 24 * 3600.0

_WRITER = r"(?P<host>[A-Za-z0-9_]{1,60})-(?P<process>[0-9]{1,10})-(?P<start>[0-9]{1,20})-[0-9a-f]{8}"
_PARTIAL = re.compile(rf"\..*\.partial-{_WRITER}(\.[^.]{{1,15}})?", re.DOTALL)
_ASIDE = re.compile(rf"\.lightarc-replaced-{_WRITER}")


def partial_name(target: Path) -> str:
    """A free hidden name for what becomes `target`, with its suffix."""
    suffix = target.suffix if len(target.suffix) <= 16 else ""
    ending = f".partial-{_writer()}{suffix}"
    stem = target.name.removesuffix(suffix)
    while len(os.fsencode(stem + ending)) >= LONGEST_NAME_BYTES:
        stem = stem[:-1]
    return f".{stem}{ending}"


def aside_name() -> str:
    """A free hidden name for a folder in which another lies while it is being replaced."""
    return f".lightarc-replaced-{_writer()}"


def is_partial(name: str) -> bool:
    """True for the names that `partial_name` gives."""
    return _PARTIAL.fullmatch(name) is not None


def is_aside(name: str) -> bool:
    """True for the names that `aside_name` gives."""
    return _ASIDE.fullmatch(name) is not None


def is_abandoned(path: Path) -> bool:
    """True for a partial or a folder put aside whose writer is gone, or is this very process."""
    found = _PARTIAL.fullmatch(path.name) or _ASIDE.fullmatch(path.name)
    if found is None:
        return False
    if found["host"] != _host():
        return _rested_s(path) > ABANDONED_S
    return int(found["process"]) == os.getpid() or not _runs(int(found["process"]), int(found["start"]))


def _writer() -> str:
    return f"{_host()}-{os.getpid()}-{_start_of(os.getpid()) or 0}-{secrets.token_hex(4)}"


@cache
def _host() -> str:
    """This machine and, on Linux, the container in which its processes are numbered."""
    name = re.sub(r"[^A-Za-z0-9]+", "_", platform.node())[:40] or "unnamed"
    numbering = Path("/proc/self/ns/pid")
    return f"{name}_{numbering.stat().st_ino:x}" if numbering.exists() else name


def _runs(process: int, start: int) -> bool:
    """True unless `process` is gone or known to have started at another time."""
    import psutil

    return psutil.pid_exists(process) and _start_of(process) in (start, None)


def _start_of(process: int) -> int | None:
    """When a process of this machine started, in the unit of the system; None where that cannot be known."""
    import psutil

    try:
        if sys.platform == "linux":  # in ticks since the boot: what psutil says moves with the clock
            return int(Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()[19])
        return int(1000 * psutil.Process(process).create_time())
    except (OSError, psutil.Error):
        return None


def _rested_s(path: Path) -> float:
    """Seconds since anything in `path` was written; 0 where that cannot be known."""
    try:
        return time.time() - max(each.lstat().st_mtime for each in (path, *path.rglob("*")))
    except OSError:
        return 0.0
