"""Docks that float and remember: the jobs of this run, and the log."""

from __future__ import annotations

import logging
from collections.abc import Sequence

from PySide6.QtCore import QEvent, QModelIndex, QObject, QPersistentModelIndex, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QFontDatabase, QShowEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QDockWidget,
    QHeaderView,
    QPlainTextEdit,
    QStackedWidget,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableWidget,
    QTableWidgetItem,
    QToolButton,
    QWidget,
)

from app.jobs.jobs import Job, Jobs
from app.widgets import theme
from app.widgets.panels import text
from app.widgets.status_bar import describe, is_long
from app.widgets.theme import PADDING, ROW, STEP
from engine.core.escape import escape_controls
from engine.core.figure_text import time_text

JOBS_KEPT = 200
LINES_KEPT = 5000

STATES = {
    "queued": "waiting",
    "running": "running",
    "paused": "paused",
    "succeeded": "done",
    "failed": "failed",
    "cancelled": "cancelled",
}


class _Apart(QStyledItemDelegate):
    """Rows with room between them, so that a name of two lines is seen as one."""

    def sizeHint(self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex) -> QSize:
        return super().sizeHint(option, index) + QSize(0, 2 * STEP)


class JobsDock(QDockWidget):
    """Every job of this run that the user asked for or that took long, newest first, with its state and time."""

    def __init__(self, jobs: Jobs, parent: QWidget) -> None:
        super().__init__("Jobs", parent)
        self.setObjectName("jobs")
        self.jobs = jobs
        self.rows: list[Job] = []
        self.table = QTableWidget(0, 4)
        self.table.setAccessibleName("Jobs")
        self.table.setHorizontalHeaderLabels(["Job", "Now", "Time", ""])
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setMinimumSectionSize(ROW)
        self.table.setItemDelegate(_Apart(self.table))
        self.table.setShowGrid(False)
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.table.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        header = self.table.horizontalHeader()
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Interactive)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        header.resizeSection(0, 220)
        header.resizeSection(2, 80)
        header.resizeSection(3, 36)
        header.sectionResized.connect(lambda *_: self._fit_rows_soon())
        self._fitting = QTimer(self)
        self._fitting.setSingleShot(True)
        self._fitting.timeout.connect(self._fit_rows)
        nothing = text("Running and finished tasks appear here.", "secondary", wrap=True)
        nothing.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        nothing.setMargin(PADDING)
        self.pages = QStackedWidget()
        for page in (nothing, self.table):
            self.pages.addWidget(page)
        self.setWidget(self.pages)
        jobs.changed.connect(self._show)
        jobs.progressed.connect(lambda job: self._show(job) if self.isVisible() or job not in self.rows else None)

    def sizeHint(self) -> QSize:
        return QSize(480, 180)

    def _fit_rows_soon(self) -> None:
        if self.isVisible():
            self._fitting.start(0)

    def _fit_rows(self) -> None:
        self.table.resizeRowsToContents()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._fit_rows_soon()

    def _show(self, job: Job) -> None:
        if job not in self.rows:
            if not (job.is_asked_for or is_long(job)):
                return
            self._insert(job)
        place = self.rows.index(job)
        now = describe(job).removeprefix(f"{job.title}: ") if not job.over else STATES[job.state]
        for column, words in ((1, now), (2, time_text(job.time_s, 3) if job.over else "")):
            item = self.table.item(place, column)
            assert item is not None
            item.setText(escape_controls(words))
        if self.isVisible():  # or else when it is shown
            self.table.resizeRowToContents(place)  # long names wrap; all rows at each change would take 1 ms each
        cancel = self.table.cellWidget(place, 3)
        if cancel is not None and job.over:
            self.table.removeCellWidget(place, 3)
        elif cancel is not None:
            cancel.setEnabled(not job.stopping)

    def _insert(self, job: Job) -> None:
        self.rows.insert(0, job)
        self.pages.setCurrentWidget(self.table)
        self.table.insertRow(0)
        for column, words in enumerate((job.title, "", "")):
            item = QTableWidgetItem(escape_controls(words))
            if column == 2:
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self.table.setItem(0, column, item)
        cancel = QToolButton()
        cancel.setIcon(theme.icon("cancel"))
        cancel.setToolTip(f"Cancel: {job.title}")
        cancel.setAccessibleName(f"Cancel: {job.title}")
        cancel.clicked.connect(lambda: self.jobs.cancel(job))
        self.table.setCellWidget(0, 3, cancel)
        if len(self.rows) > JOBS_KEPT:
            self.rows.pop()
            self.table.removeRow(JOBS_KEPT)


class LogDock(QDockWidget):
    """The messages of the program, line by line."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__("Log", parent)
        self.setObjectName("log")
        self.words = QPlainTextEdit()
        self.words.setReadOnly(True)
        self.words.setAccessibleName("Log")
        self.words.setPlaceholderText("Nothing has been logged yet.")
        self.words.setMaximumBlockCount(LINES_KEPT)
        fixed = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)
        fixed.setPixelSize(12)
        self.words.setFont(fixed)
        self.setWidget(self.words)
        self.handler = _Handler()
        self.handler.lines.arrived.connect(self.words.appendPlainText)
        logging.getLogger().addHandler(self.handler)

    def sizeHint(self) -> QSize:
        return QSize(480, 180)

    def disconnect_log(self) -> None:
        """Stop listening; comes before the window goes."""
        logging.getLogger().removeHandler(self.handler)


class DocksOf(QObject):
    """Docks that belong to one workspace: other workspaces hide them, and they come back unchanged.

    `closed` are the names of those that the user has closed.
    """

    def __init__(self, parent: QWidget, docks: Sequence[QDockWidget]) -> None:
        super().__init__(parent)
        self.docks = tuple(docks)
        self.actions: list[QAction] = []
        self._open = dict.fromkeys(self.docks, True)
        self._in_front = False
        for dock in self.docks:
            action = QAction(dock.windowTitle(), parent)
            action.setCheckable(True)
            action.setChecked(True)
            action.triggered.connect(lambda checked, dock=dock: self._want(dock, checked))
            dock.installEventFilter(self)
            self.actions.append(action)

    @property
    def closed(self) -> tuple[str, ...]:
        return tuple(dock.objectName() for dock in self.docks if not self._open[dock])

    def close(self, names: Sequence[str]) -> None:
        """Those that were closed when the program ended."""
        for dock in self.docks:
            self._want(dock, dock.objectName() not in names)

    def show(self, in_front: bool) -> None:
        """Their workspace has come to the front, or another one."""
        self._in_front = in_front
        for dock in self.docks:
            dock.setVisible(in_front and self._open[dock])

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Close and isinstance(watched, QDockWidget) and self._in_front:
            self._want(watched, False)
        return super().eventFilter(watched, event)

    def _want(self, dock: QDockWidget, is_open: bool) -> None:
        self._open[dock] = is_open
        self.actions[self.docks.index(dock)].setChecked(is_open)
        dock.setVisible(is_open and self._in_front)
        if is_open and self._in_front:
            dock.raise_()


class _Lines(QObject):
    arrived = Signal(str)


class _Handler(logging.Handler):
    """Hands records of any thread to the window's."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self.lines = _Lines()
        self.setFormatter(logging.Formatter("%(asctime)s  %(levelname)s  %(message)s", "%H:%M:%S"))

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.arrived.emit(self.format(record))
