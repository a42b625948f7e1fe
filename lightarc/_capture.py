"""Photographs of a flat sample under a moving lamp, and the stack that an import makes of them.

Modules of the engine are imported within functions: `import lightarc` then takes 20 ms in place of a second.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from engine.core.steps import Step, drain
from lightarc._border import public

if TYPE_CHECKING:
    from engine.capture.lights.sources import Sources
    from engine.capture.stack import ImageStack

File = str | os.PathLike[str]
Progress = Callable[[Step], None]


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
    """Photograph a procedural sample on the virtual light arc into `folder`, which is returned.

    Parameters
    ----------
    elevations_deg : of the lamp above the sample, one photograph each, 1 … 90 degrees.
    size : width and height of a photograph in pixels, 16 … 2048.
    seed : equal seeds give equal files.

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
    """The photographs in `paths` and what is known of their lights: a folder, files, or one zip or tar.

    `angles_deg` are elevations of the lamp, one for each photograph in the order of the file names; without them
    capture.toml, an .lp file or the file names say them. InputError where photographs are missing or do not fit.

    >>> capture = lightarc.open_capture("capture")
    >>> capture.angle_source, len(capture.photographs)
    ('capture.toml', 3)
    """
    from engine.capture.lights.sources import find_packed

    return drain(find_packed([Path(path) for path in paths], angles_deg))


@public
def import_capture(
    capture: Sources | File,
    folder: File,
    *,
    angles_deg: Sequence[float] | None = None,
    motion: Literal["auto", "none", "translation", "euclidean", "affine", "homography"] = "auto",
    white_balance: Literal["camera", "none"] | tuple[float, float, float] = "camera",
    transfer: Literal["auto", "srgb", "linear"] = "auto",
    crop: tuple[int, int, int, int] | None = None,
    progress: Progress | None = None,
) -> ImageStack:
    """Decode, calibrate and align photographs into the stack `folder`, and open it.

    Parameters
    ----------
    capture : what `open_capture` returns, or a folder or an archive (then with `angles_deg`, as there).
    motion : of the camera between photographs, which alignment may undo; 'none' leaves pixels where they are.
    white_balance : of raw files: the camera's, none, or factors of red, green and blue.
    transfer : how 8- and 16-bit files are coded.
    crop : (left, top, width, height) in pixels of the photographs; None for all that they share.

    InputError for photographs that cannot be read or do not fit together, OutputError where the stack cannot be
    written.

    >>> stack = lightarc.import_capture(capture, "stack", motion="none")
    >>> stack.radiance.shape, stack.elevation_deg.tolist()
    ((3, 32, 32, 3), [30.0, 60.0, 90.0])
    """
    from engine.capture.import_stack import ImportSettings, import_stack
    from engine.capture.lights.sources import Sources

    sources = capture if isinstance(capture, Sources) else open_capture(capture, angles_deg=angles_deg)
    settings = ImportSettings(motion=motion, white_balance=white_balance, transfer=transfer, crop=crop)
    return drain(import_stack(sources, settings, folder), progress)


@public
def open_stack(folder: File) -> ImageStack:
    """The stack that an import left in `folder`; InputError where it is damaged or is none.

    >>> stack = lightarc.open_stack("stack")
    >>> stack.sources
    ('plain_30.tif', 'plain_60.tif', 'plain_90.tif')
    """
    from engine.capture.stack import open_stack as opened

    return opened(folder)
