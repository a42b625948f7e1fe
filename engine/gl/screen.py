"""Images of linear radiance in GPU memory, and how they are brought to the screen: one, two side by side, or apart.

A `Layer` is an image and, by a share, a better one laid over it. Images of fewer pixels than the screen are
enlarged. Exposure and tone mapping come last, so that another exposure needs no other image; what they make of an
image is kept, so that showing it again copies bytes.
"""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.core.colour import srgb_decode
from engine.gl.context import NO_SCISSOR, Owned
from engine.gl.program import load_program, set_uniforms
from engine.gl.tiles import uniforms_of
from engine.light.environment import EnvironmentMap, reduce
from engine.render.background import Backdrop
from engine.render.display import BLUE, GREY, ORANGE, Display

#: Exposure and tone mapping of an image, and the environment behind it.
Shown = tuple[Display, Backdrop | None]

#: Rows of an environment behind an image, at most: finer ones would be seen on no screen.
MAX_ROWS = 1024


class Image:
    """Owns a texture of float32 (radiance times coverage, and coverage) of `size` (width, height).

    Attributes
    ----------
    coded : the same as it was shown last, sRGB-coded in 8 bits, and for which display and backdrop; None before.
    """

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.context, self.size = context, size
        self.texture = context.texture(size, 4, dtype="f4")
        self.texture.filter = (context.LINEAR, context.LINEAR)
        self.texture.repeat_x = self.texture.repeat_y = False
        self.framebuffer = context.framebuffer([self.texture])
        self.coded: tuple[Shown, moderngl.Texture, moderngl.Framebuffer] | None = None

    def write(self, pixels: NDArray[np.float32]) -> None:
        """Take (height, width, 4) float32, row 0 on top."""
        self.texture.write(np.ascontiguousarray(pixels[::-1], np.float32))
        self._forget_coded()

    def _forget_coded(self) -> None:
        if self.coded is not None:
            # a new framebuffer restores the one bound before it, which must not be one that is gone
            self.context.detect_framebuffer(0).use()
            _, texture, framebuffer = self.coded
            self.coded = None
            framebuffer.release()
            texture.release()

    def target(self, shown: Shown) -> moderngl.Framebuffer:
        """A framebuffer of 8 bits and of the image's size, for the image as it is `shown`."""
        self._forget_coded()
        texture = self.context.texture(self.size, 4)
        texture.filter = (self.context.LINEAR, self.context.LINEAR)
        texture.repeat_x = texture.repeat_y = False
        self.coded = (shown, texture, self.context.framebuffer([texture]))
        return self.coded[2]

    def read(self, first: int = 0, count: int | None = None) -> NDArray[np.float32]:
        """`count` rows from row `first` (0 on top), (count, width, 4)."""
        width, height = self.size
        count = height - first if count is None else min(count, height - first)
        below = (0, height - first - count, width, count)
        content = self.framebuffer.read(viewport=below, components=4, dtype="f4")
        return np.frombuffer(content, np.float32).reshape(count, width, 4)[::-1]

    def release(self) -> None:
        self._forget_coded()
        self.context.detect_framebuffer(0).use()
        self.framebuffer.release()
        self.texture.release()


@dataclass(frozen=True, eq=False)
class Layer:
    """An image and, where there is one, another that covers it by `share` in [0, 1]."""

    image: Image
    over: Image | None = None
    share: float = 0.0

    def uniforms(self, name: str, unit: int) -> dict[str, object]:
        """Bind the textures from texture unit `unit` on; returns what the shader has to know."""
        over = self.over if self.over is not None else self.image
        self.image.texture.use(unit)
        over.texture.use(unit + 1)
        share = self.share if self.over is not None else 0.0
        return {name: unit, f"{name}_over": unit + 1, f"{name}_share": share}


class Screen:
    """Owns the programs that show layers."""

    def __init__(self, context: moderngl.Context) -> None:
        self.context = context
        self._shown = load_program(context, "screen.vert", "show.frag")
        self._before: moderngl.Program | None = None
        self._sky: tuple[EnvironmentMap, moderngl.Texture] | None = None
        self._apart = load_program(context, "screen.vert", "show.frag", {"DIFFERENCE": "1"})
        self._copied = load_program(context, "screen.vert", "copy.frag")
        programs = (self._shown, self._apart, self._copied)
        self._arrays = {id(program): context.vertex_array(program, []) for program in programs}

    def show(
        self,
        layer: Layer,
        framebuffer: moderngl.Framebuffer,
        display: Display,
        columns: tuple[int, int] | None = None,
        behind: Backdrop | None = None,
    ) -> None:
        """Show `layer` over `framebuffer`, or only over its `columns` (first, end) of pixels, before `behind`."""
        first, end = columns if columns is not None else (0, framebuffer.size[0])
        if end <= first:
            return
        share = layer.share if layer.over is not None else 0.0
        whole = layer.over if share >= 1.0 else layer.image if share <= 0.0 else None
        program, shown = self._shown if behind is None else self._program_before(), (display, behind)
        if whole is not None and (whole.coded is None or whole.coded[0] != shown):
            values = {**Layer(whole).uniforms("first", 0), **uniforms_of(display), **self._behind(behind, whole.size)}
            self._draw(program, whole.target(shown), values)
        framebuffer.scissor = (first, 0, end - first, framebuffer.size[1])
        if whole is not None and whole.coded is not None:
            whole.coded[1].use(0)
            self._draw(self._copied, framebuffer, {"picture": 0})
        else:
            values = {**layer.uniforms("first", 0), **uniforms_of(display), **self._behind(behind, framebuffer.size)}
            self._draw(program, framebuffer, values)
        framebuffer.scissor = NO_SCISSOR

    def _program_before(self) -> moderngl.Program:
        """The program that shows an image before an environment, compiled when it is first wanted."""
        if self._before is None:
            self._before = load_program(self.context, "screen.vert", "show.frag", {"BEHIND": "1"})
            self._arrays[id(self._before)] = self.context.vertex_array(self._before, [])
        return self._before

    def _behind(self, backdrop: Backdrop | None, size: tuple[int, int]) -> dict[str, object]:
        """Bind the environment, and what the shader has to know of it for an image of `size`."""
        if backdrop is None:
            return {}
        if self._sky is None or self._sky[0] is not backdrop.environment:
            self._forget_sky()
            radiance = reduce(backdrop.environment, MAX_ROWS).radiance
            texture = self.context.texture(
                radiance.shape[1::-1], 3, np.ascontiguousarray(radiance).tobytes(), dtype="f4"
            )
            texture.filter = (self.context.LINEAR, self.context.LINEAR)
            texture.repeat_x, texture.repeat_y = True, False
            self._sky = (backdrop.environment, texture)
        self._sky[1].use(4)
        camera, extent = backdrop.camera, np.tan(np.radians(backdrop.camera.fov_deg) / 2.0)
        cosine, sine = np.cos(backdrop.rotation), np.sin(backdrop.rotation)
        map_from_world = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
        map_from_camera = map_from_world @ camera.camera_from_world.T
        return {
            "environment": 4,
            "environment_gain": backdrop.gain,
            "map_from_camera": tuple(map_from_camera.T.ravel()),  # column by column
            "extent": (extent * size[0] / size[1], extent),
        }

    def _forget_sky(self) -> None:
        if self._sky is not None:
            self._sky[1].release()
            self._sky = None

    def show_difference(
        self, a: Layer, b: Layer, framebuffer: moderngl.Framebuffer, display: Display, scale: float
    ) -> None:
        """Show the luminance of `a` less that of `b` as `diverging` does, full at ±`scale`."""
        colours = {"below": BLUE, "above": ORANGE, "grey": GREY}
        values = {name: tuple(float(v) for v in srgb_decode(list(colour))) for name, colour in colours.items()}
        layers = {**a.uniforms("first", 0), **b.uniforms("second", 2)}
        self._draw(self._apart, framebuffer, {**layers, **uniforms_of(display), **values, "scale": scale})

    def _draw(self, program: moderngl.Program, framebuffer: moderngl.Framebuffer, values: dict[str, object]) -> None:
        framebuffer.use()
        framebuffer.viewport = (0, 0, *framebuffer.size)
        self.context.disable(self.context.DEPTH_TEST | self.context.BLEND | self.context.CULL_FACE)
        set_uniforms(program, {**values, "size": framebuffer.size})
        self._arrays[id(program)].render(vertices=3)

    def release(self) -> None:
        self._forget_sky()
        programs = (self._shown, self._apart, self._copied, *([self._before] if self._before is not None else []))
        items: tuple[Owned, ...] = (*self._arrays.values(), *programs)
        for item in items:
            item.release()
