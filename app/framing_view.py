"""The big picture with handles: four corners of what becomes the material, and a rectangle over a grey patch."""

from __future__ import annotations

from math import hypot

from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF

from app import theme
from app.image_view import ImageView

Place = tuple[float, float]
Corners = tuple[Place, Place, Place, Place]
Patch = tuple[int, int, int, int]

REACH_PX = 12.0
HANDLE_PX = 5.0


class FramingView(ImageView):
    """Shows corners in pixels of the photograph (centres at integers) and lets them be dragged.

    `corners_moved(corners, final)` follows a drag, `patch_drawn(patch)` a rectangle (left, top, width, height) that was
    drawn while `drawing_patch` is on.
    """

    corners_moved = Signal(object, bool)
    patch_drawn = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.corners: Corners | None = None
        self.upright = False
        self.patch: Patch | None = None
        self.drawing_patch = False
        self._held: int | None = None
        self._patch_from: QPointF | None = None

    def show_corners(self, corners: Corners | None, *, upright: bool = False) -> None:
        """Show four `corners`, or none; `upright` keeps them a rectangle while one is dragged."""
        self.corners, self.upright = corners, upright
        self.update()

    def show_patch(self, patch: Patch | None) -> None:
        """Show the rectangle of the grey patch."""
        self.patch = patch
        self.update()

    def draw_patch(self, drawing: bool) -> None:
        """Let the next drag draw the grey patch."""
        self.drawing_patch = drawing
        self.setCursor(Qt.CursorShape.CrossCursor if drawing else Qt.CursorShape.ArrowCursor)

    def handle(self, place: int) -> QPointF:
        """Where corner number `place` is on the screen."""
        assert self.corners is not None
        x, y = self.corners[place]
        return self._to_screen(QPointF(x + 0.5, y + 0.5))

    def _place(self, point: QPointF) -> QPointF:
        """The point of the picture under `point`, held inside it; its upper left corner is (0, 0)."""
        assert self.picture is not None
        width, height = self.picture.size
        place = self.place_at(point)
        return QPointF(min(max(place.x(), 0.0), width), min(max(place.y(), 0.0), height))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if self.picture is not None and event.button() == Qt.MouseButton.LeftButton:
            if self.drawing_patch:
                self._patch_from = self._place(event.position())
                return
            offsets = [self.handle(place) - event.position() for place in range(4 if self.corners else 0)]
            near = [place for place, offset in enumerate(offsets) if hypot(offset.x(), offset.y()) <= REACH_PX]
            if near:
                self._held = near[0]
                return
        super().mousePressEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._held is not None:
            place = self._place(event.position())
            self._move(self._held, place.x() - 0.5, place.y() - 0.5)
            self.corners_moved.emit(self.corners, False)
        elif self._patch_from is not None:
            area = QRectF(self._patch_from, self._place(event.position())).normalized()
            self.show_patch((int(area.x()), int(area.y()), max(1, int(area.width())), max(1, int(area.height()))))
        else:
            super().mouseMoveEvent(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if self._held is not None:
            self._held = None
            self.corners_moved.emit(self.corners, True)
        elif self._patch_from is not None:
            self._patch_from = None
            self.draw_patch(False)
            if self.patch is not None:
                self.patch_drawn.emit(self.patch)
        else:
            super().mouseReleaseEvent(event)

    def _move(self, held: int, x: float, y: float) -> None:
        """Move one corner; of an upright rectangle its two neighbours follow."""
        assert self.corners is not None
        moved = list(self.corners)
        moved[held] = (round(x) - 0.5, round(y) - 0.5) if self.upright else (x, y)
        if self.upright:
            across, along = (held ^ 1, 3 - held)
            moved[across] = (moved[across][0], moved[held][1])
            moved[along] = (moved[held][0], moved[along][1])
        if _clockwise(moved):
            self.show_corners((moved[0], moved[1], moved[2], moved[3]), upright=self.upright)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.picture is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for colour, width in ((QColor(0, 0, 0, 170), 3.5), (QColor(theme.current().accent), 1.5)):
            painter.setPen(QPen(colour, width))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            if self.corners:
                handles = [self.handle(place) for place in range(4)]
                painter.drawPolygon(QPolygonF(handles))
                for handle in handles:
                    painter.drawEllipse(handle, HANDLE_PX, HANDLE_PX)
            if self.patch is not None:
                left, top, across, along = self.patch
                start, end = QPointF(left, top), QPointF(left + across, top + along)
                painter.drawRect(QRectF(self._to_screen(start), self._to_screen(end)))


def _clockwise(corners: list[tuple[float, float]]) -> bool:
    """Whether the corners run clockwise on the screen around a figure without dents, of a pixel at least."""
    for place in range(4):
        (x0, y0), (x1, y1), (x2, y2) = (corners[(place + step) % 4] for step in range(3))
        if (x1 - x0) * (y2 - y1) - (y1 - y0) * (x2 - x1) < 1.0:
            return False
    return True
