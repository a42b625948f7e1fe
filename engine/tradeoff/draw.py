"""Images and the time of their frames, with OpenGL where there is any, else on the CPU.

A frame is what a window draws when only the camera has moved: everything is compiled and uploaded, tone mapping is part
of it. It is timed several times and the shortest counts, as in `engine.core.stopwatch`.

The vertices that images of a scene need: those of the faces that its camera sees, and of the faces around them.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import MODELS
from engine.core.errors import MissingCapability
from engine.core.steps import Step, Steps
from engine.core.stopwatch import shortest
from engine.geometry.ray_caster import caster_of
from engine.gl.brdf_textures import factor_source
from engine.gl.context import create_context, renderer_name
from engine.gl.scene_renderer import SceneRenderer
from engine.render.shadowed import draw as draw_shadowed
from engine.scene.scene import Scene

if TYPE_CHECKING:
    from engine.gl.context import Context

#: Frames that are timed after one that warms up, and the seconds after which no further one begins.
FRAMES, LONG_ENOUGH_S = 5, 1.0

#: A frame that takes so many seconds the first time is not drawn again to be timed.
FAR_TOO_LONG_S = 2.0

#: Sub-pixels along a side of a pixel.
SAMPLES = 2

Image = NDArray[np.float32]
ON_CPU = "none (drawn on the CPU)"


@dataclass(frozen=True, eq=False)
class Drawn:
    """An image (height, width, 4) of linear radiance times coverage, and coverage, and the seconds of its frame."""

    image: Image
    frame_s: float


class Drawer:
    """Draws scenes in one size; `device` names what draws. Made by `drawing`, and used on the thread that made it."""

    def __init__(self, size: tuple[int, int], context: Context | None = None) -> None:
        self.size = size
        self._context = context
        self.device = ON_CPU if context is None else renderer_name(context)
        self._stack = ExitStack()
        if context is not None:
            self._renderer = SceneRenderer(context)
            self._target = context.framebuffer([context.renderbuffer(size)])
            for owner in (self._renderer, self._target):
                self._stack.callback(owner.release)

    def draw(self, scene: Scene) -> Steps[Drawn]:
        """The image of `scene`, of its bake where it has one."""
        yield Step(0.0, "drawing")
        context = self._context
        if context is None or not _has_shader(scene):
            return (yield from self._on_cpu(scene))
        with context:

            def frame() -> None:
                self._renderer.draw(scene, self._target, self.size, samples=SAMPLES)
                context.finish()

            started = time.perf_counter()
            image = self._renderer.radiance(scene, self.size, samples=SAMPLES)
            passed = time.perf_counter() - started
            return Drawn(image, passed if passed > FAR_TOO_LONG_S else shortest(frame, FRAMES, LONG_ENOUGH_S))

    def _on_cpu(self, scene: Scene) -> Steps[Drawn]:
        started = time.perf_counter()
        image = yield from draw_shadowed(scene, self.size, SAMPLES)
        return Drawn(image, time.perf_counter() - started)

    def release(self) -> None:
        self._stack.close()


def _has_shader(scene: Scene) -> bool:
    """True if OpenGL shows the BRDF as it is."""
    brdf = scene.brdf
    return scene.relit is not None or brdf.isotropic or type(brdf) in MODELS.values() or factor_source(brdf) is not None


@contextmanager
def drawing(size: tuple[int, int]) -> Iterator[Drawer]:
    """A `Drawer` for images of `size` (width, height), on the CPU where there is no OpenGL."""
    with ExitStack() as stack:
        context = None
        try:
            context = create_context()
            stack.callback(context.release)
        except MissingCapability:
            pass
        drawer = Drawer(size, context)
        stack.callback(drawer.release)
        yield drawer


def find_shown_vertices(scene: Scene, size: tuple[int, int], samples: int) -> NDArray[np.int64]:
    """Vertices of model and ground, rising, for images of `size` (width, height), `samples` along a side of a pixel.

    Faces around those that are seen belong to them: drawn on a grid or by rays, an edge may fall on either side.
    """
    surface = scene.surface
    width, height = size[0] * samples, size[1] * samples
    column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    directions = scene.camera.rays(column, row, width, height).reshape(-1, 3)
    hits = caster_of(surface).intersect(np.broadcast_to(scene.camera.eye, directions.shape), directions)
    needed = np.zeros(len(surface.positions), np.bool_)
    needed[surface.faces[np.unique(hits.face[hits.face >= 0])]] = True
    needed[surface.faces[needed[surface.faces].any(axis=1)]] = True
    return np.flatnonzero(needed)
