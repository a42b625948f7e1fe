"""The welcome tour: six parts of the window, one after the other, each with a sentence on what it is for.

A frame goes around the part, and a card stands beside it. Nothing is dimmed or blocked, so that a user can
try what a hint says while it stands there. With the focus on the card, Enter or Right goes on and Left goes back; Esc
ends it wherever the focus is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, QPoint, QRect, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QKeyEvent, QKeySequence, QPainter, QPaintEvent, QPen, QShortcut
from PySide6.QtWidgets import QAbstractButton, QComboBox, QHBoxLayout, QLabel, QLineEdit, QVBoxLayout, QWidget

from app.view.tab import ViewTab
from app.widgets import theme
from app.widgets.panels import button, text
from app.widgets.theme import PADDING, STEP, role

#: Width of the card: that of a panel less its margins. Room around the part, and the line of the frame, in pixels.
CARD_PX, AROUND_PX, LINE_PX = 272, 3, 2


@dataclass(frozen=True)
class Hint:
    """A part of the window, a heading and a sentence; `workspace` is brought to the front before."""

    workspace: str
    place: Callable[[], QWidget]
    heading: str
    words: str


class Tour(QWidget):
    """The card, over `window`. `workspace_wanted` before each hint, `ended` at the end."""

    workspace_wanted = Signal(str)
    ended = Signal()

    def __init__(self, window: QWidget, hints: Sequence[Hint]) -> None:
        super().__init__(window)
        self.hints, self.at = tuple(hints), 0
        self.watched: QObject | None = None
        self.frame = Frame(window)
        role(self, "card")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Welcome tour")
        self.setFixedWidth(CARD_PX)
        self.heading, self.words, self.count = text("", "title"), text("", wrap=True), text("", "secondary")
        self.back, self.next, self.skip = button("Previous"), button("Next", "primary"), button("End", "link")
        self.back.clicked.connect(lambda: self.show_hint(self.at - 1))
        self.next.clicked.connect(lambda: self.show_hint(self.at + 1))
        self.skip.clicked.connect(self.end)
        QShortcut(QKeySequence(Qt.Key.Key_Escape), self, context=Qt.ShortcutContext.WindowShortcut).activated.connect(
            self.end
        )
        foot = QHBoxLayout()
        foot.setSpacing(2 * STEP)
        for widget in (self.count, self.skip):
            foot.addWidget(widget)
        foot.addStretch(1)
        for widget in (self.back, self.next):
            foot.addWidget(widget)
        column = QVBoxLayout(self)
        column.setContentsMargins(PADDING, PADDING, PADDING, PADDING)
        column.setSpacing(2 * STEP)
        for widget in (self.heading, self.words):
            column.addWidget(widget)
        column.addLayout(foot)
        window.installEventFilter(self)

    def begin(self) -> None:
        """Show the first hint."""
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
        self.next.setText("Next" if at + 1 < len(self.hints) else "Done")
        self._watch(hint.place())
        self._show(True)
        self._lay_out()
        self.next.setFocus()

    def _show(self, is_seen: bool) -> None:
        """Show the hint, or let it wait while the part that it describes is out of sight."""
        self.frame.setVisible(is_seen)
        self.setVisible(is_seen)

    def _watch(self, part: QWidget) -> None:
        """Follow `part` where it moves or takes another size, as with docks that come up beside it."""
        if self.watched is not None:
            self.watched.removeEventFilter(self)
        self.watched = part
        part.installEventFilter(self)

    def end(self) -> None:
        """Leave the window as it is."""
        self.hide()
        self.frame.hide()
        self.ended.emit()
        self.frame.deleteLater()
        self.deleteLater()

    @property
    def place(self) -> QRect:
        """The part of the window that the hint describes, within the window."""
        widget, window = self.hints[self.at].place(), self.parentWidget()
        assert window is not None
        seen = QRect(widget.mapTo(window, QPoint()), widget.size())
        return seen.adjusted(-AROUND_PX, -AROUND_PX, AROUND_PX, AROUND_PX) & window.rect()

    def _lay_out(self) -> None:
        """Frame the part, and put the card beside it: where it covers least of it, and then least that can be read."""
        window = self.parentWidget()
        assert window is not None
        self.frame.surround(self.place)
        height = self.layout().totalHeightForWidth(CARD_PX)  # type: ignore[union-attr]
        self.setFixedHeight(max(height, self.sizeHint().height()))
        place, card, room = self.place, self.rect(), window.rect().adjusted(PADDING, PADDING, -PADDING, -PADDING)
        across = (place.left(), place.center().x() - card.width() // 2, place.right() - card.width())
        down = (place.top(), place.center().y() - card.height() // 2, place.bottom() - card.height())
        corners = [
            *(QPoint(x, y) for y in (place.bottom() + PADDING, place.top() - PADDING - card.height()) for x in across),
            *(QPoint(x, y) for x in (place.right() + PADDING, place.left() - PADDING - card.width()) for y in down),
        ]
        shifted = [_within(QRect(corner, card.size()), room) for corner in corners]
        read = self._readable()
        self.move(min(shifted, key=lambda at: (_area(at & place), sum(_area(at & each) for each in read))).topLeft())
        self.frame.raise_()
        self.raise_()

    def _readable(self) -> list[QRect]:
        """Where words and controls of the window stand."""
        window = self.parentWidget()
        assert window is not None
        found = [each for kind in (QLabel, QAbstractButton, QLineEdit, QComboBox) for each in window.findChildren(kind)]
        return [
            QRect(each.mapTo(window, QPoint()), each.size())
            for each in found
            if each.isVisible() and not self.isAncestorOf(each) and window.isAncestorOf(each)
        ]

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self.watched and event.type() in (QEvent.Type.Show, QEvent.Type.Hide):
            self._show(event.type() == QEvent.Type.Show)
        if event.type() in (QEvent.Type.Resize, QEvent.Type.Move, QEvent.Type.Show) and self.isVisible():
            QTimer.singleShot(0, self, self._lay_out)
        return super().eventFilter(watched, event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        steps = {Qt.Key.Key_Right: 1, Qt.Key.Key_Return: 1, Qt.Key.Key_Enter: 1, Qt.Key.Key_Left: -1}
        if event.key() in steps:
            self.show_hint(max(0, self.at + steps[Qt.Key(event.key())]))
        else:
            super().keyPressEvent(event)


class Frame(QWidget):
    """A line around a part of `window`, through which the mouse reaches what lies below."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)

    def surround(self, place: QRect) -> None:
        """Lie over `place` of the window."""
        self.setGeometry(place)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(theme.current().accent), LINE_PX))
        painter.drawRoundedRect(self.rect().adjusted(1, 1, -1, -1), STEP, STEP)


def _area(rect: QRect) -> int:
    return max(0, rect.width()) * max(0, rect.height())


def _within(rect: QRect, room: QRect) -> QRect:
    """`rect`, moved into `room`."""
    left = max(room.left(), min(rect.left(), room.right() - rect.width()))
    top = max(room.top(), min(rect.top(), room.bottom() - rect.height()))
    return QRect(QPoint(left, top), rect.size())


def first_hints(view: ViewTab, status: QWidget, export: QWidget) -> tuple[Hint, ...]:
    """The hints on a material in the View workspace; `export` is the button of the Export workspace."""
    return (
        Hint(
            "view",
            lambda: view.viewport,
            "The material on a model",
            "Drag rotates, the wheel zooms, Ctrl+drag moves the light. Try it now: the tour waits.",
        ),
        Hint("view", lambda: view.model, "The model", "Built-in models, or a mesh of your own: File > Open files."),
        Hint("view", lambda: view.lights, "The light", "Direction and strength of the light, more lights, or an HDR."),
        Hint(
            "view",
            lambda: view.mode,
            "Modes",
            "Each mode trades accuracy for time. Help > Which mode when shows what was measured on your machine.",
        ),
        Hint(
            "view",
            lambda: status,
            "The error is always stated",
            "What is on screen is compared with a reference in the background; its error is shown here.",
        ),
        Hint(
            "view",
            lambda: export,
            "Hand it on",
            "Capture to Export follow the work. Export writes the material for other programs. F1 explains each panel.",
        ),
    )
