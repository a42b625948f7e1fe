"""Photographs of a flat sample under a moving lamp, the stack that an import makes of them, and the surface behind it.

Modules of the engine are imported within functions: `import lightarc` then takes some 20 ms in place of a second.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.mirror_sphere import Circle
from engine.capture.lights.selection import Arc, Listed
from engine.capture.lights.sources import find_packed
from engine.capture.photograph.grey_patch import GreyPatch
from engine.capture.registration.framing import Framing
from engine.capture.registration.framing import crop as crop_to_size
from engine.capture.registration.warp import Region
from engine.capture.scale import CameraDistance, ChartPitch, KnownLength, ScaleChoice
from engine.capture.stack import open_stack as read_stack
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.shading.shading_map import include
from engine.simulate.arc import LightArc
from engine.simulate.simulate import simulate
from engine.surface.recover import check_white, recover
from engine.surface.write import write_surface
from lightarc._border import check_size, public
from lightarc._inputs import File, Progress, as_azimuth, as_stack, capture_of, is_array, numeric

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from engine.capture.lights.mirror_sphere import Circle
    from engine.capture.lights.sources import Sources
    from engine.capture.stack import ImageStack
    from engine.surface.recover import Surface

#: Where a mirror sphere is seen: found in the photographs, or (column, row, radius) in pixels.
Outline = Literal["auto"] | tuple[float, float, float]

#: Settings of `LightArc` that `simulate_capture` passes on.
SIMULATION_OPTIONS = frozenset(
    {
        "format",
        "noise",
        "misalignment_px",
        "turn",
        "exposure",
        "lamp_distance",
        "corner_loss",
        "dark",
        "calibration",
        "sphere",
        "raw_bits",
        "interreflection",
    }
)


@public
def simulate_capture(
    folder: File,
    *,
    sample: Literal["woven", "hammered", "leather", "medal", "plain"] = "woven",
    elevations_deg: Sequence[float] = (5, 10, 20, 30, 40, 50, 60, 70, 80, 90),
    azimuths_deg: Sequence[float] = (0,),
    size: int = 512,
    seed: int = 1,
    progress: Progress | None = None,
    **options: Any,
) -> Path:
    """Photograph a procedural sample on the virtual light arc or dome.

    Parameters
    ----------
    folder : path
        Folder of the photographs; it is made where it does not exist.
    sample : {'woven', 'hammered', 'leather', 'medal', 'plain'}
        The sample.
    elevations_deg : sequence of float
        Elevations of the lamp above the sample, 1 … 90 degrees.
    azimuths_deg : sequence of float
        Azimuths of the lamp, 0 … 360 degrees, 0 = right, 90 = up in the image; one photograph for each pair.
    size : int
        Width and height of a photograph in pixels, 16 … 2048.
    seed : int
        Equal seeds give equal files.
    progress : callable, optional
        Called with a step, `done` in [0, 1] and a `note`.
    **options
        Further settings, as options of `lightarc simulate`: `format`, `noise`, `misalignment_px`, `exposure`,
        `lamp_distance`, `corner_loss`, `dark`, `calibration`, `sphere`, `raw_bits`, `interreflection`, and `turn` in
        radians.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    UsageError
        For a sample, an elevation or a size that is not possible.
    OutputError
        Where the folder cannot be written.

    Examples
    --------
    >>> import lightarc
    >>> folder = lightarc.simulate_capture("capture", sample="plain", elevations_deg=(30, 60, 90), size=32)
    >>> sorted(path.name for path in folder.glob("*.tif"))
    ['plain_30.tif', 'plain_60.tif', 'plain_90.tif']
    """
    if unknown := sorted(options.keys() - SIMULATION_OPTIONS):
        raise UsageError(f"unknown option {unknown[0]!r}; choose from {', '.join(sorted(SIMULATION_OPTIONS))}")
    elevation, azimuth = (tuple(map(math.radians, angles)) for angles in (elevations_deg, azimuths_deg))
    arc = LightArc(sample=sample, elevation=elevation, azimuth=azimuth, size=size, seed=seed, **options)
    return drain(simulate(arc, Path(folder)), progress).folder


@public
def open_capture(
    *paths: File,
    angles_deg: Sequence[float] | None = None,
    sphere: Outline | None = None,
    pair: File | Literal["auto", "none"] = "auto",
) -> Sources:
    """Find photographs and the position of the light in each.

    Parameters
    ----------
    *paths : path
        A folder, files, or one zip or tar.
    angles_deg : sequence of float, optional
        Elevations of the lamp in degrees, one for each photograph in the order of the file names. Without it
        `capture.toml`, an `.lp` file or the file names give them.
    sphere : 'auto' or (float, float, float), optional
        Measure the lights on a mirror sphere: found in the photographs, or with the outline (column, row, radius) in
        pixels.
    pair : 'auto', 'none' or path
        Pairs under parallel and crossed polarisers: told by names of files or folders, or the folder of the crossed
        photographs; 'none' takes each photograph by itself.

    Returns
    -------
    Sources
        The photographs, their lights, and the source of the angles.

    Raises
    ------
    InputError
        Where photographs are missing or do not fit together, and where the sphere is not found.

    Examples
    --------
    >>> capture = lightarc.open_capture("capture")
    >>> capture
    Sources(name='capture', photographs=3, angles='capture.toml')
    """
    chosen: Any = pair if pair in ("auto", "none") else Path(pair)
    return drain(find_packed([Path(path) for path in paths], angles_deg, sphere=_outline(sphere), pair=chosen))


@public
def import_capture(
    capture: Sources | File | Sequence[File] | ArrayLike,
    folder: File,
    *,
    angles_deg: ArrayLike | None = None,
    lights: ArrayLike | None = None,
    motion: Literal["auto", "none", "translation", "euclidean", "affine", "homography"] = "auto",
    white_balance: Literal["camera", "none"] | tuple[float, float, float] | tuple[int, int, int, int] = "camera",
    transfer: Literal["auto", "srgb", "linear"] = "auto",
    working_space: Literal["rec709", "rec2020", "acescg", "auto"] = "rec709",
    bands: Sequence[int] = (),
    crop: tuple[int, int, int, int] | None = None,
    corners: ArrayLike | None = None,
    size: tuple[int, int] | None = None,
    dark: File | Literal["auto", "none"] = "auto",
    flat: File | Literal["auto", "none"] = "auto",
    lamp_distance: float | None = None,
    equalise: Literal["object"] | tuple[int, int, int, int] | None = None,
    sphere: Outline | None = None,
    second_sphere: Outline | None = None,
    azimuth_deg: float | tuple[float, float] | None = None,
    arc: bool = False,
    keep: Sequence[int | str] | None = None,
    calibrate: Literal["auto", "none"] | Sequence[str] = "auto",
    lights_form: str = "listed",
    chart: File | Literal["auto"] | None = None,
    mask: File | Literal["alpha"] | None = None,
    estimate_lights: bool = False,
    pair_gain: float | None = None,
    scale: float | tuple[Sequence[float], Sequence[float], float] | Literal["exif"] | None = None,
    distance_mm: float | None = None,
    chart_pitch_mm: float | None = None,
    lens: File | None = None,
    trust_angles: bool = False,
    strict: bool = False,
    use_all: bool = False,
    progress: Progress | None = None,
) -> ImageStack:
    """Decode, calibrate and align photographs into a stack.

    Parameters
    ----------
    capture : Sources, path, sequence of paths, or array of shape (N, H, W, 3)
        The result of `open_capture`, a folder, an archive, files, or the photographs themselves: floats are linear
        radiance, 1 = white level; 8 and 16 bits are sRGB-coded.
    folder : path
        Folder of the stack.
    angles_deg : array_like, shape (N,), optional
        Elevations of the lamp in degrees, in the order of the file names or of the array.
    lights : array_like, shape (N, 3), optional
        In their place, for arrays: vectors towards the lamp, x to the right of the photograph, y up, z to the camera.
    motion : {'auto', 'none', 'translation', 'euclidean', 'affine', 'homography'}
        Motion of the camera between photographs, which alignment may undo.
    white_balance : {'camera', 'none'} or tuple
        Of raw files: the camera's, none, or three factors of red, green and blue. Four whole numbers are a grey patch
        (left, top, width, height), which balances all files.
    transfer : {'auto', 'srgb', 'linear'}
        Transfer function of 8- and 16-bit files; 'auto' is that of their colour profile. A stated one overrides the
        curve of a profile, not its primaries.
    working_space : {'rec709', 'rec2020', 'acescg', 'auto'}
        Linear space in which maps of the capture are made, since colours beyond it do not fit between 0 and 1; 'auto'
        is Rec.2020 where colours go beyond Rec.709. Radiance is linear Rec.709 all the same, with negative components
        beyond. ``stack.provenance["gamut"]`` says how many texels are.
    bands : sequence of int
        Of images with more bands than colours, the one that becomes grey, or the three that become red, green and
        blue; the first is 1.
    crop : tuple of int, optional
        (left, top, width, height) in pixels of the photographs.
    corners : array_like, shape (4, 2), optional
        In place of a crop, the corners (x, y) of a rectangle to rectify, clockwise from its top left.
    size : (int, int), optional
        (width, height) of the images in the stack, with `crop` or `corners`.
    dark, flat : path, 'auto' or 'none'
        Photographs without light, and of an even white surface; 'auto' for those found beside the photographs. A folder
        has one of each lamp, named as the photographs or in their order.
    lamp_distance : float, optional
        Distance of a near lamp from the middle of the photograph, in its widths.
    equalise : 'object' or tuple, optional
        Divide out that lamps differ in intensity, by the object or by a white patch (left, top, width, height).
    sphere : 'auto' or (float, float, float), optional
        Measure the lights on a mirror sphere, as in `open_capture`.
    second_sphere : 'auto' or (float, float, float), optional
        A second mirror sphere on the sample, which with the first determines the positions of near lamps.
    azimuth_deg : float or (float, float), optional
        Keep the lights of this azimuth alone, in degrees, 0 = right, 90 = up in the image, within a tolerance (2.5).
    arc : bool
        Keep the lights of one arc: the azimuth ±10° with most elevations.
    keep : sequence of int or str, optional
        Keep these photographs alone: numbers from 1 in the order of the file names, or file names.
    calibrate : {'auto', 'none'} or sequence of str
        Properties of the rig to estimate from the photographs: 'distance', 'gains', 'ambient', 'motion', 'lights'.
    lights_form : str
        Form in which a list of lights is read, as the report of an import suggests, such as 'mirrored-x'.
    chart : path or 'auto', optional
        Correct colours by a classic chart of 24 patches: in a photograph of the capture ('auto'), in another one under
        the same lamps, or as ``lightarc import --write-chart`` saved it. ``stack.provenance["chart"]`` has its figures.
    mask : path or 'alpha', optional
        An image, drawn on a photograph, whose white pixels show the object, or the alpha channel of the photographs:
        surface maps have no background.
    estimate_lights : bool
        Estimate the lights from the photographs alone, as equally bright lamps on several sides over a matte sample
        that lies flat; ``stack.angle_source`` is then 'photographs'.
    pair_gain : float, optional
        Of pairs under polarisers (see `open_capture`), the brightness of a matte white patch in crossed photographs
        over that in parallel ones; without it, it is estimated. ``stack.provenance["polarisation"]`` has its figures.
    scale : float or (point, point, float), optional
        Millimetres per pixel of the photographs; or two points (x, y) in pixels of the one that the others are aligned
        to, and the millimetres between them; or 'exif' for an estimate from the focal length, the sensor and the
        distance that the camera notes. ``stack.provenance["scale"]`` has the size of a texel.
    distance_mm : float, optional
        With ``scale="exif"``, the millimetres from the sample to the sensor as measured.
    chart_pitch_mm : float, optional
        In its place, the millimetres between the middles of neighbouring patches of the `chart`.
    lens : path, optional
        Take off the distortion of the lens: a folder of photographs of a chessboard, or a ``.lens`` file.
    trust_angles : bool
        Take unstated angles also where the photographs do not grow brighter with them.
    strict : bool
        Refuse a capture of which a photograph cannot be read, in place of leaving that one out.
    use_all : bool
        Use photographs that show nothing too.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    ImageStack
        The stack, opened.

    Raises
    ------
    UsageError
        For settings that do not fit, and arrays without angles.
    InputError
        For photographs that cannot be read or do not fit together.
    OutputError
        Where the stack cannot be written.

    Examples
    --------
    >>> stack = lightarc.import_capture(capture, "stack", motion="none")
    >>> stack
    ImageStack(photographs=3, size='32 × 32 px', elevations='30° to 90°', angles='capture.toml', warnings=0)

    Photographs that are arrays already:

    >>> arrays = lightarc.import_capture(stack.radiance[:], "arrays", angles_deg=[30, 60, 90], motion="none")
    >>> bool((arrays.radiance[:] == stack.radiance[:]).all())
    True
    """

    def patch(choice: Any) -> Any:
        return GreyPatch(*choice) if isinstance(choice, tuple | list) and len(choice) == 4 else choice

    settings = ImportSettings(
        motion=motion,
        white_balance=patch(white_balance),
        transfer=transfer,
        working_space=working_space,
        bands=tuple(bands),
        crop=crop if size is None else None,
        framing=_framing(crop, corners, size),
        dark=dark if dark in ("auto", "none") else Path(dark),
        flat=flat if flat in ("auto", "none") else Path(flat),
        lamp_distance=lamp_distance,
        equalise=patch(equalise),
        lights=_selection(azimuth_deg, arc, keep),
        second_sphere=_outline(second_sphere),
        calibrate=calibrate if calibrate in ("auto", "none") else tuple(calibrate),
        lights_form=lights_form,
        chart=None if chart is None else "auto" if chart == "auto" else Path(chart),
        mask=None if mask is None else "alpha" if mask == "alpha" else Path(mask),
        estimate_lights=estimate_lights,
        pair_gain=pair_gain,
        scale=_scale(scale, chart_pitch_mm, distance_mm),
        lens=None if lens is None else Path(lens),
        trust_angles=trust_angles,
        strict=strict,
        use_all=use_all,
    )
    with capture_of(capture, angles_deg, lights, _outline(sphere)) as sources:
        return drain(import_stack(sources, settings, folder), progress)


def _scale(scale: Any, chart_pitch_mm: float | None, distance_mm: float | None) -> ScaleChoice | None:
    """Return the size of a pixel, or what tells it, as the engine takes it."""
    if scale is not None and chart_pitch_mm is not None:
        raise UsageError("give scale or chart_pitch_mm, not both")
    if distance_mm is not None and scale != "exif":
        raise UsageError('distance_mm is for scale="exif"')
    if isinstance(scale, str):
        if scale != "exif":
            raise UsageError(
                f"a scale is millimetres per pixel, two points with their distance, or 'exif', not {scale!r}"
            )
        return CameraDistance(None if distance_mm is None else float(distance_mm))
    if chart_pitch_mm is not None:
        return ChartPitch(float(chart_pitch_mm))
    if scale is None or isinstance(scale, int | float):
        return None if scale is None else float(scale)
    first, second, length = scale
    (x0, y0), (x1, y1) = (map(float, numeric(each, "scale", 2)) for each in (first, second))
    return KnownLength((x0, y0), (x1, y1), float(length))


def _outline(sphere: Circle | Literal["auto"] | ArrayLike | None) -> Any:
    """Return the outline of a mirror sphere as the engine takes it."""
    if sphere is None or sphere == "auto" or isinstance(sphere, Circle):
        return sphere
    numbers = numeric(sphere, "sphere", 3)
    if not numbers[2] > 2.0:
        raise UsageError("a sphere is 'auto' or (column, row, radius) with a radius above 2 px")
    return Circle(*map(float, numbers))


def _framing(crop: Sequence[int] | None, corners: ArrayLike | None, size: tuple[int, int] | None) -> Any:
    """Return the part of the photographs that a stack shows, None for all or a plain crop."""
    if crop is not None and corners is not None:
        raise UsageError("give crop or corners, not both")
    if size is not None:
        check_size(size)
    if corners is not None:
        points: Any = tuple((float(x), float(y)) for x, y in numeric(corners, "corners", 4, 2))
        return points if size is None else Framing(points, *size)
    if size is None:
        return None
    if crop is None:
        raise UsageError("size needs crop or corners, the part of the photographs that gets this size")
    return crop_to_size(Region(*crop), *size)


def _selection(azimuth_deg: float | Sequence[float] | None, arc: bool, keep: Sequence[int | str] | None) -> Any:
    """Return the lights that an import keeps, None for all."""
    if (azimuth_deg is not None) + arc + (keep is not None) > 1:
        raise UsageError("give azimuth_deg, arc or keep, one of them alone")
    if keep is not None:
        return Listed(tuple(map(str, [keep] if isinstance(keep, str) else keep)))
    return Arc() if arc else as_azimuth(azimuth_deg)


@public
def open_stack(folder: File) -> ImageStack:
    """Open the stack that an import left in a folder.

    Parameters
    ----------
    folder : path
        Folder of the stack.

    Returns
    -------
    ImageStack
        The stack; its pixels stay on disk and are read as they are indexed.

    Raises
    ------
    InputError
        Where the folder holds no stack or a damaged one.

    Examples
    --------
    >>> stack = lightarc.open_stack("stack")
    >>> stack.sources
    ('plain_30.tif', 'plain_60.tif', 'plain_90.tif')
    """
    return read_stack(folder)


@public
def recover_normals(
    stack: ImageStack | File | ArrayLike,
    folder: File | None = None,
    *,
    lights: ArrayLike | None = None,
    white: float | None = None,
    excluded: Collection[str] = (),
    errors: bool = True,
    progress: Progress | None = None,
) -> Surface:
    """Recover normals, height and PBR maps from photographs of lamps on several sides.

    Parameters
    ----------
    stack : ImageStack, path, or array of shape (N, H, W, 3)
        Photographs of one view under lamps on several sides.
    folder : path, optional
        Folder for the maps as files; without it nothing is written.
    lights : array_like, shape (N, 3), optional
        For arrays: vectors towards the lamps, x to the right of the photograph, y up, z to the camera.
    white : float, optional
        Radiance of a white card that faces a lamp; None for 1, or more where the sample is brighter.
    excluded : collection of str
        File names of photographs to leave out.
    errors : bool
        Whether the errors of photographs that are left out are measured, which takes a fit for each.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    Surface
        `maps` with their uncertainty, the lamps, and the health of the recovery.

    Raises
    ------
    UsageError
        For arrays without lights, and photographs that the stack does not hold.
    InputError
        Where the lamps do not determine any slope.
    OutputError
        Where the folder cannot be written.

    References
    ----------
    .. [1] R. J. Woodham, "Photometric Method for Determining Surface Orientation from Multiple Images", Optical
       Engineering 19(1), 1980, https://doi.org/10.1117/12.7972479.

    Examples
    --------
    A flat matt sample under twelve lamps has normals along z:

    >>> import numpy as np
    >>> angle = np.radians(np.arange(0, 360, 30))
    >>> lights = np.column_stack([np.cos(angle), np.sin(angle), np.ones(12)]) / np.sqrt(2)
    >>> photographs = np.full((12, 16, 16, 3), 0.3, np.float32)
    >>> surface = lightarc.recover_normals(photographs, lights=lights, errors=False)
    >>> np.round(surface.maps.normal[8, 8], 3).tolist()
    [0.0, 0.0, 1.0]
    """
    if is_array(stack) and lights is None:
        raise UsageError("normals need lights, one vector towards the lamp for each photograph")
    check_white(white, "white")
    images = as_stack(stack, None, lights)
    surface = drain(recover(images, include(images, excluded), white=white, left_out=errors), progress)
    if folder is not None:
        provenance = {**images.provenance, "excluded_photographs": list(excluded)}
        drain(write_surface(Path(folder), surface, provenance, "Lightarc normals"), progress)
    return surface
