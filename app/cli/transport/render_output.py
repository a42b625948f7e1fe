"""Common parts of all modes of `lightarc render`: draw the image on a device if there is one, and write it."""

from __future__ import annotations

import argparse
import dataclasses
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from app.arguments.quantities import Degrees
from app.session.machine_profile import learn_frame, learn_relit
from engine.core.budget import free_bytes
from engine.core.colour import luminance
from engine.core.directions import world_angles
from engine.core.errors import MissingCapability, UsageError
from engine.core.figure_text import size_text
from engine.planning.costs.setting import Setting
from engine.render.background import blur
from engine.render.reference import BYTES_PER_PIXEL
from engine.scene.mode import SHADING_MAP, is_traced

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.core.stopwatch import Spent
    from engine.geometry.camera import Camera
    from engine.gl.draw import OffScreen
    from engine.light.environment import EnvironmentMap
    from engine.light.lamps import Lamp
    from engine.scene.scene import Scene
    from engine.transport.relight import RelightTransport

#: Value of `gl_renderer` if no device has drawn.
ON_CPU = "none (drawn on the CPU)"

#: Name of the CPU in a machine profile, and seconds of a frame from which the profile learns: of the reference,
#: whose prediction takes rays all over the model, and of frames without.
CPU, LONG_S, DRAWN_LONG_S = "processor", 1.0, 0.1

#: Widest blur of a background: beyond it the environment is one colour.
MAX_BLUR_DEG = 90.0


def off_screen(
    renderer: str, draw: Callable[[Any], OffScreen], warnings: list[str]
) -> tuple[NDArray[np.float32], dict[str, Any]] | None:
    """The result of `draw` with a context, and its record: frame_s, gl_renderer, warnings.

    None with the `renderer` "cpu", and with "auto" where there is no OpenGL, which is added to `warnings`.
    MissingCapability with "gl" where there is none.
    """
    from engine.gl.context import create_context

    if renderer == "cpu":
        return None
    try:
        context = create_context()
    except MissingCapability as missing:
        if renderer == "gl":
            raise
        warnings.append(str(missing))
        return None
    try:
        with context:
            image, frame_s, name, messages = draw(context)
    finally:
        context.release()
    return image, {"frame_s": frame_s, "gl_renderer": name, "warnings": [*warnings, *messages]}


def teach(
    scene: Scene,
    arguments: argparse.Namespace,
    mode: str,
    frame_s: float,
    since: Spent,
    device: str = CPU,
) -> None:
    """Let the machine profile learn from a frame, begun at `since`, that took longer than it takes to predict it.

    Plans know a material of slices or their fit, and parameters in their own ranges. Frames of a film that OpenGL draws
    are not timed, each being read back and coded between two of them.
    """
    is_reference, material = is_traced(mode), scene.material
    if frame_s < (LONG_S if is_reference else DRAWN_LONG_S):
        return
    parameters = {"samples": arguments.samples} if is_reference else {"directions": arguments.directions}
    if material is not None:
        if is_reference or material.directional is not None or material.pbr is not None:
            return
        mode, parameters = SHADING_MAP.name, {**parameters, "power_law": int(scene.source == "power-law")}
    try:
        setting = Setting(mode, parameters)
    except ValueError:
        return
    samples, depth = (1, arguments.max_depth) if is_reference else (arguments.samples, 1)
    size = (arguments.width, arguments.height)
    learn_frame(scene, setting, size, frame_s, since, samples=samples, depth=depth, device=device)


def teach_relit(
    relit: RelightTransport,
    camera: Camera,
    arguments: argparse.Namespace,
    frame_s: float,
    since: Spent,
    device: str = CPU,
) -> None:
    """Let the machine profile learn from a frame of a bake, begun at `since`, that took as long as its prediction."""
    if frame_s >= DRAWN_LONG_S:
        size = (arguments.width, arguments.height)
        learn_relit(relit, camera, size, frame_s, since, samples=arguments.samples, device=device)


def check_memory(size: tuple[int, int]) -> None:
    """UsageError where a reference of `size` (width, height) needs more memory than is free."""
    width, height = size
    needed = width * height * BYTES_PER_PIXEL
    if needed > free_bytes():
        raise UsageError(
            f"A reference of {width} × {height} pixels needs {size_text(needed)} of memory, more than free"
        )


def record_of(image: NDArray[np.float32]) -> dict[str, Any]:
    """Size, mean and coverage of an image (height, width, 4)."""
    height, width = image.shape[:2]
    return {
        "width_px": width,
        "height_px": height,
        "mean_radiance": float(luminance(image[..., :3].astype("f8")).mean()),
        "covered_fraction": float(image[..., 3].mean(dtype="f8")),
    }


def lights_of(scene: Scene) -> dict[str, Any]:
    """The lights of the scene, and the ground that they fall on."""
    lights: dict[str, Any] = {}
    if scene.environment is not None:
        lights = {"environment": scene.environment.name, "directions": scene.directions}
    elif scene.irradiance or not (scene.lamps or scene.near_lamps):
        lights = {"light_direction": list(scene.light), "directions": 1}
    if scene.lamps:
        lights["lamps"] = [_describe(lamp) for lamp in scene.lamps]
        lights["directional_lights"] = len(scene.lights.direction)
    if scene.near_lamps:
        lights["near_lamps"] = [dataclasses.asdict(lamp) for lamp in scene.near_lamps]
    if scene.ground is not None:
        lights["ground_albedo"] = scene.ground.albedo
    return lights


def _describe(lamp: Lamp) -> dict[str, Any]:
    theta, phi = world_angles(lamp.direction)
    return {
        "theta_deg": math.degrees(theta),
        "phi_deg": math.degrees(phi),
        "radius_deg": math.degrees(lamp.radius),
        "irradiance": list(lamp.irradiance),
    }


def add_background_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of what is behind the model."""
    parser.add_argument(
        "--background",
        default="plain",
        choices=("plain", "environment", "transparent"),
        help="behind the model: a plain grey, the --env, or nothing (opacity in .png and .exr) (plain)",
    )
    parser.add_argument(
        "--background-blur-deg",
        type=Degrees(1, "20", is_small=True),
        default=0.0,
        metavar="R",
        help="blur of the environment behind the model, as an angle; the light stays as it is (0)",
    )
    parser.add_argument(
        "--layers", action="store_true", help="store albedo and normals beside the radiance, as layers of an .exr"
    )


def check_background(arguments: argparse.Namespace, environment: EnvironmentMap | None) -> EnvironmentMap | None:
    """The environment behind the model, blurred as asked for; None for any other background."""
    if arguments.layers and (not arguments.output.lower().endswith(".exr") or arguments.turntable):
        raise UsageError("--layers needs an image that is an .exr")
    if not 0.0 <= arguments.background_blur_deg <= MAX_BLUR_DEG:
        raise UsageError(f"--background-blur-deg {arguments.background_blur_deg:g} is outside 0 … {MAX_BLUR_DEG:g}")
    if arguments.background != "environment":
        if arguments.background_blur_deg:
            raise UsageError("--background-blur-deg needs --background environment")
        return None
    if environment is None:
        raise UsageError("--background environment needs --env")
    return blur(environment, math.radians(arguments.background_blur_deg))


def join(record: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """A record with the values of another, whose warnings follow its own."""
    warnings = dict.fromkeys([*record.get("warnings", ()), *other.get("warnings", ())])
    return {**record, **other, "warnings": list(warnings)}
