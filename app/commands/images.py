"""An image or a film of the View workspace as a file, in the work of a job: any size, background and layers.

OpenGL draws in tiles, off screen and in a context of the job's own, so that neither the screen nor the largest texture
of the device bounds the image; where there is none, the CPU draws. The reference traces paths, and stores its
standard error as a layer.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from engine.core.errors import MissingCapability, UsageError
from engine.core.steps import Step, Steps, part
from engine.gl.context import create_context
from engine.render.background import blur, in_front_of
from engine.render.display import display as display_image
from engine.render.display import display_apart
from engine.render.layers import layers as all_layers
from engine.render.path import check_scene
from engine.render.reference import reference
from engine.render.shadowed import draw
from engine.render.turntable import frames
from engine.storage.atomic import write_bytes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from app.document.modes import Mode
    from engine.gl.context import Context
    from engine.gl.scene_renderer import SceneRenderer
    from engine.render.display import Display
    from engine.render.turntable import Turns
    from engine.scene.scene import Scene
    from engine.transport.relight import RelightTransport

Background = Literal["plain", "environment", "transparent"]

#: Most pixels of an image, as of the command line, and largest side of a film.
MAX_PIXELS, MAX_FILM_PX = 2**28, 16383

SOFTWARE = "Lightarc"


@dataclass(frozen=True)
class Saving:
    """The file that is wanted.

    Attributes
    ----------
    size : (width, height) in pixels.
    blur_deg : of the environment behind the model.
    frames : of a film of one turn; 0 for an image. turns, fps : as in `lightarc render --turntable`.
    samples : sub-pixels along a side, and paths of a pixel of the reference.
    layers : whether an .exr has albedo and normals too.
    """

    path: Path
    size: tuple[int, int] = (1920, 1080)
    background: Background = "plain"
    blur_deg: float = 0.0
    frames: int = 0
    turns: Turns = "model"
    fps: float = 30.0
    samples: int = 2
    paths: int = 64
    layers: bool = False

    @property
    def why_not(self) -> str:
        """The reason why there can be no such file; empty where there can."""
        width, height = self.size
        suffix = self.path.suffix.lower()
        if min(width, height) < 2 or width * height > MAX_PIXELS:
            return f"{width} × {height} pixels are not possible"
        if not self.frames:
            return "" if suffix in (".png", ".exr") else "An image is a .png or an .exr file"
        if suffix not in ("", ".mp4", ".webp"):
            return "A film is an .mp4 or .webp file, or a folder of PNG"
        if max(self.size) > MAX_FILM_PX:
            return f"A film has at most {MAX_FILM_PX} pixels along a side"
        return "An .mp4 has no transparency" if suffix == ".mp4" and self.background == "transparent" else ""


def code(image: NDArray[np.float32], display: Display, background: Background) -> NDArray[np.uint8]:
    """The image as a screen shows it, (H, W, 3), or (H, W, 4) with the opacity of a transparent background."""
    return display_apart(image, display) if background == "transparent" else display_image(image, display)


def write_image(
    path: str | Path,
    image: NDArray[np.float32],
    display: Display,
    layers: dict[str, NDArray[np.float32]] | None = None,
    background: Background = "plain",
    software: str = SOFTWARE,
) -> None:
    """Tone-mapped, or the radiance: in half, as float where `layers` are stored beside it to measure by."""
    from engine.images.encode import encode_png, rgb_channels, write_exr

    if str(path).lower().endswith(".exr"):
        channels = rgb_channels(image[..., :3])
        if background == "transparent":
            channels |= {"A": image[..., 3]}
        for name, layer in (layers or {}).items():
            channels |= rgb_channels(layer, name)
        write_exr(path, channels, half=not layers, attributes={"software": software})
    else:
        write_bytes(path, encode_png(code(image, display, background), software=software))


#: Relights the bake of a mode by the light of a scene.
Relighting = Callable[["Scene"], "Steps[RelightTransport]"]


def save(
    scene: Scene, saving: Saving, display: Display, mode: Mode, relighting: Relighting | None = None, bounces: int = 0
) -> Steps[str]:
    """Draw `scene` in `mode` and write it; the sentence that says so. UsageError where `Saving.why_not` says why."""
    yield Step(0.0, "preparing")
    from engine.images.animation import film

    if saving.why_not:
        raise UsageError(saving.why_not)
    environment = scene.environment if saving.background == "environment" else None
    behind = blur(environment, radians(saving.blur_deg)) if environment is not None else None
    device = _Device()

    def draw(each: Scene) -> Steps[tuple[NDArray[np.float32], dict[str, Any]]]:
        image, found = yield from device.image(each, saving, mode, relighting, bounces)
        if behind is not None:
            image = in_front_of(image, each.camera, behind, each.environment_rotation, each.irradiance)
        return image, found

    try:
        if not saving.frames:
            image, layers = yield from part(draw(scene), 0.0, 0.9)
            if saving.layers and saving.path.suffix.lower() == ".exr":
                layers |= yield from part(all_layers(scene, saving.size), 0.9, 0.97)
            yield Step(0.97, "writing")
            write_image(saving.path, image, display, layers, saving.background)
        else:
            with film(saving.path, saving.size, saving.fps, software=SOFTWARE) as keep:
                for number, each in enumerate(frames(scene, saving.frames, saving.turns)):
                    first, last = number / saving.frames, (number + 1) / saving.frames
                    image, _ = yield from part(draw(each), first, last)
                    keep(code(image, display, saving.background))
                    yield Step(last, f"frame {number + 1} of {saving.frames}")
    finally:
        device.release()
    what = f"{saving.frames} frames of " if saving.frames else ""
    return f"{saving.path.name} saved: {what}{saving.size[0]} × {saving.size[1]} pixels"


class _Device:
    """Draws images with OpenGL in a context of its own, made on the thread that asks first, or on the CPU."""

    def __init__(self) -> None:
        self.made: tuple[Context, SceneRenderer] | None = None
        self.is_asked = False

    def image(
        self, scene: Scene, saving: Saving, mode: Mode, relighting: Relighting | None, bounces: int
    ) -> Steps[tuple[NDArray[np.float32], dict[str, Any]]]:
        """The image (height, width, 4) of a scene, and its layers."""
        if mode.progressive:
            return (yield from _reference(scene, saving, bounces))
        if mode.baked:
            if relighting is None:
                raise UsageError("There is no bake yet: bake this mode first")
            scene = replace(scene, relit=(yield from part(relighting(scene), 0.0, 0.4)))
        if (made := self._make()) is not None:
            context, renderer = made
            yield Step(0.4, "drawing")
            with context:
                return renderer.radiance(scene, saving.size, samples=saving.samples), {}
        return (yield from part(draw(scene, saving.size, saving.samples), 0.4, 1.0)), {}

    def _make(self) -> tuple[Context, SceneRenderer] | None:
        """The context and its renderer, made when they are first asked for; None where there is no OpenGL."""
        from engine.gl.scene_renderer import SceneRenderer

        if not self.is_asked:
            self.is_asked = True
            with contextlib.suppress(MissingCapability):
                context = create_context()
                self.made = context, SceneRenderer(context)
        return self.made

    def release(self) -> None:
        """Give the context up, on the thread that made it."""
        if self.made is not None:
            context, renderer = self.made
            with context:
                renderer.release()
            context.release()


def _reference(scene: Scene, saving: Saving, bounces: int) -> Steps[tuple[NDArray[np.float32], dict[str, Any]]]:
    check_scene(scene)
    found = yield from reference(scene, saving.size, samples=saving.paths, max_depth=bounces + 1)
    if found.variance is None:
        return found.image, {}
    error = np.sqrt(found.variance).clip(0.0, np.finfo(np.float32).max).astype(np.float32)
    return found.image, {"standard_error": error}
