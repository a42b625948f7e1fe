"""The first hints: six places of the window, one after the other, each with a sentence on what it is for.

Everything but the place is dimmed. Enter or Right goes on, Left goes back, Esc ends it; nothing moves by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, QPoint, QRect, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QKeyEvent, QPainter, QPainterPath, QPaintEvent
from PySide6.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from app.view.tab import ViewTab
from app.widgets.panels import button, text
from app.widgets.theme import PADDING, STEP, role

#: Width of the words, room around a place, and the darkness of what lies around it.
WORDS_PX, AROUND_PX, DIMMED = 320, 4, 150


@dataclass(frozen=True)
class Hint:
    """A place of the window, a heading and a sentence; `workspace` is brought to the front before."""

    workspace: str
    place: Callable[[], QWidget]
    heading: str
    words: str


class Tour(QWidget):
    """Lies over `window`. `workspace_wanted` before each hint, `ended` at the end."""

    workspace_wanted = Signal(str)
    ended = Signal()

    def __init__(self, window: QWidget, hints: Sequence[Hint]) -> None:
        super().__init__(window)
        self.hints, self.at = tuple(hints), 0
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("First hints")
        self.card = role(QWidget(self), "panel")
        self.card.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.card.setFixedWidth(WORDS_PX)
        self.heading, self.words, self.count = text("", "title"), text("", wrap=True), text("", "secondary")
        self.back, self.next, self.skip = button("Back"), button("Next", "primary"), button("End", "link")
        self.back.clicked.connect(lambda: self.show_hint(self.at - 1))
        self.next.clicked.connect(lambda: self.show_hint(self.at + 1))
        self.skip.clicked.connect(self.end)
        foot = QHBoxLayout()
        foot.setSpacing(2 * STEP)
        for widget in (self.count, self.skip):
            foot.addWidget(widget)
        foot.addStretch(1)
        for widget in (self.back, self.next):
            foot.addWidget(widget)
        column = QVBoxLayout(self.card)
        column.setContentsMargins(PADDING, PADDING, PADDING, PADDING)
        column.setSpacing(2 * STEP)
        for widget in (self.heading, self.words):
            column.addWidget(widget)
        column.addLayout(foot)
        window.installEventFilter(self)

    def begin(self) -> None:
        """Show the first hint."""
        self.show()
        self.raise_()
        self.show_hint(0)

    def show_hint(self, at: int) -> None:
        """Show hint number `at`; after the last one it is over."""
        if not 0 <= at < len(self.hints):
            self.end()
            return
        self.at, hint = at, self.hints[at]
        self.workspace_wanted.emit(hint.workspace)
        self.heading.setText(hint.heading)
        self.words.setText(hint.words)
        self.count.setText(f"{at + 1} of {len(self.hints)}")
        self.setAccessibleDescription(f"{hint.heading}. {hint.words}")
        self.back.setEnabled(at > 0)
        self.next.setText("Next" if at + 1 < len(self.hints) else "Begin")
        self._lay_out()
        QTimer.singleShot(0, self, lambda: self._lay_out())  # a workspace that was not seen before has its size then
        self.raise_()
        self.next.setFocus()

    def end(self) -> None:
        """Leave the window as it is."""
        self.hide()
        self.ended.emit()
        self.deleteLater()

    @property
    def place(self) -> QRect:
        """The place of the hint within the window."""
        widget, window = self.hints[self.at].place(), self.parentWidget()
        assert window is not None
        seen = QRect(widget.mapTo(window, QPoint()), widget.size())
        return seen.adjusted(-AROUND_PX, -AROUND_PX, AROUND_PX, AROUND_PX) & window.rect()

    def _lay_out(self) -> None:
        """Cover the window, with the words below, above or beside the place, or low in it where there is no room."""
        window = self.parentWidget()
        assert window is not None
        self.setGeometry(window.rect())
        height = self.card.layout().totalHeightForWidth(WORDS_PX)  # type: ignore[union-attr]
        self.card.setFixedHeight(max(height, self.card.sizeHint().height()))
        place, card, room = self.place, self.card.rect(), self.rect().adjusted(PADDING, PADDING, -PADDING, -PADDING)
        corners = (
            QPoint(place.left(), place.bottom() + PADDING),
            QPoint(place.left(), place.top() - PADDING - card.height()),
            QPoint(place.right() + PADDING, place.top()),
            QPoint(place.left() - PADDING - card.width(), place.top()),
        )
        below_words = QPoint(place.center().x() - card.center().x(), place.bottom() - PADDING - card.height())
        shifted = (_within(QRect(corner, card.size()), room) for corner in corners)
        free = [each for each in shifted if not each.intersects(place)]
        self.card.move((free or [_within(QRect(below_words, card.size()), room)])[0].topLeft())
        self.update()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self.parentWidget() and event.type() == QEvent.Type.Resize and self.isVisible():
            self._lay_out()
        return super().eventFilter(watched, event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        steps = {Qt.Key.Key_Right: 1, Qt.Key.Key_Return: 1, Qt.Key.Key_Enter: 1, Qt.Key.Key_Left: -1}
        if event.key() == Qt.Key.Key_Escape:
            self.end()
        elif event.key() in steps:
            self.show_hint(max(0, self.at + steps[Qt.Key(event.key())]))
        else:
            super().keyPressEvent(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        dimmed, place = QPainterPath(), QPainterPath()
        dimmed.addRect(self.rect())
        place.addRoundedRect(self.place, STEP, STEP)
        painter.fillPath(dimmed.subtracted(place), QColor(0, 0, 0, DIMMED))


def _within(rect: QRect, room: QRect) -> QRect:
    """`rect`, moved into `room`."""
    left = max(room.left(), min(rect.left(), room.right() - rect.width()))
    top = max(room.top(), min(rect.top(), room.bottom() - rect.height()))
    return QRect(QPoint(left, top), rect.size())


def first_hints(bar: QWidget, workspaces: Mapping[str, QWidget]) -> tuple[Hint, ...]:
    """The hints of a first start, along the work; `bar` holds the buttons of the workspaces."""
    view = workspaces["view"]
    assert isinstance(view, ViewTab)
    return (
        Hint("capture", lambda: bar, "From left to right", "The buttons at the top follow the work. Ctrl+1 to Ctrl+6."),
        Hint(
            "capture",
            lambda: workspaces["capture"],
            "Begin with photographs",
            "Drop a folder of photographs of a flat sample under a moving lamp here, or try the sample capture.",
        ),
        Hint(
            "material",
            lambda: workspaces["material"],
            "The material",
            "The photographs become slices of even brightness. The error map shows where the compression loses detail.",
        ),
        Hint(
            "view",
            lambda: view.viewport,
            "On a model, under light",
            "Drag rotates, the wheel zooms, Ctrl+drag moves the light. The reference refines while nothing moves.",
        ),
        Hint(
            "view",
            lambda: view.mode,
            "Modes",
            "Each mode trades accuracy for time. Help > Which mode when shows what was measured on your machine.",
        ),
        Hint(
            "export",
            lambda: workspaces["export"],
            "Hand it on",
            "The material as files for other programs. F1 explains the panel under the pointer, everywhere.",
        ),
    )
