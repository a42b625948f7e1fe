"""The drawing surface of the viewport: OpenGL inside the window (`app.viewport.cpu_surface` where there is none).

A surface shows one scene, or two beside each other (`Split`). Over the image of each it takes a better one that was
computed elsewhere (the reference); that goes with the scene, and at once when another is shown.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSize, QTimer, Signal
from PySide6.QtGui import QColor, QOffscreenSurface, QOpenGLContext, QSurfaceFormat

from app.viewport.gl_widget import GlWidget
from app.viewport.refining import MOVING_S, STILL_S, Quality, Refining, same
from app.widgets import theme
from engine.core.colour import Operator, srgb_decode
from engine.gl.screen import Image, Layer, Screen
from engine.render.background import Backdrop
from engine.render.display import Display
from engine.scene.scene import Scene

if TYPE_CHECKING:
    from engine.gl.context import Context, Framebuffer

Pixels = NDArray[np.float32]

#: Seconds in which the reference takes the place of the image below it.
FADE_S = 0.25

#: Bytes of an image that are read back at a time.
STRIP_BYTES = 2**21


@dataclass(frozen=True)
class Split:
    """The arrangement of two images on the screen.

    Attributes
    ----------
    wipe : share of the width that shows the first; None where only the first is seen.
    difference : full colour at ± this luminance in place of the images; None for the images themselves.
    """

    wipe: float | None = None
    difference: float | None = None


def request_format() -> None:
    """Ask for OpenGL 3.3 core; must come before the application is made. Edges are smoothed by the renderer itself."""
    wanted = QSurfaceFormat()
    wanted.setVersion(3, 3)
    wanted.setProfile(QSurfaceFormat.OpenGLContextProfile.CoreProfile)
    QSurfaceFormat.setDefaultFormat(wanted)


@cache
def why_no_gl() -> str:
    """The reason why OpenGL 3.3 cannot be used; empty where it can. Asked once: a context takes some 25 ms."""
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


def display_of(exposure_ev: float, operator: Operator) -> Display:
    """Exposure and tone mapping over the window's canvas colour."""
    canvas = QColor(theme.current().canvas)
    red, green, blue = (float(v) for v in srgb_decode([canvas.redF(), canvas.greenF(), canvas.blueF()]))
    return Display(exposure_ev, operator, (red, green, blue))


class GlSurface(GlWidget):
    """Draws through `engine.gl`: coarsely at once, then finer and finer, in pieces that leave the thread free between.

    The last images that are complete are on screen, before `behind` where that is not None. `drawn(seconds)` follows
    each one, `broken` says that this scene could not be drawn.
    """

    drawn = Signal(float)
    broken = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.scenes: tuple[Scene, ...] = ()
        self.display = display_of(0.0, "neutral")
        self.split = Split()
        self.budget_s = STILL_S
        self.behind: Backdrop | None = None
        self.messages: tuple[str, ...] = ()
        self._painted: tuple[QSize, float] | None = None
        self._sides: list[Refining] = []
        self._over = [_Over(), _Over()]
        self._screen: Screen | None = None
        self._next = QTimer(self)
        self._next.setSingleShot(True)
        self._next.setInterval(0)
        self._next.timeout.connect(lambda: self._on_guarded(self._go_on))

    @property
    def scene(self) -> Scene | None:
        return self.scenes[0] if self.scenes else None

    @property
    def quality(self) -> Quality | None:
        """Quality of the first image, None while it is of another scene."""
        return self._sides[0].quality if self._sides and self._is_shown() else None

    @property
    def is_finished(self) -> bool:
        """True if the images on screen are the finest that will be drawn of these scenes."""
        at_rest = bool(self.scenes) and self._is_shown() and self.budget_s > MOVING_S
        return (
            at_rest and len(self._sides) >= len(self.scenes) and not any(map(self._needs_more, range(len(self.scenes))))
        )

    def _needs_more(self, at: int) -> bool:
        """True if image number `at` will become finer; not while something better covers it."""
        covered = self._over[at].pixels is not None and self._sides[at].quality is not None
        return not covered and not self._sides[at].is_finished(self.budget_s)

    def _is_shown(self) -> bool:
        """True if the present or coming image is of the requested scenes and size."""
        pairs = zip(self._sides, self.scenes, strict=False)
        is_same = all(side.scene is not None and same(side.scene, scene) for side, scene in pairs)
        return is_same and self._painted == (self.size(), self.devicePixelRatioF())

    def show_scene(self, scene: Scene | None, display: Display, budget_s: float) -> None:
        """Draw `scene` with the next frame, and from then on as finely as `budget_s` seconds allow."""
        self.show_scenes(() if scene is None else (scene,), Split(), display, budget_s)

    def show_scenes(self, scenes: tuple[Scene, ...], split: Split, display: Display, budget_s: float) -> None:
        """Draw one scene or two in this way."""
        for at, over in enumerate(self._over):
            if at >= len(scenes) or at >= len(self.scenes) or not same(scenes[at], self.scenes[at]):
                over.pixels = None
        if scenes != self.scenes:
            self._next.stop()
        self.scenes, self.split, self.display, self.budget_s = scenes, split, display, budget_s
        self.update()

    def show_over(self, side: int, pixels: Pixels | None) -> None:
        """Lay (H, W, 4) over the image of scene number `side`, whatever its size; None takes it away."""
        over = self._over[side]
        if pixels is over.pixels:
            return
        if over.pixels is None:
            over.since_s = time.monotonic()
        over.pixels, over.is_new = pixels, True
        self.update()

    def strips(self, side: int) -> Iterator[Pixels]:
        """The image of scene number `side` as it was drawn, some rows at a time; none where it is a coarse one.

        Ends early where another image takes its place.
        """
        drawn = self._sides[side] if side < len(self._sides) else None
        if drawn is None or drawn.quality is None or drawn.quality.is_coarse or drawn.image is None:
            return
        image = drawn.image
        count = max(1, STRIP_BYTES // (16 * image.size[0]))
        for first in range(0, image.size[1], count):
            if self.gl is None or drawn.image is not image:
                return
            with self.current():
                rows = image.read(first, count)
            yield rows

    def begin(self) -> None:
        self._sides, self._screen = [], None
        for over in self._over:
            over.image = None
            over.is_new = True

    def paint(self, framebuffer: Framebuffer) -> None:
        if not self.scenes or min(framebuffer.size) < 1:
            self._clear(framebuffer)
            return
        self._on_guarded(lambda: self._paint(framebuffer))

    def _clear(self, framebuffer: Framebuffer) -> None:
        canvas = QColor(theme.current().canvas)
        framebuffer.clear(canvas.redF(), canvas.greenF(), canvas.blueF(), 1.0)

    def _on_guarded(self, work: Callable[[], None]) -> None:
        try:
            work()
        except Exception as error:  # the border to Qt: what leaves a paint event is raised in whatever runs next
            self.scenes = ()
            self.emit_later(self.broken, error)

    def _paint(self, framebuffer: Framebuffer) -> None:
        """Show the images; draw a first one of a scene or a size that is new."""
        self._painted = (self.size(), self.devicePixelRatioF())
        while len(self._sides) < len(self.scenes):
            self._sides.append(Refining(self.device))
        for side, scene in zip(self._sides, self.scenes, strict=False):
            side.wants(scene, framebuffer.size)
            seconds = side.draw_first()
            if seconds is not None:
                self._after(seconds)
        self._show(framebuffer)
        is_loading = any(side.is_loading for side in self._sides[: len(self.scenes)])
        if is_loading or (self.budget_s > MOVING_S and not self.is_finished):
            self._next.start()

    def _go_on(self) -> None:
        """One piece of a finer image, of the first scene that is not finished."""
        if self.gl is None or not self._is_shown():
            return
        at = next((at for at in range(len(self.scenes)) if self._needs_more(at)), None)
        if at is None:
            return
        with self.current():
            seconds = self._sides[at].go_on(self.budget_s)
        if seconds is not None:
            self._after(seconds)
            self.update()
        else:
            self._next.start()

    def _after(self, seconds: float) -> None:
        self.messages = tuple(self._sides[0].renderer.messages)
        self.emit_later(self.drawn, seconds)

    def _show(self, framebuffer: Framebuffer) -> None:
        self._screen = self._screen or Screen(self.device)
        pairs = zip(self.scenes, self._sides, self._over, strict=False)
        layers = [self._layer(side.image, over) for _, side, over in pairs if side.image is not None]
        if not layers:
            self._clear(framebuffer)
        elif len(layers) < 2:
            self._screen.show(layers[0], framebuffer, self.display, behind=self.behind)
        elif self.split.difference is not None:
            self._screen.show_difference(layers[0], layers[1], framebuffer, self.display, self.split.difference)
        else:
            width = framebuffer.size[0]
            middle = width if self.split.wipe is None else round(self.split.wipe * width)
            self._screen.show(layers[0], framebuffer, self.display, (0, middle), self.behind)
            self._screen.show(layers[1], framebuffer, self.display, (middle, width), self.behind)

    def _layer(self, image: Image, over: _Over) -> Layer:
        """The image of a scene, and the image over it."""
        if over.pixels is None:
            return Layer(image)
        over.upload(self.device)
        share = min(1.0, (time.monotonic() - over.since_s) / FADE_S)
        if share < 1.0:
            QTimer.singleShot(16, self.update)
        return Layer(image, over.image, share)

    def forget(self) -> None:
        for owner in (*self._sides, self._screen, *(over.image for over in self._over)):
            if owner is not None:
                owner.release()
        self._sides, self._screen = [], None


@dataclass(eq=False)
class _Over:
    """An image laid over the drawn one, with its time and its texture."""

    pixels: Pixels | None = None
    since_s: float = 0.0
    is_new: bool = True
    image: Image | None = None

    def upload(self, context: Context) -> None:
        assert self.pixels is not None
        if not self.is_new and self.image is not None:
            return
        size = (self.pixels.shape[1], self.pixels.shape[0])
        if self.image is None or self.image.size != size:
            if self.image is not None:
                self.image.release()
            self.image = Image(context, size)
        self.image.write(self.pixels)
        self.is_new = False
