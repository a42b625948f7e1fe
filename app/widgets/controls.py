"""Combo boxes and sliders, which the wheel leaves alone until a click has put the focus there.

Over a panel the wheel scrolls the panel: whoever scrolls means the panel, and not the control that passes below the
pointer. Number fields do the same (`app.widgets.number_field`).
"""

from __future__ import annotations

from PySide6.QtCore import QPointF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFocusEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QWheelEvent
from PySide6.QtWidgets import QComboBox, QSlider

from app.widgets import theme
from app.widgets.theme import ROW

TICKS = 1000
KNOB = 6


class ComboBox(QComboBox):
    """A combo box that ignores the wheel, so that the panel below scrolls, unless it was clicked and has the focus."""

    def __init__(self) -> None:
        super().__init__()
        self.clicked = False
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.clicked = True
        super().mousePressEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        self.clicked = self.clicked and keeps_focus(event)
        super().focusOutEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        if self.clicked and self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()


class Slider(QSlider):
    """A horizontal slider that jumps to the click and asks for a reset on Ctrl+click; the wheel needs a click first."""

    reset = Signal()

    def __init__(self) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        self.setRange(0, TICKS)
        self.setSingleStep(TICKS // 100)
        self.setPageStep(TICKS // 10)
        self.clicked = False
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        self.clicked = self.clicked and keeps_focus(event)
        super().focusOutEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        if self.clicked and self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.clicked = True
        if event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            self.reset.emit()
            return
        self.setSliderDown(True)
        self._go_to(event.position().x())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self.isSliderDown():
            self._go_to(event.position().x())

    def mouseReleaseEvent(self, _event: QMouseEvent) -> None:
        self.setSliderDown(False)

    def _go_to(self, x: float) -> None:
        self.setSliderPosition(round(TICKS * (x - KNOB) / max(1, self.width() - 2 * KNOB)))

    def sizeHint(self) -> QSize:
        return QSize(80, ROW - 4)

    def minimumSizeHint(self) -> QSize:
        return QSize(36, ROW - 4)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colours, middle = theme.current(), self.height() / 2
        active = colours.accent if self.isEnabled() else colours.line
        left, right = float(KNOB), float(self.width() - KNOB)
        knob = left + (right - left) * self.sliderPosition() / TICKS
        for start, end, colour in ((left, right, colours.line), (left, knob, active)):
            painter.setPen(QPen(QColor(colour), 2))
            painter.drawLine(QPointF(start, middle), QPointF(end, middle))
        lit = self.hasFocus() or self.underMouse() or self.isSliderDown()
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(colours.disabled if not self.isEnabled() else colours.accent if lit else colours.text))
        painter.drawEllipse(QPointF(knob, middle), KNOB, KNOB)


def keeps_focus(event: QFocusEvent) -> bool:
    """True where the focus comes back by itself, from a menu of the control's own or another window."""
    moved = (Qt.FocusReason.MouseFocusReason, Qt.FocusReason.TabFocusReason, Qt.FocusReason.BacktabFocusReason)
    return event.reason() not in moved
