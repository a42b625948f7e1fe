"""A loupe on the big image: its pixels at 100 % or larger, at a place that stays while photographs change.

It is dragged, or moved by the arrow keys while it has the focus (Ctrl: finer, Shift: farther); the wheel, + and −
magnify.
"""

from __future__ import annotations

import math

from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, QSize, QSizeF, Qt, Signal
from PySide6.QtGui import QAccessible, QColor, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QWheelEvent
from PySide6.QtWidgets import QWidget

from app.capture.marker_view import STEPS
from app.widgets import theme
from app.widgets.image_view import ImageView

SIDE_PX, MARGIN_PX = 240, 12
MAGNIFICATIONS = (1, 2, 4, 8)

#: Pixels of the photograph that an arrow key moves by: with Ctrl, alone, with Shift.
FINE, PLAIN, FAR = 1.0, 16.0, 128.0


class Loupe(QWidget):
    """Lies over `view` and magnifies the image in it around `place`. `closed` when a user closes it."""

    accessible_role = QAccessible.Role.Graphic

    closed = Signal()

    def __init__(self, view: ImageView) -> None:
        super().__init__(view)
        self.view = view
        self.place = QPointF()
        self.magnification = 1
        self._size = (0, 0)
        self._grabbed: QPointF | None = None
        self.setAccessibleName("Loupe")
        self.setToolTip("Drag it, or move it by the arrow keys; the wheel magnifies. Z or Esc closes it")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.hide()
        view.zoomed.connect(lambda _zoom: self._follow())

    def open(self) -> None:
        """Show it under the pointer, or where the pointer is beside the image, in its middle; there must be one.

        An image that is itself magnified is magnified further: the loupe never shows it smaller.
        """
        assert self.view.image is not None
        self._size = self.view.image.size
        pointer = QPointF(self.view.mapFromGlobal(self.view.cursor().pos()))
        is_over = self.view.underMouse() and self.view.texel_at(pointer) is not None
        width, height = self._size
        self.place = self.view.place_at(pointer) if is_over else QPointF(width / 2, height / 2)
        while self._scale <= self.view.zoom and self.magnification < MAGNIFICATIONS[-1]:
            self.magnify(1)
        self.show()
        self.raise_()
        self._follow()

    def move_to(self, place: QPointF) -> None:
        """Look at `place` of the image, held inside it."""
        width, height = self._size
        self.place = QPointF(min(max(place.x(), 0.0), width), min(max(place.y(), 0.0), height))
        self._follow()

    def magnify(self, by: int) -> None:
        """Show pixels larger (1) or smaller (-1)."""
        at = MAGNIFICATIONS.index(self.magnification) + by
        self.magnification = MAGNIFICATIONS[min(max(at, 0), len(MAGNIFICATIONS) - 1)]
        self.update()

    def _follow(self) -> None:
        """Lie over the place, within the view; in an image of another size it is the same share of it."""
        image = self.view.image
        if image is None:
            return
        if image.size != self._size and all(self._size):
            ratio = image.size[0] / self._size[0], image.size[1] / self._size[1]
            self.place = QPointF(self.place.x() * ratio[0], self.place.y() * ratio[1])
            self._size = image.size
        around = self.view.rect().adjusted(MARGIN_PX, MARGIN_PX, -MARGIN_PX, -MARGIN_PX)
        side = min(SIDE_PX, around.width(), around.height())
        middle = self.view.to_screen(self.place).toPoint()
        left = min(max(middle.x() - side // 2, around.left()), around.right() + 1 - side)
        top = min(max(middle.y() - side // 2, around.top()), around.bottom() + 1 - side)
        self.resize(QSize(side, side))
        self.move(QPoint(left, top))
        self.update()

    @property
    def _scale(self) -> float:
        """Width of a pixel of the photograph on the screen, in units of the window."""
        return self.magnification / self.devicePixelRatioF()

    def _point(self, event: QMouseEvent) -> None:
        """Let the read-out follow the pixel under the pointer."""
        at = self.place + (event.position() - QPointF(self.width() / 2, self.height() / 2)) / self._scale
        width, height = self._size
        column, row = math.floor(at.x()), math.floor(at.y())
        self.view.pointed.emit(*((column, row) if 0 <= column < width and 0 <= row < height else (-1, -1)))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self._grabbed = event.globalPosition()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._grabbed is None:
            self._point(event)
            return
        moved = event.globalPosition() - self._grabbed
        self._grabbed = event.globalPosition()
        self.move_to(self.place + moved / self.view.zoom)

    def mouseReleaseEvent(self, _event: QMouseEvent) -> None:
        self._grabbed = None

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """The second click of two is not a gesture of the image below."""
        event.accept()

    def wheelEvent(self, event: QWheelEvent) -> None:
        self.magnify(1 if event.angleDelta().y() > 0 else -1)
        event.accept()

    def event(self, event: QEvent) -> bool:
        """The arrow keys move the loupe while it has the focus, before they mean anything else."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and event.key() in STEPS:
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = STEPS.get(Qt.Key(event.key()))
        if step is not None:
            keys = event.modifiers()
            is_fine, is_far = keys & Qt.KeyboardModifier.ControlModifier, keys & Qt.KeyboardModifier.ShiftModifier
            by = FINE if is_fine else FAR if is_far else PLAIN
            self.move_to(self.place + QPointF(*step) * by)
        elif event.key() in (Qt.Key.Key_Plus, Qt.Key.Key_Minus):
            self.magnify(1 if event.key() == Qt.Key.Key_Plus else -1)
        elif event.key() == Qt.Key.Key_Escape:
            self.closed.emit()
        else:
            super().keyPressEvent(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter, colours = QPainter(self), theme.current()
        painter.fillRect(self.rect(), QColor(colours.canvas))
        image = self.view.image
        if image is not None:
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, False)
            across = QSizeF(self.size()) / self._scale
            corner = self.place - QPointF(across.width() / 2, across.height() / 2)
            source = QRectF(QPointF(math.floor(corner.x()), math.floor(corner.y())), across)
            inside = source.intersected(QRectF(image.levels[0].rect()))
            target = QRectF((inside.topLeft() - source.topLeft()) * self._scale, inside.size() * self._scale)
            marks = image.marks[:1] if self.view.marks_visible else ()
            for layer in (image.levels[0], *marks):
                painter.drawImage(target, layer, inside)
        self._paint_frame(painter)

    def _paint_frame(self, painter: QPainter) -> None:
        colours = theme.current()
        painter.setPen(QPen(QColor(colours.accent if self.hasFocus() else colours.secondary), 2.0))
        painter.drawRect(self.rect().adjusted(1, 1, -1, -1))
        painter.setFont(theme.font(12))
        words = f"{100 * self.magnification} %"
        tag = QRectF(2.0, self.height() - 22.0, painter.fontMetrics().horizontalAdvance(words) + 12.0, 20.0)
        painter.fillRect(tag, QColor(colours.panel))
        painter.setPen(QColor(colours.text))
        painter.drawText(tag, Qt.AlignmentFlag.AlignCenter, words)
