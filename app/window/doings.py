"""The doings of a user, for the report of a crash: steps, jobs, workspaces and lines of the log, as they come."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import PySide6
from PySide6.QtCore import QObject, QUrl, qVersion
from PySide6.QtGui import QDesktopServices
from shiboken6 import isValid

from app.commands.workbench import Workbench
from app.jobs.jobs import Job
from app.process import crash
from engine.core.errors import OutputError
from engine.storage.atomic import make_folder


class Doings(QObject):
    """Tells `app.process.crash` of all that is done in one window, until `close`."""

    def __init__(self, bench: Workbench, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._stack, self._jobs = bench.document.undo_stack, bench.jobs
        self._last: dict[int, str] = {}
        self._handler = _Handler()
        logging.getLogger().addHandler(self._handler)
        self._stack.indexChanged.connect(self._on_stepped)
        self._jobs.changed.connect(self._job_changed)
        crash.state("Libraries", f"PySide6 {PySide6.__version__}, Qt {qVersion()}, numpy {np.__version__}")

    def close(self) -> None:
        """Listen no longer."""
        self._stack.indexChanged.disconnect(self._on_stepped)
        self._jobs.changed.disconnect(self._job_changed)
        logging.getLogger().removeHandler(self._handler)

    def _on_stepped(self, position: int) -> None:
        if not isValid(self._stack):
            return  # it says its end, where a window goes without having been closed
        words = self._stack.undoText() or "the beginning"
        crash.did(f"{'undone to' if self._stack.canRedo() else 'did'} {position}: {words}")

    def _job_changed(self, job: Job) -> None:
        if job.is_asked_for and self._last.get(id(job)) != job.state:
            self._last[id(job)] = job.state
            crash.did(f"{job.title}: {job.state}")
            if job.over:
                del self._last[id(job)]


class _Handler(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.INFO)

    def emit(self, record: logging.LogRecord) -> None:
        crash.did(f"{record.levelname.lower()}: {record.getMessage()}")


def show_reports() -> Path:
    """Open the folder of crash reports in the user's file manager; its path, since some show nothing.

    Raises OutputError where it cannot be made.
    """
    folder = make_folder(crash.report_folder())
    if not QDesktopServices.openUrl(QUrl.fromLocalFile(str(folder))):
        raise OutputError(folder, "cannot be opened in a file manager", "Open it by hand")
    return folder
