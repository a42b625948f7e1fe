"""Notices of a system about a folder: files that were closed after writing, and a wait that ends when one changes.

`watchdog` gives them by the means of each system (inotify on Linux), where it is installed: `pip install
"lightarc[watch]"`. Without it, and in folders on a network, whose changes by other machines no system notices, a wait
lasts as long as it is asked for, and whoever waits looks for himself.
"""

from __future__ import annotations

import importlib.util
import threading
from collections.abc import Collection
from pathlib import Path
from typing import Any

import psutil

#: Beginnings of the kinds of file systems that lie on other machines.
_NETWORK = ("nfs", "cifs", "smb", "9p", "fuse.sshfs", "afp", "webdav", "davfs", "ncpfs", "ceph", "glusterfs")

#: Events of `watchdog` after which a file is complete: closed after writing, and moved here from elsewhere.
_COMPLETE = ("closed", "moved")


class Notices:
    """Notices about one folder; to be closed."""

    def __init__(self, folder: Path) -> None:
        self._changed = threading.Event()
        self._lock = threading.Lock()
        self._closed: set[Path] = set()
        self._observer = None if is_on_network(folder) else self._observe(folder)

    @property
    def come(self) -> bool:
        """True where the system gives notices, False where the folder has to be looked at."""
        return self._observer is not None

    def wait(self, seconds: float) -> Collection[Path]:
        """Wait for at most `seconds`, or until something changes; the files that were closed since the last time."""
        self._changed.wait(seconds)
        self._changed.clear()
        with self._lock:
            closed, self._closed = self._closed, set()
        return closed

    def close(self) -> None:
        """Ask for no more notices."""
        if self._observer is not None:
            self._observer.stop()
            self._observer.join(1.0)
            self._observer = None

    def _observe(self, folder: Path) -> Any:
        """An observer of `watchdog` that runs; None where there is none, or where the system refuses it."""
        if importlib.util.find_spec("watchdog") is None:
            return None
        from watchdog.events import FileSystemEventHandler
        from watchdog.observers import Observer

        notices = self

        class Handler(FileSystemEventHandler):
            def on_any_event(self, event: Any) -> None:
                notices._take(event)

        try:
            observer = Observer()
            observer.schedule(Handler(), str(folder), recursive=False)
            observer.start()
        except (OSError, RuntimeError):  # as where a user has no more watches of inotify
            return None
        return observer

    def _take(self, event: Any) -> None:
        if event.event_type in ("opened", "closed_no_write"):  # as by our own decoders
            return
        if event.event_type in _COMPLETE:
            path = event.dest_path if event.event_type == "moved" else event.src_path
            with self._lock:
                self._closed.add(Path(path.decode() if isinstance(path, bytes) else path))
        self._changed.set()


def is_on_network(folder: Path) -> bool:
    """True for a folder on another machine, as far as the system tells."""
    try:
        place = folder.resolve()
        mounts = [each for each in psutil.disk_partitions(all=True) if place.is_relative_to(each.mountpoint)]
    except (OSError, ValueError):
        return False
    inner = max(mounts, key=lambda each: len(each.mountpoint), default=None)
    return inner is not None and inner.fstype.lower().startswith(_NETWORK)
