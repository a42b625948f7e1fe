"""The model on screen and the hand on it.

Left-drag turns like a turntable without roll, middle-drag moves, the wheel zooms, Ctrl+left-drag or the handle moves
the light or turns the environment, F frames the model. The camera is the viewport's own; the light is the project's.
"""

from __future__ import annotations

import dataclasses
from math import degrees, hypot, pi, radians, sqrt

import numpy as np
from PySide6.QtCore import QPointF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import QHBoxLayout, QSizePolicy, QWidget

from app.jobs import Jobs
from app.panels import text
from app.quality import IDLE_S, MOVING_S, STILL_S
from app.surfaces import GlSurface, ProcessorSurface, display_of, why_no_gl
from app.theme import PADDING, role
from engine.camera import Camera, frame, orbit, pan, zoom
from engine.directions import Vectors, world_angles, world_direction
from engine.errors import MissingCapability
from engine.mesh import Mesh
from engine.render.display import Display
from engine.scene import Scene

STILL_AFTER_MS = 180
HANDLE_PX = 8
HANDLE_REACH = 0.46


class Viewport(QWidget):
    """Shows a scene with its own camera.

    `light_moved(theta_deg, phi_deg, final)` asks to move the light, `environment_turned(angle_deg, final)` to turn
    what lights the model instead; `camera_moved` says that the model is seen from elsewhere.
    """

    light_moved = Signal(float, float, bool)
    environment_turned = Signal(float, bool)
    camera_moved = Signal()
    drawn = Signal(float)
    broken = Signal(object)

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.jobs = jobs
        self.scene: Scene | None = None
        self.display = Display()
        self.camera: Camera | None = None
        self.light_deg = (50.0, 35.0)
        self._mesh: Mesh | None = None
        self._framed = True
        self._grab: tuple[str, QPointF] | None = None
        self._exposure: tuple[float, str] = (0.0, "neutral")
        self._still = QTimer(self)
        self._still.setSingleShot(True)
        self._still.setInterval(STILL_AFTER_MS)
        self._still.timeout.connect(lambda: self._draw(moving=False))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(160, 120)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setAccessibleName("Viewport")
        self.banner = _Banner(self)
        jobs.changed.connect(lambda job: self._still.start() if job.over and job.heavy else None)
        self.surface: GlSurface | ProcessorSurface
        self._choose_surface(why_no_gl())
        self.overlay = _Overlay(self)

    def sizeHint(self) -> QSize:
        return QSize(640, 480)

    def _choose_surface(self, why_not: str) -> None:
        self.surface = ProcessorSurface(self.jobs) if why_not else GlSurface()
        self.surface.setParent(self)
        self.surface.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.surface.drawn.connect(self._after_frame)
        if isinstance(self.surface, GlSurface):
            self.surface.failed.connect(self._without_gl, Qt.ConnectionType.QueuedConnection)
            self.surface.broken.connect(self.broken, Qt.ConnectionType.QueuedConnection)
        self.banner.say(f"{why_not}. Pictures are computed on the processor, more slowly." if why_not else "")
        self.surface.lower()
        self.surface.show()

    def _without_gl(self, error: MissingCapability) -> None:
        self.surface.deleteLater()
        self._choose_surface(error.capability)
        self._place()
        self._draw(moving=False)

    def show_scene(self, scene: Scene, exposure_ev: float, tone_map: str, light_deg: tuple[float, float]) -> None:
        """Show `scene` (its camera is replaced by the viewport's own); a new mesh is framed."""
        moved = self.scene is not None
        self.light_deg = light_deg
        self._exposure = (exposure_ev, tone_map)
        if self._mesh is not scene.mesh or self.camera is None:
            self._mesh = scene.mesh
            self._frame()
        self.scene = scene
        self._draw(moving=moved)

    def frame(self) -> None:
        """Look at the whole model from where it is looked at first."""
        if self._mesh is not None:
            self._frame()
            self._draw(moving=False)

    def _frame(self) -> None:
        """Until somebody moves it, the camera follows the size of the window as well."""
        assert self._mesh is not None
        self.camera = frame(self._mesh.positions, max(1, self.width()) / max(1, self.height()))
        self._framed = True
        self.camera_moved.emit()

    def redraw(self) -> None:
        """Draw again, as after a change of theme."""
        self._draw(moving=False)

    def _draw(self, *, moving: bool) -> None:
        if self.scene is None or self.camera is None:
            return
        scene = dataclasses.replace(self.scene, camera=self.camera)
        still_s = STILL_S if any(job.heavy for job in self.jobs.active) else IDLE_S
        self.surface.show_scene(scene, display_of(*self._exposure), MOVING_S if moving else still_s)
        self.overlay.update()
        if moving:
            self._still.start()

    def _after_frame(self, seconds: float) -> None:
        self.drawn.emit(seconds)
        if not self.banner.because_of_gl:
            self.banner.say("  ".join(self.surface.messages), because_of_gl=False)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place()
        if self._framed and self._mesh is not None:
            self._frame()
        self._draw(moving=True)

    def _place(self) -> None:
        self.surface.setGeometry(self.rect())
        self.overlay.setGeometry(self.rect())
        self.banner.setGeometry(PADDING, PADDING, max(0, self.width() - 2 * PADDING), 36)
        self.banner.raise_()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        handle = self.overlay.handle()
        near = handle is not None and _distance(handle, event.position()) < 2 * HANDLE_PX
        left = event.button() == Qt.MouseButton.LeftButton
        if left and event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            kind = "turn light" if self._lit_by_one() else "turn environment"
        elif left and near:
            kind = "drag light"
        elif left:
            kind = "orbit"
        else:
            kind = "pan" if event.button() == Qt.MouseButton.MiddleButton else ""
        self._grab = (kind, event.position())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self.overlay.show_near(event.position())
        if self._grab is None or self.camera is None:
            return
        kind, before = self._grab
        moved = event.position() - before
        self._grab = (kind, event.position())
        height = max(1, self.height())
        if kind == "orbit":
            self.turn(-moved.x() * pi / height, moved.y() * pi / height)
        elif kind == "pan":
            self._move(pan(self.camera, -moved.x() / height, moved.y() / height))
        elif kind == "turn light":
            theta, phi = self.light_deg
            self._move_light(theta + 180.0 * moved.y() / height, phi + 180.0 * moved.x() / height)
        elif kind == "turn environment" and self.scene is not None:
            self._turn(self.scene.environment_rotation + pi * moved.x() / height, final=False)
        elif kind == "drag light":
            self._move_light(*self.overlay.light_at(event.position()))

    def mouseReleaseEvent(self, _event: QMouseEvent) -> None:
        grabbed, self._grab = self._grab, None
        if grabbed is not None and "light" in grabbed[0]:
            self.light_moved.emit(*self.light_deg, True)
        if grabbed is not None and "environment" in grabbed[0] and self.scene is not None:
            self._turn(self.scene.environment_rotation, final=True)

    def turn(self, azimuth: float, elevation: float) -> None:
        """Go round the model by these angles in radians, as a hand that drags."""
        if self.camera is not None:
            self._move(orbit(self.camera, azimuth, elevation))

    def _turn(self, angle: float, *, final: bool) -> None:
        self.environment_turned.emit(round((degrees(angle) + 180.0) % 360.0 - 180.0, 2), final)

    def _lit_by_one(self) -> bool:
        return self.scene is None or self.scene.environment is None

    def _move(self, camera: Camera) -> None:
        self.camera, self._framed = camera, False
        self.camera_moved.emit()
        self._draw(moving=True)

    def _move_light(self, theta_deg: float, phi_deg: float) -> None:
        theta_deg = min(180.0, max(0.0, theta_deg))
        phi_deg = (phi_deg + 180.0) % 360.0 - 180.0
        self.light_moved.emit(round(theta_deg, 2), round(phi_deg, 2), False)

    def wheelEvent(self, event: QWheelEvent) -> None:
        if self.camera is not None:
            self._move(zoom(self.camera, 2.0 ** (-event.angleDelta().y() / 600.0)))


class _Banner(QWidget):
    """Says over the picture what is not as it should be."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        role(self, "banner")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.because_of_gl = False
        self.words = text("")
        row = QHBoxLayout(self)
        row.setContentsMargins(PADDING, 0, PADDING, 0)
        row.addWidget(self.words)
        self.hide()

    def say(self, words: str, *, because_of_gl: bool = True) -> None:
        """Show `words`, or nothing where they are empty."""
        self.because_of_gl = because_of_gl and bool(words)
        self.words.setText(words)
        self.setVisible(bool(words))


class _Overlay(QWidget):
    """The handle of the light: a sun on a circle around the picture's centre, hollow while the light is behind."""

    def __init__(self, viewport: Viewport) -> None:
        super().__init__(viewport)
        self.viewport = viewport
        self.near = False
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)

    def _reach(self) -> float:
        return HANDLE_REACH * min(self.width(), self.height())

    def _middle(self) -> QPointF:
        return QPointF(self.width() / 2, self.height() / 2)

    def _seen(self) -> Vectors | None:
        """The light's direction as the camera sees it: right, up, towards the viewer."""
        camera = self.viewport.camera
        scene = self.viewport.scene
        if camera is None or scene is None or scene.environment is not None:
            return None
        theta, phi = (radians(angle) for angle in self.viewport.light_deg)
        return camera.camera_from_world @ world_direction(theta, phi)

    def handle(self) -> QPointF | None:
        """Where the handle is."""
        seen = self._seen()
        return None if seen is None else self._middle() + QPointF(seen[0], -seen[1]) * self._reach()

    def light_at(self, point: QPointF) -> tuple[float, float]:
        """Angles (theta, phi) in degrees of the light whose handle is at `point`, on the side where it is now."""
        camera, seen = self.viewport.camera, self._seen()
        assert camera is not None
        assert seen is not None
        offset = (point - self._middle()) / max(1.0, self._reach())
        x, y = offset.x(), -offset.y()
        length = hypot(x, y)
        if length > 1.0:
            x, y = x / length, y / length
        depth = sqrt(max(0.0, 1.0 - x * x - y * y))
        direction = camera.camera_from_world.T @ np.array([x, y, depth if seen[2] >= 0.0 else -depth])
        theta, phi = world_angles(direction)
        return degrees(theta), degrees(phi)

    def show_near(self, point: QPointF) -> None:
        """Draw the circle while the pointer is near the handle."""
        handle = self.handle()
        near = handle is not None and _distance(handle, point) < 3 * HANDLE_PX
        if near != self.near:
            self.near = near
            self.viewport.setCursor(Qt.CursorShape.OpenHandCursor if near else Qt.CursorShape.ArrowCursor)
            self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        handle, seen = self.handle(), self._seen()
        if handle is None or seen is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.near:
            painter.setPen(QPen(QColor(255, 255, 255, 50), 1))
            painter.drawEllipse(self._middle(), self._reach(), self._reach())
        for colour, width in ((QColor(0, 0, 0, 170), 3.5), (QColor(255, 236, 190), 1.5)):
            painter.setPen(QPen(colour, width))
            painter.setBrush(QColor(255, 236, 190) if seen[2] >= 0 else Qt.BrushStyle.NoBrush)
            painter.drawEllipse(handle, HANDLE_PX - 3, HANDLE_PX - 3)
            for spoke in range(8):
                out = QPointF(np.cos(spoke * pi / 4), np.sin(spoke * pi / 4))
                painter.drawLine(handle + out * (HANDLE_PX + 0.5), handle + out * (HANDLE_PX + 4))


def _distance(one: QPointF, other: QPointF) -> float:
    return hypot(one.x() - other.x(), one.y() - other.y())
