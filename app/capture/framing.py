"""The framing, the part of the photographs that becomes the image: its start, and the size that its corners give.

It is shown as the big image with handles for the four corners, and for a rectangle over a grey patch.
"""

from __future__ import annotations

from math import hypot
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF

from app.capture.import_panel import is_upright
from app.widgets import theme
from app.widgets.image_view import ImageView
from engine.capture.object_outline import simplify_outline
from engine.capture.registration.framing import Framing, estimate_aspect
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from engine.capture.registration.framing import Framing

Place = tuple[float, float]
Corners = tuple[Place, Place, Place, Place]
Patch = tuple[int, int, int, int]
Ends = tuple[float, float, float, float]

REACH_PX = 12.0
HANDLE_PX = 5.0

#: Length of a line in pixels of the photograph from which it tells a scale.
SHORTEST_PX = 2.0


class FramingView(ImageView):
    """Shows corners in pixels of the photograph (centres at integers) and lets them be dragged.

    `corners_moved(corners, final)` follows a drag, `patch_drawn(patch)` a rectangle (left, top, width, height) that was
    drawn while `drawing_patch` is on, `length_drawn(ends)` a line (x, y, x, y) while `drawing_length` is, or one of
    whose ends was dragged, and `outline_drawn(outline)` the path of a drag while `drawing_outline` is.
    """

    corners_moved = Signal(object, bool)
    patch_drawn = Signal(object)
    length_drawn = Signal(object)
    outline_drawn = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.corners: Corners | None = None
        self.upright = False
        self.patch: Patch | None = None
        self.drawing_patch = False
        self._held: int | None = None
        self._patch_from: QPointF | None = None
        self.length: Ends | None = None
        self.drawing_length = False
        self._end_held: int | None = None
        self.outline: tuple[Place, ...] = ()
        self.drawing_outline = False
        self._path: list[Place] | None = None

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

    def show_length(self, ends: Ends | None) -> None:
        """Show the line of a known length."""
        self.length = ends
        self.update()

    def draw_length(self, drawing: bool) -> None:
        """Let the next drag draw the line of a known length."""
        self.drawing_length = drawing
        self.setCursor(Qt.CursorShape.CrossCursor if drawing else Qt.CursorShape.ArrowCursor)

    def show_outline(self, points: tuple[Place, ...]) -> None:
        """Show the outline of the object."""
        self.outline = points
        self.update()

    def draw_outline(self, drawing: bool) -> None:
        """Let the next drag draw around the object."""
        self.drawing_outline = drawing
        self.setCursor(Qt.CursorShape.CrossCursor if drawing else Qt.CursorShape.ArrowCursor)

    def end(self, place: int) -> QPointF:
        """The position of an end of the line on the screen, 0 or 1."""
        assert self.length is not None
        x, y = self.length[2 * place : 2 * place + 2]
        return self.to_screen(QPointF(x + 0.5, y + 0.5))

    def _move_end(self, place: int, point: QPointF) -> None:
        assert self.length is not None
        at = self._place(point)
        ends = list(self.length)
        ends[2 * place : 2 * place + 2] = at.x() - 0.5, at.y() - 0.5
        self.show_length((ends[0], ends[1], ends[2], ends[3]))

    def handle(self, place: int) -> QPointF:
        """The position of corner number `place` on the screen."""
        assert self.corners is not None
        x, y = self.corners[place]
        return self.to_screen(QPointF(x + 0.5, y + 0.5))

    def _place(self, point: QPointF) -> QPointF:
        """The point of the image under `point`, held inside it; its upper left corner is (0, 0)."""
        assert self.image is not None
        width, height = self.image.size
        place = self.place_at(point)
        return QPointF(min(max(place.x(), 0.0), width), min(max(place.y(), 0.0), height))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if self.image is not None and event.button() == Qt.MouseButton.LeftButton:
            if self.drawing_patch:
                self._patch_from = self._place(event.position())
                return
            if self.drawing_outline:
                self._path = []
                self._draw_on(event.position())
                return
            if self.drawing_length:
                at = self._place(event.position())
                self.show_length((at.x() - 0.5, at.y() - 0.5, at.x() - 0.5, at.y() - 0.5))
                self._end_held = 1
                return
            if self.length is not None:
                apart = [self.end(place) - event.position() for place in (0, 1)]
                near_end = [place for place, each in enumerate(apart) if hypot(each.x(), each.y()) <= REACH_PX]
                if near_end:
                    self._end_held = near_end[0]
                    return
            offsets = [self.handle(place) - event.position() for place in range(4 if self.corners else 0)]
            near = [place for place, offset in enumerate(offsets) if hypot(offset.x(), offset.y()) <= REACH_PX]
            if near:
                self._held = near[0]
                return
        super().mousePressEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._path is not None:
            self._draw_on(event.position())
        elif self._end_held is not None:
            self._move_end(self._end_held, event.position())
        elif self._held is not None:
            place = self._place(event.position())
            self._move(self._held, place.x() - 0.5, place.y() - 0.5)
            self.corners_moved.emit(self.corners, False)
        elif self._patch_from is not None:
            area = QRectF(self._patch_from, self._place(event.position())).normalized()
            self.show_patch((int(area.x()), int(area.y()), max(1, int(area.width())), max(1, int(area.height()))))
        else:
            super().mouseMoveEvent(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if self._path is not None:
            outline, self._path = simplify_outline(self._path), None
            self.draw_outline(False)
            self.show_outline(() if outline is None else outline.points)
            if outline is not None:
                self.outline_drawn.emit(outline)
        elif self._end_held is not None:
            self._end_held = None
            self.draw_length(False)
            assert self.length is not None
            if hypot(self.length[2] - self.length[0], self.length[3] - self.length[1]) > SHORTEST_PX:
                self.length_drawn.emit(self.length)
        elif self._held is not None:
            self._held = None
            self.corners_moved.emit(self.corners, True)
        elif self._patch_from is not None:
            self._patch_from = None
            self.draw_patch(False)
            if self.patch is not None:
                self.patch_drawn.emit(self.patch)
        else:
            super().mouseReleaseEvent(event)

    def _draw_on(self, point: QPointF) -> None:
        """Let the path around the object go on to a point on the screen."""
        assert self._path is not None
        at = self._place(point)
        self._path.append((at.x() - 0.5, at.y() - 0.5))
        self.show_outline(tuple(self._path))

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
        if self.image is None:
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
            if len(self.outline) > 1:
                painter.drawPolygon(QPolygonF([self.to_screen(QPointF(x + 0.5, y + 0.5)) for x, y in self.outline]))
            if self.length is not None:
                ends = [self.end(place) for place in (0, 1)]
                painter.drawLine(*ends)
                for end in ends:
                    painter.drawEllipse(end, HANDLE_PX, HANDLE_PX)
            if self.patch is not None:
                left, top, across, along = self.patch
                start, end = QPointF(left, top), QPointF(left + across, top + along)
                painter.drawRect(QRectF(self.to_screen(start), self.to_screen(end)))


def _clockwise(corners: list[tuple[float, float]]) -> bool:
    """True if the corners form a convex quadrilateral, clockwise on the screen, of at least one pixel."""
    for place in range(4):
        (x0, y0), (x1, y1), (x2, y2) = (corners[(place + step) % 4] for step in range(3))
        if (x1 - x0) * (y2 - y1) - (y1 - y0) * (x2 - x1) < 1.0:
            return False
    return True


#: Share of the photograph that a new framing leaves out at each edge.
INSET = 0.1


def begin(path: Path, framing: Framing | None, how: str, width_px: int | None) -> Steps[Framing]:
    """A framing of the photograph to begin with ('crop' or 'corners'), or `framing` at another width."""
    yield Step(0.0, "reading the photograph")
    from engine.capture.photograph.decode import read_photograph

    if framing is not None and is_upright(framing) == (how == "crop"):
        across = width_px or framing.width_px
        return Framing(framing.corners, across, max(1, round(across * framing.height_px / framing.width_px)))
    height, width = read_photograph(path).saturated.shape
    left, top = round(INSET * width), round(INSET * height)
    across, along = width - 2 * left, height - 2 * top
    lean = 0.0 if how == "crop" else 0.25 * left
    low, right, bottom = top - 0.5, left + across - 0.5, top + along - 0.5
    corners = ((left - 0.5 + lean, low), (right - lean, low), (right, bottom), (left - 0.5, bottom))
    return Framing(corners, across, along)


def frame(corners: Corners, size: tuple[int, int], *, upright: bool) -> Framing:
    """The framing between `corners` of a photograph of `size` (width, height), as large as it is seen there."""
    width, height = size
    return Framing(corners, *_natural_size(corners, estimate_aspect(corners, (height, width)), upright))


def _natural_size(corners: Corners, aspect: float, upright: bool) -> tuple[int, int]:
    """Width and height in pixels at which nothing of the figure between `corners` is made coarser."""
    sides = [hypot(x1 - x0, y1 - y0) for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True)]
    if upright:
        return max(1, round(sides[0])), max(1, round(sides[1]))
    width = max(sides[0], sides[2], max(sides[1], sides[3]) * aspect)
    return max(1, round(width)), max(1, round(width / aspect))
