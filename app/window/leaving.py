"""The window asks and waits before it leaves a project in which something is saved, exported or baked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

from PySide6.QtCore import QObject, Qt, QTimer
from PySide6.QtWidgets import QDialog, QHBoxLayout, QLayout, QVBoxLayout, QWidget

from app.jobs.jobs import Job, Jobs
from app.widgets.panels import button, text
from app.widgets.status_bar import ProgressLine, describe_whole
from app.widgets.theme import PADDING, STEP
from app.window.projects import Projects

#: What leaves a project: the end of the program, or another project.
Verb = Literal["Quit", "Leave"]

#: What happens by itself when the work has ended.
AFTERWARDS = {"Quit": "Lightarc quits when this has ended:", "Leave": "This project closes when this has ended:"}

#: Width of the dialog, in pixels, and the jobs that it lists.
WIDTH = 420
MAX_LISTED = 5

#: Milliseconds without an answer after work was stopped.
RESTS_MS = 1000


class Leaving(QObject):
    """Leaves a project once nothing holds it any more; `dialog` is on screen meanwhile.

    A project is held while anything is saved, and by every job whose result stopping it would lose (`Job.on_stop`).
    """

    def __init__(self, window: QWidget, jobs: Jobs, projects: Projects) -> None:
        super().__init__(window)
        self.window, self.jobs, self.projects = window, jobs, projects
        self.dialog: LeavingDialog | None = None
        self._then: Callable[[], object] | None = None
        self._hurries = False
        jobs.changed.connect(lambda _job: self._look_soon())
        jobs.progressed.connect(lambda job: self._show() if job.lane == "save" or job.on_stop else None)
        jobs.failed.connect(self._on_failed)
        projects.changed.connect(self._look_soon)
        projects.broken.connect(lambda _error: self.stay())

    @property
    def is_held(self) -> bool:
        """True if leaving the project now would lose something."""
        return self.projects.is_saving or bool(self._to_stop())

    def then(self, verb: Verb, action: Callable[[], object]) -> None:
        """Call `action` now, or when nothing holds the project any more; a button of the dialog does not wait for that.

        Where a job that holds it fails, or the user cancels the dialog, the window stays as it is.
        """
        if not self.is_held:
            action()
            return
        self.stay()
        self._then, self.dialog = action, LeavingDialog(self.window, verb)
        self.dialog.go.clicked.connect(self._go)
        self.dialog.rejected.connect(self.stay)
        self._show()
        self.dialog.open()  # in the middle of the window, because it has its size by now
        self._look()

    def stay(self) -> None:
        """Do not leave the project; what holds it goes on."""
        dialog, self.dialog, self._then = self.dialog, None, None
        if self._hurries:
            self._hurries = False
            self.projects.hurry(False)
        if dialog is not None:
            dialog.close()

    def stop_others(self) -> None:
        """Stop what does not save, without a question: the system ends the program, and what is saved comes first."""
        for job in self.jobs.active:
            if job.lane != "save":
                self.jobs.cancel(job)

    def _to_stop(self) -> list[Job]:
        return [job for job in self.jobs.active if job.on_stop and not job.stopping]

    def _holding(self) -> list[Job]:
        return [*self._to_stop(), *(job for job in self.jobs.active if job.lane == "save")]

    def _go(self) -> None:
        """Stop what the dialog lists; saves are left alone until they are all that is left, and asked about anew."""
        to_stop = self._to_stop()
        for job in to_stop:
            self.jobs.cancel(job)
        if not to_stop:
            self.projects.give_up_saving()
        elif self.dialog is not None:
            self.dialog.rest()

    def _on_failed(self, job: Job, _error: object) -> None:
        if job.lane == "save" or job.on_stop:
            self.stay()

    def _look_soon(self) -> None:
        """What follows a job that has ended is submitted after its end is told."""
        if self._then is not None:
            QTimer.singleShot(0, self, self._look)

    def _look(self) -> None:
        if self._then is None:
            return
        if not self._hurries and not self._to_stop():
            self._hurries = True
            self.projects.hurry()
        if self.is_held:
            self._show()
            return
        action, dialog, self._then, self.dialog = self._then, self.dialog, None, None
        self._hurries = False
        if dialog is not None:
            dialog.close()
        action()

    def _show(self) -> None:
        if self.dialog is not None:
            self.dialog.show_jobs(self._holding(), len(self._to_stop()))


class LeavingDialog(QDialog):
    """The jobs that hold a project, how far each is and what becomes of it, and two buttons: `go` and cancel."""

    def __init__(self, window: QWidget, verb: Verb) -> None:
        super().__init__(window)
        self.verb, self._rests = verb, False
        self.setWindowTitle("Still running")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.rows: dict[Job | None, _Row] = {}
        self.go = button(f"{verb} without saving")
        self.go.setAutoDefault(False)
        cancel = button("Cancel", "primary")
        cancel.clicked.connect(self.reject)
        cancel.setDefault(True)
        buttons = QHBoxLayout()
        buttons.setSpacing(STEP)
        buttons.addStretch(1)
        buttons.addWidget(self.go)
        buttons.addWidget(cancel)
        self.list = QVBoxLayout()
        self.list.setSpacing(3 * STEP)
        self.more = text("", "secondary")
        column = QVBoxLayout(self)
        column.setContentsMargins(PADDING, PADDING, PADDING, PADDING)
        column.setSpacing(2 * STEP)
        column.setSizeConstraint(QLayout.SizeConstraint.SetFixedSize)
        column.addWidget(text(AFTERWARDS[verb]))
        column.addLayout(self.list)
        column.addWidget(self.more)
        column.addLayout(buttons)

    def rest(self) -> None:
        """Take no second click for a moment: it would answer another question than the user has read."""
        self._rests = True
        self.go.setEnabled(False)
        QTimer.singleShot(RESTS_MS, self, self._end_rest)

    def _end_rest(self) -> None:
        self._rests = False
        self.go.setEnabled(True)

    def show_jobs(self, jobs: Sequence[Job], to_stop: int) -> None:
        """Show `jobs`, of which `to_stop` end without a result where the user goes on; none between two saves."""
        if jobs or not self.rows:
            self._list(jobs[:MAX_LISTED] or [None])
        self.more.setText(f"and {len(jobs) - MAX_LISTED} more")
        self.more.setVisible(len(jobs) > MAX_LISTED)
        for job, row in self.rows.items():
            if job is not None and not job.over:
                row.show_job(job)
        if to_stop:
            self.go.setText(f"{self.verb} and stop {'it' if to_stop == 1 else 'them'}")
        else:
            self.go.setText(f"{self.verb} without saving")
        self.go.setEnabled(not self._rests and not (jobs and all(job.stopping for job in jobs)))

    def _list(self, jobs: Sequence[Job | None]) -> None:
        """Have a row for each of `jobs`, in their order, and for no other."""
        if list(self.rows) == list(jobs):
            return
        for job in [job for job in self.rows if job not in jobs]:
            row = self.rows.pop(job)
            self.list.removeWidget(row)
            row.hide()
            row.deleteLater()
        self.rows = {job: self.rows.get(job) or _Row() for job in jobs}
        for at, row in enumerate(self.rows.values()):
            self.list.insertWidget(at, row)


class _Row(QWidget):
    """One job: its title with its progress, and what becomes of its result."""

    def __init__(self) -> None:
        super().__init__()
        self.words = text("Saving…", wrap=True)
        self.bar = ProgressLine()
        self.on_stop = text("", "secondary", wrap=True)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(STEP)
        for widget in (self.words, self.bar, self.on_stop):
            widget.setFixedWidth(WIDTH - 2 * PADDING)
            column.addWidget(widget)
        self.on_stop.hide()

    def show_job(self, job: Job) -> None:
        self.words.setText(describe_whole(job))
        self.bar.show_done(job.step.done)
        self.on_stop.setText(job.on_stop)
        self.on_stop.setVisible(bool(job.on_stop))
        for label in (self.words, self.on_stop):  # layouts within layouts do not ask a text that wraps for its height
            label.setFixedHeight(max(0, label.heightForWidth(label.width())))
