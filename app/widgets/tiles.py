"""Several views beside each other, of which one can fill the whole place."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QSize, Qt, Signal
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QSizePolicy, QToolButton, QVBoxLayout, QWidget

from app.widgets import theme
from app.widgets.panels import text
from app.widgets.theme import PADDING, STEP, role

#: Heights of the line above a view, in pixels: with words alone, and with a control.
HEAD, HEAD_WITH_CONTROL = 26, 34


class Tile(QWidget):
    """A view under a line with its name, a caption on the right, and the button that enlarges it."""

    enlarge_wanted = Signal()

    def __init__(self, title: str, view: QWidget, control: QWidget | None = None) -> None:
        """`control` stands in the line, before the button."""
        super().__init__()
        role(self, "panel")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.title = title
        self.head = QWidget()
        self.head.setFixedHeight(HEAD_WITH_CONTROL if control is not None else HEAD)
        self.head.setToolTip("Double-click to enlarge")
        self.head.installEventFilter(self)
        self.words = self.shorter = ""
        self.caption = text("", "secondary")
        self.caption.installEventFilter(self)
        self.caption.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.caption.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        row = QHBoxLayout(self.head)
        row.setContentsMargins(PADDING - 4, 0, STEP, 0)
        row.setSpacing(STEP)
        row.addWidget(text(title, "title"))
        row.addWidget(self.caption, 1)
        if control is not None:
            row.addWidget(control)
        self.enlarge = QToolButton(self.head)
        self.enlarge.setIconSize(QSize(theme.SMALL, theme.SMALL))
        self.enlarge.clicked.connect(self.enlarge_wanted)
        row.addWidget(self.enlarge)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.head)
        column.addWidget(view, 1)
        self.show_enlarged(False)

    def say(self, words: str, shorter: str = "") -> None:
        """Show `words` on the right of the title, or `shorter` where room lacks; in full where the mouse rests."""
        self.words, self.shorter = words, shorter
        self.caption.setToolTip(words)
        self._fit_words()

    def _fit_words(self) -> None:
        room, metrics = self.caption.width() - 2, self.caption.fontMetrics()
        words = self.words if metrics.horizontalAdvance(self.words) <= room else self.shorter or self.words
        self.caption.setText(metrics.elidedText(words, Qt.TextElideMode.ElideRight, room))

    def show_enlarged(self, enlarged: bool) -> None:
        """Set the icon and tooltip of the button that enlarges the tile or shrinks it again."""
        words = f"{self.title}: {'show all views' if enlarged else 'enlarge'}"
        self.enlarge.setIcon(theme.icon("shrink" if enlarged else "enlarge"))
        self.enlarge.setToolTip(f"{words} (Esc)" if enlarged else words)
        self.enlarge.setAccessibleName(words)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self.head and event.type() == QEvent.Type.MouseButtonDblClick:
            self.enlarge_wanted.emit()
            return True
        if watched is self.caption and event.type() == QEvent.Type.Resize:
            self._fit_words()
        return super().eventFilter(watched, event)


class Tiles(QWidget):
    """Tiles on a grid, each at (row, column, rows, columns)."""

    def __init__(self, places: dict[Tile, tuple[int, int, int, int]]) -> None:
        super().__init__()
        role(self, "gap")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.places = places
        self.large: Tile | None = None
        self.grid = QGridLayout(self)
        self.grid.setContentsMargins(0, 0, 0, 0)
        self.grid.setSpacing(1)
        for tile, place in places.items():
            self.grid.addWidget(tile, *place)
            tile.enlarge_wanted.connect(lambda tile=tile: self.enlarge(None if self.large is tile else tile))
        for column in range(self.grid.columnCount()):
            self.grid.setColumnStretch(column, 1)

    def enlarge(self, large: Tile | None) -> None:
        """Let one tile fill the place, or show all."""
        self.large = large
        whole = (0, 0, self.grid.rowCount(), self.grid.columnCount())
        for tile, place in self.places.items():
            self.grid.removeWidget(tile)
            self.grid.addWidget(tile, *(whole if tile is large else place))
            tile.setVisible(large in (None, tile))
            tile.show_enlarged(tile is large)
