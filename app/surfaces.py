"""What the viewport draws on: OpenGL inside the window, or a picture computed on the processor where there is none."""

from __future__ import annotations

import time
from typing import Any

from PySide6.QtCore import QRectF, QTimer, Signal
from PySide6.QtGui import QColor, QImage, QOffscreenSurface, QOpenGLContext, QPainter, QPaintEvent, QSurfaceFormat
from PySide6.QtOpenGLWidgets import QOpenGLWidget
from PySide6.QtWidgets import QWidget
from shiboken6 import isValid

from app import theme
from app.jobs import Jobs
from app.latest import Latest
from app.pictures import rgb_image
from engine.colour import srgb_decode
from engine.errors import MissingCapability
from engine.render.display import Display, displayed
from engine.scene import Scene
from engine.steps import Step, Steps

#: How long a frame may take: while something moves, when it is still, and when it is still and no job runs either.
#: The last is long enough for software to draw every pixel once: a picture at rest that stays coarse is worse.
MOVING_S, STILL_S, IDLE_S = 0.03, 0.045, 0.6

#: Sub-pixels along a side of a pixel, and the fraction of pixels that is drawn, from best to quickest.
QUALITIES = ((2, 1), (1, 1), (1, 2), (1, 3), (1, 4), (1, 6), (1, 9))


def request_format() -> None:
    """Ask for OpenGL 3.3 core; must come before the application is made. Edges are smoothed by the renderer itself."""
    wanted = QSurfaceFormat()
    wanted.setVersion(3, 3)
    wanted.setProfile(QSurfaceFormat.OpenGLContextProfile.CoreProfile)
    QSurfaceFormat.setDefaultFormat(wanted)


def why_no_gl() -> str:
    """Why OpenGL 3.3 cannot be used in this window; empty where it can."""
    context = QOpenGLContext()
    if not context.create():
        return "OpenGL is not available"
    found = context.format()
    if (found.majorVersion(), found.minorVersion()) < (3, 3):
        return f"OpenGL is {found.majorVersion()}.{found.minorVersion()}, and 3.3 is needed"
    surface = QOffscreenSurface()
    surface.create()
    usable = context.makeCurrent(surface)
    context.doneCurrent()
    return "" if usable else "OpenGL cannot be started"


class Cost:
    """What a frame costs, learnt from the frames so far: a part for the model, and a part for each sub-pixel.

    Each light counts as pixels of its own, so that an environment is drawn coarsely at once and not after a long frame.
    """

    def __init__(self) -> None:
        self.fixed_s, self.each_s = 0.0, 0.0
        self.level = len(QUALITIES)
        self._seen: dict[int, float] = {}

    def learn(self, level: int, pixels: int, seconds: float) -> None:
        """A frame at `level` of `QUALITIES`, of `pixels` on the screen, took `seconds`."""
        self.level = level
        self._seen[sub_pixels(level, pixels)] = seconds
        few, many = min(self._seen), max(self._seen)
        if few < many:
            self.each_s = max(0.0, (self._seen[many] - self._seen[few]) / (many - few))
        self.fixed_s = max(0.0, seconds - self.each_s * sub_pixels(level, pixels))

    def best(self, pixels: int, budget_s: float) -> int:
        """The level to draw next: within `budget_s`, and at most one finer than the last, whose cost is known.

        Where the model alone takes too long, fewer pixels do not help: then they may cost as much as the model.
        """
        room_s = max(budget_s - self.fixed_s, self.fixed_s)
        fits = (at for at in range(len(QUALITIES)) if self.each_s * sub_pixels(at, pixels) <= room_s)
        return max(next(fits, len(QUALITIES) - 1), self.level - 1)


def sub_pixels(level: int, pixels: int) -> int:
    """How many sub-pixels a frame of `pixels` on the screen has at `level` of `QUALITIES`."""
    samples, reduction = QUALITIES[level]
    return max(1, pixels * samples**2 // reduction**2)


def display_of(exposure_ev: float, operator: Any) -> Display:
    """Exposure and tone mapping over the window's canvas colour."""
    canvas = QColor(theme.current().canvas)
    red, green, blue = (float(v) for v in srgb_decode([canvas.redF(), canvas.greenF(), canvas.blueF()]))
    return Display(exposure_ev, operator, (red, green, blue))


class GlSurface(QOpenGLWidget):
    """Draws through `engine.gl`. `drawn(seconds)` follows each frame.

    `failed` says that OpenGL cannot be used at all, `broken` that this scene could not be drawn.
    """

    drawn = Signal(float)
    failed = Signal(object)
    broken = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.scene: Scene | None = None
        self.display = display_of(0.0, "neutral")
        self.budget_s = STILL_S
        self.messages: tuple[str, ...] = ()
        self._context: Any = None
        self._renderer: Any = None
        self._small: tuple[tuple[int, int], Any] | None = None
        self._enlarge: Any = None
        self._cost = Cost()
        self._finer = QTimer(self)
        self._finer.setSingleShot(True)
        self._finer.timeout.connect(self.update)

    def show_scene(self, scene: Scene | None, display: Display, budget_s: float) -> None:
        """Draw `scene` with the next frame, as finely as `budget_s` seconds allow."""
        self.scene, self.display, self.budget_s = scene, display, budget_s
        self.update()

    def initializeGL(self) -> None:
        from engine.gl.context import attach_context
        from engine.gl.direct import DirectRenderer

        self._small = self._enlarge = None
        try:
            self._context = attach_context()
        except MissingCapability as error:
            self._context = self._renderer = None
            self.failed.emit(error)
            return
        self._renderer = DirectRenderer(self._context)
        self.context().aboutToBeDestroyed.connect(self._forget)

    def paintGL(self) -> None:
        if self._context is None:
            return
        framebuffer = self._context.detect_framebuffer(self.defaultFramebufferObject())
        if self.scene is None or min(framebuffer.size) < 1:
            canvas = QColor(theme.current().canvas)
            framebuffer.clear(canvas.redF(), canvas.greenF(), canvas.blueF(), 1.0)
            return
        try:
            self._draw(framebuffer)
        except Exception as error:  # the border to Qt: what leaves a paint event is raised in whatever runs next
            self.scene = None
            self.broken.emit(error)

    def _draw(self, framebuffer: Any) -> None:
        """One frame at the quality that the budget allows, and another where a finer one turns out to fit."""
        assert self.scene is not None
        width, height = framebuffer.size
        started = time.perf_counter()
        pixels = width * height * len(self.scene.lights.direction)
        level = self._cost.best(pixels, self.budget_s)
        samples, reduction = QUALITIES[level]
        if reduction == 1:
            self._renderer.draw(self.scene, framebuffer, (width, height), samples=samples, display=self.display)
        else:
            self._draw_small(framebuffer, (max(1, width // reduction), max(1, height // reduction)))
        self._context.finish()
        seconds = time.perf_counter() - started
        self._cost.learn(level, pixels, seconds)
        self.messages = tuple(self._renderer.messages)
        self.drawn.emit(seconds)
        if self.budget_s > MOVING_S and self._cost.best(pixels, self.budget_s) < level:
            self._finer.start()

    def _draw_small(self, framebuffer: Any, size: tuple[int, int]) -> None:
        from engine.gl.program import load_program

        context = self._context
        if self._small is None or self._small[0] != size:
            if self._small is not None:
                self._small[1].color_attachments[0].release()
                self._small[1].release()
            texture = context.texture(size, 4)
            texture.filter = (context.LINEAR, context.LINEAR)
            texture.repeat_x = texture.repeat_y = False
            self._small = (size, context.framebuffer([texture]))
        small = self._small[1]
        self._renderer.draw(self.scene, small, size, samples=1, display=self.display)
        if self._enlarge is None:
            program = load_program(context, "screen.vert", "enlarge.frag")
            self._enlarge = (program, context.vertex_array(program, []))
        framebuffer.use()
        framebuffer.viewport = (0, 0, *framebuffer.size)
        context.disable(context.DEPTH_TEST | context.BLEND | context.CULL_FACE)
        small.color_attachments[0].use(0)
        self._enlarge[0]["picture"] = 0
        self._enlarge[0]["size"] = framebuffer.size
        self._enlarge[1].render(vertices=3)

    def _forget(self) -> None:
        """The context goes away (the window moved to another screen, say); everything is made anew in the next one."""
        if not isValid(self):
            return
        self.makeCurrent()
        if self._renderer is not None:
            self._renderer.release()
        self._renderer = self._context = self._small = self._enlarge = None
        self.doneCurrent()


class ProcessorSurface(QWidget):
    """Draws on the processor, in a job: coarse while something moves, then in full, band after band."""

    drawn = Signal(float)

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.messages: tuple[str, ...] = ()
        self._latest = Latest(jobs, "Rendering")
        self._image: QImage | None = None

    def show_scene(self, scene: Scene | None, display: Display, budget_s: float) -> None:
        """Ask for a picture of `scene`; it is shown when it is done."""
        if scene is None or self.width() < 1 or self.height() < 1:
            return
        share = 0.3 if budget_s <= MOVING_S else 1.0
        scale = self.devicePixelRatioF() * share
        size = (max(1, round(self.width() * scale)), max(1, round(self.height() * scale)))
        self._latest.ask(lambda: _computed(scene, size, display), self._show)

    def _show(self, result: tuple[QImage, float]) -> None:
        self._image, seconds = result
        self.drawn.emit(seconds)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(theme.current().canvas))
        if self._image is not None:
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
            painter.drawImage(QRectF(self.rect()), self._image)


def _computed(scene: Scene, size: tuple[int, int], display: Display) -> Steps[tuple[QImage, float]]:
    yield Step(0.0, "rendering on the processor")
    from engine.render.direct import radiance

    started = time.perf_counter()
    picture = yield from radiance(scene, size, samples=1)
    return rgb_image(displayed(picture, display)), time.perf_counter() - started
