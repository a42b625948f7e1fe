"""`lightarc render --turntable N`: a film of a full turn of the model, of the light or of both, in N frames."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from app.arguments.results import FILM, FRAMES, image_by, software
from app.cli.doubts import doubts_of_light, doubts_of_scene
from app.cli.transport.render_output import ON_CPU, teach
from app.commands.images import code
from engine.core.errors import MissingCapability, UsageError
from engine.core.steps import Step, drain
from engine.core.stopwatch import read_clock
from engine.geometry.camera import frame
from engine.gl.context import create_context, renderer_name
from engine.gl.draw import frames_off_screen, relight_frames_off_screen
from engine.images.animation import film, kind_of
from engine.render.background import in_front_of
from engine.render.direct import radiance
from engine.render.reference import reference
from engine.render.shadowed import combine_shadowed, with_and_without
from engine.render.transported import image_of
from engine.render.turntable import about_y, camera_about, frame_all_round, frames, near_about
from engine.scene.mode import REFERENCE, is_traced
from engine.storage.outputs import Kind

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.brdf.brdf import Brdf
    from engine.geometry.camera import Camera, Vector
    from engine.gl.context import Context
    from engine.gl.draw import Frames
    from engine.light.environment import EnvironmentMap
    from engine.render.display import Display
    from engine.scene.scene import Scene
    from engine.transport.baking.file import TransportFile
    from engine.transport.method import Method
    from engine.transport.relight import Illuminated, Light, RelightTransport

#: Most frames of a film: five minutes at 30 a second.
MAX_FRAMES = 9000

FASTEST = 120.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--turntable",
        type=int,
        metavar="N",
        help="a film of one full turn in N frames: .mp4 (VP9), .webp (loops, may be transparent), or a folder of PNG",
    )
    parser.add_argument(
        "--turns",
        default="model",
        choices=("model", "light", "both"),
        help="turn the model before the light, the light around the model, or both together (model)",
    )
    parser.add_argument("--fps", type=float, default=30.0, metavar="F", help="frames in a second of the film (30)")


def output_at(path: str, options: argparse.Namespace) -> list[tuple[str, Kind]]:
    """A film or a folder of frames with --turntable, and else an image."""
    if getattr(options, "turntable", None) is None:
        return [(path, image_by("render", ".png", ".exr"))]
    return [(path, FILM if Path(path).suffix else FRAMES)]


def check(arguments: argparse.Namespace) -> None:
    """UsageError where the options of a film cannot be."""
    if arguments.turntable is None:
        if arguments.turns != "model" or arguments.fps != 30.0:
            raise UsageError("--turns and --fps need --turntable")
        return
    if not 2 <= arguments.turntable <= MAX_FRAMES:
        raise UsageError(f"--turntable {arguments.turntable} is outside 2 … {MAX_FRAMES}")
    if not 1.0 <= arguments.fps <= FASTEST:
        raise UsageError(f"--fps {arguments.fps:g} is outside 1 … {FASTEST:g}")
    if arguments.measure_error:
        raise UsageError("--measure-error is of one image, not of a --turntable")
    if kind_of(arguments.output) == "mp4" and arguments.background == "transparent":
        raise UsageError("an .mp4 has no transparency; choose .webp or a folder for --background transparent")


def frame_turntable(positions: NDArray[Any], arguments: argparse.Namespace) -> Camera:
    """The camera unless another is asked for: it sees all of the model, also when that turns."""
    is_turning = arguments.turntable and arguments.turns != "light"
    return (frame_all_round if is_turning else frame)(positions, arguments.width / arguments.height)


def with_background(image: NDArray[np.float32], scene: Scene, behind: EnvironmentMap | None) -> NDArray[np.float32]:
    """`image` in front of the environment `behind` it, turned and as bright as the light of the scene is."""
    if behind is None:
        return image
    return in_front_of(image, scene.camera, behind, scene.environment_rotation, scene.irradiance)


def run(
    scene: Scene,
    arguments: argparse.Namespace,
    display: Display,
    show: Callable[[Step], None],
    behind: EnvironmentMap | None,
) -> dict[str, Any]:
    """The film of a scene that is drawn by sums over lights, or by paths."""
    scenes = list(frames(scene, arguments.turntable, arguments.turns))
    size, warnings = (arguments.width, arguments.height), doubts_of_scene(scene)

    seconds: list[float] = []

    def on_cpu() -> Frames:
        for each in scenes:
            if is_traced(arguments.mode):
                options = {"samples": arguments.samples, "max_depth": arguments.max_depth, "seed": arguments.seed}
                begun = time.perf_counter()
                image = drain(reference(each, size, **options)).image
                seconds.append(time.perf_counter() - begun)
                yield image
            else:
                yield drain(radiance(each, size, samples=arguments.samples))

    def on_device(context: Context) -> Frames:
        return frames_off_screen(context, scenes, size, arguments.samples)

    def finish(images: Iterator[NDArray[np.float32]]) -> Iterator[NDArray[np.float32]]:
        return (with_background(image, each, behind) for image, each in zip(images, scenes, strict=True))

    renderer = "cpu" if is_traced(arguments.mode) else arguments.renderer
    since = read_clock()
    made = _write(arguments, display, show, warnings, renderer, on_device, on_cpu, finish)
    if seconds:
        teach(scene, arguments, REFERENCE.name, median(seconds), since)
    return made


def run_baked(
    file: TransportFile,
    method: Method,
    light: Light,
    asked: Any,
    camera: Camera,
    axis: Vector,
    arguments: argparse.Namespace,
    display: Display,
    show: Callable[[Step], None],
    behind: EnvironmentMap | None,
    textured: tuple[Scene, Brdf | None] | None = None,
) -> dict[str, Any]:
    """The film of baked transport: relit for each frame where the light turns, and once where the camera alone does.

    `textured` are a scene whose material gives its texels, and the BRDF that was baked, that of the scene where None.
    """
    size, count = (arguments.width, arguments.height), arguments.turntable
    turn = {"model": (-1.0, -1.0), "light": (0.0, 1.0), "both": (-1.0, 0.0)}[arguments.turns]
    angles = [2.0 * math.pi * number / count for number in range(count)]
    cameras = [camera_about(camera, turn[0] * angle, axis) for angle in angles]
    lights = [
        replace(
            light,
            rotation=light.rotation + turn[1] * angle,
            lamps=tuple(replace(each, direction=about_y(each.direction, turn[1] * angle)) for each in light.lamps),
            near_lamps=tuple(near_about(each, turn[1] * angle, axis) for each in light.near_lamps),
        )
        for angle in angles
    ]

    warnings = doubts_of_light(light.environment)
    pairs: list[tuple[Scene, Scene]] = []
    if textured is not None and textured[0].has_texels:
        for each, seen_from in zip(lights, cameras, strict=True):
            lit = replace(textured[0], camera=seen_from, environment_rotation=each.rotation, lamps=each.lamps)
            lit = replace(lit, near_lamps=each.near_lamps)
            pairs.append(with_and_without(lit, textured[1]))

    def relight_transport() -> Iterator[tuple[RelightTransport, Camera]]:
        found: Illuminated | None = None
        for each, seen_from in zip(lights, cameras, strict=True):
            if found is None or turn[1]:
                found = drain(method.baking.illuminate(file, each, asked, arguments.brdf))
            yield found.relit, seen_from

    def on_cpu() -> Frames:
        for number, (each, seen_from) in enumerate(relight_transport()):
            image = drain(image_of(each, seen_from, size, arguments.samples)).image
            if pairs:
                one, other = (drain(radiance(scene, size, samples=arguments.samples)) for scene in pairs[number])
                image = combine_shadowed(one, other, image)
            yield image

    def on_device(context: Context) -> Frames:
        with closing(relight_frames_off_screen(context, relight_transport(), size, arguments.samples)) as baked:
            if not pairs:
                yield from baked
                return
            with_texels, without = zip(*pairs, strict=True)
            with (
                closing(frames_off_screen(context, with_texels, size, arguments.samples)) as texels,
                closing(frames_off_screen(context, without, size, arguments.samples)) as plain,
            ):
                for one, other, image in zip(texels, plain, baked, strict=True):
                    yield combine_shadowed(one, other, image)

    def finish(images: Iterator[NDArray[np.float32]]) -> Iterator[NDArray[np.float32]]:
        for image, each, seen_from in zip(images, lights, cameras, strict=True):
            yield image if behind is None else in_front_of(image, seen_from, behind, each.rotation, each.factor)

    made = _write(arguments, display, show, warnings, arguments.renderer, on_device, on_cpu, finish)
    return {**made, "mode": method.name}


def _write(
    arguments: argparse.Namespace,
    display: Display,
    show: Callable[[Step], None],
    warnings: list[str],
    renderer: str,
    on_device: Callable[[Any], Frames],
    on_cpu: Callable[[], Frames],
    finished: Callable[[Frames], Iterator[NDArray[np.float32]]],
) -> dict[str, Any]:
    """Draw all frames on a device, or on the CPU, and write the film; its record."""
    start, count, context = time.perf_counter(), arguments.turntable, None
    if renderer != "cpu":
        try:
            context = create_context()
        except MissingCapability as missing:
            if renderer == "gl":
                raise
            warnings.append(str(missing))
    try:
        images = on_cpu() if context is None else on_device(context)
        device = ON_CPU if context is None else renderer_name(context)
        size = (arguments.width, arguments.height)
        # closed before the context: a frame that is not taken, because writing failed, holds parts of it
        with closing(images), film(arguments.output, size, arguments.fps, software=software("render")) as keep:
            for number, image in enumerate(finished(images), 1):
                keep(code(image, display, arguments.background))
                show(Step(number / count, f"frame {number} of {count}"))
    finally:
        if context is not None:
            context.release()
    return {
        "image": arguments.output,
        "frames": count,
        "turns": arguments.turns,
        "frames_per_second": arguments.fps,
        "width_px": arguments.width,
        "height_px": arguments.height,
        "gl_renderer": device,
        "warnings": warnings,
        "time_s": time.perf_counter() - start,
    }
