"""Camera RAW through LibRaw (rawpy): sensor samples to linear sRGB. Runs in the decoder child.

LibRaw unpacks; black, white, saturation, balance, interpolation and colour matrix are done here in floating point,
without any automatic brightening. LibRaw half-decodes truncated files without an exception: what it prints is an
error, and so is an image with rows that were never filled.
"""

from __future__ import annotations

import io
import logging
from collections.abc import Sequence
from typing import Any

import numpy as np
import rawpy
import tifffile
from numpy.typing import NDArray

from engine.capture.photograph import demosaic, radiometry
from engine.capture.photograph.bayer import Mosaic, Sensor, is_bayer, turn_back
from engine.core.colour import invertible, srgb_from_camera
from engine.core.errors import InputError, UsageError
from engine.images.decode import halve_image
from engine.images.exif import EXPOSURE_GARBLED, Exif, rational, read_exif
from engine.images.raster import check_size
from engine.images.tiff import RAW_PHOTOMETRICS, check_segments, check_tags
from engine.images.tiff_directories import check_directories
from engine.storage.decoder_child import complaints
from engine.storage.shared_memory import result_array
from engine.storage.untrusted import AGAIN

WhiteBalance = str | Sequence[float]

#: EXIF orientation of LibRaw's `flip` bits (4 transpose, 2 rows, 1 columns).
_ORIENTATION = (1, 2, 4, 3, 5, 8, 6, 7)

_MIN_SIDE = 4

#: Bands of rows in which missing data is looked for.
_BANDS = 64

#: Most directories of a RAW file; cameras write some 10.
_DIRECTORIES_LIMIT = 100

_WITHOUT_DATA = "is an incomplete RAW file: it has rows without data"

_CONVERT = "Convert it to DNG, for example with Adobe DNG Converter"

logging.getLogger("tifffile").setLevel(logging.CRITICAL)


def decode_raw(
    content: bytes,
    name: str,
    white_balance: WhiteBalance,
    half_size: bool,
    keep_mosaic: bool,
    mosaic_alone: bool,
) -> dict[str, Any]:
    """Fields of `engine.capture.photograph.decode.Photograph` as arrays and JSON values, and the `shape` of its pixels.

    With `keep_mosaic` a Bayer mosaic that is not halved comes as it is too, with its `colours` and the `turn` that
    makes it upright; with `mosaic_alone` without the pixels that are made of it.
    """
    raw = _unpack(content, name)  # which holds the samples until the last view of them has gone
    warnings: list[str] = []
    samples, sites = _samples(raw, name)
    black, white = _levels(raw, sites)
    _check_filled(samples, black, white, name)
    multipliers = _multipliers(raw, white_balance, warnings)
    camera, matrix_source = _matrix(raw, warnings)
    colours = None if samples.ndim == 3 else _colours(raw, sites, name)
    orientation = _ORIENTATION[raw.sizes.flip % 8]
    try:
        radiometry.level_scale(black, white)
    except UsageError as error:
        raise InputError(name, f"has impossible levels ({error})", "Convert it again to DNG") from None
    matrix = radiometry.balance_matrix(camera, multipliers)
    if colours is not None and is_bayer(colours):
        samples = np.ascontiguousarray(samples)
        mosaic = Mosaic.turn_upright(samples, Sensor(black, white, colours, matrix, orientation))
        pixels = {} if mosaic_alone and not half_size else _develop(mosaic, half_size)
        pixels |= _describe_mosaic(samples, mosaic) if keep_mosaic and not half_size else {}
    else:
        pixels = _interpolate(samples, black, white, colours, matrix, orientation, half_size)
    exposure = _exposure(raw, read_exif(content), warnings)
    return {
        **pixels,
        **exposure,
        "black_level": black.ravel().tolist(),
        "white_level": white.ravel().tolist(),
        "bit_depth": int(white.max()).bit_length(),
        "container": "RAW",
        "transfer": "linear",
        "white_balance": multipliers.tolist(),
        "camera_matrix": camera.ravel().tolist(),
        "matrix_source": matrix_source,
        "warnings": warnings,
    }


def read_noted_exposure(content: bytes, name: str) -> dict[str, Any]:
    """exposure_s, iso and aperture as LibRaw finds them, without decoding the image."""
    with rawpy.RawPy() as raw, complaints():
        try:
            raw.open_buffer(io.BytesIO(content))
            exposure = _exposure(raw, Exif(), [])  # which unpacks the samples
        except rawpy.LibRawError as error:
            raise InputError(name, f"cannot be opened (LibRaw: {error})", _CONVERT) from None
    return {key: exposure[key] for key in ("exposure_s", "iso", "aperture")}


def _unpack(content: bytes, name: str) -> rawpy.RawPy:
    _check_strips(content, name)
    raw = rawpy.RawPy()
    with complaints() as said:
        try:
            raw.open_buffer(io.BytesIO(content))
            sizes = raw.sizes
            check_size(name, sizes.raw_width, sizes.raw_height, 2, len(content))
            raw.unpack()
        except (rawpy.LibRawFileUnsupportedError, rawpy.NotSupportedError):
            raise InputError(name, "is a RAW file of a kind that LibRaw does not read", _CONVERT) from None
        except rawpy.LibRawError as error:
            reason = error.args[0].decode() if error.args and isinstance(error.args[0], bytes) else str(error)
            raise InputError(name, f"is a damaged RAW file (LibRaw: {reason})", AGAIN) from None
    if said:
        raise InputError(name, f"is an incomplete RAW file (LibRaw: {' '.join(said)[:120]})", AGAIN)
    return raw


def _check_strips(content: bytes, name: str) -> None:
    """All tags, strips and tiles of a TIFF-like file must lie inside it, and in a DNG fit the size it states."""
    if not content.startswith((b"II*\0", b"MM\0*")):
        return
    check_directories(content, name, _DIRECTORIES_LIMIT)
    with tifffile.TiffFile(io.BytesIO(content)) as file:
        pages = [page for top in file.pages for page in (top, *(top.pages or ()))]
        for page in pages:
            check_tags(content, page.offset, name)
            if page.photometric in RAW_PHOTOMETRICS and "DNGVersion" in file.pages[0].tags:
                check_segments(page, content, name)
            for offset, count in zip(page.dataoffsets, page.databytecounts, strict=False):
                if offset + count > len(content):
                    raise InputError(name, "is an incomplete RAW file: it ends before its image does", AGAIN)


def _samples(raw: rawpy.RawPy, name: str) -> tuple[NDArray[np.uint16], NDArray[np.integer]]:
    """Sensor samples (H, W), or (H, W, 3) where every pixel has all colours, and the channel of each site."""
    samples = raw.raw_image_visible
    if min(samples.shape[:2]) < _MIN_SIDE:
        raise InputError(name, f"has {samples.shape[1]} × {samples.shape[0]} samples only", AGAIN)
    if samples.ndim == 3:
        return samples[..., :3], np.arange(3)[None]
    sites = raw.raw_pattern
    if sites is None:
        raise InputError(name, "has a colour filter array that LibRaw does not describe", _CONVERT)
    return samples, sites


def _describe_mosaic(samples: NDArray[np.uint16], mosaic: Mosaic) -> dict[str, Any]:
    """The fields by which the parent makes it anew, besides those of every RAW file."""
    sensor = mosaic.sensor
    colours = sensor.colours.ravel().tolist()
    return {"mosaic": samples, "colours": colours, "turn": sensor.orientation, "shape": mosaic.shape}


def _develop(mosaic: Mosaic, half_size: bool) -> dict[str, Any]:
    pixels = result_array((*mosaic.shape, 3), np.float32), result_array(mosaic.shape, np.bool_)
    mosaic.develop_into(*pixels)
    return _name_pixels(pixels, half_size)


def _interpolate(
    samples: NDArray[np.uint16],
    black: NDArray[np.float64],
    white: NDArray[np.float64],
    colours: NDArray[np.integer] | None,
    matrix: NDArray[np.float32],
    orientation: int,
    half_size: bool,
) -> dict[str, Any]:
    """The same of other sensors; `colours` per site is None for `samples` of all colours."""
    shape = samples.shape[1::-1] if orientation >= 5 else samples.shape[:2]
    pixels = result_array((*shape, 3), np.float32), result_array(shape, np.bool_)
    radiance, saturated = (turn_back(array, orientation) for array in pixels)
    if colours is not None:
        camera = demosaic.demosaic(radiometry.linearise(samples, black, white), colours)
        np.matmul(camera, matrix.T, out=radiance)
        saturated[...] = demosaic.spread(radiometry.at_white(samples, white))
    else:
        channels = [radiometry.linearise(samples[..., c], black[0, c], white[0, c]) for c in range(3)]
        radiance[...] = np.stack(channels, axis=-1) @ matrix.T
        saturated[...] = (samples >= white).any(axis=2)
    return _name_pixels(pixels, half_size)


def _name_pixels(pixels: tuple[NDArray[np.float32], NDArray[np.bool_]], half_size: bool) -> dict[str, Any]:
    radiance, saturated = halve_image(*pixels) if half_size else pixels
    return {"radiance": radiance, "saturated": saturated, "shape": saturated.shape}


def _levels(raw: rawpy.RawPy, sites: NDArray[np.integer]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Black and white level per site of the pattern."""
    black = np.asarray(raw.black_level_per_channel, float)
    white = np.full(4, float(raw.white_level))
    per_channel = raw.camera_white_level_per_channel
    if per_channel is not None:
        stated = np.asarray(per_channel, float)
        white = np.where((stated > black) & (stated <= white), stated, white)
    return black[sites], white[sites]


def _colours(raw: rawpy.RawPy, sites: NDArray[np.integer], name: str) -> NDArray[np.int64]:
    """0, 1, 2 for red, green, blue per site."""
    letters = raw.color_desc.decode("ascii", "replace")
    if {letters[site] for site in sites.ravel()} != set("RGB"):
        raise InputError(name, f"has a sensor with the colours {letters}, not red, green and blue", _CONVERT)
    return np.asarray(np.vectorize(lambda site: "RGB".index(letters[site]))(sites), np.int64)


def _check_filled(
    samples: NDArray[np.uint16], black: NDArray[np.float64], white: NDArray[np.float64], name: str
) -> None:
    """Refuse an image with rows that were never filled: bands of one value, or of zeros where black is above 0.

    Bands at the black level or at white are left alone, as an image without noise may have them, unless they are
    zeros at its end. So is an image of one value, unless that is 0 where black is above 0: no sensor gives it, and
    LibRaw does for a file that ends before its image begins.
    """
    bands = np.array_split(samples, min(_BANDS, samples.shape[0]))
    lowest, highest = ([int(extreme(band)) for band in bands] for extreme in (np.min, np.max))
    if min(lowest) == max(highest) and (max(highest) > 0 or black.min() <= 0):
        return
    if max(highest) == 0:
        raise InputError(name, _WITHOUT_DATA, AGAIN)
    for number, (low, high) in enumerate(zip(lowest, highest, strict=True)):
        last = number == len(bands) - 1
        if low == high < white.min() and (low not in black or (last and low == 0)) and bands[number].size > 1:
            where = "its last rows" if last else "some of its rows"
            raise InputError(name, f"is an incomplete RAW file: {where} all hold the value {low}", AGAIN)
    if black.min() > 0 and any(np.count_nonzero(band) < band.size / 2 for band in bands):
        raise InputError(name, _WITHOUT_DATA, AGAIN)


def _multipliers(raw: rawpy.RawPy, choice: WhiteBalance, warnings: list[str]) -> NDArray[np.float64]:
    if choice == "none":
        return np.ones(3)
    values = raw.camera_whitebalance[:3] if isinstance(choice, str) else choice
    multipliers = radiometry.white_balance(values)
    if multipliers is None:
        given = ", ".join(f"{value:g}" for value in values)
        warnings.append(f"has unusable white balance multipliers ({given}); none is applied")
        return np.ones(3)
    return multipliers


def _matrix(raw: rawpy.RawPy, warnings: list[str]) -> tuple[NDArray[np.float64], str]:
    """Camera RGB to linear sRGB and its source: what LibRaw knows of the camera or the DNG, else what the file states
    otherwise."""
    tabulated = srgb_from_camera(raw.rgb_xyz_matrix[:3])
    if tabulated is not None:
        return tabulated, "LibRaw"
    stated = np.asarray(raw.color_matrix[:, :3], float)
    if invertible(stated):
        return stated, "the file"
    warnings.append("has no usable colour matrix; camera colours are taken as sRGB")
    return np.eye(3), ""


def _exposure(raw: rawpy.RawPy, exif: Exif, warnings: list[str]) -> dict[str, Any]:
    """Exposure by EXIF, else by LibRaw from elsewhere in the file (it takes n/0 for n, so EXIF has the last word)."""
    other = raw.other
    if exif.exposure_garbled:
        warnings.append(EXPOSURE_GARBLED)
    return {
        "camera": exif.camera,
        "exposure_s": exif.exposure_s if exif.exposure_garbled else exif.exposure_s or rational(other.shutter_speed, 1),
        "iso": exif.iso or rational(other.iso_speed, 1),
        "aperture": exif.aperture or rational(other.aperture, 1),
    }
