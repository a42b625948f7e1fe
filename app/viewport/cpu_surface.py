"""The drawing surface of the viewport without OpenGL: images that the CPU computes, in jobs."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from PySide6.QtCore import QRectF, Signal
from PySide6.QtGui import QColor, QImage, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from app.jobs.jobs import Jobs
from app.jobs.newest import Latest
from app.viewport.gl_surface import Pixels, Split, display_of
from app.viewport.refining import MOVING_S, same
from app.widgets import theme
from app.widgets.image_view import rgb_image
from engine.core.colour import luminance
from engine.core.steps import Step, Steps
from engine.render.background import Backdrop
from engine.render.display import Display, diverging
from engine.render.display import display as display_image
from engine.render.shadowed import draw
from engine.scene.scene import Scene


class CpuSurface(QWidget):
    """Draws on the CPU, in jobs: coarse while something moves, then in full, band after band."""

    drawn = Signal(float)

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.scenes: tuple[Scene, ...] = ()
        self.split = Split()
        self.display = display_of(0.0, "neutral")
        self.behind: Backdrop | None = None
        self.messages: tuple[str, ...] = ()
        self._rendering = [Latest(jobs, "Rendering", refines=True) for _side in range(2)]
        self._showing = Latest(jobs, "Showing an image")
        self._frames: list[Pixels | None] = [None, None]
        self._over: list[Pixels | None] = [None, None]
        self._wanted: list[tuple[Scene, tuple[int, int]] | None] = [None, None]
        self._images: tuple[QImage, ...] = ()
        self._is_moving = False
        self._seconds = 0.0

    @property
    def is_finished(self) -> bool:
        """True if the images on screen are whole."""
        return not (self._is_moving or self._showing.busy or any(one.busy for one in self._rendering))

    def show_scene(self, scene: Scene | None, display: Display, budget_s: float) -> None:
        """Ask for an image of `scene`; it is shown when it is done."""
        self.show_scenes(() if scene is None else (scene,), Split(), display, budget_s)

    def show_scenes(self, scenes: tuple[Scene, ...], split: Split, display: Display, budget_s: float) -> None:
        """Ask for images of one scene or two."""
        if not scenes or self.width() < 1 or self.height() < 1:
            return
        self.scenes, self.split, self.display = scenes, split, display
        self._is_moving = budget_s <= MOVING_S
        share = 0.3 if self._is_moving else 1.0
        scale = self.devicePixelRatioF() * share
        size = (max(1, round(self.width() * scale)), max(1, round(self.height() * scale)))
        for at, scene in enumerate(scenes):
            before = self._wanted[at]
            if before is None or not same(before[0], scene):
                self._over[at] = None
            if before is None or before[1] != size or not same(before[0], scene):
                self._wanted[at] = (scene, size)
                self._ask(at, scene, size)
        self._refresh()

    def _ask(self, at: int, scene: Scene, size: tuple[int, int]) -> None:
        self._rendering[at].ask(lambda: _compute(scene, size), lambda found: self._take(at, *found))

    def _take(self, at: int, frame: Pixels, seconds: float) -> None:
        self._frames[at], self._seconds = frame, seconds
        self._refresh()

    def show_over(self, side: int, pixels: Pixels | None) -> None:
        """Show (H, W, 4) in place of the image of scene number `side`; None shows that image again."""
        if pixels is not self._over[side]:
            self._over[side] = pixels
            self._refresh()

    def strips(self, side: int) -> Iterator[Pixels]:
        """The image of scene number `side`, in one piece."""
        frame = self._frames[side]
        if frame is not None and not self._rendering[side].busy:
            yield frame

    def _refresh(self) -> None:
        chosen = [self._frames[at] if self._over[at] is None else self._over[at] for at in range(len(self.scenes))]
        found = [frame for frame in chosen if frame is not None]
        if len(found) == len(self.scenes):
            display, scale, behind = self.display, self.split.difference, self.behind
            if behind is not None and scale is None:
                found = [behind.behind(frame) for frame in found]
            self._showing.ask(lambda: _images(found, display, scale), self._show)

    def _show(self, images: tuple[QImage, ...]) -> None:
        self._images = images
        self.drawn.emit(self._seconds)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(theme.current().canvas))
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        middle = self.width() if self.split.wipe is None else self.split.wipe * self.width()
        for at, image in enumerate(self._images):
            if at:
                painter.setClipRect(QRectF(middle, 0, self.width() - middle, self.height()))
            painter.drawImage(QRectF(self.rect()), image)


def _compute(scene: Scene, size: tuple[int, int]) -> Steps[tuple[Pixels, float]]:
    yield Step(0.0, "rendering on the CPU")
    started = time.perf_counter()
    frame = yield from draw(scene, size, 1)
    return frame, time.perf_counter() - started


def _images(frames: list[Pixels], display: Display, scale: float | None) -> Steps[tuple[QImage, ...]]:
    """The images as a screen shows them; or, with a `scale`, the difference of the two."""
    yield Step(0.0, "showing an image")
    if scale is None or len(frames) < 2 or frames[0].shape != frames[1].shape:
        return tuple(rgb_image(display_image(frame, display)) for frame in frames)
    apart = luminance(frames[0][..., :3]) - luminance(frames[1][..., :3])
    covered = np.minimum(frames[0][..., 3], frames[1][..., 3]) > 0.999
    empty = display_image(np.zeros((1, 1, 4), np.float32), display)
    return (rgb_image(np.where(covered[..., None], diverging(apart / scale), empty)),)
