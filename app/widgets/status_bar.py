"""The line at the bottom: the running job with progress and cancel, health, error, frame time and memory."""

from __future__ import annotations

import time

import psutil
from PySide6.QtCore import QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAccessible, QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QToolButton, QWidget

from app.jobs.jobs import Job, Jobs
from app.widgets import theme
from app.widgets import theme as icons
from app.widgets.fitting import Elided
from app.widgets.panels import text
from app.widgets.theme import PADDING, STEP, role
from engine.core.escape import escape_controls
from engine.core.figure_text import local, percent, size_text, time_text
from engine.core.health import Health, Verdict
from engine.core.steps import time_left

HEIGHT = 30

OF_MATERIAL = "Error of the compressed material against its slices"

#: The workspaces that are about the material.
ABOUT_MATERIAL = ("material", "view", "export")

#: Jobs for the screen, and those in the background, are shown with progress and a cancel button after this time.
SHOWN_AFTER_S = 1.0

#: Milliseconds for which a confirmation stands before the words of a job that runs.
CONFIRMED_MS = 4000

#: Icon, colour of the theme and word of each verdict.
VERDICTS = {
    Verdict.GOOD: ("check", "good", "Health"),
    Verdict.NOTE: ("note", "secondary", "Health: note"),
    Verdict.WARNING: ("warning", "warning", "Health: check"),
    Verdict.BAD: ("bad", "bad", "Health: problem"),
}


class StatusBar(QWidget):
    """Shows figures that others hand over; asks `jobs` to cancel. `health_clicked` asks for the report."""

    health_clicked = Signal()

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.jobs = jobs
        self._said = self._confirmed = ""
        self._health: Health | None = None
        role(self, "bar")
        self.setFixedHeight(HEIGHT)
        self.words = Elided()
        self.bar = ProgressLine()
        self.cancel = QToolButton()
        self.cancel.setIconSize(QSize(icons.SMALL, icons.SMALL))
        self.cancel.setToolTip("Cancel the running job")
        self.cancel.setAccessibleName("Cancel the running job")
        self.cancel.clicked.connect(self._cancel)
        self.health = QToolButton()
        self.health.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.health.setIconSize(QSize(icons.SMALL, icons.SMALL))
        self.health.clicked.connect(self.health_clicked)
        self.error = figure(OF_MATERIAL, "error 10.00 % ± 0.01")
        self._of_material = ""
        self._in_front = ""
        self._of_image: tuple[str, str] | None = None
        self.frame = figure("Time of the last frame in the viewport", "1000.0 ms")
        self.memory = figure("Memory that this program holds", "99.9 GB")
        self.row = row = QHBoxLayout(self)
        row.setContentsMargins(PADDING, 0, PADDING, 0)
        row.setSpacing(2 * STEP)
        row.addWidget(self.cancel)  # before the text, whose width changes: a click finds the button
        row.addWidget(self.bar)
        row.addWidget(self.words, 1)
        for widget in (self.health, self.error, self.frame, self.memory):
            row.addSpacing(STEP)
            row.addWidget(widget)
        jobs.changed.connect(lambda _job: self._show_job())
        jobs.progressed.connect(self._on_progressed)
        self._confirming = QTimer(self)
        self._confirming.setSingleShot(True)
        self._confirming.setInterval(CONFIRMED_MS)
        self._confirming.timeout.connect(self._end_confirming)
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._show_memory)
        self._timer.timeout.connect(self._show_job)
        self._timer.start(1000)
        self.show_health(None)
        self._show_job()
        self._show_memory()
        self.apply_theme()

    def apply_theme(self) -> None:
        """Take the colours of the current theme."""
        self.cancel.setIcon(icons.icon("cancel"))
        self._health = None

    def say(self, words: str) -> None:
        """A sentence about what just happened, until the next job begins."""
        self._said = words
        self._show_job()

    def confirm(self, words: str) -> None:
        """A few words about what was just done, for a moment, also while a job runs."""
        self._said = self._confirmed = words
        self._confirming.start()
        self._show_job()

    def _end_confirming(self) -> None:
        self._confirmed = ""
        self._show_job()

    def show_health(self, health: Health | None) -> None:
        """The worst finding of the project."""
        self.health.setVisible(health is not None)
        if health is None or health is self._health:
            return
        self._health = health
        name, look, word = VERDICTS[health.verdict]
        self.health.setIcon(icons.icon(name, getattr(theme.current(), look)))
        self.health.setText(word)
        worst = [finding.sentence for finding in health.summary if finding.verdict == health.verdict]
        self.health.setToolTip("\n".join(worst[:3]) if worst else "Nothing to report")

    def belong_to(self, workspace: str) -> None:
        """Show what belongs to the workspace in front, by its name."""
        self._in_front = workspace
        self._show_error()

    def show_error(self, rms: float | None, r_max: float = 1.0) -> None:
        """Error of the compression as a share of the brightest slice's mean."""
        self._of_material = "" if rms is None else f"error {percent(rms / r_max, 3)}"
        self._show_error()

    def show_image_error(self, words: str | None, hint: str = "") -> None:
        """Error of the image on screen, '1.2 % ± 0.1', or nothing; None for that of the material in its place."""
        self._of_image = None if words is None else (f"error {words}" if words else "", hint)
        self._show_error()

    def _show_error(self) -> None:
        of_material = self._of_material if self._in_front in ABOUT_MATERIAL else ""
        words, hint = (of_material, OF_MATERIAL) if self._of_image is None else self._of_image
        if words != self.error.text() or hint != self.error.toolTip():
            self.error.setText(words)
            self.error.setToolTip(hint)
            self.error.setVisible(bool(words))
            self.row.activate()  # or else the words are cut until the event loop lays out anew

    def show_frame_time(self, seconds: float | None) -> None:
        """Time of the last frame; None where no viewport is on screen."""
        self.frame.setVisible(seconds is not None)
        if seconds is not None:
            self.frame.setText(local(f"{1000 * seconds:.1f} ms") if seconds < 1.0 else time_text(seconds))

    def _current(self) -> Job | None:
        """The job to show: a save, what else the user asked for, or another one that takes long by now."""
        active = self.jobs.active
        saves = [job for job in active if job.lane == "save"]
        asked = [job for job in active if job.is_asked_for]
        return next(iter([*saves, *asked, *(job for job in active if is_long(job))]), None)

    def _cancel(self) -> None:
        job = self._current()
        if job is not None:
            self.jobs.cancel(job)

    def _show_job(self) -> None:
        job = self._current()
        self.bar.setVisible(job is not None)
        self.cancel.setVisible(job is not None)
        if job is None:
            self.words.setText(self._said)
            return
        self._said = self._confirmed
        self.bar.show_done(job.step.done)
        self.cancel.setEnabled(not job.stopping)
        self.words.setText(self._confirmed or describe(job))

    def _on_progressed(self, job: Job) -> None:
        if job is self._current():
            self._show_job()

    def _show_memory(self) -> None:
        self.memory.setText(size_text(psutil.Process().memory_info().rss))


class ProgressLine(QWidget):
    """A thin bar. Qt's own repaints the whole window at once with every value; this one waits its turn."""

    accessible_role = QAccessible.Role.ProgressBar

    def __init__(self) -> None:
        super().__init__()
        self.done = 0.0
        self.setFixedSize(140, 4)
        self.setAccessibleName("Progress of the running job")

    def show_done(self, done: float) -> None:
        """`done` in [0, 1]."""
        self.done = min(1.0, max(0.0, done))
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        for share, colour in ((1.0, theme.current().line), (self.done, theme.current().accent)):
            painter.setBrush(QColor(colour))
            painter.drawRoundedRect(QRectF(0, 0, share * self.width(), self.height()), 2, 2)


def is_long(job: Job) -> bool:
    """True for a job that nobody sees at its start and that has run for a while; what only refines does not count."""
    is_new = time.monotonic() - job.started_s <= SHOWN_AFTER_S
    return job.state == "running" and not (job.is_asked_for or job.refines or is_new)


def describe(job: Job) -> str:
    """A job in one line: its current step and its remaining time."""
    if job.stopping:
        return f"{job.title}: stopping…"
    if job.state in ("queued", "paused"):
        return f"{job.title}: {waiting_text(job) if job.state == 'queued' else 'paused'}"
    if job.lane == "save":
        return describe_whole(job)
    note = escape_controls(job.step.note or job.title)
    return _with_time_left(job, f"{note[:1].upper()}{note[1:]}")


def describe_whole(job: Job) -> str:
    """A job in one line, by its title: how far it is and its remaining time, or why it does not run."""
    if job.stopping or job.state != "running":
        return describe(job)
    return _with_time_left(job, f"{job.title}… {percent(job.step.done, 1)}")


def _with_time_left(job: Job, words: str) -> str:
    """The words with the remaining time; those of work that knows its own better stay as they are."""
    left = job.left_s
    if left is None or left < 1 or words.endswith(" left"):
        return words
    return f"{words} · {time_left(left)}"


def waiting_text(job: Job) -> str:
    """The reason why a job does not run now."""
    return f"waiting for {job.waits_for}" if job.waits_for else "waiting"


def figure(hint: str, widest: str) -> QLabel:
    """A read-out of the status bar, right-aligned in room for its `widest` text."""
    label = text("", "secondary")
    label.setMinimumWidth(label.fontMetrics().horizontalAdvance(widest))
    label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    label.setToolTip(hint)
    return label
