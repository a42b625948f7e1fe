"""Images of any size, drawn in tiles into a texture of linear radiance and brought to a framebuffer.

`samples` sub-pixels along each side of a pixel are drawn and averaged (a box, symmetric about the pixel centre); with
1 the pixel centre alone. A tile has at most 2048 sub-pixels along a side, and where a window must go on meanwhile it
is drawn band by band. What is drawn is a function: it gets the matrix that makes the tile fill clip space, and draws
everything into the framebuffer that is bound, radiance and coverage of 1.

From a texture of linear radiance to a framebuffer: the mean of sub-pixels, exposure, tone mapping, sRGB coding.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.core.colour import OPERATORS
from engine.gl.context import NO_SCISSOR, Limits, Owned
from engine.gl.program import load_program, set_uniforms
from engine.render.display import Display


class ToneMapper:
    """Owns the programs that take sub-pixels to pixels, which are shown or stay linear."""

    def __init__(self, context: moderngl.Context) -> None:
        self.context = context
        self.programs = [load_program(context, "screen.vert", name) for name in ("tonemap.frag", "resolve.frag")]
        self.arrays = [context.vertex_array(program, []) for program in self.programs]

    def draw(
        self,
        radiance: moderngl.Texture,
        framebuffer: moderngl.Framebuffer,
        rectangle: tuple[int, int, int, int],
        samples: int,
        display: Display | None,
    ) -> None:
        """Show texture `radiance` in `rectangle` (left, bottom, width, height; pixels) of `framebuffer`.

        Without a `display` the framebuffer, then of floats, gets the radiance times coverage, and the coverage.
        """
        left, bottom, _, _ = rectangle
        framebuffer.use()
        framebuffer.viewport = rectangle
        self.context.disable(self.context.DEPTH_TEST | self.context.BLEND | self.context.CULL_FACE)
        radiance.use(0)
        values = {"radiance_map": 0, "first_pixel": (left, bottom), "samples": samples}
        at = 0 if display is not None else 1
        set_uniforms(self.programs[at], {**values, **(uniforms_of(display) if display is not None else {})})
        self.arrays[at].render(vertices=3)

    def release(self) -> None:
        items: tuple[Owned, ...] = (*self.arrays, *self.programs)
        for item in items:
            item.release()


def uniforms_of(display: Display) -> dict[str, object]:
    """Uniforms of tonemap.glsl."""
    return {
        "gain": 2.0**display.exposure_ev,
        "operator": OPERATORS.index(display.operator),
        "background": display.background,
    }


#: Longest side of the texture that is drawn into, in sub-pixels.
TILE = 2048

#: A part of an image: left, top, width, height in pixels.
Tile = tuple[int, int, int, int]

Paint = Callable[[NDArray[np.float64]], None]


class Tiles:
    """Owns the texture that tiles are drawn into, with its depths, and the programs that take it to an image.

    Attributes
    ----------
    invalid_samples : how many samples of the last `radiance` had a coverage above 1: a shader says so that they were
        not finite.
    """

    def __init__(self, context: moderngl.Context, texture_limits: Limits) -> None:
        self.context = context
        self.limits = texture_limits
        self.invalid_samples = 0
        self._target: tuple[tuple[int, int], moderngl.Texture, moderngl.Framebuffer] | None = None
        self._tone_mapper: ToneMapper | None = None

    def draw(
        self, paint: Paint, framebuffer: moderngl.Framebuffer, size: tuple[int, int], samples: int, display: Display
    ) -> None:
        """Draw tone-mapped and sRGB-coded over `framebuffer`, whose `size` is (width, height) in pixels."""
        for tile, texture in self.each(paint, size, samples):
            self._show(tile, texture, framebuffer, size, samples, display)

    def bands(
        self, paint: Paint, framebuffer: moderngl.Framebuffer, size: tuple[int, int], samples: int
    ) -> Generator[None, int, None]:
        """The linear image in pieces, for a thread that has more to do: each `send(rows)` draws so many rows.

        Rows are of sub-pixels. The float32 `framebuffer` (`engine.gl.screen.Image`) holds radiance times coverage,
        and coverage, when the generator ends; with 1, 2 or 4 samples they show what `draw` shows to the bit. Other
        drawing with these tiles in the meantime spoils it.
        """
        for tile in self._cut(size, samples):
            done, rows = 0, tile[3] * samples
            while done < rows:
                wanted = yield
                texture = self._shade(paint, size, tile, samples, (done, min(wanted, rows - done)))
                done += wanted
            self._show(tile, texture, framebuffer, size, samples, None)

    def radiance(self, paint: Paint, size: tuple[int, int], samples: int) -> NDArray[np.float32]:
        """The image (height, width, 4) float32, row 0 on top: linear radiance times coverage, and coverage."""
        image = np.zeros((size[1], size[0], 4), np.float32)
        self.invalid_samples = 0
        for (left, top, width, height), texture in self.each(paint, size, samples):
            texels = np.frombuffer(texture.read(), np.float32).reshape(texture.height, texture.width, 4)
            part = texels[: height * samples, : width * samples]
            self.invalid_samples += int(np.sum(part[..., 3] > 1.5))
            blocks = np.minimum(part, (np.inf, np.inf, np.inf, 1.0)).reshape(height, samples, width, samples, 4)
            image[top : top + height, left : left + width] = blocks.mean(axis=(1, 3), dtype=np.float64)[::-1]
        return image

    def each(self, paint: Paint, size: tuple[int, int], samples: int) -> Iterator[tuple[Tile, moderngl.Texture]]:
        """Draw tile by tile; yields each and the texture whose lower left holds it."""
        for tile in self._cut(size, samples):
            yield tile, self._shade(paint, size, tile, samples, (0, tile[3] * samples))

    def _cut(self, size: tuple[int, int], samples: int) -> Iterator[Tile]:
        if samples < 1:
            raise ValueError(f"samples = {samples} must be at least 1")
        edge = self._edge(samples)
        for top in range(0, size[1], edge):
            for left in range(0, size[0], edge):
                yield left, top, min(edge, size[0] - left), min(edge, size[1] - top)

    def _edge(self, samples: int) -> int:
        return max(1, min(TILE, self.limits.texture_size) // samples)

    def _shade(
        self, paint: Paint, size: tuple[int, int], tile: Tile, samples: int, band: tuple[int, int]
    ) -> moderngl.Texture:
        """Draw the rows `band` (first, count) of sub-pixels of `tile`, from below; returns the texture they are in."""
        edge = self._edge(samples)
        texture, target = self._make_target((min(size[0], edge) * samples, min(size[1], edge) * samples))
        target.use()
        target.viewport = (0, 0, tile[2] * samples, tile[3] * samples)
        target.scissor = (0, band[0], tile[2] * samples, band[1])
        target.clear(0.0, 0.0, 0.0, 0.0)
        self.context.enable_only(self.context.DEPTH_TEST)
        try:
            paint(_tile_from_clip(tile, size))
        finally:
            target.scissor = NO_SCISSOR
        return texture

    def _show(
        self,
        tile: Tile,
        texture: moderngl.Texture,
        framebuffer: moderngl.Framebuffer,
        size: tuple[int, int],
        samples: int,
        display: Display | None,
    ) -> None:
        if self._tone_mapper is None:
            self._tone_mapper = ToneMapper(self.context)
        left, top, width, height = tile
        rectangle = (left, size[1] - top - height, width, height)
        self._tone_mapper.draw(texture, framebuffer, rectangle, samples, display)

    def _make_target(self, size: tuple[int, int]) -> tuple[moderngl.Texture, moderngl.Framebuffer]:
        if self._target is None or self._target[0] != size:
            self._release_target()
            colour = self.context.texture(size, 4, dtype="f4")
            colour.filter = (self.context.NEAREST, self.context.NEAREST)
            depth = self.context.depth_renderbuffer(size)
            self._target = (size, colour, self.context.framebuffer([colour], depth))
        return self._target[1:]

    def _release_target(self) -> None:
        if self._target is not None:
            _, texture, framebuffer = self._target
            # a new framebuffer restores the one bound before it, which must not be one that is gone
            self.context.detect_framebuffer(0).use()
            for item in (framebuffer, framebuffer.depth_attachment, texture):
                item.release()
            self._target = None

    def release(self) -> None:
        """Free everything; the tiles can be used again afterwards."""
        if self._tone_mapper is not None:
            self._tone_mapper.release()
        self._release_target()
        self._tone_mapper = None


def _tile_from_clip(tile: Tile, size: tuple[int, int]) -> NDArray[np.float64]:
    """(4, 4) matrix that makes the tile (left, top, width, height) of an image of `size` fill clip space."""
    left, top, width, height = tile
    matrix = np.eye(4)
    matrix[0, 0], matrix[1, 1] = size[0] / width, size[1] / height
    matrix[0, 3] = (size[0] - 2.0 * left) / width - 1.0
    matrix[1, 3] = 1.0 - (size[1] - 2.0 * top) / height
    return matrix
