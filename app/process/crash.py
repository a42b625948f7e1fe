"""Reports of crashes: the Python stack of every thread of the window when the process ended by a fault.

While the window is open, a file named after its process lies in the person's folder for logs. `faulthandler` writes
into it when a library written in C fails, and `note` when Python code does. An end without either removes it. The
next start gives what it finds of processes that are gone its last name, so that each is reported once, and keeps a few.
"""

from __future__ import annotations

import faulthandler
import logging
import time
from pathlib import Path
from typing import IO

import platformdirs

from engine.core.errors import OutputError
from engine.storage.atomic import make_folder
from engine.storage.writer import is_gone, is_own, writer

log = logging.getLogger(__name__)

#: Prefixes of the names of reports, while their process runs and afterwards.
OPEN, KEPT = "running-", "crash-"

#: Reports that are kept, and bytes of Python tracebacks in one of them.
MOST_REPORTS, MOST_BYTES = 10, 2**18

_report: IO[bytes] | None = None


def report_folder() -> Path:
    """The folder of crash reports; it may not exist yet."""
    return Path(platformdirs.user_log_dir("lightarc", appauthor=False))


def begin() -> str:
    """Open this process's report. A sentence about a crash before, empty where there was none."""
    global _report
    folder = report_folder()
    try:
        make_folder(folder)
        crashed = _of_the_dead(folder)
        path = folder / f"{OPEN}{writer()}.txt"
        _report = path.open("wb", buffering=0)
    except (OutputError, OSError) as error:
        log.warning("crashes are not recorded: %s", error)
        return ""
    faulthandler.enable(_report)
    if not crashed:
        return ""
    return f"Lightarc crashed the last time; {crashed[-1]} says where, and sending it to its makers helps to mend that."


def note(words: str) -> None:
    """Add a traceback of Python code to the report, as long as there is room in it."""
    if _report is not None and _report.tell() + len(words) < MOST_BYTES:
        _report.write(words.encode(errors="backslashreplace") + b"\n")


def end() -> None:
    """Close the report, and remove it where nothing went wrong."""
    global _report
    if _report is None:
        return
    faulthandler.disable()
    path, is_empty = Path(str(_report.name)), _report.tell() == 0
    _report.close()
    _report = None
    if is_empty:
        path.unlink(missing_ok=True)


def _of_the_dead(folder: Path) -> list[Path]:
    """Reports that processes left which are gone, under their last names, the latest last; only a few stay."""
    found = []
    for path in sorted(folder.glob(f"{OPEN}*.txt"), key=lambda path: path.stat().st_mtime):
        if not (is_own(path) or is_gone(path)):
            continue
        if path.stat().st_size == 0:  # killed, or the machine went off
            path.unlink()
            continue
        when = time.strftime("%Y-%m-%d-%H%M%S", time.localtime(path.stat().st_mtime))
        found.append(path.replace(folder / f"{KEPT}{when}-{path.stem.removeprefix(OPEN)}.txt"))
    for path in sorted(folder.glob(f"{KEPT}*.txt"))[:-MOST_REPORTS]:
        path.unlink()
    return found
