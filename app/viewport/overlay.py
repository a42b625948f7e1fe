"""Overlay of the viewport's image: the handles of the lights, the line between two images, and their names.

A light is a sun on a circle around the image's centre, hollow while it is behind; a round one has its size. A lamp
near the model is a ring at its own place. Nothing here takes the mouse: the viewport asks what is near it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, degrees, hypot, pi, radians, sin, sqrt, tan

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QLinearGradient, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from app.widgets import theme
from app.widgets.number_field import plain
from app.widgets.theme import PADDING, STEP
from engine.core.directions import Vectors, world_angles, world_direction
from engine.geometry.camera import Camera, Vector
from engine.render.display import BLUE, GREY, ORANGE

HANDLE_PX = 8
HANDLE_REACH = 0.46

#: Reach of the mouse around the line between two images.
WIPE_PX = 6

#: Radius of the ring around a chosen point of the model.
MARK_PX = 6

#: The warm white of a lamp whose colour is none.
SUN = (255, 236, 190)


@dataclass(frozen=True)
class Handle:
    """A light that can be dragged: the one light (`lamp` is None) or a lamp by its number; angles in degrees.

    A lamp near the model has a `place` in its coordinates, and no angles; `outline` are the corners of one that has a
    front, and `front` is a place before it.
    """

    lamp: int | None
    theta_deg: float = 0.0
    phi_deg: float = 0.0
    radius_deg: float = 0.0
    colour: tuple[int, int, int] = SUN
    chosen: bool = False
    place: Vector | None = None
    outline: tuple[Vector, ...] = ()
    front: Vector | None = None

    def is_of(self, other: Handle) -> bool:
        """True if both are of one light."""
        return self.lamp == other.lamp and (self.place is None) == (other.place is None)


class Overlay(QWidget):
    """Draws and locates the handles. The viewport sets its content and the camera."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.camera: Camera | None = None
        self.handles: tuple[Handle, ...] = ()
        self.near: Handle | None = None
        self.wipe: float | None = None
        self.names = ("", "")
        self.scale: float | None = None
        self.mark: tuple[float, float, float] | None = None
        self.is_preparing = False
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)

    def show_preparing(self, preparing: bool) -> None:
        """Say of a difference that its images are not complete yet, and show something else than they will."""
        self.is_preparing = preparing
        self.update()

    def _reach(self) -> float:
        return HANDLE_REACH * min(self.width(), self.height())

    def _middle(self) -> QPointF:
        return QPointF(self.width() / 2, self.height() / 2)

    def _seen(self, handle: Handle) -> Vectors:
        """The light's direction as the camera sees it: right, up, towards the viewer."""
        assert self.camera is not None
        return self.camera.camera_from_world @ world_direction(radians(handle.theta_deg), radians(handle.phi_deg))

    def place(self, handle: Handle) -> QPointF:
        """The position of a handle; far off where it is behind the viewer."""
        if handle.place is not None:
            return self._project(handle.place) or QPointF(-1e6, -1e6)
        seen = self._seen(handle)
        return self._middle() + QPointF(seen[0], -seen[1]) * self._reach()

    def _project(self, place: Vector) -> QPointF | None:
        """The position of a place of the model on screen; None where it is behind the viewer."""
        right, up, depth = self._before(place)
        return self._middle() + QPointF(right, -up) / (depth * self._pixel) if depth > 0.0 else None

    def _before(self, place: Vector) -> tuple[float, float, float]:
        """Coordinates of a place in front of the camera: to the right, up and away from the viewer."""
        assert self.camera is not None
        x, y, z = self.camera.camera_from_world @ (np.asarray(place) - self.camera.eye)
        return float(x), float(y), -float(z)

    @property
    def _pixel(self) -> float:
        """Side of a pixel of the image at the distance 1 from the viewer."""
        assert self.camera is not None
        return 2.0 * tan(radians(self.camera.fov_deg) / 2.0) / max(1, self.height())

    def place_at(self, handle: Handle, point: QPointF) -> Vector:
        """The place of a near lamp whose handle is at `point`, as far from the viewer as it is now."""
        assert self.camera is not None
        assert handle.place is not None
        depth = self._before(handle.place)[2]
        offset = (point - self._middle()) * depth * self._pixel
        moved = self.camera.camera_from_world.T @ np.array([offset.x(), -offset.y(), -depth])
        x, y, z = (float(f"{value:.4g}") for value in moved + np.asarray(self.camera.eye))
        return x, y, z

    def handle(self, lamp: int | None = None, *, near: bool = False) -> QPointF | None:
        """The position of the handle of the one light, or of a lamp, far or near; None if it does not exist."""
        wanted = Handle(lamp, place=(0.0, 0.0, 0.0) if near else None)
        found = [self.place(handle) for handle in self.handles if handle.is_of(wanted) and self.camera is not None]
        return found[0] if found else None

    def at(self, point: QPointF, reach: float = 2 * HANDLE_PX) -> Handle | None:
        """The handle nearest to `point`, at most `reach` pixels away."""
        if self.camera is None or not self.handles:
            return None
        distance, handle = min(
            ((_distance(self.place(handle), point), handle) for handle in self.handles), key=lambda found: found[0]
        )
        return handle if distance < reach else None

    def light_at(self, handle: Handle, point: QPointF) -> tuple[float, float]:
        """Angles (theta, phi) in degrees of the light whose handle is at `point`, on the side where it is now."""
        assert self.camera is not None
        offset = (point - self._middle()) / max(1.0, self._reach())
        x, y = offset.x(), -offset.y()
        length = hypot(x, y)
        if length > 1.0:
            x, y = x / length, y / length
        depth = sqrt(max(0.0, 1.0 - x * x - y * y))
        behind = self._seen(handle)[2] < 0.0
        direction = self.camera.camera_from_world.T @ np.array([x, y, -depth if behind else depth])
        theta, phi = world_angles(direction)
        return degrees(theta), degrees(phi)

    def is_on_wipe(self, point: QPointF) -> bool:
        """True if `point` is on the line between two images."""
        return self.wipe is not None and abs(point.x() - self.wipe * self.width()) <= WIPE_PX

    def show_near(self, point: QPointF) -> Qt.CursorShape:
        """Draw the circle while the pointer is near a handle; returns how the pointer should look."""
        near = self.at(point, 3 * HANDLE_PX)
        if near != self.near:
            self.near = near
            self.update()
        if near is not None:
            return Qt.CursorShape.OpenHandCursor
        return Qt.CursorShape.SplitHCursor if self.is_on_wipe(point) else Qt.CursorShape.ArrowCursor

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(theme.font(12))
        if self.wipe is not None:
            self._paint_wipe(painter, round(self.wipe * self.width()))
        if self.scale is not None:
            self._paint_scale(painter, self.scale)
        if self.camera is not None:
            for handle in self.handles:
                self._paint_handle(painter, handle)
            if self.mark is not None:
                self._paint_mark(painter, self.camera, self.mark)

    def _paint_mark(self, painter: QPainter, camera: Camera, point: tuple[float, float, float]) -> None:
        """A ring around a point of the model, behind what hides it or not."""
        clip = camera.clip_from_model(point, 1.0, self.width() / max(1, self.height())) @ (0.0, 0.0, 0.0, 1.0)
        if clip[3] <= 0.0:
            return
        place = QPointF((0.5 + 0.5 * clip[0] / clip[3]) * self.width(), (0.5 - 0.5 * clip[1] / clip[3]) * self.height())
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for ink, width in ((QColor(0, 0, 0, 170), 3.5), (QColor(235, 235, 235), 1.5)):
            painter.setPen(QPen(ink, width))
            painter.drawEllipse(place, MARK_PX, MARK_PX)

    def _paint_wipe(self, painter: QPainter, x: int) -> None:
        """The line, a grip half way down, and the names of the images on either side."""
        middle = self.height() / 2
        for colour, width in ((QColor(0, 0, 0, 150), 3.0), (QColor(235, 235, 235), 1.0)):
            painter.setPen(QPen(colour, width))
            painter.drawLine(QPointF(x, 0), QPointF(x, self.height()))
        painter.setPen(QPen(QColor(0, 0, 0, 150), 1.0))
        painter.setBrush(QColor(235, 235, 235))
        painter.drawRoundedRect(QRectF(x - 4, middle - 14, 8, 28), 4, 4)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for side, words in enumerate(self.names):
            wide = painter.fontMetrics().horizontalAdvance(words) + 4 * STEP
            left = x + PADDING if side else x - PADDING - wide
            if left >= STEP and left + wide <= self.width() - STEP:
                _tag(painter, QRectF(left, PADDING, wide, 22), words)

    def _paint_scale(self, painter: QPainter, scale: float) -> None:
        """The colours of the difference and the luminance that each stands for."""
        width, height = min(220, self.width() - 2 * PADDING), 8
        frame = QRectF(PADDING, self.height() - PADDING - 46, width + 2 * PADDING, 46)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(0, 0, 0, 150))
        painter.drawRoundedRect(frame, 4, 4)
        bar = QRectF(frame.left() + PADDING, frame.top() + 2 * STEP, width, height)
        colours = QLinearGradient(bar.topLeft(), bar.topRight())
        for at, colour in ((0.0, BLUE), (0.5, GREY), (1.0, ORANGE)):
            colours.setColorAt(at, QColor.fromRgbF(*colour))
        painter.setBrush(colours)
        painter.drawRect(bar)
        painter.setPen(QColor(235, 235, 235))
        below = QRectF(bar.left(), bar.bottom() + 3, bar.width(), 20)
        ends = ((Qt.AlignmentFlag.AlignLeft, f"−{plain(scale)}"), (Qt.AlignmentFlag.AlignRight, f"+{plain(scale)}"))
        what = "preparing…" if self.is_preparing else f"{self.names[0]} − {self.names[1]}"
        for side, words in (*ends, (Qt.AlignmentFlag.AlignHCenter, what)):
            painter.drawText(below, side | Qt.AlignmentFlag.AlignTop, words)

    def _paint_near(self, painter: QPainter, handle: Handle) -> None:
        """A bulb, a disc in a ring; with the outline of a lamp that has a front, and a line towards what it faces."""
        place, colour = self.place(handle), QColor(*handle.colour)
        corners = [point for corner in handle.outline if (point := self._project(corner)) is not None]
        front = None if handle.front is None else self._project(handle.front)
        for ink, width in ((QColor(0, 0, 0, 170), 3.5), (colour, 2.5 if handle.chosen else 1.5)):
            painter.setPen(QPen(ink, width))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            if corners and len(corners) == len(handle.outline):
                painter.drawPolygon(corners)
            if front is not None:
                painter.drawLine(place, front)
            painter.drawEllipse(place, HANDLE_PX + 2, HANDLE_PX + 2)
            painter.setBrush(colour)
            painter.drawEllipse(place, HANDLE_PX - 4, HANDLE_PX - 4)

    def _paint_handle(self, painter: QPainter, handle: Handle) -> None:
        if handle.place is not None:
            self._paint_near(painter, handle)
            return
        place, seen = self.place(handle), self._seen(handle)
        if handle == self.near:
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(QColor(255, 255, 255, 50), 1))
            painter.drawEllipse(self._middle(), self._reach(), self._reach())
        colour = QColor(*handle.colour)
        if handle.radius_deg > 0.0:
            size = max(HANDLE_PX + 5.0, sin(radians(handle.radius_deg)) * self._reach())
            painter.setBrush(Qt.BrushStyle.NoBrush)
            for ink, width in ((QColor(0, 0, 0, 120), 2.5), (colour, 1.0)):
                painter.setPen(QPen(ink, width, Qt.PenStyle.DashLine))
                painter.drawEllipse(place, size, size)
        for ink, width in ((QColor(0, 0, 0, 170), 3.5), (colour, 2.5 if handle.chosen else 1.5)):
            painter.setPen(QPen(ink, width))
            painter.setBrush(colour if seen[2] >= 0 else Qt.BrushStyle.NoBrush)
            painter.drawEllipse(place, HANDLE_PX - 3, HANDLE_PX - 3)
            for spoke in range(8):
                out = QPointF(cos(spoke * pi / 4), sin(spoke * pi / 4))
                painter.drawLine(place + out * (HANDLE_PX + 0.5), place + out * (HANDLE_PX + 4))


def _tag(painter: QPainter, place: QRectF, words: str) -> None:
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(0, 0, 0, 150))
    painter.drawRoundedRect(place, 4, 4)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QColor(235, 235, 235))
    painter.drawText(place, Qt.AlignmentFlag.AlignCenter, words)


def _distance(one: QPointF, other: QPointF) -> float:
    return hypot(one.x() - other.x(), one.y() - other.y())
