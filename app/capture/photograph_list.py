"""The photographs by rising elevation: thumbnail, angle, name and verdict in one row each."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import (
    QAbstractListModel,
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    QRect,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QImage, QKeyEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLineEdit,
    QListView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QVBoxLayout,
    QWidget,
)

from app.document.document import Project
from app.widgets import theme
from app.widgets import theme as icons
from app.widgets.controls import ComboBox
from app.widgets.import_controls import name_controls
from app.widgets.language import translate
from app.widgets.number_field import number_from_text, plain
from app.widgets.panels import button, text
from app.widgets.status_bar import VERDICTS
from app.widgets.theme import PADDING, STEP, role
from engine.capture.stack import ImageStack
from engine.core.errors import UsageError
from engine.core.figure_text import format_fixed
from engine.core.health import Health, Verdict

LIST_WIDTH = 232
ROW_HEIGHT = 52
THUMBNAIL = QSize(56, 40)

Index = QModelIndex | QPersistentModelIndex


@dataclass(frozen=True)
class Row:
    """The cells of one row of the list of photographs."""

    name: str
    elevation_deg: float
    azimuth_deg: float | None = None
    verdict: Verdict = Verdict.GOOD
    finding: str = ""
    excluded: bool = False
    done: bool = True


#: Rows that a filter shows: its words, those where it shows none, and the condition.
FILTERS: dict[str, tuple[str, str, Callable[[Row], bool]]] = {
    "all": ("All", "", lambda _row: True),
    "used": ("Used", "No photograph is used", lambda row: not row.excluded),
    "excluded": ("Excluded", "No photograph is excluded", lambda row: row.excluded),
    "warnings": ("With warnings", "No photograph has a warning", lambda row: row.verdict >= Verdict.WARNING),
}


def file_name(path: Path) -> str:
    """The name of a photograph as a stack records it: bytes that are not UTF-8 become replacement characters."""
    return os.fsencode(path.name).decode("utf-8", "replace")


def rows_of(project: Project) -> list[Row]:
    """A row for each photograph of `project`, from its stack or else from its sources, with its worst finding."""
    stack = project.stack
    health = stack.health if stack is not None else Health()
    return [
        Row(name, elevation, azimuth, *_worst(health, name), excluded=name in project.excluded, done=stack is not None)
        for name, elevation, azimuth in _photographs(project)
    ]


def _photographs(project: Project) -> list[tuple[str, float, float | None]]:
    """Names, elevations and azimuths in degrees; None where the azimuth is not known."""
    lit = project.stack or project.sources
    if lit is None:
        return []
    names = lit.sources if isinstance(lit, ImageStack) else [file_name(path) for path in lit.photographs]
    elevations = [round(math.degrees(angle), 9) for angle in lit.elevation]
    if lit.azimuth is None:
        return [(name, elevation, None) for name, elevation in zip(names, elevations, strict=True)]
    azimuths = [round(math.degrees(angle) % 360.0, 9) for angle in lit.azimuth]
    return list(zip(names, elevations, azimuths, strict=True))


def _worst(health: Health, name: str) -> tuple[Verdict, str]:
    findings = [finding for finding in health.findings if finding.source == name]
    worst = max(findings, key=lambda finding: finding.verdict, default=None)
    return (worst.verdict, worst.text) if worst is not None else (Verdict.GOOD, "")


class PhotographModel(QAbstractListModel):
    """Rows and their thumbnails by name."""

    angle_edited = Signal(int, float, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.rows: tuple[Row, ...] = ()
        self.thumbnails: dict[str, QImage] = {}
        self.angles_editable = False

    def show_rows(self, rows: Sequence[Row]) -> None:
        """Replace the rows; a change of content alone keeps selection and scroll position."""
        same = [row.name for row in rows] == [row.name for row in self.rows]
        if not same:
            self.beginResetModel()
        self.rows = tuple(rows)
        if not same:
            self.endResetModel()
        elif rows:
            self.dataChanged.emit(self.index(0), self.index(len(rows) - 1))

    def show_thumbnail(self, name: str, image: QImage) -> None:
        """The small image of one photograph."""
        self.thumbnails[name] = image
        for place, row in enumerate(self.rows):
            if row.name == name:
                self.dataChanged.emit(self.index(place), self.index(place))

    def rowCount(self, _parent: Index = QModelIndex()) -> int:  # noqa: B008 - Qt's own signature
        return len(self.rows)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        row = self.rows[index.row()]
        if role == Qt.ItemDataRole.DisplayRole:
            return row.name
        if role == Qt.ItemDataRole.EditRole:
            return " / ".join(plain(angle) for angle in (row.elevation_deg, row.azimuth_deg) if angle is not None)
        if role == Qt.ItemDataRole.ToolTipRole:
            state = "Excluded from the material. " if row.excluded else ""
            editable = "\nDouble-click to enter elevation / azimuth in degrees (0 = right, 90 = up)"
            return name_controls(
                f"{row.name}\n{state}{row.finding}".strip() + (editable if self.angles_editable else "")
            )
        if role == Qt.ItemDataRole.AccessibleTextRole:
            return translate(f"{row.name}, {row.elevation_deg:g} degrees, {row.verdict.name.lower()}")
        return None

    def flags(self, index: Index) -> Qt.ItemFlag:
        editable = Qt.ItemFlag.ItemIsEditable if self.angles_editable else Qt.ItemFlag.NoItemFlags
        return super().flags(index) | editable

    def setData(self, index: Index, value: object, role: int = Qt.ItemDataRole.EditRole) -> bool:
        parts = str(value).split("/")
        try:
            elevation, *others = (number_from_text(each, "°") for each in parts)
        except UsageError:
            return False
        azimuth = others[0] if others else None
        is_possible = 0.0 <= elevation <= 90.0 and len(others) < 2 and (azimuth is None or abs(azimuth) <= 360.0)
        if role != Qt.ItemDataRole.EditRole or not is_possible:
            return False
        row = self.rows[index.row()]
        if elevation != row.elevation_deg or azimuth not in (None, row.azimuth_deg):
            self.angle_edited.emit(index.row(), elevation, azimuth)
        return True


class PhotographList(QListView):
    """Shows a `PhotographModel`, or the rows of it that a filter shows.

    Signals
    -------
    chosen : the row on which the user is.
    picked : those that are selected.
    filtered : the filter, where another one came.
    use_toggled : the space bar was pressed.
    """

    chosen = Signal(int)
    picked = Signal(list)
    filtered = Signal(str)
    use_toggled = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.photographs = PhotographModel(self)
        self.filter = "all"
        self.setModel(self.photographs)
        self.setItemDelegate(_Delegate(self))
        self.setUniformItemSizes(True)
        self.setVerticalScrollMode(QListView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setEditTriggers(QListView.EditTrigger.DoubleClicked | QListView.EditTrigger.EditKeyPressed)
        self.setAccessibleName("Photographs")
        self.setSelectionMode(QListView.SelectionMode.ExtendedSelection)
        self.selectionModel().currentChanged.connect(lambda index, _old: self.chosen.emit(index.row()))
        self.selectionModel().selectionChanged.connect(lambda _new, _old: self.picked.emit(self.selection))

    @property
    def selection(self) -> list[int]:
        """The rows that are selected and seen, rising."""
        rows = sorted(index.row() for index in self.selectionModel().selectedIndexes())
        return [row for row in rows if not self.isRowHidden(row)]

    @property
    def shown(self) -> list[int]:
        """The rows that the filter shows."""
        return [row for row in range(len(self.photographs.rows)) if not self.isRowHidden(row)]

    def show_rows(self, rows: Sequence[Row]) -> None:
        """Replace the rows, of which the filter shows some."""
        self.photographs.show_rows(rows)
        self._filter_rows()

    def show_only(self, name: str) -> None:
        """Show the rows of the filter `name`, one of `FILTERS`."""
        if name != self.filter:
            self.filter = name
            self._filter_rows()
            self.filtered.emit(name)

    def _filter_rows(self) -> None:
        """Hide the other rows; nothing that is hidden stays selected, and the user is on a row that is seen."""
        belongs = FILTERS[self.filter][-1]
        picked = self.selection
        for place, row in enumerate(self.photographs.rows):
            self.setRowHidden(place, not belongs(row))
        now, shown = self.currentIndex().row(), self.shown
        if now >= 0 and shown and now not in shown:
            later = [place for place in shown if place > now]
            self.choose(later[0] if later else shown[-1])
        elif set(picked) - set(shown):
            self.pick([place for place in picked if place in shown])
        self.viewport().update()

    def choose(self, place: int) -> None:
        """Go to row `place`; where the filter hides it, all are shown again."""
        if self.isRowHidden(place):
            self.show_only("all")
        self.setCurrentIndex(self.photographs.index(place))

    def forget(self) -> None:
        """Select nothing and show all rows, as before the first photographs came."""
        self.show_only("all")
        self.setCurrentIndex(QModelIndex())
        self.clearSelection()

    def step(self, by: int) -> None:
        """Go to the next row that is seen (1), or to the one before (-1)."""
        now = self.currentIndex().row()
        ahead = [place for place in self.shown if (place - now) * by > 0]
        if ahead:
            self.choose(min(ahead, key=lambda place: abs(place - now)))

    def pick(self, places: Sequence[int]) -> None:
        """Select the rows `places`, and go to the first unless the user is on one of them."""
        if any(self.isRowHidden(place) for place in places):
            self.show_only("all")
        chosen = QItemSelection()
        for place in places:
            chosen.select(self.photographs.index(place), self.photographs.index(place))
        model = self.selectionModel()
        if places and self.currentIndex().row() not in places:
            model.setCurrentIndex(self.photographs.index(places[0]), QItemSelectionModel.SelectionFlag.NoUpdate)
        model.select(chosen, QItemSelectionModel.SelectionFlag.ClearAndSelect)

    def selectAll(self) -> None:
        """Select all rows that are seen."""
        self.pick(self.shown)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Space and not event.isAutoRepeat():
            self.use_toggled.emit()
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.photographs.rows and not self.shown:
            painter = QPainter(self.viewport())
            painter.setPen(QColor(theme.current().secondary))
            around = self.viewport().rect().adjusted(PADDING, PADDING, -PADDING, -PADDING)
            words = FILTERS[self.filter][1]
            painter.drawText(around, Qt.AlignmentFlag.AlignTop | Qt.TextFlag.TextWordWrap, words)


class PhotographColumn(QWidget):
    """The list below its title, count and filter, and a link to other photographs."""

    others_wanted = Signal()

    def __init__(self) -> None:
        super().__init__()
        role(self, "panel")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setFixedWidth(LIST_WIDTH)
        self.list = PhotographList()
        self.count = text("", "secondary")
        self.filter = ComboBox()
        self.filter.setAccessibleName("Photographs that are shown")
        for name, (words, *_) in FILTERS.items():
            self.filter.addItem(words, name)
        self.filter.activated.connect(lambda _place: self.list.show_only(self.filter.currentData()))
        self.list.filtered.connect(lambda name: self.filter.setCurrentIndex(self.filter.findData(name)))
        more = button("Open other photographs…", "link")
        more.clicked.connect(self.others_wanted)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, PADDING, 0, PADDING)
        column.setSpacing(2 * STEP)
        head, middle, foot = QHBoxLayout(), QHBoxLayout(), QHBoxLayout()
        for line in (head, middle, foot):
            line.setContentsMargins(PADDING, 0, PADDING, 0)
        head.addWidget(text("Photographs", "title"))
        head.addStretch(1)
        head.addWidget(self.count)
        middle.addWidget(self.filter)
        foot.addWidget(more)
        column.addLayout(head)
        column.addLayout(middle)
        column.addWidget(self.list, 1)
        column.addLayout(foot)

    def show_rows(self, rows: Sequence[Row]) -> None:
        """Show the photographs, how many there are and are in use, and how many each filter shows."""
        self.list.show_rows(rows)
        used = sum(not row.excluded for row in rows)
        self.count.setText(f"{len(rows)}" if used == len(rows) else f"{used} of {len(rows)}")
        for place, (words, _none, belongs) in enumerate(FILTERS.values()):
            number = sum(map(belongs, rows))
            self.filter.setItemText(place, f"{words} ({number})")


class _Delegate(QStyledItemDelegate):
    def sizeHint(self, _option: QStyleOptionViewItem, _index: Index) -> QSize:
        return QSize(120, ROW_HEIGHT)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        model = index.model()
        assert isinstance(model, PhotographModel)
        row = model.rows[index.row()]
        colours = theme.current()
        rect: QRect = option.rect
        selected = bool(option.state & QStyle.StateFlag.State_Selected)
        painter.save()
        if selected or option.state & QStyle.StateFlag.State_MouseOver:
            painter.fillRect(rect, QColor(colours.hover if selected else colours.field))
        if selected:
            painter.fillRect(QRect(rect.left(), rect.top(), 2, rect.height()), QColor(colours.accent))
        self._paint_thumbnail(painter, rect, model.thumbnails.get(row.name), row)
        self._paint_words(painter, rect, row)
        painter.restore()

    def _paint_thumbnail(self, painter: QPainter, rect: QRect, image: QImage | None, row: Row) -> None:
        frame = QRect(rect.left() + PADDING, rect.top() + 6, THUMBNAIL.width(), THUMBNAIL.height())
        painter.fillRect(frame, QColor(theme.current().canvas))
        if image is None:
            return
        painter.setOpacity(0.35 if row.excluded else 1.0)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        size = image.size().scaled(frame.size(), Qt.AspectRatioMode.KeepAspectRatio)
        place = QRect(frame.topLeft(), size)
        place.moveCenter(frame.center())
        painter.drawImage(place, image)
        painter.setOpacity(1.0)

    def _paint_words(self, painter: QPainter, rect: QRect, row: Row) -> None:
        colours = theme.current()
        left = rect.left() + PADDING + THUMBNAIL.width() + 10
        width = rect.right() - PADDING - 20 - left
        top = QRect(left, rect.top() + 7, width, 18)
        bottom = QRect(left, rect.top() + 26, width + 20, 18)
        painter.setFont(theme.font())
        painter.setPen(QColor(colours.disabled if row.excluded else colours.text))
        known = [each for each in (row.elevation_deg, row.azimuth_deg) if each is not None and not math.isnan(each)]
        angles = " / ".join(f"{format_fixed(each, 1)}°" for each in known)
        painter.drawText(top, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, angles)
        painter.setFont(theme.font(12))
        painter.setPen(QColor(colours.disabled if row.excluded else colours.secondary))
        name = painter.fontMetrics().elidedText(row.name, Qt.TextElideMode.ElideMiddle, bottom.width())
        painter.drawText(bottom, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, name)
        if row.done:
            image, look, _ = VERDICTS[row.verdict]
            mark = "exclude" if row.excluded else image
            colour = colours.disabled if row.excluded else getattr(colours, look)
            painter.drawPixmap(
                rect.right() - PADDING - 15,
                rect.top() + 8,
                icons.pixmap(mark, 16, colour, painter.device().devicePixelRatioF()),
            )

    def createEditor(self, parent: QWidget, _option: QStyleOptionViewItem, _index: Index) -> QWidget:
        editor = QLineEdit(parent)
        editor.setAccessibleName("Elevation / azimuth of the light in degrees")
        return editor

    def updateEditorGeometry(self, editor: QWidget, option: QStyleOptionViewItem, _index: Index) -> None:
        rect: QRect = option.rect
        editor.setGeometry(rect.left() + PADDING + THUMBNAIL.width() + 4, rect.top() + 2, 112, 24)
