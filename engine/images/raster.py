"""A decoded image of one file format: samples as they are stored, and their meaning."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.core.figure_text import size_text
from engine.images.colour_space import ColourSpace
from engine.images.exif import Exif

Transfer = Literal["srgb", "linear"]

#: The largest number of half floats.
HALF_MAX = 65504.0

PIXEL_LIMIT = 200_000_000
DECODED_LIMIT_BYTES = 4 * 2**30

#: No compression of photographs reaches this; a small file that promises more lies about its size.
_RATIO_LIMIT = 2000
_RATIO_FREE_BYTES = 256 * 2**20

UNWANTED = "Save it as an RGB or grey image with 8 or 16 bits, or as EXR"


@dataclass(frozen=True, eq=False)
class Raster:
    """Samples of one image, (H, W) or (H, W, 3) in R, G, B order.

    `white` is the integer code of full scale, None for floating-point samples (which have no clipping level).
    `environment` is 'latlong' or 'cube' where the file says that it is an environment map in that layout.
    `bands` are all samples (H, W, S) of a file that holds more than its colours. `is_grey` where the file has no
    colours, also where `samples` have three channels. `profile` is the ICC profile, and `space` what else of the file
    states the meaning of its samples, which `transfer` states where both are missing; `invalid_space` says why a
    statement cannot be applied.
    """

    samples: NDArray[Any]
    white: int | None
    bit_depth: int
    transfer: Transfer
    container: str
    warnings: tuple[str, ...] = ()
    exif: Exif | None = None
    environment: str = ""
    bands: NDArray[Any] | None = None
    is_grey: bool = False
    profile: bytes = b""
    space: ColourSpace | None = None
    invalid_space: str = ""


def choose_bands(raster: Raster, bands: Sequence[int], name: str) -> Raster:
    """`raster` with one of all bands of its file as grey, or three as red, green and blue; they count from 1."""
    samples = raster.samples if raster.bands is None else raster.bands
    samples = samples[..., None] if samples.ndim == 2 else samples
    count = samples.shape[2]
    if max(bands) > count:
        problem = f"holds {count} band{'s' * (count > 1)}, and no band {max(bands)}"
        raise InputError(name, problem, f"Choose one or three of the bands 1 to {count}")
    chosen = samples[..., [band - 1 for band in bands]]
    return replace(raster, samples=chosen[..., 0] if len(bands) == 1 else chosen, bands=None)


def about_bands(raster: Raster) -> tuple[str, ...]:
    """A warning where a file holds more than the colours that are used."""
    if raster.bands is None:
        return ()
    used, count = 1 if raster.samples.ndim == 2 else raster.samples.shape[2], raster.bands.shape[2]
    if count == used + 1:
        return ("has an alpha or extra channel, which is ignored",)
    return (f"has {count} bands, of which the first {'is' if used == 1 else f'{used} are'} used",)


def check_size(name: str, width: int, height: int, bytes_per_pixel: int, file_bytes: int) -> None:
    """Refuse what a header promises, before anything is allocated for it."""
    if width <= 0 or height <= 0:
        raise InputError(name, f"says it has {width} × {height} pixels", "Export it again")
    pixels = width * height
    if pixels > PIXEL_LIMIT:
        problem = f"says it has {width} × {height} pixels, more than the limit of {PIXEL_LIMIT // 10**6} megapixels"
        raise InputError(name, problem, "Scale it down, or export it again if it is smaller than that")
    size_bytes = pixels * bytes_per_pixel
    if size_bytes > DECODED_LIMIT_BYTES:
        raise InputError(name, f"needs {size_text(size_bytes)} decoded, more than the limit of 4 GiB", "Scale it down")
    if size_bytes > max(_RATIO_FREE_BYTES, _RATIO_LIMIT * file_bytes):
        problem = f"says it has {width} × {height} pixels, which {file_bytes} bytes cannot hold"
        raise InputError(name, problem, "Export it again")


def white_code(samples: NDArray[np.unsignedinteger[Any]], bits: int) -> int:
    """Code of full scale for samples of `bits`, where fewer bits may have been stored high-aligned.

    A 12-bit image shifted left by 4 never sets its low bits, so its white is 65520, not 65535. At most 6 such bits
    are believed; an image of few values that happens to look shifted is off by less than 0.1 %.
    """
    used = int(np.bitwise_or.reduce(samples, axis=None))
    unused = (used & -used).bit_length() - 1 if used else 0
    return (1 << bits) - (1 << (unused if unused <= min(6, bits - 8) else 0))
