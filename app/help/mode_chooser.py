"""The choice of a mode: the use of each, and what was measured of it on the user's scene and machine."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QDialog, QHBoxLayout, QHeaderView, QTableWidget, QTableWidgetItem, QVBoxLayout, QWidget

from app.document.document import Project
from app.document.measured import setting_text
from app.document.modes import modes, why_not
from app.widgets.panels import button, text
from app.widgets.theme import ROW, STEP
from engine.core.figure_text import percent_within, size_text, time_text
from engine.tradeoff.point import Point

HEADINGS = ("Mode", "Good for", "Error", "Frame", "Bake", "Memory")

#: Width and height of the dialog, which fits the smallest window.
SIZE_PX = (860, 360)


class ModeChooser(QDialog):
    """`mode_wanted` by its name; `measuring_wanted`: all modes are to be measured on the scene."""

    mode_wanted = Signal(str)
    measuring_wanted = Signal()

    def __init__(self, window: QWidget, project: Project) -> None:
        super().__init__(window)
        self.setWindowTitle("Which mode when")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.resize(*SIZE_PX)
        self.table = QTableWidget(0, len(HEADINGS))
        self.table.setAccessibleName("Modes")
        self.table.setHorizontalHeaderLabels(list(HEADINGS))
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setDefaultSectionSize(ROW)
        self.table.setShowGrid(False)
        self.table.setEditTriggers(QTableWidget.EditTrigger.NoEditTriggers)
        self.table.setSelectionBehavior(QTableWidget.SelectionBehavior.SelectRows)
        self.table.setSelectionMode(QTableWidget.SelectionMode.SingleSelection)
        self.table.setTabKeyNavigation(False)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        self.table.itemActivated.connect(lambda _item: self._use())
        self.words = text("", "secondary", wrap=True)
        self.measure = button("Measure all modes", hint="Draw with every mode and compare with the reference")
        self.measure.clicked.connect(self._measure)
        self.use = button("Use this mode", "primary")
        self.use.clicked.connect(self._use)
        close = button("Close")
        close.clicked.connect(self.close)
        foot = QHBoxLayout()
        foot.setSpacing(2 * STEP)
        foot.addWidget(self.words, 1)
        for each in (self.measure, close, self.use):
            foot.addWidget(each)
        column = QVBoxLayout(self)
        column.addWidget(self.table)
        column.addLayout(foot)
        self.show_project(project)

    def show_project(self, project: Project) -> None:
        """The modes, with the most accurate that was measured of each."""
        accuracy = project.accuracy
        points = accuracy.points if accuracy is not None else ()
        known = modes()
        self.table.setRowCount(len(known))
        for place, mode in enumerate(known):
            best = best_of(points, mode.value)
            for column, words in enumerate((f"{mode.label} ({mode.key})", mode.hint, *figures(best))):
                item = QTableWidgetItem(words)
                item.setToolTip(setting_text(best.setting) if best is not None else mode.hint)
                if column > 1:
                    item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
                if why_not(mode, project):
                    item.setFlags(Qt.ItemFlag.NoItemFlags)
                    item.setToolTip(why_not(mode, project))
                self.table.setItem(place, column, item)
        shown = next(at for at, mode in enumerate(known) if mode.value == project.look.mode)
        self.table.setCurrentCell(shown, 0)
        self.words.setText(
            f"Measured on {accuracy.device}: of each mode the setting with the least error."
            if accuracy is not None
            else "Nothing was measured on this scene yet."
        )

    def _use(self) -> None:
        place = self.table.currentRow()
        if place >= 0:
            self.mode_wanted.emit(modes()[place].value)
            self.close()

    def _measure(self) -> None:
        self.measuring_wanted.emit()
        self.close()


def best_of(points: tuple[Point, ...], mode: str) -> Point | None:
    """The measured point of a mode with the least error; None where there is none."""
    return min((each for each in points if each.mode == mode), key=lambda each: each.error_rmse_rel, default=None)


def figures(point: Point | None) -> tuple[str, str, str, str]:
    """Error, frame time, bake time and memory of a point, in words."""
    if point is None:
        return ("–",) * 4
    bake = time_text(point.bake_s) if point.bake_s else "–"
    error = percent_within(point.error_rmse_rel, point.error_uncertainty)
    return error, time_text(point.frame_s), bake, size_text(point.memory_bytes)
