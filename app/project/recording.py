"""The document is on disk all the time: each change reaches the project file within a fraction of a second.

The thread of the window only hands over references to frozen values; a thread of its own writes what is new in them,
since hashing and writing a large material takes longer than a frame. Of several changes that wait, the last is written.
"""

from __future__ import annotations

import logging
import threading
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from app.document.document import Project
from app.document.open_document import Document
from app.project.project_file import History, Writer
from engine.core.errors import FileError

log = logging.getLogger(__name__)

#: Milliseconds after a change until it is handed over; a drag changes the document many times in between.
DELAY_MS = 150

#: Seconds until what could not be written is tried again, and between two looks after the file.
AGAIN_S = 3.0

#: Seconds that closing waits for what is being written, a large material for example. A failure ends the wait at once.
CLOSING_S = 60.0


class Recording(QObject):
    """Records one document in one project file, from its making until `close`.

    Signals
    -------
    written : all changes so far are on disk.
    failed : the cause in words, without the file, and all that is known, at the first attempt that fails; the changes
        are kept in memory and tried again.
    restored : the file had been removed, and was written again.
    """

    written = Signal()
    failed = Signal(str, str)
    restored = Signal()

    def __init__(self, document: Document, path: Path, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.path = path
        self._document = document
        self._wake = threading.Condition()
        self._next: History | None = None
        self._is_idle = True
        self._ends = False
        self._failures = 0
        self._is_failing = False
        self._delay = QTimer(self)
        self._delay.setSingleShot(True)
        self._delay.setInterval(DELAY_MS)
        self._delay.timeout.connect(self.hand_over)
        document.changed.connect(self._on_changed)
        document.seen.connect(self._on_changed)
        document.undo_stack.indexChanged.connect(self._on_changed)
        self._thread = threading.Thread(target=self._write, name="project file", daemon=True)
        self._thread.start()
        self._on_changed()

    def _on_changed(self, *_: object) -> None:
        if not self._delay.isActive():
            self._delay.start()

    def hand_over(self) -> None:
        """Hand the document as it is now over to be written."""
        self._delay.stop()
        document = self._document
        history = History(document.project, document.steps, document.undo_stack.index())
        with self._wake:
            self._next, self._is_idle = history, False
            self._wake.notify_all()

    @property
    def is_idle(self) -> bool:
        """True if everything that was handed over is on disk, and nothing waits to be."""
        return self._is_idle and not self._delay.isActive()

    @property
    def is_failing(self) -> bool:
        """True from the first attempt that fails until one succeeds."""
        return self._is_failing

    def has_written(self, seconds: float) -> bool:
        """Wait, on any thread, until all that was handed over is on disk; False where that takes longer, or fails."""
        with self._wake:
            self._wake.wait_for(lambda: self._is_idle or self._is_failing, seconds)
            return self._is_idle

    def wait(self, seconds: float) -> bool:
        """Hand over and wait until everything is on disk; False as soon as that fails, or where it takes longer."""
        before = self._failures
        self.hand_over()
        with self._wake:
            self._wake.wait_for(lambda: self._is_idle or self._failures > before, seconds)
            return self._is_idle

    def close(self, seconds: float = CLOSING_S) -> bool:
        """Write what is missing and let go of the file. False where it could not be written."""
        self._document.changed.disconnect(self._on_changed)
        self._document.seen.disconnect(self._on_changed)
        self._document.undo_stack.indexChanged.disconnect(self._on_changed)
        done = self.wait(seconds)
        with self._wake:
            self._ends = True
            self._wake.notify_all()
        self._thread.join(seconds if done else 0.5)
        return done

    def _write(self) -> None:
        """The thread: write the newest history, again where that fails or the file was removed, until the end."""
        writer, reported, last = Writer(self.path), False, None
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._next is not None or self._ends, AGAIN_S)
                history, self._next = self._next, None
                if history is None and self._ends:
                    break
            is_restored = history is None and not writer.is_there
            history = last if is_restored else history
            if history is None:
                continue
            self._is_idle = False
            try:
                writer.write(history)
            except Exception as error:  # the border of the thread: what a user does shall go on
                if not reported:
                    is_expected = isinstance(error, FileError)
                    log.warning("%s", error, exc_info=None if is_expected else error)
                    cause = error.problem if isinstance(error, FileError) else f"a fault of the program ({error})"
                    self.failed.emit(cause, str(error))
                reported = True
                with self._wake:
                    self._failures += 1
                    self._is_failing = True
                    self._next, self._is_idle = self._next or history, False
                    self._wake.notify_all()
                    if self._ends:
                        break
                    self._wake.wait(AGAIN_S)
                continue
            reported, last, self._is_failing = False, history, False
            with self._wake:
                if self._next is None:
                    self._is_idle = True
                    self._wake.notify_all()
            self.written.emit()
            if is_restored:
                self.restored.emit()
        writer.close()


def is_worth_keeping(project: Project) -> bool:
    """True if a user has brought or made something: photographs, a material, a model, a light, BRDFs, notes."""
    brought = (project.sources, project.stack, project.mesh, project.environment, project.material.measured)
    worked = project.has_map or bool(project.comparison.entries or project.factoring.runs or project.notes)
    return worked or any(each is not None for each in brought)
