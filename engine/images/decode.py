"""Pictures as linear light: JPEG, PNG, TIFF, OpenEXR and Radiance, recognised by content and never by name.

Decoding happens in a child process (`engine.files.untrusted`); `read_image` is the parent's side. Integer samples are
taken as sRGB-coded unless the file or the caller says linear, floating-point ones as linear; what was assumed is
returned. Cost: 24 megapixels take about 1 s and 0.7 GB, most of it the float32 result.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.colour import srgb_decode
from engine.errors import InputError
from engine.files.untrusted import decode_in_child
from engine.images import exif, exr, hdr, jpeg, png, tiff
from engine.images.exif import Exif
from engine.images.raster import Raster, Transfer

TransferChoice = Literal["auto", "srgb", "linear"]

#: Code values from which a lookup table is cheaper than the power function.
_TABLE_LIMIT = 1 << 16


@dataclass(frozen=True, eq=False)
class Image:
    """A picture as linear light.

    Attributes
    ----------
    pixels : (H, W, 3) float32, linear sRGB primaries, upright, read-only; 1 = full scale of integer files.
    saturated : (H, W) bool, True where a channel is at full scale or was not finite (then its pixel is 0).
    transfer : how the samples were taken to be coded, 'srgb' or 'linear'.
    bit_depth : bits per sample of the file; container : 'JPEG', 'PNG', 'TIFF', 'EXR', 'HDR'.
    warnings : what was ignored or assumed, in words.
    """

    pixels: NDArray[np.float32]
    saturated: NDArray[np.bool_]
    transfer: Transfer
    bit_depth: int
    container: str
    exif: Exif
    warnings: tuple[str, ...]


def read_image(path: str | os.PathLike[str], *, transfer: TransferChoice = "auto", half_size: bool = False) -> Image:
    """Decode the picture at `path`; `half_size` averages 2×2 pixels. InputError for what cannot be decoded whole."""
    reply = decode_in_child("engine.images.decode:decode", path, transfer=transfer, half_size=half_size)
    return image_from_reply(reply)


def image_from_reply(reply: dict[str, Any]) -> Image:
    for name in ("pixels", "saturated"):
        reply[name].flags.writeable = False
    return Image(**{**reply, "exif": Exif(**reply["exif"]), "warnings": tuple(reply["warnings"])})


_READERS: tuple[tuple[tuple[bytes, ...], Callable[[bytes, str], Raster]], ...] = (
    ((jpeg.SIGNATURE,), jpeg.read_jpeg),
    ((png.SIGNATURE,), png.read_png),
    (tiff.SIGNATURES, tiff.read_tiff),
    ((exr.SIGNATURE,), exr.read_exr),
    (hdr.SIGNATURES, hdr.read_hdr),
)

#: First bytes of files that are no photographs, and what to say of them.
_OTHERS = (
    (b"version https://git-lfs", "is a Git LFS pointer, not the picture itself", "Run 'git lfs pull' where it lies"),
    (b"%PDF", "is a PDF document", "Export its pictures as TIFF or PNG"),
    (b"GIF8", "is a GIF", "Save it as PNG"),
    (b"BM", "is a BMP image", "Save it as PNG"),
    (b"PK\3\4", "is a zip archive", "Unpack it first"),
    (b"<", "is a text or web page", "Download the picture itself"),
)

SUPPORTED = "Give a JPEG, PNG, TIFF, EXR, HDR or camera RAW file"


def reader(content: bytes) -> Callable[[bytes, str], Raster] | None:
    """The reader for `content`, by its signature."""
    for signatures, read in _READERS:
        if content.startswith(signatures):
            return read
    return None


def unknown(content: bytes, name: str) -> InputError:
    for signature, problem, remedy in _OTHERS:
        if content.startswith(signature):
            return InputError(name, problem, remedy)
    if content[4:8] == b"ftyp":
        return InputError(name, "is a HEIF, AVIF or video file", "Save it as JPEG or TIFF")
    return InputError(name, "is not a picture of a known kind", SUPPORTED)


def decode(content: bytes, name: str, transfer: TransferChoice = "auto", half_size: bool = False) -> dict[str, Any]:
    """The decoder that runs in the child: fields of `Image` as arrays and JSON values."""
    read = reader(content)
    if read is None:
        raise unknown(content, name)
    raster = read(content, name)
    if transfer != "auto" and raster.white is not None:
        raster = replace(raster, transfer=transfer)
    photographed = exif.read_exif(content) if raster.container in ("JPEG", "PNG", "TIFF") else Exif()
    pixels, saturated, broken = _linear(raster)
    warnings = list(raster.warnings)
    if broken:
        warnings.append(f"has {broken} pixels that are not finite; they are masked")
    if photographed.exposure_garbled:
        warnings.append(exif.EXPOSURE_GARBLED)
    if half_size:
        pixels, saturated = halved(pixels, saturated)
    return {
        "pixels": exif.oriented(pixels, photographed.orientation),
        "saturated": exif.oriented(saturated, photographed.orientation),
        "transfer": raster.transfer,
        "bit_depth": raster.bit_depth,
        "container": raster.container,
        "exif": photographed.as_json(),
        "warnings": warnings,
    }


def _linear(raster: Raster) -> tuple[NDArray[np.float32], NDArray[np.bool_], int]:
    """Linear pixels (H, W, 3), saturation mask and the number of pixels that were not finite."""
    samples = raster.samples if raster.samples.ndim == 3 else np.repeat(raster.samples[..., None], 3, axis=2)
    if raster.white is not None:
        at_white = np.logical_or.reduce(samples >= raster.white, axis=2)
        return _from_codes(samples, raster.white, raster.transfer), at_white, 0
    with np.errstate(over="ignore"):
        pixels = samples.astype(np.float32)
    broken = ~np.logical_and.reduce(np.isfinite(pixels), axis=2)
    pixels[broken] = 0
    return pixels, broken, int(broken.sum())


def _from_codes(samples: NDArray[np.unsignedinteger[Any]], white: int, transfer: Transfer) -> NDArray[np.float32]:
    if white < _TABLE_LIMIT:
        codes = np.minimum(np.arange(min(_TABLE_LIMIT, 1 << 8 * samples.dtype.itemsize)) / white, 1.0)
        table = (srgb_decode(codes) if transfer == "srgb" else codes).astype(np.float32)
        return table[samples]
    values = samples / np.float64(white)
    return (srgb_decode(values) if transfer == "srgb" else values).astype(np.float32)


def halved(pixels: NDArray[np.float32], saturated: NDArray[np.bool_]) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Means over 2×2 pixels (an odd last row or column is dropped); saturated where one of the four is."""
    height, width = (max(1, size // 2) for size in saturated.shape)
    if min(saturated.shape) < 2:
        return pixels, saturated
    blocks = saturated[: 2 * height, : 2 * width].reshape(height, 2, width, 2)
    small = cv2.resize(pixels[: 2 * height, : 2 * width], (width, height), interpolation=cv2.INTER_AREA)
    return small, np.logical_or.reduce(blocks, axis=(1, 3))
