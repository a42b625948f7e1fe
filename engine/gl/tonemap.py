"""From a texture of linear radiance to a framebuffer that is shown: resolve, exposure, tone mapping, sRGB coding."""

from __future__ import annotations

from typing import Any

from engine.colour import OPERATORS
from engine.gl.program import load_program, set_uniforms
from engine.render.display import Display


class ToneMapper:
    """Owns the program that resolves and tone-maps."""

    def __init__(self, context: Any) -> None:
        self.context = context
        self.program = load_program(context, "screen.vert", "tonemap.frag")
        self.array = context.vertex_array(self.program, [])

    def draw(
        self, radiance: Any, framebuffer: Any, rectangle: tuple[int, int, int, int], samples: int, display: Display
    ) -> None:
        """Show texture `radiance` in `rectangle` (left, bottom, width, height; pixels) of `framebuffer`."""
        left, bottom, _, _ = rectangle
        framebuffer.use()
        framebuffer.viewport = rectangle
        self.context.disable(self.context.DEPTH_TEST | self.context.BLEND | self.context.CULL_FACE)
        radiance.use(0)
        values = {
            "radiance_map": 0,
            "first_pixel": (left, bottom),
            "samples": samples,
            "gain": 2.0**display.exposure_ev,
            "operator": OPERATORS.index(display.operator),
            "background": display.background,
        }
        set_uniforms(self.program, values)
        self.array.render(vertices=3)

    def release(self) -> None:
        self.array.release()
        self.program.release()
