"""The lobes of several BRDFs in space, seen from anywhere, for one direction of light.

Left-drag turns, the wheel zooms, Ctrl+left-drag moves the light, double-click looks from where it began.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, pi, radians
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAccessible, QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from app.brdf.plots import marker_path
from app.viewport.gl_widget import GlWidget
from app.widgets import theme
from engine.geometry.camera import Camera, orbit, zoom
from engine.gl.lobe import WORLD_FROM_SURFACE, LobeColours, LobeRenderer, LobeSurface

if TYPE_CHECKING:
    from engine.gl.context import Framebuffer

START = Camera((2.0, 1.35, 2.4), (0.0, 0.36, 0.0), fov_deg=32.0)

#: Pause after the last movement before edges are drawn smooth, by so many samples a pixel.
STILL_AFTER_MS, SAMPLES = 180, 4


@dataclass(frozen=True, eq=False)
class Lobe:
    """Directions towards the viewer (R, C, 3), a value for each (R, C) in 1/sr, colour and marker of its BRDF."""

    wo: NDArray[np.float64]
    value: NDArray[np.float64]
    colour: str
    marker: str


def lengths(value: NDArray[np.float64], highest: float, *, logarithmic: bool) -> NDArray[np.float64]:
    """The drawn length of a value, at most 1: in proportion, or as log(1 + 100 value / highest), for dim parts."""
    share = np.clip(value / highest, 0.0, 1.0)
    return np.asarray(np.log1p(100.0 * share) / np.log1p(100.0) if logarithmic else share)


def surfaces(lobes: Sequence[Lobe], highest: float, *, logarithmic: bool) -> list[LobeSurface]:
    """The lobes on one scale, on which the value `highest` has the length 1."""
    made = []
    for lobe in lobes:
        length = lengths(lobe.value, highest, logarithmic=logarithmic)
        theta = np.degrees(np.arctan2(np.hypot(lobe.wo[..., 0], lobe.wo[..., 1]), lobe.wo[..., 2]))
        phi = np.broadcast_to(np.linspace(0.0, 360.0, lobe.value.shape[1]), lobe.value.shape)
        made.append(
            LobeSurface(
                (lobe.wo * length[..., None]).astype(np.float32),
                np.stack([theta, phi], axis=-1).astype(np.float32),
                _rgb(lobe.colour),
            )
        )
    return made


class LobeView(GlWidget):
    """Shows lobes; `light_moved(theta_deg, final)` asks to move the light in its plane."""

    accessible_role = QAccessible.Role.Canvas

    light_moved = Signal(float, bool)

    def __init__(self) -> None:
        super().__init__()
        self.lobes: list[LobeSurface] = []
        self.markers: list[str] = []
        self.light = (radians(45.0), pi)
        self.camera = START
        self._renderer: LobeRenderer | None = None
        self._grab: tuple[str, QPointF] | None = None
        self._still = QTimer(self)
        self._still.setSingleShot(True)
        self._still.setInterval(STILL_AFTER_MS)
        self._still.timeout.connect(self.update)
        self._smooth: Framebuffer | None = None
        self.setMinimumSize(160, 120)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Lobes in space")
        self.setToolTip("Drag to rotate, wheel to zoom, Ctrl+drag to move the light, double-click to reset")
        self.overlay = _Markers(self)

    def sizeHint(self) -> QSize:
        return QSize(420, 320)

    def show_lobes(self, lobes: list[LobeSurface], markers: list[str], light: tuple[float, float]) -> None:
        """Show `lobes`, each with its marker; `light` is (theta, phi) in radians in the surface frame."""
        self.lobes, self.markers, self.light = lobes, markers, light
        self._redraw()

    def _redraw(self) -> None:
        """Coarse edges while something moves; the last image is drawn again with smooth ones."""
        self._still.start()
        self.update()
        self.overlay.update()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.overlay.setGeometry(self.rect())

    def tip(self, surface: LobeSurface) -> QPointF:
        """The position on the widget of the point of a lobe that is farthest from the middle."""
        points = surface.points.reshape(-1, 3).astype(np.float64)
        farthest = points[int(np.argmax(np.sum(points**2, axis=-1)))]
        matrix = self.camera.clip_from_model(np.zeros(3), 1.5, max(1, self.width()) / max(1, self.height()))
        x, y, _, w = matrix @ np.append(WORLD_FROM_SURFACE @ farthest, 1.0)
        return QPointF((x / w + 1.0) / 2.0 * self.width(), (1.0 - y / w) / 2.0 * self.height())

    def begin(self) -> None:
        self._renderer = LobeRenderer(self.device)

    def paint(self, framebuffer: Framebuffer) -> None:
        if self._renderer is None or min(framebuffer.size) < 1:
            return
        colours = theme.current()
        palette = LobeColours(_rgb(colours.canvas), _rgb(colours.disabled), _rgb(colours.text))
        smooth = not self._still.isActive()
        target = self._smooth_target(framebuffer.size) if smooth else framebuffer
        self._renderer.draw(target, self.lobes, self.light, self.camera, palette)
        if smooth:
            self.device.copy_framebuffer(framebuffer, target)

    def _smooth_target(self, size: tuple[int, int]) -> Framebuffer:
        if self._smooth is None or self._smooth.size != size:
            self._release_smooth()
            samples = min(SAMPLES, self.device.max_samples)
            colour = self.device.renderbuffer(size, samples=samples)
            depth = self.device.depth_renderbuffer(size, samples=samples)
            self._smooth = self.device.framebuffer([colour], depth)
        return self._smooth

    def _release_smooth(self) -> None:
        if self._smooth is not None:
            # a new framebuffer restores the one bound before it, which must not be one that is gone
            self.device.detect_framebuffer(self.defaultFramebufferObject()).use()
            for item in (self._smooth, *self._smooth.color_attachments, self._smooth.depth_attachment):
                item.release()
            self._smooth = None

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            control = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
            self._grab = ("light" if control else "turn", event.position())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._grab is None:
            return
        kind, before = self._grab
        moved = event.position() - before
        self._grab = (kind, event.position())
        height = max(1, self.height())
        if kind == "turn":
            self.camera = orbit(self.camera, -moved.x() * pi / height, moved.y() * pi / height)
            self._redraw()
        else:
            theta = min(89.0, max(0.0, degrees(self.light[0]) + 120.0 * moved.y() / height))
            self.light = (radians(theta), self.light[1])
            self._redraw()
            self.light_moved.emit(theta, False)

    def mouseReleaseEvent(self, _event: QMouseEvent) -> None:
        grabbed, self._grab = self._grab, None
        if grabbed is not None and grabbed[0] == "light":
            self.light_moved.emit(degrees(self.light[0]), True)

    def mouseDoubleClickEvent(self, _event: QMouseEvent) -> None:
        self.reset()

    def reset(self) -> None:
        """Look from where it began."""
        self.camera = START
        self._redraw()

    def wheelEvent(self, event: QWheelEvent) -> None:
        self.camera = zoom(self.camera, 2.0 ** (-event.angleDelta().y() / 600.0))
        self._redraw()

    def forget(self) -> None:
        if self._renderer is not None:
            self._release_smooth()
            self._renderer.release()
            self._renderer = None


class _Markers(QWidget):
    """The markers at the tips of the lobes, over the image."""

    def __init__(self, view: LobeView) -> None:
        super().__init__(view)
        self.view = view
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(theme.current().canvas), 1.0))
        for surface, marker in zip(self.view.lobes, self.view.markers, strict=True):
            painter.setBrush(QColor.fromRgbF(*surface.colour))
            painter.drawPath(marker_path(marker, 12.0).translated(self.view.tip(surface)))


def _rgb(colour: str) -> tuple[float, float, float]:
    made = QColor(colour)
    return (made.redF(), made.greenF(), made.blueF())
