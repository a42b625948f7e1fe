"""Reports of failures to the user: one dialog, one line in the log, and the program goes on.

Errors that a user can mend are shown in their own words. Anything else is a fault of the program: its traceback
goes to the log, and the dialog opens once per place in the code, however often a paint event runs into it.
"""

from __future__ import annotations

import logging
import sys
import threading
import traceback
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QLabel, QMessageBox, QWidget

from app.process import crash
from app.widgets.import_controls import name_controls
from engine.core.errors import VERBS, FileError, LightarcError, MissingCapability, UsageError, file_failure, shortage
from engine.core.escape import escape_controls

log = logging.getLogger(__name__)


class FilesExcluded(LightarcError):
    """Several files of those that were given together were not opened; `errors` say why, one for each."""

    def __init__(self, errors: Sequence[FileError]) -> None:
        super().__init__("; ".join(map(str, errors)))
        self.errors = tuple(errors)


class Failures(QObject):
    """Shows failures over `window`; `report` may be called from any thread."""

    arrived = Signal(str, object)

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.window = window
        self.open_dialogs: dict[str, QMessageBox] = {}
        self._faults_shown: set[str] = set()
        self.arrived.connect(self._show, Qt.ConnectionType.QueuedConnection)

    def report(self, title: str, error: BaseException) -> None:
        """Log `error` now and show it as soon as the window's thread is free."""
        title = escape_controls(title)
        if isinstance(error, LightarcError):
            log.warning("%s: %s", title, error)
        else:
            trace = "".join(traceback.format_exception(error))
            log.error("%s\n%s", title, trace)
            crash.note(trace)
        self.arrived.emit(title, error)

    def install(self) -> None:
        """Send exceptions that nobody caught, on any thread, to `report` instead of ending the program."""
        sys.excepthook = self._uncaught
        threading.excepthook = lambda hook: self._uncaught(hook.exc_type, hook.exc_value, hook.exc_traceback)
        sys.unraisablehook = self._unraisable

    def _uncaught(self, kind: type[BaseException], error: BaseException | None, _trace: TracebackType | None) -> None:
        if issubclass(kind, (KeyboardInterrupt, SystemExit)):
            sys.__excepthook__(kind, error or kind(), _trace)
            return
        self.report("Something went wrong", error or kind())

    def _unraisable(self, hook: sys.UnraisableHookArgs) -> None:
        self._uncaught(hook.exc_type, hook.exc_value, hook.exc_traceback)

    def _show(self, title: str, error: BaseException) -> None:
        message, detail = explain(error)
        key = message if isinstance(error, LightarcError) else _place(error)
        if key in self.open_dialogs or key in self._faults_shown:
            return
        if not isinstance(error, LightarcError):
            self._faults_shown.add(key)
        box = QMessageBox(QMessageBox.Icon.Warning, "Lightarc", "", QMessageBox.StandardButton.Close, self.window)
        box.setText(title)
        box.button(QMessageBox.StandardButton.Close).setIcon(QIcon())  # the style's own is black, also on dark
        box.setInformativeText(name_controls(message))
        for label in box.findChildren(QLabel):
            label.setTextFormat(Qt.TextFormat.PlainText)  # a file may be called <img src=…>
        if detail:
            box.setDetailedText(detail)
            box.setDefaultButton(QMessageBox.StandardButton.Close)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.finished.connect(lambda: self.open_dialogs.pop(key, None))
        self.open_dialogs[key] = box
        box.open()


def explain(error: BaseException) -> tuple[str, str]:
    """The message for the user, and the details that only a developer reads."""
    if shortage(error) is None:
        error = file_failure(error) or error
    if isinstance(error, FileError):
        return f"{sentence(error)}\n{escape_controls(error.remedy)}.\n\n{escape_controls(error.path)}", ""
    if isinstance(error, FilesExcluded):
        return "\n\n".join(f"{sentence(each)}\n{escape_controls(each.remedy)}." for each in error.errors), ""
    if isinstance(error, MissingCapability):
        return f"{error.capability}.\n{error.remedy}.", ""
    if isinstance(error, UsageError):
        words = str(error).rstrip(".")
        return f"{words[:1].upper()}{words[1:]}.", ""
    lack = shortage(error)
    if lack is not None:
        return f"{lack.problem}.\nYour work is still here. {lack.remedy}.", ""
    trace = "".join(traceback.format_exception(error))
    return "This is a fault in Lightarc, not in your files. Your work is still here; the log has the details.", trace


def sentence(error: FileError) -> str:
    """The problem as a sentence: of the file by its name, where the problem says what the file is or does."""
    words = error.problem
    if words.split(" ", 1)[0] in VERBS:
        return escape_controls(f"{Path(error.path).name or error.path} {words}.")
    return escape_controls(f"{words[:1].upper()}{words[1:]}.")


def _place(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    where = f"{frames[-1].filename}:{frames[-1].lineno}" if frames else ""
    return f"{type(error).__name__} {where}"
