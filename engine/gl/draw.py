"""One picture without a window, and how long its frame takes."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.gl.context import renderer_name
from engine.gl.direct import DirectRenderer
from engine.scene import Scene


def draw_off_screen(
    context: Any, scene: Scene, size: tuple[int, int], samples: int = 2
) -> tuple[NDArray[np.float32], float, str, list[str]]:
    """The picture of `DirectRenderer.radiance`, the seconds of one frame, the device's name, and messages.

    The frame is drawn and tone-mapped into a framebuffer of its size as a window does, once to compile and upload and
    once for the time.
    """
    renderer = DirectRenderer(context)
    try:
        picture = renderer.radiance(scene, size, samples=samples)
        return picture, frame_time(renderer, scene, size, samples), renderer_name(context), renderer.messages
    finally:
        renderer.release()


def frame_time(renderer: DirectRenderer, scene: Scene, size: tuple[int, int], samples: int = 2) -> float:
    """Seconds for one frame of `scene` when everything is compiled and uploaded, tone mapping included."""
    context = renderer.context
    most = renderer.limits.texture_size
    shown = (min(size[0], most), min(size[1], most))
    framebuffer = context.simple_framebuffer(shown, 4)
    try:
        renderer.draw(scene, framebuffer, shown, samples=samples)
        context.finish()
        start = time.perf_counter()
        renderer.draw(scene, framebuffer, shown, samples=samples)
        context.finish()
        return time.perf_counter() - start
    finally:
        for item in (*framebuffer.color_attachments, framebuffer.depth_attachment, framebuffer):
            item.release()
