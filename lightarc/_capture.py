"""Photographs of a flat sample under a moving lamp, the stack that an import makes of them, and the surface behind it.

Modules of the engine are imported within functions: `import lightarc` then takes some 20 ms in place of a second.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from engine.capture.lights.sources import find_packed
from engine.capture.photograph.grey_patch import GreyPatch
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.shading.shading_map import include
from lightarc._border import public
from lightarc._inputs import File, Progress, as_stack, capture_of, is_array, numeric

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from engine.capture.lights.sources import Sources
    from engine.capture.stack import ImageStack
    from engine.surface.recover import Surface


@public
def simulate_capture(
    folder: File,
    *,
    sample: Literal["woven", "hammered", "leather", "plain"] = "woven",
    elevations_deg: Sequence[float] = (5, 10, 20, 30, 40, 50, 60, 70, 80, 90),
    size: int = 512,
    seed: int = 1,
    progress: Progress | None = None,
) -> Path:
    """Photograph a procedural sample on the virtual light arc.

    Parameters
    ----------
    folder : path
        Folder of the photographs; it is made where it does not exist.
    sample : {'woven', 'hammered', 'leather', 'plain'}
        The sample.
    elevations_deg : sequence of float
        Elevations of the lamp above the sample, one photograph each, 1 … 90 degrees.
    size : int
        Width and height of a photograph in pixels, 16 … 2048.
    seed : int
        Equal seeds give equal files.
    progress : callable, optional
        Called with a step, `done` in [0, 1] and a `note`.

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
    from engine.simulate.arc import LightArc
    from engine.simulate.simulate import simulate

    arc = LightArc(sample=sample, elevation=tuple(map(math.radians, elevations_deg)), size=size, seed=seed)
    return drain(simulate(arc, Path(folder)), progress).folder


@public
def open_capture(*paths: File, angles_deg: Sequence[float] | None = None) -> Sources:
    """Find photographs and the position of the light in each.

    Parameters
    ----------
    *paths : path
        A folder, files, or one zip or tar.
    angles_deg : sequence of float, optional
        Elevations of the lamp in degrees, one for each photograph in the order of the file names. Without it
        `capture.toml`, an `.lp` file or the file names give them.

    Returns
    -------
    Sources
        The photographs, their lights, and the source of the angles.

    Raises
    ------
    InputError
        Where photographs are missing or do not fit together.

    Examples
    --------
    >>> capture = lightarc.open_capture("capture")
    >>> capture
    Sources(name='capture', photographs=3, angles='capture.toml')
    """
    return drain(find_packed([Path(path) for path in paths], angles_deg))


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
    crop: tuple[int, int, int, int] | None = None,
    corners: ArrayLike | None = None,
    dark: File | Literal["auto", "none"] = "auto",
    flat: File | Literal["auto", "none"] = "auto",
    lamp_distance: float | None = None,
    equalise: Literal["object"] | tuple[int, int, int, int] | None = None,
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
        Transfer function of 8- and 16-bit files.
    crop : tuple of int, optional
        (left, top, width, height) in pixels of the photographs.
    corners : array_like, shape (4, 2), optional
        In place of a crop, the corners (x, y) of a rectangle to rectify, clockwise from its top left.
    dark, flat : path, 'auto' or 'none'
        Photographs without light, and of an even white surface; 'auto' for those found beside the photographs.
    lamp_distance : float, optional
        Distance of a near lamp from the middle of the photograph, in its widths.
    equalise : 'object' or tuple, optional
        Divide out that lamps differ in intensity, by the object or by a white patch (left, top, width, height).
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
    from engine.capture.import_stack import ImportSettings, import_stack

    def patch(choice: Any) -> Any:
        return GreyPatch(*choice) if isinstance(choice, tuple | list) and len(choice) == 4 else choice

    framing: Any = None
    if corners is not None:
        framing = tuple((float(x), float(y)) for x, y in numeric(corners, "corners", 4, 2))
    settings = ImportSettings(
        motion=motion,
        white_balance=patch(white_balance),
        transfer=transfer,
        crop=crop,
        framing=framing,
        dark=dark if dark in ("auto", "none") else Path(dark),
        flat=flat if flat in ("auto", "none") else Path(flat),
        lamp_distance=lamp_distance,
        equalise=patch(equalise),
        trust_angles=trust_angles,
        strict=strict,
        use_all=use_all,
    )
    with capture_of(capture, angles_deg, lights) as sources:
        return drain(import_stack(sources, settings, folder), progress)


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
    from engine.capture.stack import open_stack as read_stack

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
    from engine.surface.recover import recover
    from engine.surface.write import write_surface

    if is_array(stack) and lights is None:
        raise UsageError("normals need lights, one vector towards the lamp for each photograph")
    if white is not None and not 1e-6 <= white <= 1e6:
        raise UsageError(f"white {white} is not a positive radiance")
    images = as_stack(stack, None, lights)
    surface = drain(recover(images, include(images, excluded), white=white, left_out=errors), progress)
    if folder is not None:
        provenance = {**images.provenance, "excluded_photographs": list(excluded)}
        drain(write_surface(Path(folder), surface, provenance, "Lightarc normals"), progress)
    return surface
