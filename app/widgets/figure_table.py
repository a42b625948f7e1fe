"""A table of figures: the first column names the row, the others hold right-aligned numbers with units."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableWidget, QTableWidgetItem

from app.widgets.theme import ROW


class FigureTable(QTableWidget):
    """`picked(row)` follows the row on which the user is; rows are replaced without moving the selection."""

    picked = Signal(int)

    def __init__(self, name: str, headings: Sequence[str]) -> None:
        super().__init__(0, len(headings))
        self.setAccessibleName(name)
        self.setHorizontalHeaderLabels(list(headings))
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(ROW)
        self.setShowGrid(False)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setTabKeyNavigation(False)
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
        for column in range(len(headings)):
            heading = self.horizontalHeaderItem(column)
            assert heading is not None
            heading.setTextAlignment(_side(column))
        self._filling = False
        self.currentCellChanged.connect(self._on_moved)

    def sizeHint(self) -> QSize:
        return QSize(320, 4 * ROW)

    def minimumSizeHint(self) -> QSize:
        return QSize(240, 3 * ROW)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the chosen row in sight."""
        super().resizeEvent(event)
        item = self.currentItem()
        if item is not None:
            self.scrollToItem(item)

    def show_rows(self, rows: Sequence[Sequence[str]], current: int | None) -> None:
        """Show `rows` with row `current` chosen, without emitting."""
        self._filling = True
        self.setRowCount(len(rows))
        for place, row in enumerate(rows):
            for column, words in enumerate(row):
                item = self.item(place, column)
                if item is None:
                    item = QTableWidgetItem()
                    item.setTextAlignment(_side(column))
                    self.setItem(place, column, item)
                if item.text() != words:
                    item.setText(words)
                    item.setToolTip(words)
        if current is None:
            self.setCurrentCell(-1, -1)
        elif self.currentRow() != current:
            self.setCurrentCell(current, 0)
        self._filling = False

    def _on_moved(self, row: int, _column: int, old: int, _old_column: int) -> None:
        if not self._filling and row >= 0 and row != old:
            self.picked.emit(row)


def _side(column: int) -> Qt.AlignmentFlag:
    return (Qt.AlignmentFlag.AlignRight if column else Qt.AlignmentFlag.AlignLeft) | Qt.AlignmentFlag.AlignVCenter
