"""A disk of directions from above, on which a light is dragged; dots are the lamps of the capture.

The middle is overhead, the rim the plane of the sample, azimuth 0° on the right and 90° on top as in the image.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from app.widgets import theme
from app.widgets.theme import PADDING

#: Radii of the light and of a lamp in pixels, and the step of an arrow key in the unit disk.
LIGHT, LAMP, KEY_STEP = 7.0, 2.5, 0.05

KEYS = {
    Qt.Key.Key_Left: (-1.0, 0.0),
    Qt.Key.Key_Right: (1.0, 0.0),
    Qt.Key.Key_Up: (0.0, 1.0),
    Qt.Key.Key_Down: (0.0, -1.0),
}


class LightPad(QWidget):
    """The disk; `moved(x, y)` follows the light, unit vectors seen from above."""

    moved = Signal(float, float)

    def __init__(self) -> None:
        super().__init__()
        self.place = (-0.5, 0.5)
        self.lamps: NDArray[np.float64] = np.zeros((0, 3))
        self.setMinimumSize(140, 140)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setCursor(Qt.CursorShape.CrossCursor)
        self.setAccessibleName("Direction of the light")
        self.setToolTip("Drag the light, or move it with the arrow keys")

    def sizeHint(self) -> QSize:
        return QSize(220, 220)

    @property
    def direction(self) -> NDArray[np.float64]:
        """(3,) unit vector towards the light: x to the right of the image, y up, z towards the camera."""
        x, y = self.place
        return np.array([x, y, math.sqrt(max(1.0 - x * x - y * y, 0.0))])

    def show_lamps(self, lamps: NDArray[np.float64]) -> None:
        """Show the lamps (N, 3), unit vectors."""
        self.lamps = lamps
        self.update()

    def move_to(self, x: float, y: float) -> None:
        """Put the light at (x, y), or where the line to it leaves the disk."""
        beyond = max(math.hypot(x, y), 1.0)
        self.place = (x / beyond, y / beyond)
        self.update()
        self.moved.emit(*self.place)

    @property
    def _middle(self) -> QPointF:
        return QPointF(0.5 * self.width(), 0.5 * self.height())

    @property
    def _radius(self) -> float:
        return 0.5 * min(self.width(), self.height()) - PADDING

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.buttons() & Qt.MouseButton.LeftButton:
            apart = (event.position() - self._middle) / self._radius
            self.move_to(apart.x(), -apart.y())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self.mousePressEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = KEYS.get(Qt.Key(event.key()))
        if step is None:
            super().keyPressEvent(event)
            return
        self.move_to(self.place[0] + KEY_STEP * step[0], self.place[1] + KEY_STEP * step[1])

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter, colours = QPainter(self), theme.current()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle, radius = self._middle, self._radius
        painter.setBrush(QColor(colours.field))
        painter.setPen(QPen(QColor(colours.accent if self.hasFocus() else colours.disabled), 1.0))
        painter.drawEllipse(middle, radius, radius)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(QColor(colours.disabled), 1.0))
        for elevation_deg in (30.0, 60.0):
            ring = radius * math.cos(math.radians(elevation_deg))
            painter.drawEllipse(middle, ring, ring)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(colours.secondary))
        for x, y, _ in self.lamps:
            painter.drawEllipse(middle + QPointF(x, -y) * radius, LAMP, LAMP)
        painter.setBrush(QColor(colours.accent))
        painter.setPen(QPen(QColor(colours.text), 1.5))
        painter.drawEllipse(middle + QPointF(self.place[0], -self.place[1]) * radius, LIGHT, LIGHT)
