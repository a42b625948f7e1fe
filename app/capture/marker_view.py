"""The big image with numbered markers: click to set one, drag it, or move it by the arrow keys.

While a marker is dragged, the corner away from it magnifies what lies under it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot

from PySide6.QtCore import QEvent, QLineF, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen

from app.widgets import theme
from app.widgets.image_view import Image, ImageView

Place = tuple[float, float]

REACH_PX, RING_PX, CLICK_PX = 12.0, 7.0, 4.0
LOUPE_PX, LOUPE_TEXELS = 144, 18.0

STEPS = {
    Qt.Key.Key_Left: (-1.0, 0.0),
    Qt.Key.Key_Right: (1.0, 0.0),
    Qt.Key.Key_Up: (0.0, -1.0),
    Qt.Key.Key_Down: (0.0, 1.0),
}


class MarkerView(ImageView):
    """Shows markers at places in pixels of the photograph (centres at integers).

    Signals
    -------
    placed(x, y) : a click beside all markers.
    moved(number, x, y, final) : a marker was dragged or moved by the arrow keys (Ctrl: by a tenth of a pixel, Shift:
        by ten); `final` ends the gesture.
    chosen(number) : a marker was clicked.
    """

    placed = Signal(float, float)
    moved = Signal(int, float, float, bool)
    chosen = Signal(int)

    def __init__(self, name: str) -> None:
        super().__init__()
        self.markers: tuple[Place, ...] = ()
        self.current: int | None = None
        self.pending: Place | None = None
        self._held: int | None = None
        self._offset = QPointF()
        self._pressed: QPointF | None = None
        self._dragged = False
        self._nudging = False
        self.setAccessibleName(name)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setCursor(Qt.CursorShape.CrossCursor)

    def show_image(self, image: Image | None) -> None:
        """Replace the image; without one, nothing is held any more."""
        if image is None:
            self._held = self._pressed = None
        super().show_image(image)

    def show_markers(self, markers: Sequence[Place], current: int | None, pending: Place | None = None) -> None:
        """Show numbered `markers`, of which number `current` is chosen, and one that waits for its counterpart."""
        self.markers, self.current, self.pending = tuple(markers), current, pending
        if self._held is not None and self._held >= len(self.markers):
            self._held = None
        self.update()

    def on_screen(self, place: Place) -> QPointF:
        """The screen position of a place of the photograph."""
        return self.to_screen(QPointF(place[0] + 0.5, place[1] + 0.5))

    def held(self, point: QPointF) -> Place:
        """The place of the photograph under `point`, held inside the image."""
        assert self.image is not None
        width, height = self.image.size
        place = self.place_at(point)
        return min(max(place.x() - 0.5, -0.5), width - 0.5), min(max(place.y() - 0.5, -0.5), height - 0.5)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        super().mousePressEvent(event)
        if self.image is None or event.button() != Qt.MouseButton.LeftButton:
            return
        self._pressed, self._dragged = event.position(), False
        offsets = [self.on_screen(marker) - event.position() for marker in self.markers]
        near = [number for number, offset in enumerate(offsets) if hypot(offset.x(), offset.y()) <= REACH_PX]
        if near:
            self._held = min(near, key=lambda number: hypot(offsets[number].x(), offsets[number].y()))
            self._offset = offsets[self._held]
            self.chosen.emit(self._held)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._pressed is not None:
            way = event.position() - self._pressed
            self._dragged = self._dragged or hypot(way.x(), way.y()) > CLICK_PX
            if not self._dragged:
                return
        if self._held is not None:
            self.moved.emit(self._held, *self.held(event.position() + self._offset), False)
        else:
            super().mouseMoveEvent(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        super().mouseReleaseEvent(event)
        held, self._held = self._held, None
        pressed, self._pressed = self._pressed, None
        if self.image is None or pressed is None:
            return
        if held is not None and self._dragged:
            self.moved.emit(held, *self.held(event.position() + self._offset), True)
        elif held is None and not self._dragged and self.texel_at(event.position()) is not None:
            self.placed.emit(*self.held(event.position()))
        self.update()

    def mouseDoubleClickEvent(self, _event: QMouseEvent) -> None:
        """The second click of two sets nothing, nor does it fit the image."""

    def event(self, event: QEvent) -> bool:
        """The arrow keys move the chosen marker, where there is one, before they mean anything else."""
        asks = event.type() == QEvent.Type.ShortcutOverride
        if asks and isinstance(event, QKeyEvent) and event.key() in STEPS and self.current is not None:
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = STEPS.get(Qt.Key(event.key()))
        if step is None or self.current is None or self.image is None or self.current >= len(self.markers):
            super().keyPressEvent(event)
            return
        modifiers = event.modifiers()
        fine, coarse = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
        by = 0.1 if modifiers & fine else 10.0 if modifiers & coarse else 1.0
        x, y = self.markers[self.current]
        width, height = self.image.size
        moved = min(max(x + by * step[0], -0.5), width - 0.5), min(max(y + by * step[1], -0.5), height - 0.5)
        self._nudging = True
        self.moved.emit(self.current, *moved, False)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        if self._nudging and not event.isAutoRepeat() and self.current is not None and self.current < len(self.markers):
            self._nudging = False
            self.moved.emit(self.current, *self.markers[self.current], True)
        super().keyReleaseEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.image is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        shown = [(self.on_screen(place), str(number + 1)) for number, place in enumerate(self.markers)]
        others = [one for number, one in enumerate(shown) if number != self.current]
        draw_markers(painter, [at for at, _ in others], [label for _, label in others], chosen=False)
        if self.current is not None and self.current < len(shown):
            draw_markers(painter, [shown[self.current][0]], [shown[self.current][1]], chosen=True)
        if self.pending is not None:
            draw_markers(painter, [self.on_screen(self.pending)], ["?"], chosen=True)
        if self._held is not None and self._dragged and self._held < len(self.markers):
            self._draw_loupe(painter, self.markers[self._held])
        if self.hasFocus():
            painter.setPen(QPen(QColor(theme.current().accent), 1.0))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5))

    def _draw_loupe(self, painter: QPainter, place: Place) -> None:
        """Magnify the surroundings of `place` in the corner farthest from it."""
        assert self.image is not None
        at = self.on_screen(place)
        right, low = at.x() < self.width() / 2, at.y() < self.height() / 2
        corner = QPointF(self.width() - LOUPE_PX - 12 if right else 12, self.height() - LOUPE_PX - 12 if low else 12)
        frame = QRectF(corner.x(), corner.y(), LOUPE_PX, LOUPE_PX)
        painter.fillRect(frame, QColor(theme.current().canvas))
        half = LOUPE_TEXELS / 2
        source = QRectF(place[0] + 0.5 - half, place[1] + 0.5 - half, LOUPE_TEXELS, LOUPE_TEXELS)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, False)
        inside = source.intersected(QRectF(self.image.levels[0].rect()))
        scale = LOUPE_PX / LOUPE_TEXELS
        target = QRectF(frame.topLeft() + (inside.topLeft() - source.topLeft()) * scale, inside.size() * scale)
        painter.drawImage(target, self.image.levels[0], inside)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(QColor(theme.current().line), 1.0))
        painter.drawRect(frame)
        draw_markers(painter, [frame.center()], chosen=True)


def draw_markers(painter: QPainter, places: Sequence[QPointF], labels: Sequence[str] = (), *, chosen: bool) -> None:
    """Rings with a gap in their middle, through which the texel is seen, and a label beside each.

    They are drawn in few calls, so that dozens follow the mouse.
    """
    colour = QColor(255, 255, 255) if chosen else QColor(theme.LINES[0])
    arms = [QPointF(x, y) for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    crosses = [QLineF(at + arm * 3.0, at + arm * (RING_PX + 3.0)) for at in places for arm in arms]
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for pen in (QPen(QColor(0, 0, 0, 190), 4.0 if chosen else 3.0), QPen(colour, 1.5)):
        painter.setPen(pen)
        painter.drawLines(crosses)
        for at in places:
            painter.drawEllipse(at, RING_PX, RING_PX)
    painter.setFont(theme.font(12, strong=True))
    for at, label in zip(places, labels, strict=bool(labels)):
        width = painter.fontMetrics().horizontalAdvance(label) + 8
        tag = QRectF(at.x() + RING_PX + 4, at.y() - RING_PX - 14, width, 17)
        painter.fillRect(tag, colour)
        painter.setPen(QColor("#101418"))
        painter.drawText(tag, Qt.AlignmentFlag.AlignCenter, label)
