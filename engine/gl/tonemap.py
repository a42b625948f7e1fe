"""From a texture of linear radiance to a framebuffer: the mean of sub-pixels, exposure, tone mapping, sRGB coding."""

from __future__ import annotations

from typing import Any

from engine.colour import OPERATORS
from engine.gl.program import load_program, set_uniforms
from engine.render.display import Display


class ToneMapper:
    """Owns the programs that take sub-pixels to pixels, which are shown or stay linear."""

    def __init__(self, context: Any) -> None:
        self.context = context
        self.programs = [load_program(context, "screen.vert", name) for name in ("tonemap.frag", "resolve.frag")]
        self.arrays = [context.vertex_array(program, []) for program in self.programs]

    def draw(
        self,
        radiance: Any,
        framebuffer: Any,
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
        for item in (*self.arrays, *self.programs):
            item.release()


def uniforms_of(display: Display) -> dict[str, Any]:
    """What tonemap.glsl wants to know."""
    return {
        "gain": 2.0**display.exposure_ev,
        "operator": OPERATORS.index(display.operator),
        "background": display.background,
    }
