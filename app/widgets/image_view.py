"""The big image: fitted, or at any zoom under the pointer; dragged; 1 for 100 %, F or double-click to fit.

Images for the screen, made off the window's thread: 8-bit levels of half size each, and marks on clipped texels.

A view draws the level nearest to its zoom, so that painting costs the pixels on the screen and not those of the
photograph. Work goes in bands of rows, so that memory stays small beside the photograph itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QAccessible,
    QColor,
    QImage,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from app.widgets import theme
from engine.core.colour import to_display8, tone_map
from engine.core.steps import Step, Steps

BAND_PIXELS = 2**19
SMALLEST = 512

#: By the channels of codes: how Qt reads them, and how it paints them fastest.
FORMATS = {
    3: (QImage.Format.Format_RGB888, QImage.Format.Format_RGB32),
    4: (QImage.Format.Format_RGBA8888, QImage.Format.Format_ARGB32_Premultiplied),
}

#: Premultiplied BGRA of a clipped texel: Okabe and Ito's vermillion, opaque.
CLIPPED = np.array([0, 94, 213, 255], np.uint8)


@dataclass(frozen=True, eq=False)
class Image:
    """Levels from full size downwards, each half of the one before; `marks` has the same sizes or is empty."""

    levels: tuple[QImage, ...]
    marks: tuple[QImage, ...] = ()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels of the full image."""
        return self.levels[0].width(), self.levels[0].height()

    @property
    def bytes(self) -> int:
        """The memory that the image takes."""
        return sum(image.sizeInBytes() for image in (*self.levels, *self.marks))


def photograph(
    radiance: NDArray[np.float32], saturated: NDArray[np.bool_] | None = None, exposure_ev: float = 0.0
) -> Steps[Image]:
    """The image of linear radiance (H, W, 3), sRGB-coded; clipped texels of (H, W) `saturated` are marked."""
    height, width = radiance.shape[:2]
    coded = np.empty((height, width, 3), np.uint8)
    rows = max(1, BAND_PIXELS // width)
    for start in range(0, height, rows):
        band = np.asarray(radiance[start : start + rows])
        coded[start : start + rows] = to_display8(tone_map(band, exposure_ev, "none"))
        yield Step(min(1.0, (start + rows) / height), "preparing the image")
    marks: tuple[QImage, ...] = ()
    if saturated is not None and saturated.any():
        marks = tuple(_mark_image(level) for level in _halve_marks(np.asarray(saturated, np.uint8)))
    return Image(pixels_image(coded).levels, marks)


def pixels_image(pixels: NDArray[np.uint8]) -> Image:
    """The image of (H, W, 3) codes as they are."""
    return Image(tuple(rgb_image(level) for level in _halve(pixels)))


def scalar_map(values: NDArray[np.float32], high: float, table: NDArray[np.uint8]) -> Steps[Image]:
    """The image of (H, W) values in [0, high] through a colour `table` (256, 3)."""
    yield Step(0.0, "preparing the map")
    return pixels_image(scalar_pixels(values, high, table))


def scalar_pixels(values: NDArray[np.float32], high: float, table: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(H, W, 3) colours of values (H, W) in [0, high] through a colour `table` (256, 3)."""
    index = np.clip(np.clip(np.nan_to_num(values), 0.0, high) * (255.0 / max(high, 1e-30)), 0, 255).astype(np.uint8)
    return np.asarray(table[index])


def rgb_image(pixels: NDArray[np.uint8]) -> QImage:
    """A QImage that owns a copy of (H, W, 3) uint8, or of (H, W, 4) with opacity."""
    height, width, channels = pixels.shape
    contiguous = np.ascontiguousarray(pixels)
    coded, painted = FORMATS[channels]
    return QImage(contiguous.data, width, height, channels * width, coded).convertToFormat(painted)


def paint_whole(widget: QWidget, image: QImage | None, words: str = "") -> None:
    """Paint an image as large as it fits into the middle of a widget, over the canvas, within its `paintEvent`; `words`
    where there is none."""
    painter = QPainter(widget)
    painter.fillRect(widget.rect(), QColor(theme.current().canvas))
    if image is None:
        _paint_words(painter, widget, words)
        return
    painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
    scale = min(widget.width() / image.width(), widget.height() / image.height())
    width, height = scale * image.width(), scale * image.height()
    painter.drawImage(QRectF((widget.width() - width) / 2, (widget.height() - height) / 2, width, height), image)


def _paint_words(painter: QPainter, widget: QWidget, words: str) -> None:
    painter.setPen(QColor(theme.current().secondary))
    painter.setFont(theme.font())
    within = widget.rect().adjusted(theme.PADDING, theme.PADDING, -theme.PADDING, -theme.PADDING)
    painter.drawText(within, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, words)


def _halve(pixels: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    import cv2

    levels = [pixels]
    while max(levels[-1].shape[:2]) > SMALLEST:
        height, width = levels[-1].shape[:2]
        size = (max(1, width // 2), max(1, height // 2))
        levels.append(np.asarray(cv2.resize(levels[-1], size, interpolation=cv2.INTER_AREA), np.uint8))
    return levels


def _halve_marks(mask: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    """A mark survives every halving, so that a single clipped texel is seen in the fitted image."""
    levels = [mask]
    while max(levels[-1].shape[:2]) > SMALLEST:
        height, width = (size // 2 * 2 for size in levels[-1].shape)
        even = levels[-1][: max(2, height), : max(2, width)]
        levels.append(even.reshape(height // 2, 2, width // 2, 2).max(axis=(1, 3)))
    return levels


def _mark_image(mask: NDArray[np.uint8]) -> QImage:
    pixels = np.ascontiguousarray(mask[:, :, None] * CLIPPED)
    height, width = mask.shape
    return QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_ARGB32_Premultiplied).copy()


LARGEST_ZOOM = 64.0
CLOSE = 8.0
MARGIN = 12


class ImageView(QWidget):
    """Shows an `Image`. `pointed(column, row)` follows the pointer, (−1, −1) when it leaves the image."""

    accessible_role = QAccessible.Role.Graphic

    pointed = Signal(int, int)
    picked = Signal(int, int)
    zoomed = Signal(float)

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName("Image")
        self.image: Image | None = None
        self.words = ""
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

    def show_image(self, image: Image | None) -> None:
        """Replace the image; zoom and place stay where the size is that of the last one."""
        self.image = image
        if image is not None:
            same, self._size = image.size == self._size, image.size
            if self.fitted or not same:
                self.fit()
        self.update()

    def say(self, words: str) -> None:
        """Show `words` where there is no image."""
        if words != self.words:
            self.words = words
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
        """The whole image, as large as it fits, but not above 100 % of a small one's whole multiples."""
        self.fitted = True
        if self.image is None:
            return
        width, height = self.image.size
        room = min((self.width() - 2 * MARGIN) / width, (self.height() - 2 * MARGIN) / height)
        self._set_zoom(max(room, 1e-3), QPointF(width / 2, height / 2))

    def actual_size(self) -> None:
        """One pixel of the image is one pixel of the screen."""
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
        """The place of the image under `point`; its upper left corner is (0, 0)."""
        return (point - QPointF(self.width() / 2, self.height() / 2)) / self.zoom + self.centre

    def texel_at(self, point: QPointF) -> tuple[int, int] | None:
        """(column, row) of the texel under `point`, None outside the image."""
        if self.image is None:
            return None
        place = self.place_at(point)
        column, row = math.floor(place.x()), math.floor(place.y())
        width, height = self.image.size
        return (column, row) if 0 <= column < width and 0 <= row < height else None

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(theme.current().canvas))
        if self.image is None:
            _paint_words(painter, self, self.words)
            return
        size = QPointF(*self.image.size)
        target = QRectF(self.to_screen(QPointF(0, 0)), self.to_screen(size))
        scale = self.zoom * self.devicePixelRatioF()
        level = min(len(self.image.levels) - 1, max(0, math.floor(-math.log2(scale) + 1e-6)))
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, scale < 2.0)
        self._draw(painter, target, level)
        if self.probe is not None:
            self._draw_probe(painter)

    def _draw(self, painter: QPainter, target: QRectF, level: int) -> None:
        """Draw the visible part of a level, so that a large image costs no more than the window."""
        assert self.image is not None
        image = self.image.levels[level]
        visible = target.intersected(QRectF(self.rect()))
        ratio_x, ratio_y = image.width() / target.width(), image.height() / target.height()
        source = QRectF(
            (visible.x() - target.x()) * ratio_x,
            (visible.y() - target.y()) * ratio_y,
            visible.width() * ratio_x,
            visible.height() * ratio_y,
        )
        painter.drawImage(visible, image, source)
        if self.marks_visible and self.image.marks:
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, False)
            painter.drawImage(visible, self.image.marks[level], source)

    def _draw_probe(self, painter: QPainter) -> None:
        assert self.probe is not None
        centre = self.to_screen(QPointF(self.probe[0] + 0.5, self.probe[1] + 0.5))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for colour, width in ((QColor(0, 0, 0, 160), 3.0), (QColor(255, 255, 255), 1.5)):
            painter.setPen(QPen(colour, width))
            painter.drawEllipse(centre, 6.0, 6.0)

    def to_screen(self, place: QPointF) -> QPointF:
        """The point of the widget over `place` of the image, whose upper left corner is (0, 0)."""
        return (place - self.centre) * self.zoom + QPointF(self.width() / 2, self.height() / 2)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self.fitted:
            self.fit()

    def wheelEvent(self, event: QWheelEvent) -> None:
        if self.image is None:
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
