"""The working folder of one run: imported stacks lie there until the program ends.

It is removed at the end; what a crashed run left behind is removed at the next start.
"""

from __future__ import annotations

import logging
import os
import shutil
import tempfile
from pathlib import Path

import platformdirs
import psutil

log = logging.getLogger(__name__)

PREFIX = "session-"


def open_session() -> Path:
    """A new folder below the cache folder, or below the one for temporary files where that cannot be written."""
    for base in _bases():
        try:
            base.mkdir(parents=True, exist_ok=True)
            remove_abandoned(base)
            return Path(tempfile.mkdtemp(prefix=f"{PREFIX}{os.getpid()}-", dir=base))
        except OSError as error:
            log.warning("%s cannot hold working data: %s", base, error)
    return Path(tempfile.mkdtemp(prefix=f"{PREFIX}{os.getpid()}-"))


def close_own_sessions() -> None:
    """Remove the working folders of this process, also those that it still uses: it ends."""
    for base in _bases():
        for folder in base.glob(f"{PREFIX}{os.getpid()}-*"):
            close_session(folder)


def close_session(folder: Path) -> None:
    """Remove the working folder with everything in it."""
    shutil.rmtree(folder, ignore_errors=True)


def remove_abandoned(base: Path) -> None:
    """Remove the working folders in `base` whose process is gone."""
    running = set(psutil.pids())
    for folder in base.glob(f"{PREFIX}*-*"):
        number = folder.name.removeprefix(PREFIX).partition("-")[0]
        if number.isdigit() and int(number) not in running:
            shutil.rmtree(folder, ignore_errors=True)


def _bases() -> tuple[Path, Path]:
    return Path(platformdirs.user_cache_dir("lightarc", appauthor=False)), Path(tempfile.gettempdir())
