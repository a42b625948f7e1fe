"""Images as linear light: JPEG, PNG, TIFF, OpenEXR, Radiance and Targa, recognised by content and never by name.

Decoding happens in a child process (`engine.storage.untrusted`); `read_image` is the parent's side. An ICC profile, or
what the chunks of a PNG and the EXIF data of a camera say of colours, is applied. Without any, integer samples are
taken as sRGB-coded unless the file or the caller says linear, floating-point ones as linear; what was assumed is
returned. Cost: 24 megapixels take about 1 s and 0.7 GB, most of it the float32 result.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.images import codes, colour_space, exif, exr, png
from engine.images.colour_space import ADOBE_RGB, LINEAR_CURVE, SRGB_CURVE, ColourSpace
from engine.images.exif import Exif
from engine.images.icc import InvalidProfile, read_profile
from engine.images.raster import HALF_MAX, Raster, Transfer, about_bands, choose_bands
from engine.storage.readers import find_reader, load, readers
from engine.storage.shared_memory import result_array
from engine.storage.untrusted import decode_in_child

TransferChoice = Literal["auto", "srgb", "linear"]
Coding = Literal["srgb", "linear", "profile"]

#: A run of so many rows that are all zero, as a share 1 / n of all, is worth a warning.
_MIN_LOST_SHARE = 64

#: Files whose readers know how many rows there should be; a model in front of nothing leaves black ones in them.
_COUNTED = ("EXR", "HDR", "PFM")

#: Pixels of which the double precision is in memory at once.
_BLOCK_PIXELS = 1 << 20

#: Samples that a plateau has at least, as a number and as a share; what is near its value, as a share of it.
_MIN_PLATEAU, _MIN_PLATEAU_SHARE, _NEAR_TOP = 4, 1e-5, 0.01

#: Code values from which a lookup table is cheaper than the power function.
_TABLE_LIMIT = 1 << 16

#: Most radiance of photographs and environments; squares, and sums of many of them, are finite in single precision.
#: The sun has 2e9 cd/m².
LARGEST_RADIANCE = 1e15


@dataclass(frozen=True, eq=False)
class Image:
    """An image as linear light.

    Attributes
    ----------
    pixels : (H, W, 3) float32, linear sRGB primaries, upright, read-only; 1 = full scale of integer files.
    saturated : (H, W) bool, True where a channel is at full scale or was not finite (then its pixel is 0).
    transfer : how the samples were taken to be coded, 'srgb', 'linear', or by another curve of their 'profile'.
    bit_depth : bits per sample of the file; container : 'JPEG', 'PNG', 'TIFF', 'EXR', 'HDR', 'TGA'.
    warnings : what was ignored or assumed, in words.
    environment : 'latlong' or 'cube' where the file says that it is an environment map in that layout, else ''.
    largest_code : largest sample of an integer file.
    largest_samples, plateaus : of a floating-point file the largest finite sample of red, green and blue, and the
        share of samples equal to it where they are so many that the channel looks clipped, else 0; empty for integers.
    profile : name of the colour space that the file states and that was applied, else ''.
    """

    pixels: NDArray[np.float32]
    saturated: NDArray[np.bool_]
    transfer: Coding
    bit_depth: int
    container: str
    exif: Exif
    warnings: tuple[str, ...]
    environment: str = ""
    largest_code: int = 0
    largest_samples: tuple[float, ...] = ()
    plateaus: tuple[float, ...] = ()
    profile: str = ""


def read_image(
    path: str | os.PathLike[str],
    *,
    transfer: TransferChoice = "auto",
    half_size: bool = False,
    clamp_infinite: bool = False,
) -> Image:
    """Decode the image at `path`; `half_size` averages 2×2 pixels. InputError for what cannot be decoded whole.

    Where `transfer` is stated the samples are data, and what the file says of colours is not applied. With
    `clamp_infinite` infinite samples are `HALF_MAX`; otherwise their pixels are masked.
    """
    options: dict[str, Any] = {"transfer": transfer, "half_size": half_size, "clamp_infinite": clamp_infinite}
    return image_from_reply(decode_in_child("engine.images.decode:decode", path, **options))


def refuse_larger(path: str | os.PathLike[str], radiance: NDArray[np.float32]) -> None:
    """InputError, naming `path`, where `radiance` (H, W, 3) is beyond `LARGEST_RADIANCE` or not a number."""
    largest = max(float(radiance.max(initial=0.0)), -float(radiance.min(initial=0.0)))
    if not largest <= LARGEST_RADIANCE:
        problem = f"holds a radiance of {largest:.3g}, and what is computed here goes up to {LARGEST_RADIANCE:g}"
        raise InputError(path, problem, "Scale it down, or correct the pixels that no lamp can have made")


def image_from_reply(reply: dict[str, Any]) -> Image:
    for name in ("pixels", "saturated"):
        reply[name].flags.writeable = False
    lists = {name: tuple(reply[name]) for name in ("warnings", "largest_samples", "plateaus")}
    return Image(**{**reply, "exif": Exif(**reply["exif"]), **lists})


#: First bytes of files that are not photographs, and what to say of them.
_OTHERS = (
    (b"version https://git-lfs", "is a Git LFS pointer, not the image itself", "Run 'git lfs pull' where it lies"),
    (b"%PDF", "is a PDF document", "Export its images as TIFF or PNG"),
    (b"GIF8", "is a GIF", "Save it as PNG"),
    (b"\xabKTX ", "is a KTX texture", "Convert it to PNG, with ktx extract for one"),
    (b"DDS ", "is a DDS texture", "Convert it to PNG"),
    (b"BM", "is a BMP image", "Save it as PNG"),
    (b"PK\3\4", "is a zip archive", "Unpack it first"),
    (b"<", "is a text or web page", "Download the image itself"),
)


def has_signature(content: bytes) -> bool:
    """Return whether `content` begins as images of a format that is read do."""
    return any(each.signatures and content.startswith(each.signatures) for each in readers("image"))


def unknown(content: bytes, name: str) -> InputError:
    for signature, problem, remedy in _OTHERS:
        if content.startswith(signature):
            return InputError(name, problem, remedy)
    if content[4:8] == b"ftyp":
        return InputError(name, "is a HEIF, AVIF or video file", "Save it as JPEG or TIFF")
    titles = ", ".join(each.title for each in readers("image"))
    return InputError(name, "is not an image of a known kind", f"Give an image as {titles} or camera RAW")


def decode(
    content: bytes,
    name: str,
    transfer: TransferChoice = "auto",
    half_size: bool = False,
    orientation: int = 0,
    white_code: int = 0,
    bands: Sequence[int] = (),
    keep_primaries: bool = False,
    white_samples: Sequence[float] = (),
    keep_codes: bool = False,
    clamp_infinite: bool = False,
    codes_alone: bool = False,
) -> dict[str, Any]:
    """The decoder that runs in the child: fields of `Image` as arrays and JSON values.

    `orientation` is taken instead of the file's, and `white_code` for full scale of 16 bits, where they are not 0 and
    no sample is above.
    Floating-point samples of red, green and blue from `white_samples` on, where there are any, are saturated.
    Of `bands`, which count from 1, one becomes grey, and three red, green and blue; without any the file's colours do.
    A stated `transfer` overrides all that the file says of colours, or with `keep_primaries` its curve alone.
    With `keep_codes` there are the fields of `codes.Coded` as well, where pixels are made by tables, or with
    `codes_alone` in the place of `pixels` and `saturated`. With `clamp_infinite` infinite samples are `HALF_MAX`.
    """
    reader = find_reader("image", content, len(content), name)
    if reader is None:
        raise unknown(content, name)
    raster: Raster = load(reader.decode)(content, name)
    of_bands = about_bands(raster) if not bands else ()
    raster = choose_bands(raster, bands, name) if bands else raster
    photographed = exif.read_exif(content) if raster.container in ("JPEG", "PNG", "TIFF") else Exif()
    turn = orientation or photographed.orientation
    has_codes = white_code > 0 and raster.white is not None and raster.bit_depth == 16
    if has_codes and int(raster.samples.max(initial=0)) <= white_code:
        raster = replace(raster, white=white_code)
    stated: Transfer | None = None if transfer == "auto" or (raster.white is None and transfer == "srgb") else transfer
    space, of_colours = _decide_space(raster, photographed, stated, bool(bands), keep_primaries, name)
    clamped = np.zeros(0, np.bool_) if raster.white is not None or not clamp_infinite else raster.samples == np.inf
    if clamped.any():
        raster = replace(raster, samples=np.where(clamped, np.float32(HALF_MAX), raster.samples))
    coded = _keep_codes(raster, space, turn) if (keep_codes or codes_alone) and not half_size else {}
    shown: dict[str, Any] = {}
    broken = 0
    if not (coded and codes_alone):
        pixels, saturated, broken = _linear(raster, space, turn)
        if white_samples and raster.white is None:
            samples = raster.samples if raster.samples.ndim == 3 else raster.samples[..., None]
            clipped = np.logical_or.reduce(samples >= np.asarray(white_samples, samples.dtype), axis=2)
            saturated |= exif.orient(clipped, turn)
        pixels, saturated = halve_image(pixels, saturated) if half_size else (pixels, saturated)
        shown = {"pixels": pixels, "saturated": saturated}
    largest, plateaus = ([], []) if raster.white is not None else _find_plateaus(raster.samples)
    rows = [] if raster.container in _COUNTED else _about_rows(raster.samples)
    warnings = [*raster.warnings, *of_colours, *of_bands, *rows]
    if count := int(clamped.sum()):
        text = "samples are infinite" if count > 1 else "sample is infinite"
        warnings.append(f"{count} {text} and taken as {HALF_MAX:g}, the largest number of half floats")
    if broken:
        warnings.append(f"has {broken} pixels that are not finite; they are masked")
    if photographed.exposure_garbled:
        warnings.append(exif.EXPOSURE_GARBLED)
    return {
        **shown,
        "transfer": space.transfer,
        "profile": space.name,
        "bit_depth": raster.bit_depth,
        "container": raster.container,
        "exif": photographed.as_json(),
        "warnings": warnings,
        "environment": raster.environment,
        "largest_code": int(raster.samples.max(initial=0)) if raster.white is not None else 0,
        "largest_samples": largest,
        "plateaus": plateaus,
        **coded,
    }


def decode_alpha(content: bytes, name: str) -> dict[str, Any]:
    """A decoder like `decode`: `alpha` (H, W) float32 of a PNG or an EXR, which is a map and no coverage."""
    if content.startswith(png.SIGNATURE):
        codes = png.read_alpha(content, name)
        values: NDArray[np.floating[Any]] = codes / np.float32(np.iinfo(codes.dtype).max)
    elif content.startswith(exr.SIGNATURE):
        values = exr.read_exr_alpha(content, name)
    else:
        raise InputError(name, "has no alpha channel that is read", "Save it as a PNG")
    alpha = result_array(values.shape, np.float32)
    alpha[...] = values
    return {"alpha": alpha}


def prepare() -> None:
    """Load the readers and compile what `decode` runs, before the child is confined."""
    codes.prepare()
    colour_space.prepare()
    for reader in readers("image"):
        load(reader.decode)


def _decide_space(
    raster: Raster, photographed: Exif, stated: Transfer | None, chosen: bool, keep_primaries: bool, name: str
) -> tuple[ColourSpace, tuple[str, ...]]:
    """The space of the samples and warnings about it; InputError for a statement of the file that cannot be applied.

    `stated` is the transfer function that the caller states, and `chosen` says that the bands are.
    """
    assumed = ColourSpace("", (LINEAR_CURVE if (stated or raster.transfer) == "linear" else SRGB_CURVE,))
    if stated and not keep_primaries:
        return assumed, ()
    try:
        space = _stated_space(raster, photographed)
    except InvalidProfile as error:
        if stated:
            return assumed, (f"has a colour profile that is not applied: it {error}",)
        problem = f"has a colour profile that cannot be applied: it {error}"
        remedy = (
            "Save it with an RGB or grey profile or without one, or import it with --transfer srgb or linear, which "
            "takes its primaries as sRGB"
        )
        raise InputError(name, problem, remedy) from None
    if space is None:
        uncalibrated = photographed.colours == "uncalibrated" and raster.container == "JPEG" and not stated
        text = "states that its colours are not sRGB, but not what they are: they are taken as sRGB"
        return assumed, (text,) * uncalibrated
    if chosen:
        return assumed, (f"has the colour profile {space.name}, which is not applied to bands that are chosen",)
    if not stated:
        contradicts = raster.transfer == "linear" and raster.white is not None and space.transfer != "linear"
        text = f"says that its samples are linear, but its colour profile {space.name} has another curve, which is used"
        return space, (text,) * contradicts
    if space.table:
        text = "is not applied, because the transfer function is stated: its primaries are taken as sRGB"
        return assumed, (f"has the colour profile {space.name} with a table, which {text}",)
    differs = space.transfer != stated
    text = f"has the colour profile {space.name}, of which the curve is not applied: the transfer function is stated"
    return replace(space, curves=assumed.curves), (text,) * differs


def _stated_space(raster: Raster, photographed: Exif) -> ColourSpace | None:
    """The space that the file states; InvalidProfile where it cannot be applied to the samples."""
    if raster.invalid_space:
        raise InvalidProfile(raster.invalid_space)
    if not raster.profile:
        of_camera = photographed.colours == "adobe" and raster.container in ("JPEG", "TIFF")
        return raster.space or (ADOBE_RGB if of_camera else None)
    space = read_profile(raster.profile)
    if space.is_grey and not raster.is_grey:
        raise InvalidProfile(f"{space.name!r} is for grey, and the image has colours")
    return space


def _linear(raster: Raster, space: ColourSpace, orientation: int) -> tuple[NDArray[np.float32], NDArray[np.bool_], int]:
    """Upright linear pixels (H, W, 3), saturation mask and the number of pixels that were not finite."""
    samples = raster.samples
    if samples.ndim == 2:
        samples = np.broadcast_to(samples[..., None], (*samples.shape, 3))
    samples = exif.orient(samples, orientation)
    pixels, saturated = result_array(samples.shape, np.float32), result_array(samples.shape[:2], np.bool_)
    if raster.white is not None:
        _from_codes(samples, raster.white, space, pixels, saturated)
        return pixels, saturated, 0
    with np.errstate(over="ignore", invalid="ignore"):
        if space.matrix is None and space.transfer == "linear":
            pixels[...] = samples
        else:
            _fill_linear(samples, 1.0, space, pixels)
    np.logical_not((np.isfinite(pixels) & np.isfinite(samples)).all(axis=2), out=saturated)
    pixels[saturated] = 0
    broken = int(np.count_nonzero(saturated))
    if space.table:
        saturated |= (samples > 1.0).any(axis=2)  # which the table cannot hold
    return pixels, saturated, broken


def _from_codes(
    samples: NDArray[np.unsignedinteger[Any]],
    white: int,
    space: ColourSpace,
    pixels: NDArray[np.float32],
    saturated: NDArray[np.bool_],
) -> None:
    if _has_tables(samples, white, space):
        matrix = None if space.matrix is None else space.matrix.astype(np.float32)
        codes.decode(samples, _tables(white, space), matrix, white, pixels, saturated)
        return
    saturated[...] = (samples >= white).any(axis=2)
    _fill_linear(samples, white, space, pixels)


def _find_plateaus(samples: NDArray[np.floating[Any]]) -> tuple[list[float], list[float]]:
    """The largest finite sample of red, green and blue, and the share of samples on the plateau there; 0 for none.

    Samples of light thin out towards the largest. A plateau has more samples at the largest itself than lie just below
    it, and more than a few.
    """
    largest, plateaus = [], []
    for channel in (samples,) * 3 if samples.ndim == 2 else np.moveaxis(samples, -1, 0):
        finite = channel[np.isfinite(channel)]
        top = finite.max(initial=0.0)
        at_top = int(np.count_nonzero(finite == top))
        near = int(np.count_nonzero(finite >= top * (1.0 - _NEAR_TOP))) - at_top
        largest.append(float(top))
        is_plateau = top > 0.0 and at_top >= max(_MIN_PLATEAU, finite.size * _MIN_PLATEAU_SHARE, 2 * near)
        plateaus.append(at_top / finite.size if is_plateau else 0.0)
    return largest, plateaus


def _has_tables(samples: NDArray[Any], white: int, space: ColourSpace) -> bool:
    """Whether the light of each code is looked up."""
    return white < _TABLE_LIMIT and samples.dtype.itemsize <= 2 and not space.table


def _tables(white: int, space: ColourSpace) -> NDArray[np.float32]:
    values = np.minimum(np.arange(_TABLE_LIMIT) / white, 1.0)
    return np.stack([curve.linear(values) for curve in space.curves]).astype(np.float32)


def _keep_codes(raster: Raster, space: ColourSpace, orientation: int) -> dict[str, Any]:
    """The fields of `Coded`; none where pixels are not made by tables."""
    if raster.white is None or not _has_tables(raster.samples, raster.white, space):
        return {}
    samples = raster.samples if raster.samples.ndim == 3 else raster.samples[..., None]
    samples = exif.orient(samples, orientation)
    kept = samples
    if not samples.flags.c_contiguous:
        kept = result_array(samples.shape, samples.dtype)
        kept[...] = samples
    tables = np.ascontiguousarray(_tables(raster.white, space)[:, : 256**samples.dtype.itemsize])
    matrix = {} if space.matrix is None else {"matrix": space.matrix.astype(np.float32)}
    return {"codes": kept, "tables": tables, "white": raster.white, **matrix}


def _fill_linear(samples: NDArray[Any], white: float, space: ColourSpace, pixels: NDArray[np.float32]) -> None:
    """Block by block, because the values of double precision take much memory."""
    rows = max(1, _BLOCK_PIXELS // samples.shape[1])
    for first in range(0, len(samples), rows):
        block = np.s_[first : first + rows]
        values = samples[block] / np.float64(white)
        pixels[block] = space.linear(values if white == 1.0 else np.minimum(values, 1.0))


def _about_rows(samples: NDArray[Any]) -> list[str]:
    """A warning where the last rows, or rows in between, are black without exception as lost data is.

    No error, because a sample in front of a black ground looks so as well; a reader that knows how much data there
    should be has refused what is too short.
    """
    height = samples.shape[0]
    empty: NDArray[np.bool_] = np.logical_not(samples.any(axis=tuple(range(1, samples.ndim))))
    if empty.all():
        return []
    rows = int(np.count_nonzero(empty))
    least = max(2, height // _MIN_LOST_SHARE)
    longest = max((len(list(run)) for lost, run in itertools.groupby(empty.tolist()) if lost), default=0)
    if longest < least:
        return []
    where = ", its last ones among them" if empty[-least:].all() else ""
    return [f"has {rows} of {height} rows that are all zero{where}: check that it is complete"]


def halve_image(
    pixels: NDArray[np.float32], saturated: NDArray[np.bool_]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Means over 2×2 pixels (an odd last row or column is dropped); saturated where one of the four is."""
    height, width = (max(1, size // 2) for size in saturated.shape)
    if min(saturated.shape) < 2:
        return pixels, saturated
    blocks = saturated[: 2 * height, : 2 * width].reshape(height, 2, width, 2)
    small = cv2.resize(pixels[: 2 * height, : 2 * width], (width, height), interpolation=cv2.INTER_AREA)
    return small, np.logical_or.reduce(blocks, axis=(1, 3))
