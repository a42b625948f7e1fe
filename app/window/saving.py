"""The window waits for what is being saved before it leaves a project, and says so."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, Qt, QTimer
from PySide6.QtWidgets import QDialog, QHBoxLayout, QVBoxLayout, QWidget

from app.jobs.jobs import Job, Jobs
from app.widgets.panels import button, text
from app.widgets.status_bar import ProgressLine, describe
from app.widgets.theme import PADDING, STEP
from app.window.projects import Projects

#: Width of the dialog, in pixels.
WIDTH = 420


class Saving(QObject):
    """Does what ends a project once nothing is being saved any more; `dialog` is on screen meanwhile."""

    def __init__(self, window: QWidget, jobs: Jobs, projects: Projects) -> None:
        super().__init__(window)
        self.window, self.jobs, self.projects = window, jobs, projects
        self.dialog: SavingDialog | None = None
        self._then: Callable[[], object] | None = None
        jobs.changed.connect(lambda _job: self._look_soon())
        jobs.progressed.connect(lambda job: self._show() if job.lane == "save" else None)
        jobs.failed.connect(self._failed)
        projects.changed.connect(self._look_soon)
        projects.broken.connect(lambda _error: self.stay())

    def then(self, without: str, action: Callable[[], object]) -> None:
        """Call `action` now, or when all is saved; the button `without` does not wait for that.

        Where saving fails, or the user cancels the dialog, the window stays as it is.
        """
        if not self.projects.is_saving:
            action()
            return
        self.stay()
        self._then, self.dialog = action, SavingDialog(self.window, without)
        self.dialog.without.clicked.connect(self.projects.give_up_saving)
        self.dialog.rejected.connect(self.stay)
        self.dialog.open()
        self._show()
        self.projects.hurry()

    def stay(self) -> None:
        """Do not leave the project; what is being saved goes on."""
        dialog, self.dialog, self._then = self.dialog, None, None
        if dialog is not None:
            self.projects.hurry(False)
            dialog.close()

    def _failed(self, job: Job, _error: object) -> None:
        if job.lane == "save":
            self.stay()

    def _look_soon(self) -> None:
        """What follows a job that has ended is submitted after its end is told."""
        if self._then is not None:
            QTimer.singleShot(0, self, self._look)

    def _look(self) -> None:
        if self._then is None:
            return
        if self.projects.is_saving:
            self._show()
            return
        action, dialog, self._then, self.dialog = self._then, self.dialog, None, None
        if dialog is not None:
            dialog.close()
        action()

    def _show(self) -> None:
        if self.dialog is not None:
            self.dialog.show_job(next((job for job in self.jobs.active if job.lane == "save"), None))


class SavingDialog(QDialog):
    """What is being saved, how far that is, and two buttons: `without` waiting, and cancel."""

    def __init__(self, window: QWidget, without: str) -> None:
        super().__init__(window)
        self.setWindowTitle("Saving…")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setFixedWidth(WIDTH)
        self.words = text("Saving…", wrap=True)
        self.bar = ProgressLine()
        self.bar.setFixedWidth(WIDTH - 2 * PADDING)
        self.without = button(without)
        self.without.setAutoDefault(False)
        cancel = button("Cancel", "primary")
        cancel.clicked.connect(self.reject)
        cancel.setDefault(True)
        row = QHBoxLayout()
        row.setSpacing(STEP)
        row.addStretch(1)
        row.addWidget(self.without)
        row.addWidget(cancel)
        column = QVBoxLayout(self)
        column.setContentsMargins(PADDING, PADDING, PADDING, PADDING)
        column.setSpacing(2 * STEP)
        column.addWidget(self.words)
        column.addWidget(self.bar)
        column.addLayout(row)

    def show_job(self, job: Job | None) -> None:
        """Show how far `job` is; None between two jobs."""
        if job is not None:
            self.words.setText(describe(job))
            self.bar.show_done(job.step.done)
            self.without.setEnabled(not job.stopping)
