"""Images of a model: of a material or a BRDF under light, and of what was baked; and the error between two."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from engine.core.errors import UsageError
from engine.core.steps import Step, drain
from lightarc._border import check_size, public

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.accuracy.compare import ImageError
    from engine.brdf.brdf import Brdf
    from engine.geometry.mesh import Mesh
    from engine.scene.material import Material

File = str | os.PathLike[str]
Progress = Callable[[Step], None]

#: World angles of the light where no other is given, in degrees: from +Y, and from +Z towards +X.
LIGHT_DEG = (50.0, 30.0)


@public
def render(
    model: str | Mesh,
    *,
    material: Material | None = None,
    brdf: str | Brdf | None = None,
    light_deg: tuple[float, float] = LIGHT_DEG,
    environment: File | None = None,
    irradiance: float = 1.0,
    ground_albedo: float | None = None,
    camera: str = "",
    size: tuple[int, int] = (512, 384),
    samples: int | None = None,
    max_depth: int = 0,
    progress: Progress | None = None,
) -> NDArray[np.float32]:
    """The image (height, width, 4) of a model, drawn on the CPU.

    Parameters
    ----------
    model : a file, or one of sphere, plane, torus-knot, cloth and blob.
    material, brdf : what is seen on it; with both, the material with another BRDF.
    light_deg : a distant light, by its angle from +Y (up) and from +Z towards +X.
    environment : light from all around in its place: a file, or a built-in such as 'studio'.
    irradiance : of the light on a surface that faces it, or the factor on the environment.
    ground_albedo : of a diffuse ground under the model; None for no ground.
    camera : 'eye=0,0,4 target=0,0,0 up=0,1,0 fov_deg=35'; what is left out frames the model.
    size : (width, height) in pixels.
    samples : sub-pixels along the side of a pixel (2), or paths of light for each pixel (64).
    max_depth : 0 leaves out shadows; from 1 paths of light are traced, which touch so many points at most.

    InputError for a file that cannot be used, ValueError for what cannot be drawn.

    >>> image = lightarc.render("sphere", material=material, light_deg=(40, 0), size=(16, 12), samples=1)
    >>> picture.shape, bool(picture[6, 8, 3] == 1)
    ((12, 16, 4), True)
    """
    from engine.brdf.brdf import brdf_from_text
    from engine.core.directions import world_direction
    from engine.factor.factor_file import open_reflectance
    from engine.geometry.camera import frame, parse
    from engine.geometry.ground import Ground
    from engine.geometry.shapes import open_mesh
    from engine.light.environment_file import open_environment
    from engine.render import direct
    from engine.render.path import check_scene
    from engine.render.reference import reference
    from engine.scene.scene import Scene

    check_size(size)
    mesh = open_mesh(model) if isinstance(model, str) else model
    seen = open_reflectance(brdf) if isinstance(brdf, str) else brdf
    x, y, z = world_direction(*map(math.radians, light_deg))
    scene = Scene(
        mesh=mesh,
        camera=parse(camera, frame(mesh.positions, size[0] / size[1])),
        brdf=seen or (material.reflectance if material else brdf_from_text("phong")),
        material=material,
        light=(x, y, z),
        irradiance=irradiance,
        environment=None if environment is None else open_environment(environment),
        ground=None if ground_albedo is None else Ground(albedo=ground_albedo),
    )
    if not max_depth:
        return drain(direct.radiance(scene, size, samples=samples or 2), progress)
    check_scene(scene)
    return drain(reference(scene, size, samples=samples or 64, max_depth=max_depth), progress).image


@public
def save_image(
    path: File,
    image: NDArray[np.float32],
    *,
    exposure_ev: float = 0.0,
    tone_map: Literal["neutral", "none", "aces"] = "neutral",
) -> None:
    """Write an image (height, width, 4): tone-mapped as `.png`, or its linear radiance as `.exr`.

    ValueError for another ending, OutputError where the file cannot be written. A file of that name is replaced.

    >>> lightarc.save_picture("plain.png", image, exposure_ev=1)
    """
    from engine.images.encode import encode_exr, encode_png, rgb_channels
    from engine.render.display import Display, display
    from engine.storage.atomic import write_bytes

    kind = Path(path).suffix.lower()
    if kind not in (".png", ".exr"):
        raise UsageError(f"an image is written as .png or .exr, not as {os.fspath(path)!r}")
    if kind == ".exr":
        content = encode_exr(rgb_channels(image[..., :3]))
    else:
        content = encode_png(display(image, Display(exposure_ev, tone_map)))
    write_bytes(Path(path), content)


@public
def compare(image: NDArray[np.floating[Any]], reference: NDArray[np.floating[Any]]) -> ImageError:
    """The error of an image (height, width, 3 or 4) against another: relative RMSE, ꟻLIP, largest difference.

    ValueError where their sizes differ.

    >>> brighter = lightarc.render(
    ...     "sphere", material=material, light_deg=(40, 0), size=(16, 12), samples=1, irradiance=1.1
    ... )
    >>> lightarc.compare(image, image).rmse_rel, lightarc.compare(brighter, image).rmse_rel > 0
    (0.0, True)
    """
    from engine.accuracy.compare import compare as compared

    return compared(image, reference)


@public
def bake(
    model: str | Mesh,
    brdf: str | Brdf,
    path: File,
    *,
    method: Literal["sh", "wavelet", "gaussian"] = "wavelet",
    ground_albedo: float | None = None,
    progress: Progress | None = None,
    **settings: Any,
) -> Path:
    """Precompute light transport for a model into the file `path`, which `relight` shows under any light.

    Parameters
    ----------
    model : a file, or one of sphere, plane, torus-knot, cloth and blob.
    ground_albedo : of a diffuse ground under the model; None for no ground.
    settings : of the method, as options of `lightarc bake` say them: `order`, `interreflection`, `terms`,
        `coefficients`, `lobes` and so on.

    A bake that was interrupted goes on where it ended. ValueError for settings that the method does not have or
    accept, OutputError where the file cannot be written.

    >>> lightarc.bake("plane", "lambert:albedo=0.6", "plane.transport", method="sh", order=3).name
    'plane.transport'
    """
    from engine.core.params import parameters
    from engine.factor.factor_file import open_reflectance
    from engine.geometry.ground import Ground
    from engine.geometry.shapes import open_mesh
    from engine.transport.method import Subject, method_of, names

    if method not in names():
        raise UsageError(f"unknown method {method!r}; known are {', '.join(names())}")
    chosen = method_of(method)
    known = [parameter.name for parameter in parameters(chosen.settings)]
    if unknown := sorted(settings.keys() - set(known)):
        raise UsageError(f"{method} has no setting {unknown[0]!r}; known are {', '.join(known)}")
    subject = Subject(
        open_mesh(model) if isinstance(model, str) else model,
        open_reflectance(brdf) if isinstance(brdf, str) else brdf,
        None if ground_albedo is None else Ground(albedo=ground_albedo),
    )
    work = drain(chosen.baking.prepare(subject, chosen.settings(**settings)), progress)
    drain(chosen.baking.bake(path, work), progress)
    return Path(path)


@public
def relight(
    path: File,
    *,
    light_deg: tuple[float, float] = LIGHT_DEG,
    environment: File | None = None,
    irradiance: float = 1.0,
    camera: str = "",
    size: tuple[int, int] = (512, 384),
    samples: int = 2,
    progress: Progress | None = None,
) -> NDArray[np.float32]:
    """The image (height, width, 4) of what was baked, under a light; arguments as those of `render`.

    InputError for a file that holds no transport or is damaged.

    >>> baked = lightarc.relight("plane.transport", light_deg=(10, 0), size=(16, 12), samples=1)
    >>> baked.shape, bool(baked[..., :3].max() > 0)
    ((12, 16, 4), True)
    """
    from engine.core.directions import world_direction
    from engine.core.errors import InputError
    from engine.geometry.camera import frame, parse
    from engine.light.environment_file import open_environment
    from engine.light.lamps import Lamp
    from engine.render.transported import image_of
    from engine.transport.baking.file import open_transport
    from engine.transport.method import method_of, names
    from engine.transport.relight import Light

    check_size(size)
    file = open_transport(path)
    if file.kind not in names():
        raise InputError(path, f"holds transport of an unknown method ({file.kind})", "Update Lightarc")
    chosen = method_of(file.kind)
    x, y, z = world_direction(*map(math.radians, light_deg))
    light = Light(lamps=(Lamp((x, y, z), (irradiance,) * 3),))
    if environment is not None:
        light = Light(open_environment(environment), factor=irradiance)
    relit = drain(chosen.baking.illuminate(file, light, chosen.light(), None), progress).relit
    shown = relit.mesh.positions[: relit.transport.ground_vertex]
    view = parse(camera, frame(shown, size[0] / size[1]))
    return drain(image_of(relit, view, size, samples), progress).image
