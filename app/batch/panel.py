"""The batch in the window: choose captures and a folder, start, watch, pause, go on, open the report and projects."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QUrl, Signal
from PySide6.QtGui import QDesktopServices, QKeyEvent, QKeySequence
from PySide6.QtWidgets import QDialog, QFileDialog, QHBoxLayout, QProgressBar, QVBoxLayout, QWidget

from app.batch.record import Row, read_rows
from app.batch.report import PAGE
from app.batch.run import Settings, go_on
from app.document.document import Project
from app.jobs.jobs import Job, Jobs
from app.widgets.controls import ComboBox
from app.widgets.figure_table import FigureTable
from app.widgets.panels import Rows, button, enable, line, text, with_buttons
from app.widgets.theme import PADDING, STEP
from engine.core.errors import FileError
from engine.core.escape import escape_controls
from engine.core.figure_text import number, time_text
from engine.core.steps import Step, Steps

#: Size of the dialog in pixels.
SIZE = (760, 560)

HEADINGS = ("Capture", "State", "Held-out error", "Time")

#: Captures that the table shows at most.
MAX_ROWS = 500

#: Words for the states of a capture.
STATES = {"waiting": "Waiting", "running": "Running", "done": "Done", "failed": "Failed"}


class BatchDialog(QDialog):
    """One batch. `project_wanted(path)`: the project of a capture that is done is to be opened. `help_wanted`: F1.

    Attributes
    ----------
    template : gives the document of the window, by whose choices captures are made.

    The run is a job of the window, which goes on while the dialog is closed; whoever opens it again sees it.
    """

    project_wanted = Signal(object)
    help_wanted = Signal()

    def __init__(self, window: QWidget, jobs: Jobs, template: Callable[[], Project]) -> None:
        super().__init__(window)
        self.jobs, self.template = jobs, template
        self.sources: list[str] = []
        self.output: Path | None = None
        self.job: Job | None = None
        self.rows: dict[str, Row] = {}
        self.setWindowTitle("Batch")
        self.resize(*SIZE)
        column = QVBoxLayout(self)
        column.setContentsMargins(PADDING, PADDING, PADDING, PADDING)
        column.setSpacing(2 * STEP)
        column.addWidget(self._choices())
        column.addWidget(line())
        self.words = text("", "secondary", wrap=True)
        self.bar = QProgressBar()
        self.bar.setTextVisible(False)
        self.bar.setRange(0, 1000)
        self.bar.setAccessibleName("Progress of the batch")
        self.table = FigureTable("Captures of the batch", HEADINGS)
        self.table.cellDoubleClicked.connect(lambda row, _column: self._open_project(row))
        self.table.picked.connect(self._explain)
        for widget, stretch in ((self.words, 0), (self.bar, 0), (self.table, 1)):
            column.addWidget(widget, stretch)
        column.addLayout(self._buttons())
        self._refresh()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.matches(QKeySequence.StandardKey.HelpContents):
            self.help_wanted.emit()
        else:
            super().keyPressEvent(event)

    def _choices(self) -> Rows:
        rows = Rows("Many captures in one run")
        self.source_words, self.output_words = text("none", wrap=True), text("none", wrap=True)
        folder, table, place = (button("Folder…"), button("Table…"), button("Choose…"))
        folder.clicked.connect(self._choose_folder)
        table.clicked.connect(self._choose_table)
        place.clicked.connect(self._choose_output)
        hint = "A folder with a folder for each capture, or a table (.csv) that lists them"
        rows.row("Captures", with_buttons(self.source_words, folder, table), hint)
        hint = "A folder for each capture and for the report; one of an earlier batch goes on"
        rows.row("Results", with_buttons(self.output_words, place), hint)
        self.choices = ComboBox()
        for words, is_of_project in (("As this project", True), ("As a new project", False)):
            self.choices.addItem(words, is_of_project)
        rows.row("Choices", self.choices, "Import, material, appearance and exports of all captures")
        return rows

    def _buttons(self) -> QHBoxLayout:
        self.start, self.pause = button("Start", "primary"), button("Pause")
        self.stop, self.report = button("Stop"), button("Open report")
        self.start.clicked.connect(self.begin)
        self.pause.clicked.connect(self._pause_or_resume)
        self.stop.clicked.connect(lambda: self.jobs.cancel(self.job) if self.job is not None else None)
        self.report.clicked.connect(self._open_report)
        row = QHBoxLayout()
        row.setSpacing(STEP)
        row.addWidget(self.report)
        row.addStretch(1)
        for each in (self.stop, self.pause, self.start):
            row.addWidget(each)
        return row

    @property
    def is_running(self) -> bool:
        return self.job is not None and not self.job.over

    def take_sources(self, *sources: str) -> None:
        """Choose the captures of `sources`."""
        self.sources = list(sources)
        self.source_words.setText(escape_controls(", ".join(sources)))
        self._refresh()

    def take_output(self, folder: Path) -> None:
        """Choose the folder of results; the captures of a batch that is there are shown."""
        self.output, self.rows = folder, {}
        self.output_words.setText(escape_controls(str(folder)))
        try:
            self.rows = {row.capture.name: row for row in read_rows(folder)}
        except FileError as error:
            self.words.setText(str(error))
        self._show_rows()
        self._refresh()

    def _choose_folder(self) -> None:
        chosen = QFileDialog.getExistingDirectory(self, "Folder of captures")
        if chosen:
            self.take_sources(chosen)

    def _choose_table(self) -> None:
        chosen, _ = QFileDialog.getOpenFileName(self, "Table of captures", "", "Tables (*.csv)")
        if chosen:
            self.take_sources(chosen)

    def _choose_output(self) -> None:
        chosen = QFileDialog.getExistingDirectory(self, "Folder of results")
        if chosen:
            self.take_output(Path(chosen))

    def begin(self) -> None:
        """Start the batch, or go on with it."""
        if self.output is None or self.is_running:
            return
        output, sources = self.output, tuple(self.sources)
        template = self.template() if self.choices.currentData() else None

        def work() -> Steps[list[Row]]:
            return (yield from go_on(output, sources, Settings(template)))

        self.job = job = self.jobs.submit(
            "Batch",
            work,
            lane="compute",
            resource=str(output),
            on_stop="It goes on where it stopped when it is started again.",
        )
        job.progressed.connect(self._on_step)
        job.succeeded.connect(self._on_done)
        job.failed.connect(lambda error: self.words.setText(str(error)))
        for ended in (job.succeeded, job.failed, job.cancelled):
            ended.connect(lambda *_: self._refresh())
        self.jobs.changed.connect(lambda changed: self._refresh() if changed is job else None)
        self._refresh()

    def _pause_or_resume(self) -> None:
        if self.job is None:
            return
        if self.job.state == "paused":
            self.jobs.resume(self.job)
        else:
            self.jobs.pause(self.job)

    def _on_step(self, step: Step) -> None:
        self.bar.setValue(round(1000 * step.done))
        self.words.setText(step.note)
        if step.partial:
            self.rows |= {row.capture.name: row for row in step.partial}
            self._show_rows()
            if not self.report.isEnabled():
                self._refresh()

    def _on_done(self, rows: list[Row]) -> None:
        self.rows |= {row.capture.name: row for row in rows}
        self.bar.setValue(1000)
        failed = sum(row.state == "failed" for row in rows)
        self.words.setText(f"{len(rows) - failed} of {len(rows)} captures are done")
        self._show_rows()

    def _show_rows(self) -> None:
        shown = []
        for row in self._shown:
            error = row.record.get("held_out_rmse_srgb8") if row.state == "done" else None
            seconds = "" if row.seconds is None else time_text(row.seconds)
            shown.append((row.capture.name, STATES[row.state], "" if error is None else number(error, 3), seconds))
        current = self.table.currentRow()
        self.table.show_rows(shown, current if 0 <= current < len(shown) else None)

    @property
    def _shown(self) -> list[Row]:
        """The captures of the table: of many those that run or have failed, and some others."""
        rows = list(self.rows.values())
        if len(rows) > MAX_ROWS:
            rows.sort(key=lambda row: ("running", "failed", "waiting", "done").index(row.state))
        return rows[:MAX_ROWS]

    def _explain(self, place: int) -> None:
        row = self._shown[place]
        self.words.setText(escape_controls(row.reason or "; ".join(row.record.get("warnings", ()))))

    def _open_project(self, place: int) -> None:
        row = self._shown[place]
        if row.state == "done" and self.output is not None and row.record.get("project"):
            self.project_wanted.emit(self.output / row.capture.name / Path(row.record["project"]).name)

    def _open_report(self) -> None:
        if self.output is not None:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(self.output / PAGE)))

    def _refresh(self) -> None:
        """Offer what can be done now."""
        running, knows = self.is_running, bool(self.rows)
        is_paused = self.job is not None and self.job.state == "paused"
        why_not = "It is running" if running else "Choose a folder of results" if self.output is None else ""
        if not why_not and not self.sources and not knows:
            why_not = "Choose captures"
        enable(self.start, why_not)
        self.start.setText("Go on" if knows and not running else "Start")
        enable(self.pause, "" if running else "Nothing is running", "Captures that are being made come to their end")
        self.pause.setText("Resume" if is_paused else "Pause")
        enable(self.stop, "" if running else "Nothing is running", "Captures that are being made start over later")
        has_report = self.output is not None and (self.output / PAGE).is_file()
        enable(self.report, "" if has_report else "There is no report yet")
