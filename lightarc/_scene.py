"""A scene: images of it, its transport, its plan, and what accuracy costs on it; the error between two images."""

from __future__ import annotations

import importlib
import math
import os
import warnings
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from app.session import machine_profile
from app.session.cache import visibility_folder
from engine.accuracy.bake_check import check_file
from engine.accuracy.compare import compare as compare_images
from engine.core.directions import world_direction
from engine.core.errors import InputError, UsageError
from engine.core.params import parameters
from engine.core.steps import drain
from engine.figures.papers.catalogue import FIGURES
from engine.geometry.backs import with_backs
from engine.geometry.brushing import parse_brushing
from engine.geometry.ground import Ground
from engine.geometry.parts import split_parts
from engine.images.encode import encode_exr, encode_png, rgb_channels
from engine.light.lamps import Lamp
from engine.planning.costs.setting import modes as all_modes
from engine.planning.plan import check_effects
from engine.planning.plan import plan as plan_effects
from engine.render import direct
from engine.render.display import Display, display
from engine.render.path import check_scene
from engine.render.transported import image_of
from engine.scene.material import Material
from engine.scene.mode import MODES
from engine.scene.scene import Scene, brdfs_of_parts
from engine.scene.scene import make_scene as build_scene
from engine.scene.settings import DEFAULTS
from engine.storage.atomic import write_bytes
from engine.tradeoff.agenda import modes_of, settings_of
from engine.tradeoff.sweep import sweep
from engine.transport.baking.check import warnings_at_render, warnings_of_check
from engine.transport.baking.file import open_transport
from engine.transport.method import Subject, method_of, methods_with, names
from engine.transport.relight import Light
from engine.transport.reuse import with_brdf
from lightarc._border import accept_old_names, check_size, public
from lightarc._image import as_shown
from lightarc._inputs import (
    BrdfLike,
    CameraLike,
    EnvironmentLike,
    File,
    FileLike,
    ImageLike,
    LightLike,
    MaterialLike,
    MeshLike,
    Progress,
    as_brdf,
    as_camera,
    as_environment,
    as_image,
    as_lamps,
    as_material,
    as_mesh,
    is_path,
    on_disk,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from engine.accuracy.compare import ImageError
    from engine.planning.costs.cost_model import CostModel
    from engine.planning.plan import EffectsPlan
    from engine.tradeoff.sweep import Tradeoff
    from lightarc._image import Image


@public
def make_scene(
    model: MeshLike,
    *,
    material: MaterialLike | None = None,
    brdf: BrdfLike | None = None,
    light: LightLike | None = None,
    light_deg: tuple[float, float] | None = None,
    environment: EnvironmentLike | None = None,
    environment_rotation_deg: float = DEFAULTS.environment_rotation_deg,
    irradiance: float = DEFAULTS.irradiance,
    ground_albedo: float | None = None,
    brushing: str | None = None,
    camera: CameraLike = "",
    repeats: float = DEFAULTS.repeats,
    size: tuple[int, int] = (512, 384),
    **options: Any,
) -> Scene:
    """Put a model, a material, light and a camera together.

    Parameters
    ----------
    model : str, path, Mesh, trimesh object, or arrays (vertices, faces) or (vertices, faces, uv)
        A file, or one of sphere, plane, torus-knot, cloth and blob.
    material : Material or path, optional
        The material; with `brdf` as well, the material with another BRDF.
    brdf : str, path, Brdf or model class, optional
        The BRDF.
    light : array_like of shape (3,) or (N, 3), or Lamp and NearLamp objects, optional
        World vectors towards distant lights, y up, each of the `irradiance`; with an environment, beside it. NearLamp
        objects are spheres, rectangles and discs near the model, in its coordinates.
    light_deg : (float, float), optional
        In its place one light by its angle from +Y (up) and from +Z towards +X; (50, 30) where nothing is given.
    environment : str, path, EnvironmentMap or array of shape (H, 2 H, 3), optional
        Light from all around: a file, linear radiance, or a built-in such as 'studio'.
    environment_rotation_deg : float
        Rotation of the environment about +Y.
    irradiance : float
        Irradiance of the light on a surface that faces it, or the factor on the environment.
    ground_albedo : float, optional
        Albedo of a diffuse ground under the model; None for no ground.
    brushing : str, optional
        Direction of an anisotropic BRDF: 'u' along the texture, 'x', 'y', 'z' or a vector as '1,0,0', projected into
        the surface, each with an angle in degrees behind a colon, 'y:30'; None for that of the model.
    camera : str or Camera
        'eye=0,0,4 target=0,0,0 up=0,1,0 fov_deg=35'; what is left out frames the model.
    repeats : float
        Repetitions of the material over one unit of texture coordinates.
    size : (int, int)
        (width, height) of the image that the camera frames.
    **options
        Further fields of `Scene`: `directions`, `source`, `lookup`, `above`, and `tiling_mode`, which is 'hex' for
        repeats without a visible period.

    Returns
    -------
    Scene
        The scene.

    Raises
    ------
    UsageError
        For values that do not fit.
    InputError
        For a file that cannot be used.

    Examples
    --------
    >>> scene = lightarc.make_scene("sphere", brdf=lightarc.Ggx(alpha=0.3), light=(0, 1, 0))
    >>> scene.light
    (0.0, 1.0, 0.0)
    """
    check_size(size)
    if light is not None and light_deg is not None:
        raise UsageError("give light or light_deg, not both")
    mesh, found = as_mesh(model), as_material(material)
    seen = None if brdf is None else as_brdf(brdf)
    lamps, near_lamps = as_lamps(light, irradiance)
    if lamps:
        options["light"] = lamps[0].direction
    return build_scene(
        mesh,
        as_camera(camera, mesh.positions, size),
        brdf=seen,
        material=found,
        light_deg=light_deg,
        irradiance=float(irradiance),
        environment=as_environment(environment),
        environment_rotation_deg=environment_rotation_deg,
        lamps=lamps,
        near_lamps=near_lamps,
        ground_albedo=ground_albedo,
        brushing=None if brushing is None else parse_brushing(brushing),
        repeats=repeats,
        **options,
    )


@public
def render(
    model: MeshLike | Scene,
    *,
    material: MaterialLike | None = None,
    brdf: BrdfLike | None = None,
    light: LightLike | None = None,
    light_deg: tuple[float, float] | None = None,
    environment: EnvironmentLike | None = None,
    environment_rotation_deg: float = DEFAULTS.environment_rotation_deg,
    irradiance: float = DEFAULTS.irradiance,
    ground_albedo: float | None = None,
    brushing: str | None = None,
    camera: CameraLike = "",
    repeats: float = DEFAULTS.repeats,
    size: tuple[int, int] = (512, 384),
    mode: str | None = None,
    samples: int | None = None,
    max_depth: int = 0,
    seed: int = 0,
    progress: Progress | None = None,
) -> Image:
    """Render an image of a model on the CPU.

    Parameters
    ----------
    model, material, brdf, ground_albedo, brushing, repeats, camera
        The scene, as `make_scene` takes it; or a Scene in place of the model, and nothing else of these.
    light, light_deg, environment, environment_rotation_deg, irradiance
        Its light, as `make_scene` takes it.
    size : (int, int)
        (width, height) in pixels.
    mode : str, optional
        'shading-map', 'direct', 'reference', or a mode that a plug-in adds; None shows the scene as it is, traced where
        `max_depth` says so.
    samples : int, optional
        Sub-pixels along the side of a pixel (2), or paths of light for each pixel (64).
    max_depth : int
        0 leaves out shadows; from 1 paths of light are traced, which touch so many points at most.
    seed : int
        Seed of the paths.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    Image, shape (height, width, 4)
        A float32 array: linear sRGB radiance times coverage, and coverage.

    Raises
    ------
    UsageError
        For values that do not fit, and a scene that cannot be rendered.
    InputError
        For a file that cannot be used.

    References
    ----------
    .. [1] J. Kautz, M. Sattler, R. Sarlette, R. Klein, H.-P. Seidel, "Decoupling BRDFs from Surface Mesostructures",
       Graphics Interface 2004.

    Examples
    --------
    >>> image = lightarc.render("sphere", material=material, light_deg=(40, 0), size=(16, 12), samples=1)
    >>> image
    Image(16 × 12 pixels, 4 channels, float32)
    >>> bool(image[6, 8, 3] == 1)
    True
    """
    from engine.render.reference import reference

    check_size(size)
    if mode is not None and mode not in MODES:
        raise UsageError(f"unknown mode {mode!r}; choose from {', '.join(MODES)}")
    scene = (
        model
        if isinstance(model, Scene)
        else make_scene(
            model,
            material=material,
            brdf=brdf,
            light=light,
            light_deg=light_deg,
            environment=environment,
            environment_rotation_deg=environment_rotation_deg,
            irradiance=irradiance,
            ground_albedo=ground_albedo,
            brushing=brushing,
            camera=camera,
            repeats=repeats,
            size=size,
        )
    )
    if mode is not None:
        if MODES[mode].needs_map and not scene.has_texels:
            raise UsageError(f"the mode {mode} needs a material")
        scene, max_depth = MODES[mode].adapt(scene), max(1, max_depth) if MODES[mode].traced else 0
    if not max_depth:
        return as_shown(drain(direct.radiance(scene, size, samples=samples or 2), progress))
    check_scene(scene)
    tracing = reference(scene, size, samples=samples or 64, max_depth=max_depth, seed=seed)
    return as_shown(drain(tracing, progress).image)


@accept_old_names({"picture": "image"})
@public
def save_image(
    path: FileLike,
    image: ArrayLike,
    *,
    exposure_ev: float = 0.0,
    tone_map: Literal["neutral", "none", "aces"] = "neutral",
) -> None:
    """Write an image: tone-mapped as PNG, or its linear radiance as OpenEXR.

    Parameters
    ----------
    path : path or file object
        A `.png` or an `.exr`; an open file whose `name` ends so, or else is written as PNG. A file of that name is
        replaced.
    image : array_like, shape (height, width, 3 or 4)
        Linear radiance (times coverage, and coverage).
    exposure_ev : float
        Exposure of the PNG in stops.
    tone_map : {'neutral', 'none', 'aces'}
        Tone mapping of the PNG.

    Raises
    ------
    UsageError
        For another ending, and an array that is not an image.
    OutputError
        Where the file cannot be written.

    Examples
    --------
    >>> lightarc.save_image("plain.png", image, exposure_ev=1)
    """
    named = is_path(path)
    name = os.fspath(path) if isinstance(path, str | os.PathLike) else str(getattr(path, "name", ""))
    kind = Path(name).suffix.lower() or ("" if named else ".png")
    if kind not in (".png", ".exr"):
        raise UsageError(f"an image is written as .png or .exr, not as {name!r}")
    values = np.asarray(image)
    if values.ndim != 3 or values.shape[2] not in (3, 4) or not values.size or values.dtype.kind not in "fiu":
        raise UsageError(f"an image must be height × width × 3 or 4 numbers, not {values.dtype} {values.shape}")
    values = values.astype(np.float32)
    if kind == ".exr":
        content = encode_exr(rgb_channels(values[..., :3]))
    else:
        whole = np.concatenate(
            [values[..., :3], values[..., 3:] if values.shape[2] == 4 else np.ones_like(values[..., :1])], 2
        )
        content = encode_png(display(whole, Display(exposure_ev, tone_map)))
    if isinstance(path, str | os.PathLike):
        write_bytes(Path(path), content)
    else:
        path.write(content)


@accept_old_names({"picture": "image"})
@public
def compare(image: ImageLike, reference: ImageLike, *, mask: ArrayLike | None = None) -> ImageError:
    """Measure the error of an image against another.

    Parameters
    ----------
    image, reference : path, file object, or array_like of shape (height, width, 3 or 4)
        Arrays of floats are linear radiance; of 8 and 16 bits they are sRGB-coded, as such files are.
    mask : array_like of bool, shape (height, width), optional
        The pixels to compare.

    Returns
    -------
    ImageError
        Relative RMSE, ꟻLIP and the largest difference.

    Raises
    ------
    UsageError
        Where the sizes differ, or no pixel is left to compare.
    InputError
        For a file that cannot be read.

    References
    ----------
    .. [1] P. Andersson et al., "ꟻLIP: A Difference Evaluator for Alternating Images", HPG 2020,
       https://doi.org/10.1145/3406183.

    Examples
    --------
    >>> lightarc.compare(image, image).rmse_rel, round(lightarc.compare(1.1 * image, image).rmse_rel, 3)
    (0.0, 0.1)
    """
    (first, is_shown), (second, other) = as_image(image), as_image(reference)
    chosen = None if mask is None else np.asarray(mask, np.bool_)
    if chosen is not None and chosen.shape != second.shape[:2]:
        raise UsageError(f"mask must have the shape {second.shape[:2]} of the images, not {chosen.shape}")
    return compare_images(first, second, chosen, displayed=is_shown and other)


@public
def bake(
    model: MeshLike,
    brdf: BrdfLike | Material,
    path: File,
    *,
    method: str = "wavelet",
    ground_albedo: float | None = None,
    brushing: str | None = None,
    check: bool = True,
    progress: Progress | None = None,
    **settings: Any,
) -> Path:
    """Precompute light transport for a model into a file, which `relight` shows under any light.

    A bake that was interrupted goes on where it ended.

    Parameters
    ----------
    model : str, path, Mesh, trimesh object, or arrays (vertices, faces)
        A file, or one of sphere, plane, torus-knot, cloth and blob.
    brdf : str, path, Brdf, model class or Material
        The BRDF; or the material of a model that brings several, of which each part has its own, at the mean of its
        maps.
    path : path
        The file.
    method : str
        'sh', 'wavelet', 'gaussian', or a method that a plug-in adds.
    ground_albedo : float, optional
        Albedo of a diffuse ground under the model; None for no ground.
    brushing : str, optional
        Direction of an anisotropic BRDF, as that of `make_scene`.
    check : bool
        Compare small images of the bake with the reference when it ends, which takes seconds, and keep the errors in
        the file; a Python warning names the lights under which the bake is wrong, and `relight` repeats it there.
    progress : callable, optional
        Called with a step.
    **settings
        Settings of the method, as options of `lightarc bake`: `order`, `interreflection`, `terms`, `coefficients`,
        `lobes` and so on.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    UsageError
        For settings that the method does not have or accept.
    OutputError
        Where the file cannot be written.

    References
    ----------
    .. [1] P.-P. Sloan, J. Kautz, J. Snyder, "Precomputed Radiance Transfer for Real-Time Rendering in Dynamic,
       Low-Frequency Lighting Environments", SIGGRAPH 2002, https://doi.org/10.1145/566654.566612.
    .. [2] R. Wang, J. Tran, D. Luebke, "All-Frequency Relighting of Non-Diffuse Objects using Separable BRDF
       Approximation", EGSR 2004, https://doi.org/10.2312/EGWR/EGSR04/345-354.
    .. [3] P. Green, J. Kautz, W. Matusik, F. Durand, "View-Dependent Precomputed Light Transport using Nonlinear
       Gaussian Function Approximations", I3D 2006, https://doi.org/10.1145/1111411.1111413.

    Examples
    --------
    >>> lightarc.bake("plane", "lambert:albedo=0.6", "plane.transport", method="sh", order=3).name
    'plane.transport'
    """
    if method not in names():
        raise UsageError(f"unknown method {method!r}; choose from {', '.join(names())}")
    chosen = method_of(method)
    known = [parameter.name for parameter in parameters(chosen.settings)]
    if unknown := sorted(settings.keys() - set(known)):
        raise UsageError(f"{method} has no setting {unknown[0]!r}; choose from {', '.join(known)}")
    ground = None if ground_albedo is None else Ground(albedo=ground_albedo)
    mesh = as_mesh(model) if brushing is None else as_mesh(model).brush(parse_brushing(brushing))
    parts = brdfs_of_parts(mesh, brdf) if isinstance(brdf, Material) else ()
    one = brdf.reflectance if isinstance(brdf, Material) else as_brdf(brdf)
    whole = with_backs(split_parts(mesh) if parts else mesh, ground)
    subject = Subject(whole, one, ground, kept=visibility_folder(), parts=parts)
    chosen.check_parts(subject)
    asked = chosen.settings(**settings)
    work = drain(chosen.baking.prepare(subject, asked), progress)
    baked = drain(chosen.baking.bake(path, work), progress)
    if check:
        checked = drain(check_file(path, baked.transport, chosen, subject, asked), progress)
        for text in warnings_of_check(checked, method):
            warnings.warn(text, stacklevel=3)
    return Path(path)


@public
def relight(
    path: File,
    *,
    light: LightLike | None = None,
    light_deg: tuple[float, float] | None = None,
    environment: EnvironmentLike | None = None,
    environment_rotation_deg: float = DEFAULTS.environment_rotation_deg,
    irradiance: float = DEFAULTS.irradiance,
    camera: CameraLike = "",
    size: tuple[int, int] = (512, 384),
    samples: int = 2,
    brdf: BrdfLike | None = None,
    progress: Progress | None = None,
) -> Image:
    """Render what was baked, under a light.

    Parameters
    ----------
    path : path or file object
        The file that `bake` wrote.
    light, light_deg, environment, environment_rotation_deg, irradiance, camera, size
        As those of `render`.
    samples : int
        Sub-pixels along the side of a pixel.
    brdf : BRDF or text, optional
        In place of the one that was baked, made from the visibility that `bake` kept on this machine; the file stays
        as it is.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    Image, shape (height, width, 4)
        A float32 array, as that of `render`.

    Raises
    ------
    InputError
        For a file that holds no transport or is damaged.
    UsageError
        For another BRDF where the visibility is not kept: then `bake` again.

    Examples
    --------
    >>> baked = lightarc.relight("plane.transport", light=(0, 1, 0.2), size=(16, 12), samples=1)
    >>> baked.shape, bool(baked[..., :3].max() > 0)
    ((12, 16, 4), True)
    """
    check_size(size)
    if light is not None and light_deg is not None:
        raise UsageError("give light or light_deg, not both")
    lamps, near_lamps = as_lamps(light, irradiance)
    surroundings = as_environment(environment)
    if surroundings is None and not (lamps or near_lamps):
        x, y, z = world_direction(*map(math.radians, light_deg or DEFAULTS.light_deg))
        lamps = (Lamp((float(x), float(y), float(z)), (float(irradiance),) * 3),)
    chosen_light = Light(surroundings, math.radians(environment_rotation_deg), float(irradiance), lamps, near_lamps)
    with on_disk(path, ".transport") as place:
        file = open_transport(place)
        if file.kind not in names():
            raise InputError(place, f"holds transport of an unknown method ({file.kind})", "Update Lightarc")
        chosen = method_of(file.kind)
        if near_lamps and not chosen.near_light:
            shown_by = ", ".join(each.name for each in methods_with("near_light"))
            raise UsageError(f"a {file.kind} bake shows no NearLamp; bake in mode {shown_by}, or use render or a Lamp")
        around = None if surroundings is None else surroundings.name
        for text in warnings_at_render(file.check, file.kind, around) if brdf is None else ():
            warnings.warn(text, stacklevel=3)
        if brdf is not None:
            file = drain(with_brdf(file, as_brdf(brdf), visibility_folder()), progress).file
        relit = drain(chosen.baking.illuminate(file, chosen_light, chosen.light(), None), progress).relit
        shown = relit.mesh.positions[: relit.transport.ground_vertex]
        view = as_camera(camera, shown, size)
        return as_shown(drain(image_of(relit, view, size, samples), progress).image)


@public
def plan(
    model: MeshLike | Scene,
    brdf: BrdfLike | None = None,
    environment: EnvironmentLike | None = "studio",
    *,
    material: MaterialLike | None = None,
    error: float | None = None,
    time_ms: float | None = None,
    force: Collection[str] = (),
    skip: Collection[str] = (),
    ground_albedo: float | None = None,
    camera: CameraLike = "",
    size: tuple[int, int] = (960, 540),
    frames: int = 20_000,
    costs: CostModel | None = None,
    progress: Progress | None = None,
) -> EffectsPlan:
    """Plan which effects a scene calls for, and the mode and settings that show them within a budget.

    Parameters
    ----------
    model, brdf, environment, material, ground_albedo, camera, size
        The scene, as `make_scene` takes it; or a Scene in place of the model.
    error : float, optional
        Allowed relative error; 0.01 where neither budget is given.
    time_ms : float, optional
        In its place, the allowed time of a frame.
    force, skip : collection of str
        Effects to compute, and to leave out, whatever they add.
    frames : int
        Images that are drawn with one bake.
    costs : CostModel, optional
        What settings cost on this machine; without it the kept profile is taken, or measured once, which takes some
        ten seconds.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    EffectsPlan
        The effects, the setting, and its predicted error and costs.

    Raises
    ------
    UsageError
        For both budgets, budgets that are not positive, and effects that do not exist.

    Examples
    --------
    >>> found = lightarc.plan("sphere", lightarc.Lambert, "sky", error=0.05)
    >>> found.predicted_error_rel < 0.05 and not found.shows("glossy")
    True
    """
    check_effects(force, skip)
    scene = _scene_under(model, brdf, environment, material, ground_albedo, camera, size)
    return plan_effects(
        scene.mesh,
        scene.brdf,
        scene.environment,  # type: ignore[arg-type] # checked by `_scene_under`
        cost=costs or drain(machine_profile.cost_model(), progress),
        error=error,
        time_ms=time_ms,
        force=force,
        skip=skip,
        ground=scene.ground,
        rotation=scene.environment_rotation,
        camera=scene.camera,
        material=scene.material,
        pixels=size[0] * size[1],
        aspect=size[0] / size[1],
        frames=frames,
    )


@public
def tradeoff(
    model: MeshLike | Scene,
    brdf: BrdfLike | None = None,
    environment: EnvironmentLike | None = "studio",
    *,
    material: MaterialLike | None = None,
    modes: Sequence[str] = (),
    seconds: float = 480.0,
    max_depth: int = 1,
    ground_albedo: float | None = None,
    camera: CameraLike = "",
    size: tuple[int, int] = (320, 240),
    seed: int = 0,
    folder: File | None = None,
    progress: Progress | None = None,
) -> Tradeoff:
    """Measure what accuracy costs on a scene: settings of all modes against one reference.

    Parameters
    ----------
    model, brdf, environment, material, ground_albedo, camera, size
        The scene, as `make_scene` takes it; or a Scene in place of the model.
    modes : sequence of str
        Modes to measure; all that show the scene where none is given.
    seconds : float
        Time of the measurement, at most a day.
    max_depth : int
        Points of the surface that light of the reference may touch.
    seed : int
        Seed of the reference.
    folder : path, optional
        Folder for JSON, CSV and plots; without it nothing is written.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    Tradeoff
        The measured points.

    Raises
    ------
    UsageError
        For modes that do not exist, and scenes without a reference.
    OutputError
        Where the folder cannot be written.

    Examples
    --------
    >>> found = lightarc.tradeoff("plane", lightarc.Lambert, "sky", modes=["direct"], seconds=2, size=(16, 16))
    >>> {point.mode for point in found.points}
    {'direct'}
    """
    from engine.tradeoff.write import write

    if not 0.0 < seconds <= 86_400.0:
        raise UsageError(f"seconds must be above 0 and at most 86,400, not {seconds}")
    if unknown := [mode for mode in modes if mode not in all_modes()]:
        raise UsageError(f"unknown mode {unknown[0]!r}; choose from {', '.join(all_modes())}")
    scene = _scene_under(model, brdf, environment, material, ground_albedo, camera, size)
    settings = settings_of(scene, list(modes) or modes_of(scene), bounces=max_depth > 1)
    found = drain(sweep(scene, settings, size, seconds=seconds, max_depth=max_depth, seed=seed), progress)
    if folder is not None:
        drain(write(found, Path(folder)), progress)
    return found


@public
def draw_figures(
    names: str | Sequence[str],
    folder: File,
    *,
    model: MeshLike | None = None,
    environment: EnvironmentLike | None = None,
    quick: bool = False,
    progress: Progress | None = None,
) -> list[Path]:
    """Draw the papers' figures, each panel with its error against the reference.

    Parameters
    ----------
    names : str or sequence of str
        Figures: those of `lightarc figures`, such as kautz-6 or wang-2, or all.
    folder : path
        Folder for the results; each figure gets a folder in it.
    model, environment : optional
        In place of the figures' own, as `make_scene` takes them.
    quick : bool
        Few vertices, pixels and samples, as a quick test.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    list of Path
        The sheet of each figure.

    Raises
    ------
    UsageError
        For a figure that does not exist.
    OutputError
        Where the folder cannot be written.

    Examples
    --------
    >>> [sheet.name for sheet in lightarc.draw_figures("wang-2", "figures", model="plane", quick=True)]
    ['wang-2.png']
    """
    from engine.figures.figure import Settings
    from engine.figures.write import draw_into

    wanted = [names] if isinstance(names, str) else list(names)
    chosen = list(dict.fromkeys(each for name in wanted for each in (FIGURES if name == "all" else (name,))))
    if unknown := [name for name in chosen if name not in FIGURES]:
        raise UsageError(f"unknown figure {unknown[0]!r}; choose from {', '.join(FIGURES)} and all")
    settings = Settings(None if model is None else as_mesh(model), as_environment(environment), quick)
    sheets = []
    for name in chosen:
        module, function = FIGURES[name][0].split(":")
        make = getattr(importlib.import_module(module), function)
        record = drain(draw_into(Path(folder), name, make(settings)), progress)
        sheets.append(Path(folder) / name / record["picture"])
    return sheets


def _scene_under(
    model: MeshLike | Scene,
    brdf: BrdfLike | None,
    environment: EnvironmentLike | None,
    material: MaterialLike | None,
    ground_albedo: float | None,
    camera: CameraLike,
    size: tuple[int, int],
) -> Scene:
    """The scene of the arguments, which has an environment; UsageError where it has none."""
    if isinstance(model, Scene):
        scene = model
    else:
        scene = make_scene(
            model,
            brdf=brdf,
            environment=environment,
            material=material,
            ground_albedo=ground_albedo,
            camera=camera,
            size=size,
        )
    if scene.environment is None:
        raise UsageError("a plan or a tradeoff needs an environment")
    return scene
