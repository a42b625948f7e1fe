"""The list of projects on the start page: thumbnail, name, folder, date and size of each, and what can be searched."""

from __future__ import annotations

import datetime
import time
from pathlib import Path

from PySide6.QtCore import QAbstractListModel, QModelIndex, QPersistentModelIndex, QRect, QSize, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPainterPath, QPixmap
from PySide6.QtWidgets import QListView, QStyle, QStyledItemDelegate, QStyleOptionViewItem

from app.project.listing import Listed
from app.project.thumbnail import SIZE
from app.widgets import theme
from app.widgets.theme import PADDING, STEP
from engine.core.escape import escape_controls
from engine.core.figure_text import size_text

#: Height of a row, and of the thumbnail in it, in pixels.
ROW, IMAGE = 60, 48

#: Widths of the columns of dates and sizes, in pixels.
DATE, BYTES = 132, 76

AnyIndex = QModelIndex | QPersistentModelIndex


class ProjectModel(QAbstractListModel):
    """The projects that fit a search, with the sizes and thumbnails that are known so far, by path."""

    def __init__(self) -> None:
        super().__init__()
        self.all: tuple[Listed, ...] = ()
        self.shown: tuple[Listed, ...] = ()
        self.sizes: dict[Path, int] = {}
        self.thumbnails: dict[Path, QPixmap] = {}
        self._wanted = ""

    def rowCount(self, parent: AnyIndex = QModelIndex()) -> int:  # noqa: B008 - as Qt declares it
        return 0 if parent.isValid() else len(self.shown)

    def data(self, index: AnyIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        if not index.isValid():
            return None
        project = self.shown[index.row()]
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.AccessibleTextRole):
            return escape_controls(project.name)
        if role == Qt.ItemDataRole.AccessibleDescriptionRole:
            return f"{where(project)}, {date_text(project.modified_s)}"
        if role == Qt.ItemDataRole.ToolTipRole:
            return escape_controls(str(project.path))
        return project if role == Qt.ItemDataRole.UserRole else None

    def show_projects(self, projects: tuple[Listed, ...]) -> None:
        """Show `projects`; sizes and thumbnails of those that were there before stay until newer ones arrive."""
        self.all = projects
        self.search(self._wanted)

    def search(self, wanted: str) -> None:
        """Show the projects whose names or folders contain every word of `wanted`."""
        self._wanted, words = wanted, wanted.casefold().split()
        self.beginResetModel()
        self.shown = tuple(
            each for each in self.all if all(word in f"{each.name} {where(each)}".casefold() for word in words)
        )
        self.endResetModel()

    def add_details(self, path: Path, size_bytes: int, thumbnail: QImage) -> None:
        """Show size and thumbnail of the project at `path`."""
        self.sizes[path] = size_bytes
        if thumbnail.isNull():
            self.thumbnails.pop(path, None)
        else:
            self.thumbnails[path] = QPixmap.fromImage(thumbnail)
        for row, project in enumerate(self.shown):
            if project.path == path:
                self.dataChanged.emit(self.index(row), self.index(row))


class ProjectList(QListView):
    """Shows a `ProjectModel`; `project` is the one that is selected."""

    def __init__(self) -> None:
        super().__init__()
        self.projects = ProjectModel()
        self.setModel(self.projects)
        self.setItemDelegate(_Row(self.projects))
        self.setUniformItemSizes(True)
        self.setVerticalScrollMode(QListView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.setAccessibleName("Projects")
        self.setMouseTracking(True)

    @property
    def project(self) -> Listed | None:
        index = self.currentIndex()
        return self.projects.shown[index.row()] if index.isValid() else None

    def select(self, path: Path | None) -> None:
        """Select the project at `path`; none where it is not there, so that no command meets another project."""
        shown = [each.path for each in self.projects.shown]
        self.setCurrentIndex(self.projects.index(shown.index(path)) if path in shown else QModelIndex())


class _Row(QStyledItemDelegate):
    """Draws one project: thumbnail, name over folder, date, size."""

    def __init__(self, model: ProjectModel) -> None:
        super().__init__(model)
        self._model = model

    def sizeHint(self, _option: QStyleOptionViewItem, _index: AnyIndex) -> QSize:
        return QSize(240, ROW)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: AnyIndex) -> None:
        project, colours, place = self._model.shown[index.row()], theme.current(), option.rect
        state = option.state
        is_chosen, is_under = state & QStyle.StateFlag.State_Selected, state & QStyle.StateFlag.State_MouseOver
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        inner = place.adjusted(STEP, 1, -STEP, -1)
        if is_chosen or is_under:
            shape = QPainterPath()
            shape.addRoundedRect(inner, STEP, STEP)
            painter.fillPath(shape, QColor(colours.line if is_chosen else colours.hover))
            if is_chosen and state & QStyle.StateFlag.State_HasFocus:
                painter.setPen(QColor(colours.accent))
                painter.drawPath(shape)
        image = QRect(inner.left() + 2 * STEP, inner.center().y() - IMAGE // 2 + 1, IMAGE * SIZE[0] // SIZE[1], IMAGE)
        self._draw_image(painter, project, image)
        right = inner.right() - 2 * STEP
        size = self._model.sizes.get(project.path)
        words = ("" if size is None else size_text(size), date_text(project.modified_s))
        painter.setFont(theme.font())
        for width, said in zip((BYTES, DATE), words, strict=True):
            column = QRect(right - width, inner.top(), width, inner.height())
            painter.setPen(QColor(colours.secondary))
            painter.drawText(column, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, said)
            right -= width + PADDING
        left, middle = image.right() + PADDING, inner.center().y()
        name, folder = escape_controls(project.name), where(project)
        self._draw_line(painter, QRect(left, middle - 21, right - left, 20), name, colours.text, strong=True)
        self._draw_line(painter, QRect(left, middle + 2, right - left, 20), folder, colours.secondary)
        painter.restore()

    def _draw_image(self, painter: QPainter, project: Listed, place: QRect) -> None:
        found = self._model.thumbnails.get(project.path)
        if found is not None:
            painter.drawPixmap(place, found)
            return
        painter.fillRect(place, QColor(theme.current().canvas))
        icon = theme.pixmap("material", theme.LARGE, theme.current().disabled)
        painter.drawPixmap(place.center() - icon.rect().center(), icon)

    @staticmethod
    def _draw_line(painter: QPainter, place: QRect, words: str, colour: str, *, strong: bool = False) -> None:
        painter.setFont(theme.font(strong=strong))
        painter.setPen(QColor(colour))
        elide = Qt.TextElideMode.ElideRight if strong else Qt.TextElideMode.ElideMiddle
        shown = painter.fontMetrics().elidedText(words, elide, place.width())
        painter.drawText(place, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, shown)


def where(project: Listed) -> str:
    """The folder of a project, in one line."""
    folder = escape_controls(str(project.path.parent))
    home = str(Path.home()) if Path.home().is_absolute() else ""
    if home and folder.startswith(f"{home}/"):
        folder = f"~{folder.removeprefix(home)}"
    words = "Not saved under a name yet" if project.is_untitled else folder
    return f"{words} · open in another window" if project.is_open else words


def date_text(modified_s: float) -> str:
    """When a project was changed: 'Today 14:02', 'Yesterday 09:30', '2026-11-24 17:26'."""
    try:
        then = datetime.datetime.fromtimestamp(modified_s)
    except (ValueError, OverflowError, OSError):
        return ""
    days = (datetime.date.fromtimestamp(time.time()) - then.date()).days
    return f"{ {0: 'Today', 1: 'Yesterday'}.get(days, f'{then:%Y-%m-%d}') } {then:%H:%M}".strip()
