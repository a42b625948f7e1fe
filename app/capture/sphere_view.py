"""The big image with the outline of a mirror sphere, its middle, and the lamp's reflection, all to be dragged."""

from __future__ import annotations

from math import hypot
from typing import Literal

from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen

from app.capture.marker_view import CLICK_PX, REACH_PX, STEPS, draw_markers
from app.widgets import theme
from app.widgets.image_view import Image, ImageView

Spot = tuple[float, float]
Outline = tuple[float, float, float]

RIM_PX, HANDLE_PX, SMALLEST_PX = 8.0, 5.0, 3.0
#: Share of the view that an inspected sphere fills.
SHARE = 0.6


class SphereView(ImageView):
    """Shows an outline (column, row, radius) and a reflection, in pixels whose upper left corner is (0, 0).

    Signals
    -------
    outline_moved(outline, final) : it was dragged by its inside or its rim.
    highlight_moved(column, row, final) : the reflection was dragged, set by a click inside the outline, or moved by
        the arrow keys (Ctrl: by a tenth of a pixel, Shift: by ten).
    """

    outline_moved = Signal(object, bool)
    highlight_moved = Signal(float, float, bool)

    def __init__(self) -> None:
        super().__init__()
        self.outline: Outline | None = None
        self.highlight: Spot | None = None
        self.sure = True
        self._held: Literal["", "rim", "highlight", "inside"] = ""
        self._offset = QPointF()
        self._pressed = QPointF()
        self._dragged = False
        self._nudging = False
        self.setAccessibleName("Mirror sphere")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def show_image(self, image: Image | None) -> None:
        """Replace the image; without one, nothing is held any more."""
        if image is None:
            self._held = ""
        super().show_image(image)

    def show_sphere(self, outline: Outline | None, highlight: Spot | None, *, sure: bool) -> None:
        """Show the outline, dashed where it is not `sure`, and the reflection."""
        self.outline, self.highlight, self.sure = outline, highlight, sure
        self.update()

    def look_near(self, outline: Outline) -> None:
        """Show the sphere large, with its surroundings."""
        column, row, radius = outline
        self.look_through(SHARE * min(self.width(), self.height()) / (2.0 * radius), QPointF(column, row))

    def middle(self) -> QPointF:
        """The middle of the outline on the screen."""
        assert self.outline is not None
        return self.to_screen(QPointF(self.outline[0], self.outline[1]))

    def rim(self) -> QPointF:
        """The handle at the right of the outline on the screen."""
        assert self.outline is not None
        return self.middle() + QPointF(self.outline[2] * self.zoom, 0.0)

    def spot(self) -> QPointF:
        """The reflection on the screen."""
        assert self.highlight is not None
        return self.to_screen(QPointF(*self.highlight))

    def _under(self, point: QPointF) -> Literal["", "rim", "highlight", "inside"]:
        """The part that a drag from `point` would move."""
        if self.outline is None:
            return ""
        if self.highlight is not None and _apart(self.spot(), point) <= REACH_PX:
            return "highlight"
        from_middle, radius = _apart(self.middle(), point), self.outline[2] * self.zoom
        if abs(from_middle - radius) <= RIM_PX and from_middle > radius / 2:
            return "rim"
        return "inside" if from_middle < max(radius, REACH_PX) else ""

    def mousePressEvent(self, event: QMouseEvent) -> None:
        super().mousePressEvent(event)
        if self.image is None or event.button() != Qt.MouseButton.LeftButton:
            return
        self._held, self._pressed, self._dragged = self._under(event.position()), event.position(), False
        if self._held in ("inside", "highlight"):
            self._offset = (self.middle() if self._held == "inside" else self.spot()) - event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if not event.buttons():
            shapes = {"": Qt.CursorShape.ArrowCursor, "rim": Qt.CursorShape.SizeHorCursor}
            self.setCursor(shapes.get(self._under(event.position()), Qt.CursorShape.SizeAllCursor))
        self._dragged = self._dragged or _apart(event.position(), self._pressed) > CLICK_PX
        if not self._held:
            super().mouseMoveEvent(event)
        elif self._dragged:
            self._drag(event.position(), final=False)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        super().mouseReleaseEvent(event)
        held = self._held
        if self.image is not None and held == "inside" and not self._dragged:
            spot = self._clamp(self.place_at(event.position()))
            self.highlight_moved.emit(*spot, True)
        elif held and self._dragged:
            self._drag(event.position(), final=True)
        self._held = ""

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """The second click of two sets nothing; beside the sphere it fits the image."""
        if not self._under(event.position()):
            super().mouseDoubleClickEvent(event)

    def _drag(self, point: QPointF, *, final: bool) -> None:
        if self.outline is None:
            return
        column, row, radius = self.outline
        if self._held == "rim":
            away = self.place_at(point) - QPointF(column, row)
            self.outline_moved.emit((column, row, max(SMALLEST_PX, hypot(away.x(), away.y()))), final)
            return
        x, y = self._clamp(self.place_at(point + self._offset))
        if self._held == "inside":
            self.outline_moved.emit((x, y, radius), final)
        else:
            self.highlight_moved.emit(x, y, final)

    def _clamp(self, place: QPointF) -> Spot:
        assert self.image is not None
        width, height = self.image.size
        return min(max(place.x(), 0.0), float(width)), min(max(place.y(), 0.0), float(height))

    def event(self, event: QEvent) -> bool:
        """The arrow keys move the reflection before they mean anything else."""
        asks = event.type() == QEvent.Type.ShortcutOverride
        if asks and isinstance(event, QKeyEvent) and event.key() in STEPS and self.highlight is not None:
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = STEPS.get(Qt.Key(event.key()))
        if step is None or self.highlight is None or self.image is None:
            super().keyPressEvent(event)
            return
        modifiers = event.modifiers()
        fine, coarse = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
        by = 0.1 if modifiers & fine else 10.0 if modifiers & coarse else 1.0
        x, y = self.highlight
        self._nudging = True
        self.highlight_moved.emit(*self._clamp(QPointF(x + by * step[0], y + by * step[1])), False)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        if self._nudging and not event.isAutoRepeat() and self.highlight is not None:
            self._nudging = False
            self.highlight_moved.emit(*self.highlight, True)
        super().keyReleaseEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.image is None or self.outline is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        radius = self.outline[2] * self.zoom
        accent = QPen(QColor(theme.LINES[0]), 1.5, Qt.PenStyle.SolidLine if self.sure else Qt.PenStyle.DashLine)
        for pen in (QPen(QColor(0, 0, 0, 170), 3.5), accent):
            painter.setPen(pen)
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawEllipse(self.middle(), radius, radius)
        for handle in (self.middle(), self.rim()):
            painter.setPen(QPen(QColor(0, 0, 0, 170), 1.5))
            painter.setBrush(QColor(theme.LINES[0]))
            painter.drawEllipse(handle, HANDLE_PX, HANDLE_PX)
        if self.highlight is not None:
            draw_markers(painter, [self.spot()], chosen=True)


def _apart(one: QPointF, other: QPointF) -> float:
    return hypot(one.x() - other.x(), one.y() - other.y())
