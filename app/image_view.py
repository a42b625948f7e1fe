"""The big picture: fitted, or at any zoom under the pointer; dragged; 1 for 100 %, F or double-click to fit."""

from __future__ import annotations

import math

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from app import theme
from app.pictures import Picture

LARGEST_ZOOM = 64.0
CLOSE = 8.0
MARGIN = 12


class ImageView(QWidget):
    """Shows a `Picture`. `pointed(column, row)` follows the pointer, (−1, −1) when it leaves the picture."""

    pointed = Signal(int, int)
    picked = Signal(int, int)
    zoomed = Signal(float)

    def __init__(self) -> None:
        super().__init__()
        self.picture: Picture | None = None
        self.marks_visible = True
        self.probe: tuple[int, int] | None = None
        self.zoom = 1.0
        self.centre = QPointF()
        self.fitted = True
        self._size = (0, 0)
        self._grabbed: QPointF | None = None
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(160, 120)

    def sizeHint(self) -> QSize:
        return QSize(640, 480)

    def show_picture(self, picture: Picture | None) -> None:
        """Replace the picture; zoom and place stay where the size is that of the last one."""
        self.picture = picture
        if picture is not None:
            same, self._size = picture.size == self._size, picture.size
            if self.fitted or not same:
                self.fit()
        self.update()

    def show_marks(self, visible: bool) -> None:
        """Mark clipped texels or not."""
        self.marks_visible = visible
        self.update()

    def show_probe(self, place: tuple[int, int] | None) -> None:
        """Mark one texel (column, row)."""
        self.probe = place
        self.update()

    def fit(self) -> None:
        """The whole picture, as large as it fits, but not above 100 % of a small one's whole multiples."""
        self.fitted = True
        if self.picture is None:
            return
        width, height = self.picture.size
        room = min((self.width() - 2 * MARGIN) / width, (self.height() - 2 * MARGIN) / height)
        self._set_zoom(max(room, 1e-3), QPointF(width / 2, height / 2))

    def actual_size(self) -> None:
        """One pixel of the picture is one pixel of the screen."""
        self.fitted = False
        self._set_zoom(1.0 / self.devicePixelRatioF(), self.centre)

    def look_at(self, column: int, row: int) -> None:
        """Bring one texel to the middle, large enough to be seen."""
        self.fitted = False
        self._set_zoom(max(self.zoom, CLOSE), QPointF(column + 0.5, row + 0.5))

    def look_through(self, zoom: float, centre: QPointF) -> None:
        """Show `centre` in the middle at `zoom`, as another view does."""
        self.fitted = False
        self._set_zoom(zoom, centre)

    def _set_zoom(self, zoom: float, centre: QPointF) -> None:
        self.zoom, self.centre = zoom, centre
        self.zoomed.emit(zoom * self.devicePixelRatioF())
        self.update()

    def place_at(self, point: QPointF) -> QPointF:
        """The place of the picture under `point`; its upper left corner is (0, 0)."""
        return (point - QPointF(self.width() / 2, self.height() / 2)) / self.zoom + self.centre

    def texel_at(self, point: QPointF) -> tuple[int, int] | None:
        """(column, row) of the texel under `point`, None outside the picture."""
        if self.picture is None:
            return None
        place = self.place_at(point)
        column, row = math.floor(place.x()), math.floor(place.y())
        width, height = self.picture.size
        return (column, row) if 0 <= column < width and 0 <= row < height else None

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(theme.current().canvas))
        if self.picture is None:
            return
        size = QPointF(*self.picture.size)
        target = QRectF(self._to_screen(QPointF(0, 0)), self._to_screen(size))
        scale = self.zoom * self.devicePixelRatioF()
        level = min(len(self.picture.levels) - 1, max(0, math.floor(-math.log2(scale) + 1e-6)))
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, scale < 2.0)
        self._draw(painter, target, level)
        if self.probe is not None:
            self._draw_probe(painter)

    def _draw(self, painter: QPainter, target: QRectF, level: int) -> None:
        """Draw the visible part of a level, so that a large picture costs no more than the window."""
        assert self.picture is not None
        image = self.picture.levels[level]
        visible = target.intersected(QRectF(self.rect()))
        ratio_x, ratio_y = image.width() / target.width(), image.height() / target.height()
        source = QRectF(
            (visible.x() - target.x()) * ratio_x,
            (visible.y() - target.y()) * ratio_y,
            visible.width() * ratio_x,
            visible.height() * ratio_y,
        )
        painter.drawImage(visible, image, source)
        if self.marks_visible and self.picture.marks:
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, False)
            painter.drawImage(visible, self.picture.marks[level], source)

    def _draw_probe(self, painter: QPainter) -> None:
        assert self.probe is not None
        centre = self._to_screen(QPointF(self.probe[0] + 0.5, self.probe[1] + 0.5))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for colour, width in ((QColor(0, 0, 0, 160), 3.0), (QColor(255, 255, 255), 1.5)):
            painter.setPen(QPen(colour, width))
            painter.drawEllipse(centre, 6.0, 6.0)

    def _to_screen(self, place: QPointF) -> QPointF:
        return (place - self.centre) * self.zoom + QPointF(self.width() / 2, self.height() / 2)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self.fitted:
            self.fit()

    def wheelEvent(self, event: QWheelEvent) -> None:
        if self.picture is None:
            return
        factor = 2.0 ** (event.angleDelta().y() / 240.0)
        zoom = min(LARGEST_ZOOM, max(0.02, self.zoom * factor))
        under = self.place_at(event.position())
        self.fitted = False
        self._set_zoom(zoom, under + (self.centre - under) * (self.zoom / zoom))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self._grabbed = event.position()
        texel = self.texel_at(event.position())
        if texel is not None and event.button() == Qt.MouseButton.LeftButton:
            self.picked.emit(*texel)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._grabbed is not None:
            self.fitted = False
            self._set_zoom(self.zoom, self.centre - (event.position() - self._grabbed) / self.zoom)
            self._grabbed = event.position()
        self.pointed.emit(*(self.texel_at(event.position()) or (-1, -1)))

    def mouseReleaseEvent(self, _event: QMouseEvent) -> None:
        self._grabbed = None

    def mouseDoubleClickEvent(self, _event: QMouseEvent) -> None:
        self.fit()
