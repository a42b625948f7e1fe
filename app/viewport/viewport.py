"""The model on screen and the hand on it.

Left-drag turns like a turntable without roll, middle-drag moves, the wheel zooms, Ctrl+left-drag or the handle moves
the light or turns the environment, F frames the model. The camera is the viewport's own; the light is the project's.
Two scenes that differ in how they are drawn share camera, light and screen; the line between them is dragged.
"""

from __future__ import annotations

import dataclasses
from math import degrees, pi, radians

from PySide6.QtCore import QPointF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAccessible, QKeyEvent, QMouseEvent, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import QHBoxLayout, QSizePolicy, QWidget

from app.jobs.jobs import Jobs
from app.viewport.cpu_surface import CpuSurface
from app.viewport.gl_surface import GlSurface, Pixels, Split, display_of, why_no_gl
from app.viewport.overlay import Handle, Overlay
from app.viewport.refining import IDLE_S, MOVING_S, STILL_S
from app.widgets.panels import text
from app.widgets.theme import PADDING, STEP, role
from engine.core.colour import Operator
from engine.core.errors import MissingCapability
from engine.geometry.camera import Camera, frame, orbit, pan, zoom
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import frame_mesh
from engine.light.environment import EnvironmentMap
from engine.render.background import Backdrop
from engine.render.display import Display
from engine.scene.scene import Scene

STILL_AFTER_MS = 180

#: Steps to the right and upwards by key, in degrees, and the keys that zoom, with the factor of the distance.
ARROWS = {
    int(Qt.Key.Key_Left): (-5.0, 0.0),
    int(Qt.Key.Key_Right): (5.0, 0.0),
    int(Qt.Key.Key_Up): (0.0, 5.0),
    int(Qt.Key.Key_Down): (0.0, -5.0),
}
ZOOMS = {int(Qt.Key.Key_Plus): 2.0**-0.2, int(Qt.Key.Key_Minus): 2.0**0.2}

#: Share of the height that a key pans by, and of the width that it moves the wipe line by, for each degree of `ARROWS`.
PAN, WIPE = 0.01, 0.004

#: Pixels that the mouse may move between press and release of a click.
CLICK_PX = 3


#: Sides that a model is seen from, by the world direction towards the eye.
VIEWS = {
    "Front": (0.0, 0.0, 1.0),
    "Back": (0.0, 0.0, -1.0),
    "Right": (1.0, 0.0, 0.0),
    "Left": (-1.0, 0.0, 0.0),
    "Top": (0.0, 1.0, 0.0),
}


class Viewport(QWidget):
    """Shows a scene with its own camera.

    `light_moved(theta_deg, phi_deg, final)` asks to move the light, `lamp_moved(number, theta_deg, phi_deg, final)` a
    lamp beside it, `near_lamp_moved(number, place, final)` one near the model, `environment_rotated(angle_deg, final)`
    to rotate the environment instead. `camera_moved` says that the model is seen from elsewhere or in another size,
    `rested` that nothing has moved for a while, `clicked` that the left button went down and up at one place.
    """

    accessible_role = QAccessible.Role.Canvas

    light_moved = Signal(float, float, bool)
    lamp_moved = Signal(int, float, float, bool)
    near_lamp_moved = Signal(int, tuple, bool)
    wipe_moved = Signal(float)
    rested = Signal()
    environment_rotated = Signal(float, bool)
    camera_moved = Signal()
    clicked = Signal(QPointF)
    drawn = Signal(float)
    broken = Signal(object)

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.jobs = jobs
        self.scene: Scene | None = None
        self.other: Scene | None = None
        self.split = Split()
        self.display = Display()
        self.environment: EnvironmentMap | None = None
        self.camera: Camera | None = None
        self.light_deg = (50.0, 35.0)
        self._mesh: Mesh | None = None
        self._framed = True
        self._grab: tuple[str, QPointF, Handle | None] | None = None
        self._pressed: QPointF | None = None
        self._exposure: tuple[float, Operator] = (0.0, "neutral")
        self._still = QTimer(self)
        self._still.setSingleShot(True)
        self._still.setInterval(STILL_AFTER_MS)
        self._still.timeout.connect(self._rest)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(160, 120)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setAccessibleName("Viewport")
        self.banner = _Banner(self)
        jobs.changed.connect(lambda job: self._still.start() if job.over and job.is_asked_for else None)
        self.surface: GlSurface | CpuSurface
        self._choose_surface(why_no_gl())
        self.overlay = Overlay(self)

    def sizeHint(self) -> QSize:
        return QSize(640, 480)

    def _choose_surface(self, why_not: str) -> None:
        self.surface = CpuSurface(self.jobs) if why_not else GlSurface()
        self.surface.setParent(self)
        self.surface.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.surface.drawn.connect(self._after_frame)
        if isinstance(self.surface, GlSurface):
            self.surface.failed.connect(self._without_gl)
            self.surface.broken.connect(self.broken)
        self.banner.say(f"{why_not}. Images are computed on the CPU, more slowly." if why_not else "")
        self.surface.lower()
        self.surface.show()

    def _without_gl(self, error: MissingCapability) -> None:
        self.surface.deleteLater()
        self._choose_surface(error.capability)
        self._place()
        self._draw(moving=False)

    def show_scene(
        self,
        scene: Scene,
        exposure_ev: float,
        tone_map: Operator,
        light_deg: tuple[float, float],
        handles: tuple[Handle, ...] | None = None,
    ) -> None:
        """Show `scene` (its camera is replaced by the viewport's own); a new mesh is framed.

        `handles` are the lights that can be dragged; without them it is the one light, where that is what shines.
        """
        moved = self.scene is not None
        self.light_deg = light_deg
        self._exposure = (exposure_ev, tone_map)
        if self._mesh is not scene.mesh or self.camera is None:
            self._mesh = scene.mesh
            self._frame()
        self.scene = scene
        one_light = (Handle(None, *light_deg),) if scene.environment is None else ()
        self.overlay.handles = one_light if handles is None else handles
        self._draw(moving=moved)
        self._still.start()

    def show_beside(self, other: Scene | None, split: Split, names: tuple[str, str] = ("", "")) -> None:
        """From the next scene on, show `other` beside it, with the same camera; None for one image alone."""
        self.other, self.split = other, split
        self.overlay.names = names
        self.overlay.wipe = split.wipe if other is not None and split.difference is None else None
        self.overlay.scale = split.difference if other is not None else None

    def show_over(self, side: int, pixels: Pixels | None) -> None:
        """Lay a better image over that of the scene (0) or the other (1), until something changes."""
        self.surface.show_over(side, pixels)

    @property
    def placed(self) -> Camera | None:
        """The camera, where somebody has placed it; None where it frames the model."""
        return None if self._framed else self.camera

    def look_from(self, camera: Camera) -> None:
        """See the model from `camera`."""
        if camera != self.camera:
            self._move(camera)

    def look_along(self, view: str) -> None:
        """See the whole model from one of the sides of `VIEWS`."""
        if self._mesh is not None:
            aspect, direction = max(1, self.width()) / max(1, self.height()), VIEWS[view]
            self._move(frame(self._mesh.positions, aspect, direction=direction))

    def frame(self) -> None:
        """Look at the whole model from where it is looked at first."""
        if self._mesh is not None:
            self._frame()
            self._draw(moving=False)

    def _frame(self) -> None:
        """Until somebody moves it, the camera follows the size of the window as well."""
        assert self._mesh is not None
        self.camera = frame_mesh(self._mesh, max(1, self.width()) / max(1, self.height()))
        self._framed = True
        self.camera_moved.emit()

    def redraw(self) -> None:
        """Draw again, as after a change of theme, also where there is nothing but the background yet."""
        self._draw(moving=False)
        self.surface.update()

    def _draw(self, *, moving: bool) -> None:
        if self.scene is None or self.camera is None:
            return
        still_s = STILL_S if any(job.is_asked_for for job in self.jobs.active) else IDLE_S
        display, budget_s = display_of(*self._exposure), MOVING_S if moving else still_s
        self.surface.behind = self._behind(self.scene, self.camera)
        self.surface.show_scenes(self.on_screen(), self.split, display, budget_s)
        self.overlay.camera = self.camera
        self.overlay.update()
        if moving:
            self._still.start()

    def show_behind(self, environment: EnvironmentMap | None) -> None:
        """Show an environment, blurred already, behind the model; None for the plain canvas."""
        if environment is not self.environment:
            self.environment = environment
            self._draw(moving=False)

    def _behind(self, scene: Scene, camera: Camera) -> Backdrop | None:
        if self.environment is None:
            return None
        return Backdrop(self.environment, camera, scene.environment_rotation, scene.irradiance)

    def on_screen(self) -> tuple[Scene, ...]:
        """The scenes that are shown, with the camera that they are seen with."""
        if self.camera is None:
            return ()
        scenes = (scene for scene in (self.scene, self.other) if scene is not None)
        return tuple(dataclasses.replace(scene, camera=self.camera) for scene in scenes)

    def screen_px(self) -> tuple[int, int]:
        """Width and height in pixels of the screen, halves rounded up as Qt does."""
        ratio = self.devicePixelRatioF()
        return max(1, int(self.width() * ratio + 0.5)), max(1, int(self.height() * ratio + 0.5))

    def _rest(self) -> None:
        self._draw(moving=False)
        self.rested.emit()

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
        self.banner.fit(max(0, self.width() - 2 * PADDING))
        self.banner.raise_()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        handle = self.overlay.at(event.position())
        left = event.button() == Qt.MouseButton.LeftButton
        if left and event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            kind = "turn light" if self._is_lit_by_one() else "turn environment"
        elif left and handle is not None:
            kind = "drag light"
        elif left and self.overlay.is_on_wipe(event.position()):
            kind = "wipe"
        elif left:
            kind = "orbit"
        else:
            kind = "pan" if event.button() == Qt.MouseButton.MiddleButton else ""
        self._grab = (kind, event.position(), handle)
        self._pressed = event.position() if kind == "orbit" else None

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        shape = self.overlay.show_near(event.position())
        if self.cursor().shape() != shape:
            self.setCursor(shape)
        if self._grab is None or self.camera is None:
            return
        kind, before, handle = self._grab
        moved = event.position() - before
        self._grab = (kind, event.position(), handle)
        height = max(1, self.height())
        if kind == "orbit":
            self.turn(-moved.x() * pi / height, moved.y() * pi / height)
        elif kind == "pan":
            self._move(pan(self.camera, -moved.x() / height, moved.y() / height))
        elif kind == "turn light":
            theta, phi = self.light_deg
            self._move_light(None, theta + 180.0 * moved.y() / height, phi + 180.0 * moved.x() / height)
        elif kind == "turn environment" and self.scene is not None:
            self._turn(self.scene.environment_rotation + pi * moved.x() / height, final=False)
        elif kind == "drag light" and handle is not None:
            if handle.place is not None:
                self.near_lamp_moved.emit(handle.lamp, self.overlay.place_at(handle, event.position()), False)
            else:
                self._move_light(handle.lamp, *self.overlay.light_at(handle, event.position()))
        elif kind == "wipe":
            self.wipe_moved.emit(min(1.0, max(0.0, event.position().x() / max(1, self.width()))))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        grabbed, self._grab = self._grab, None
        pressed, self._pressed = self._pressed, None
        if pressed is not None and (event.position() - pressed).manhattanLength() <= CLICK_PX:
            self.clicked.emit(pressed)
        if grabbed is not None and "light" in grabbed[0]:
            dragged = grabbed[2] if grabbed[2] is not None and grabbed[0] == "drag light" else Handle(None)
            for handle in self.overlay.handles:
                if handle.is_of(dragged) and handle.place is not None:
                    self.near_lamp_moved.emit(handle.lamp, handle.place, True)
                elif handle.is_of(dragged):
                    self._say_light(handle.lamp, handle.theta_deg, handle.phi_deg, final=True)
        if grabbed is not None and "environment" in grabbed[0] and self.scene is not None:
            self._turn(self.scene.environment_rotation, final=True)

    def turn(self, azimuth: float, elevation: float) -> None:
        """Go round the model by these angles in radians, as a hand that drags."""
        if self.camera is not None:
            self._move(orbit(self.camera, azimuth, elevation))

    def _turn(self, angle: float, *, final: bool) -> None:
        self.environment_rotated.emit(round((degrees(angle) + 180.0) % 360.0 - 180.0, 2), final)

    def _is_lit_by_one(self) -> bool:
        return self.scene is None or self.scene.environment is None

    def _move(self, camera: Camera) -> None:
        self.camera, self._framed = camera, False
        self.camera_moved.emit()
        self._draw(moving=True)

    def _move_light(self, lamp: int | None, theta_deg: float, phi_deg: float) -> None:
        phi_deg = (phi_deg + 180.0) % 360.0 - 180.0
        self._say_light(lamp, round(min(180.0, max(0.0, theta_deg)), 2), round(phi_deg, 2), final=False)

    def _say_light(self, lamp: int | None, theta_deg: float, phi_deg: float, *, final: bool) -> None:
        if lamp is None:
            self.light_moved.emit(theta_deg, phi_deg, final)
        else:
            self.lamp_moved.emit(lamp, theta_deg, phi_deg, final)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Do by keys what drags do: arrows rotate the model, + and − zoom.

        With Ctrl arrows move the light or the environment, with Shift they pan, with Alt they move the wipe line.
        """
        right, up = ARROWS.get(event.key(), (0.0, 0.0))
        held = event.modifiers()
        if self.camera is None or not (right or up or event.key() in ZOOMS):
            super().keyPressEvent(event)
        elif event.key() in ZOOMS:
            self._move(zoom(self.camera, ZOOMS[event.key()]))
        elif held & Qt.KeyboardModifier.ShiftModifier:
            self._move(pan(self.camera, -PAN * right, -PAN * up))
        elif held & Qt.KeyboardModifier.AltModifier:
            if self.overlay.wipe is not None:
                self.wipe_moved.emit(min(1.0, max(0.0, self.overlay.wipe + WIPE * right)))
        elif not held & Qt.KeyboardModifier.ControlModifier:
            self.turn(-radians(right), -radians(up))
        elif self._is_lit_by_one():
            theta_deg, phi_deg = self.light_deg
            theta_deg, phi_deg = min(180.0, max(0.0, theta_deg - up)), (phi_deg + right + 180.0) % 360.0 - 180.0
            self._say_light(None, theta_deg, phi_deg, final=True)
        elif self.scene is not None:
            self._turn(self.scene.environment_rotation + radians(right), final=True)

    def wheelEvent(self, event: QWheelEvent) -> None:
        if self.camera is not None:
            self._move(zoom(self.camera, 2.0 ** (-event.angleDelta().y() / 600.0)))


class _Banner(QWidget):
    """Says over the image what is not as it should be."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        role(self, "banner")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.because_of_gl = False
        self.words = text("", wrap=True)
        self.words.setMinimumWidth(10)
        row = QHBoxLayout(self)
        row.setContentsMargins(PADDING, 0, PADDING, 0)
        row.addWidget(self.words)
        self.hide()

    def say(self, words: str, *, because_of_gl: bool = True) -> None:
        """Show `words`, or nothing where they are empty."""
        self.because_of_gl = because_of_gl and bool(words)
        self.words.setText(words)
        self.setVisible(bool(words))
        self.fit(self.width())

    def fit(self, width: int) -> None:
        """Take `width`, and the height that the words need in it."""
        lines = self.words.heightForWidth(max(10, width - 2 * PADDING))
        self.setGeometry(PADDING, PADDING, width, max(36, lines + 2 * STEP))
