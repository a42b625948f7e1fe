"""What the viewport draws on: OpenGL inside the window, or a picture computed on the processor where there is none."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from dataclasses import dataclass, fields
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
from app.quality import MANY_LIGHTS, MOVING_S, ONE_LIGHT, STILL_S, Cost, Quality, next_rows
from engine.colour import srgb_decode
from engine.errors import MissingCapability
from engine.render.display import Display, displayed
from engine.scene import Scene
from engine.steps import Step, Steps


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


def display_of(exposure_ev: float, operator: Any) -> Display:
    """Exposure and tone mapping over the window's canvas colour."""
    canvas = QColor(theme.current().canvas)
    red, green, blue = (float(v) for v in srgb_decode([canvas.redF(), canvas.greenF(), canvas.blueF()]))
    return Display(exposure_ev, operator, (red, green, blue))


class GlSurface(QOpenGLWidget):
    """Draws through `engine.gl`: coarsely at once, then finer and finer, in pieces that leave the thread free between.

    The last picture that is complete is on screen. `drawn(seconds)` follows each one; `failed` says that OpenGL cannot
    be used at all, `broken` that this scene could not be drawn.
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
        self.quality: Quality | None = None
        self._context: Any = None
        self._renderer: Any = None
        self._picture: _Picture | None = None
        self._coming: _Coming | None = None
        self._given_up: list[_Picture] = []
        self._enlarge: Any = None
        self._cost = Cost()
        self._next = QTimer(self)
        self._next.setSingleShot(True)
        self._next.setInterval(0)
        self._next.timeout.connect(lambda: self._guarded(self._go_on))

    @property
    def is_finished(self) -> bool:
        """Whether the picture on screen is the finest that is going to be drawn of this scene."""
        at_rest = self.quality is not None and self._coming is None and self.budget_s > MOVING_S
        return at_rest and self._finer() is None

    def show_scene(self, scene: Scene | None, display: Display, budget_s: float) -> None:
        """Draw `scene` with the next frame, and from then on as finely as `budget_s` seconds allow."""
        if self.scene is None or scene is None or display != self.display or not _same(scene, self.scene):
            self._start_anew()
        self.scene, self.display, self.budget_s = scene, display, budget_s
        self.update()

    def _start_anew(self) -> None:
        """What is on screen or coming is of something else; without a context nothing can be released yet."""
        if self._coming is not None:
            self._given_up.append(self._coming.picture)
        self.quality = self._coming = None
        self._next.stop()

    def initializeGL(self) -> None:
        from engine.gl.context import attach_context
        from engine.gl.direct import DirectRenderer

        self._picture = self._coming = self._enlarge = self.quality = None
        self._given_up.clear()
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
        self._guarded(lambda: self._paint(framebuffer))

    def _guarded(self, work: Callable[[], None]) -> None:
        try:
            work()
        except Exception as error:  # the border to Qt: what leaves a paint event is raised in whatever runs next
            self.scene = self._coming = None
            self.broken.emit(error)

    def _paint(self, framebuffer: Any) -> None:
        """Show the picture; draw a first one of a scene or a size that is new."""
        assert self.scene is not None
        if self._picture is not None and self._picture.screen != framebuffer.size:
            self._start_anew()
        if self.quality is None:
            self._draw_first(framebuffer.size)
        self._show(framebuffer)
        if self.budget_s > MOVING_S and (self._coming is not None or self._finer() is not None):
            self._next.start()

    def _levels(self) -> tuple[Quality, ...]:
        assert self.scene is not None
        return ONE_LIGHT if len(self.scene.lights.direction) == 1 else MANY_LIGHTS

    def _evaluations(self, level: Quality, screen: tuple[int, int]) -> int:
        assert self.scene is not None
        return level.evaluations(screen[0] * screen[1], len(self.scene.lights.direction))

    def _draw_first(self, screen: tuple[int, int]) -> None:
        scene = self.scene
        assert scene is not None
        self._cost.about(scene.mesh, scene.shading, type(scene.brdf), scene.lookup)
        levels = self._levels()
        level = levels[self._cost.best(levels, screen[0] * screen[1], len(scene.lights.direction), MOVING_S)]
        coming = self._begin(level, screen)
        started = time.perf_counter()
        size, samples = coming.picture.size, level.samples
        self._renderer.draw(level.of(scene), coming.picture.framebuffer, size, samples=samples, display=self.display)
        self._context.finish()
        coming.seconds = time.perf_counter() - started
        self._complete(coming)

    def _finer(self) -> Quality | None:
        """The next level to draw of a scene that is at rest."""
        assert self.scene is not None
        if self.quality is None or self._picture is None:
            return None
        levels, (width, height) = self._levels(), self._picture.screen
        best = self._cost.best(levels, width * height, len(self.scene.lights.direction), self.budget_s)
        return levels[best] if best < levels.index(self.quality) else None

    def _go_on(self) -> None:
        """Draw the next piece of a finer picture, and show the picture with its last piece."""
        if self.scene is None or self._renderer is None or self._picture is None or not self.isVisible():
            return
        level = self._finer()
        if self._coming is None and level is None:
            return
        self.makeCurrent()
        if self._coming is None:
            assert level is not None
            self._coming = self._begin(level, self._picture.screen)
            next(self._coming.bands)
        coming, started = self._coming, time.perf_counter()
        done = False
        try:
            coming.bands.send(coming.rows)
        except StopIteration:
            done = True
        self._context.finish()
        seconds = time.perf_counter() - started
        coming.seconds += seconds
        coming.rows = next_rows(coming.rows, seconds, coming.first_rows)
        if done:
            self._coming = None
            self._complete(coming)
            self.update()
        else:
            self._next.start()
        self.doneCurrent()

    def _begin(self, level: Quality, screen: tuple[int, int]) -> _Coming:
        assert self.scene is not None
        while self._given_up:
            self._given_up.pop().release(self._context)
        size = (max(1, screen[0] // level.reduction), max(1, screen[1] // level.reduction))
        picture = _Picture(self._context, size, screen)
        scene, samples = level.of(self.scene), level.samples
        bands = self._renderer.bands(scene, picture.framebuffer, size, samples=samples, display=self.display)
        rows = self._cost.rows(self._evaluations(level, screen), size[1] * samples)
        return _Coming(level, picture, bands, rows, rows)

    def _complete(self, coming: _Coming) -> None:
        if self._picture is not None:
            self._picture.release(self._context)
        self._picture, self.quality = coming.picture, coming.level
        self._cost.learn(self._evaluations(coming.level, coming.picture.screen), coming.seconds)
        self.messages = tuple(self._renderer.messages)
        self.drawn.emit(coming.seconds)

    def _show(self, framebuffer: Any) -> None:
        from engine.gl.program import load_program

        context = self._context
        if self._enlarge is None:
            program = load_program(context, "screen.vert", "enlarge.frag")
            self._enlarge = (program, context.vertex_array(program, []))
        framebuffer.use()
        framebuffer.viewport = (0, 0, *framebuffer.size)
        context.disable(context.DEPTH_TEST | context.BLEND | context.CULL_FACE)
        assert self._picture is not None
        self._picture.texture.use(0)
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
        self._renderer = self._context = self._picture = self._coming = self._enlarge = self.quality = None
        self.doneCurrent()


class _Picture:
    """A finished or growing picture of `size` for a framebuffer of size `screen`, as a texture."""

    def __init__(self, context: Any, size: tuple[int, int], screen: tuple[int, int]) -> None:
        self.size, self.screen = size, screen
        self.texture = context.texture(size, 4)
        self.texture.filter = (context.LINEAR, context.LINEAR)
        self.texture.repeat_x = self.texture.repeat_y = False
        self.framebuffer = context.framebuffer([self.texture])

    def release(self, context: Any) -> None:
        # a new framebuffer restores the one bound before it, which must not be one that is gone
        context.detect_framebuffer(0).use()
        self.framebuffer.release()
        self.texture.release()


@dataclass
class _Coming:
    """A finer picture under way: its pieces, the rows of the next and of the first, and the seconds so far."""

    level: Quality
    picture: _Picture
    bands: Generator[None, int, None]
    rows: int
    first_rows: int
    seconds: float = 0.0


def _same(scene: Scene, other: Scene) -> bool:
    """Whether two scenes are one picture."""
    return all(getattr(scene, part.name) == getattr(other, part.name) for part in fields(scene))


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
