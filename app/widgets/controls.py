"""Combo boxes and sliders, which the wheel leaves alone until a click has put the focus there.

Over a panel the wheel scrolls the panel: whoever scrolls means the panel, and not the control that passes below the
pointer. Number fields do the same (`app.widgets.number_field`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFocusEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QWheelEvent
from PySide6.QtWidgets import QComboBox, QSlider

from app.widgets import theme
from app.widgets.theme import ROW

if TYPE_CHECKING:  # `ClickFirst` stands before a widget of Qt, to whose methods its own go on
    from PySide6.QtWidgets import QWidget as _Control
else:
    _Control = object

TICKS = 1000
PARAMETER = 6


class ClickFirst(_Control):
    """A second nature of controls: the wheel is left to the panel until the control was clicked and has the focus."""

    clicked = False

    @property
    def takes_wheel(self) -> bool:
        """True after a click, as long as the focus stays or comes back by itself."""
        return self.clicked and self.hasFocus()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.clicked = True
        super().mousePressEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        moved = (Qt.FocusReason.MouseFocusReason, Qt.FocusReason.TabFocusReason, Qt.FocusReason.BacktabFocusReason)
        self.clicked = self.clicked and event.reason() not in moved
        super().focusOutEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        if self.takes_wheel:
            super().wheelEvent(event)
        else:
            event.ignore()


class ComboBox(ClickFirst, QComboBox):
    """A combo box that the wheel changes only after a click."""

    def __init__(self) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)


class Slider(ClickFirst, QSlider):
    """A horizontal slider that jumps to the click and asks for a reset on Ctrl+click; the wheel needs a click first."""

    reset = Signal()

    def __init__(self) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        self.setRange(0, TICKS)
        self.setSingleStep(TICKS // 100)
        self.setPageStep(TICKS // 10)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

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
        self.setSliderPosition(round(TICKS * (x - PARAMETER) / max(1, self.width() - 2 * PARAMETER)))

    def sizeHint(self) -> QSize:
        return QSize(80, ROW - 4)

    def minimumSizeHint(self) -> QSize:
        return QSize(28, ROW - 4)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colours, middle = theme.current(), self.height() / 2
        active = colours.accent if self.isEnabled() else colours.line
        left, right = float(PARAMETER), float(self.width() - PARAMETER)
        parameter = left + (right - left) * self.sliderPosition() / TICKS
        for start, end, colour in ((left, right, colours.line), (left, parameter, active)):
            painter.setPen(QPen(QColor(colour), 2))
            painter.drawLine(QPointF(start, middle), QPointF(end, middle))
        lit = self.hasFocus() or self.underMouse() or self.isSliderDown()
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(colours.disabled if not self.isEnabled() else colours.accent if lit else colours.text))
        painter.drawEllipse(QPointF(parameter, middle), PARAMETER, PARAMETER)
