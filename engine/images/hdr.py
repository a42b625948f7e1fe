"""Radiance images (Ward1991): RGBE or XYZE, eight orientations, EXPOSURE and COLORCORR divided out.

Three codings of lines: plain, the run-length coding by components of 1991, and the one before, in which a pixel of
mantissas 1, 1, 1 repeats the last one as often as its exponent says (times 256 for each that follows another).
Ours instead of OpenCV's, which refuses XYZE and other orientations than -Y +X, and passes over EXPOSURE. OpenImageIO
(8 MB) would come in for this format alone: the others have decoders, whose limits are tested.
"""

from __future__ import annotations

import re

import imagecodecs
import numpy as np

from engine.core.colour import srgb_from_xyz
from engine.core.errors import InputError
from engine.images.colour_space import ColourSpace, linear_space
from engine.images.raster import Raster, check_size
from engine.storage.untrusted import AGAIN

SIGNATURES = (b"#?RADIANCE", b"#?RGBE")

_HEADER_LIMIT = 65536
_RESOLUTION = re.compile(rb"([+-])([XY]) (\d{1,9}) ([+-])([XY]) (\d{1,9})\n")
_CANONICAL = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n"
_WIDTHS_WITH_RUNS = range(8, 32768)


def read_hdr(content: bytes, name: str) -> Raster:
    header, _, rest = content[:_HEADER_LIMIT].partition(b"\n\n")
    size = _RESOLUTION.match(rest)
    if size is None or {size[2], size[5]} != {b"X", b"Y"}:
        raise InputError(name, "is a damaged Radiance image (its size is missing)", AGAIN)
    lines, columns = int(size[3]), int(size[6])
    check_size(name, columns, lines, 12, len(content))
    body = _plain(content[len(header) + 2 + size.end() :], lines, columns, name)
    samples = imagecodecs.rgbe_decode(_CANONICAL % (lines, columns) + body)
    samples = _upright(samples, size) / _exposure(header, name)
    if b"FORMAT=32-bit_rle_xyze" in header:
        samples = srgb_from_xyz(samples).astype(np.float32)
        space, invalid = None, ""
    else:
        space, invalid = _space(header)
    return Raster(samples, None, 32, "linear", "HDR", _list_ignored(header), space=space, invalid_space=invalid)


def _list_ignored(header: bytes) -> tuple[str, ...]:
    """A warning of a gamma, which the header states and nobody applies."""
    gamma = b"".join(_find_stated(header, b"GAMMA")[:1]).strip()
    if gamma not in (b"", b"1", b"1.0", b"1.00"):
        return (f"states a gamma of {gamma[:20].decode('ascii', 'replace')}, which is not applied",)
    return ()


def _space(header: bytes) -> tuple[ColourSpace | None, str]:
    """The space of the line PRIMARIES, None for that of sRGB, that which Radiance takes for its own (equal energy), and
    where nothing is stated; or else why the statement cannot be applied."""
    primaries = _find_stated(header, b"PRIMARIES")
    if not primaries:
        return None, ""
    try:
        stated = [float(each) for each in primaries[0].split()]
    except ValueError:
        stated = []
    if len(stated) != 8:
        return None, "states primaries that are not eight numbers"
    known = ((0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290), (0.64, 0.33, 0.29, 0.60, 0.15, 0.06, 0.333, 0.333))
    if not any(stated) or any(np.allclose(stated, one, atol=0.011) for one in known):  # zeros are Photoshop's
        return None, ""
    try:
        return linear_space(stated), ""
    except ValueError as error:
        return None, f"states {error}"


def _find_stated(header: bytes, key: bytes) -> list[bytes]:
    """Values of the lines `key=value`, in their order."""
    return [line.partition(b"=")[2] for line in header.split(b"\n") if line.startswith(key + b"=")]


def _plain(body: bytes, lines: int, columns: int, name: str) -> bytes:
    """The body as the decoder reads it, with runs as before 1991 written out; refused where it holds too little."""
    if body[:2] == b"\2\2" and columns in _WIDTHS_WITH_RUNS:
        return body
    wanted = lines * columns
    if len(body) < 4 * wanted and b"\1\1\1" in body:
        pixels = np.frombuffer(body, "<u4", len(body) // 4)
        body = _without_runs(pixels, wanted, name)
    if len(body) < 4 * wanted:
        raise InputError(name, "is an incomplete Radiance image: it ends before its image does", AGAIN)
    return body


def _without_runs(pixels: np.ndarray, wanted: int, name: str) -> bytes:
    """Pixels (P,) as 32-bit words with all runs repeated: `wanted` of them."""
    run = pixels & 0xFFFFFF == 0x010101
    number = np.arange(len(pixels))
    last = np.maximum.accumulate(np.where(run, -1, number))
    digit = number - last - 1  # each run that follows another counts 256 times as much
    if run[0] or digit.max() > 3:
        raise InputError(name, "is a damaged Radiance image: its runs repeat nothing, or far too much", AGAIN)
    count = np.where(run, (pixels >> 24).astype(np.int64) << (8 * np.maximum(digit, 0)), 1)
    ends = np.cumsum(count)
    kept = int(np.searchsorted(ends, wanted)) + 1
    if kept > len(ends) or ends[kept - 1] != wanted:
        raise InputError(name, "is an incomplete Radiance image: its runs do not end where its image does", AGAIN)
    return np.repeat(pixels[last[:kept]], count[:kept]).tobytes()


def _upright(samples: np.ndarray, size: re.Match[bytes]) -> np.ndarray:
    """First axis down and second to the right, from the directions in which lines and pixels were stored."""
    if size[1] == (b"+" if size[2] == b"Y" else b"-"):
        samples = samples[::-1]
    if size[4] == (b"+" if size[5] == b"Y" else b"-"):
        samples = samples[:, ::-1]
    return samples if size[2] == b"Y" else samples.swapaxes(0, 1)


def _exposure(header: bytes, name: str) -> np.ndarray:
    """(3,) by which the samples were multiplied: all EXPOSURE lines, and all COLORCORR lines for each channel."""
    product = np.ones(3)
    for count, value in [
        *((1, value) for value in _find_stated(header, b"EXPOSURE")),
        *((3, value) for value in _find_stated(header, b"COLORCORR")),
    ]:
        try:
            factors = np.array([float(word) for word in value.split()])
        except ValueError:
            factors = np.zeros(1)
        if len(factors) != count:
            factors = np.zeros(1)
        with np.errstate(over="ignore", invalid="ignore"):
            product = product * factors
    if not ((product > 1e-30) & (product < 1e30)).all():
        problem = "says that its exposure is not a factor above 0"
        raise InputError(name, problem, "Correct the EXPOSURE and COLORCORR lines of its header")
    return product.astype(np.float32)
