"""Texts that a window shows: read from its widgets, actions, lists and tables."""

from __future__ import annotations

from collections.abc import Iterator

from PySide6.QtCore import QAbstractItemModel, QAbstractListModel, QModelIndex, QObject, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QAbstractItemView, QApplication, QComboBox, QLineEdit, QMenu, QWidget

#: Properties of Qt that hold a text for users.
PROPERTIES = (
    "text",
    "toolTip",
    "title",
    "placeholderText",
    "windowTitle",
    "accessibleName",
    "accessibleDescription",
    "hint",
)


#: Title of the menu that pyqtgraph makes for each plot, and that no plot shows.
OF_PLOTS = "Plot Options"


def read(*windows: QWidget) -> Iterator[tuple[QObject, str]]:
    """Each text of the windows and of all that is in them, with the widget or action that shows it."""
    menus = [menu for menu in QApplication.topLevelWidgets() if isinstance(menu, QMenu) and not _is_of_plot(menu)]
    for window in (*windows, *menus):
        for shown in (window, *window.findChildren(QWidget), *window.findChildren(QAction)):
            for name in PROPERTIES[isinstance(shown, QLineEdit) :]:  # what a field holds is the user's
                text = shown.property(name)
                if isinstance(text, str) and text:
                    yield shown, text
            if isinstance(shown, QComboBox | QAbstractItemView):
                model = shown.model()
                yield from ((shown, text) for text in _read_cells(model) if model is not None)


def _is_of_plot(menu: QWidget | None) -> bool:
    return isinstance(menu, QMenu) and (menu.title() == OF_PLOTS or _is_of_plot(menu.parentWidget()))


def _read_cells(model: QAbstractItemModel) -> Iterator[str]:
    top = QModelIndex()
    rows, columns = model.rowCount(top), 1 if isinstance(model, QAbstractListModel) else model.columnCount(top)
    heads = ((column, Qt.Orientation.Horizontal) for column in range(columns))
    texts = [model.headerData(*head) for head in heads]
    for cell in (model.index(row, column) for row in range(rows) for column in range(columns)):
        texts += [cell.data(role) for role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.ToolTipRole)]
    yield from (text for text in texts if isinstance(text, str) and text)
