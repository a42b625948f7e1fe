"""One image without a window, and how long its frame takes; or the frames of a film, one after the other."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.geometry.camera import Camera
from engine.gl.context import limits, renderer_name
from engine.gl.direct import DirectRenderer
from engine.gl.transported import TransportRenderer
from engine.scene.scene import Scene
from engine.transport.relight import RelightTransport

#: An image (height, width, 4), the seconds of one frame, the device's name, and messages.
OffScreen = tuple[NDArray[np.float32], float, str, list[str]]

#: Images (height, width, 4), to be closed before the context.
Frames = Generator[NDArray[np.float32], None, None]


def draw_off_screen(context: moderngl.Context, scene: Scene, size: tuple[int, int], samples: int = 2) -> OffScreen:
    """The image of `DirectRenderer.radiance`.

    The frame is drawn and tone-mapped into a framebuffer of its size as a window does, once to compile and upload and
    once for the time.
    """
    renderer = DirectRenderer(context)
    try:
        image = renderer.radiance(scene, size, samples=samples)
        frame_s = _frame_s(context, size, lambda target, shown: renderer.draw(scene, target, shown, samples=samples))
        return image, frame_s, renderer_name(context), renderer.messages
    finally:
        renderer.release()


def relight_off_screen(
    context: moderngl.Context, relit: RelightTransport, camera: Camera, size: tuple[int, int], samples: int = 2
) -> OffScreen:
    """The image of `TransportRenderer.radiance`, timed in the same way."""
    renderer = TransportRenderer(context)
    try:
        image = renderer.radiance(relit, camera, size, samples=samples)
        frame_s = _frame_s(
            context, size, lambda target, shown: renderer.draw(relit, camera, target, shown, samples=samples)
        )
        return image, frame_s, renderer_name(context), renderer.messages
    finally:
        renderer.release()


def frames_off_screen(
    context: moderngl.Context, scenes: Iterable[Scene], size: tuple[int, int], samples: int = 2
) -> Frames:
    """The image of each scene; models and materials that they share are uploaded once."""
    renderer = DirectRenderer(context)
    try:
        for scene in scenes:
            yield renderer.radiance(scene, size, samples=samples)
    finally:
        renderer.release()


def relight_frames_off_screen(
    context: moderngl.Context, relit: Iterable[tuple[RelightTransport, Camera]], size: tuple[int, int], samples: int = 2
) -> Frames:
    """The image of each relit bake with its camera."""
    renderer = TransportRenderer(context)
    try:
        for each, camera in relit:
            yield renderer.radiance(each, camera, size, samples=samples)
    finally:
        renderer.release()


def _frame_s(
    context: moderngl.Context, size: tuple[int, int], draw: Callable[[moderngl.Framebuffer, tuple[int, int]], None]
) -> float:
    """Seconds for one frame when everything is compiled and uploaded, tone mapping included."""
    most = limits(context).texture_size
    shown = (min(size[0], most), min(size[1], most))
    framebuffer = context.simple_framebuffer(shown, 4)
    try:
        draw(framebuffer, shown)
        context.finish()
        start = time.perf_counter()
        draw(framebuffer, shown)
        context.finish()
        return time.perf_counter() - start
    finally:
        for item in (*framebuffer.color_attachments, framebuffer.depth_attachment, framebuffer):
            item.release()
