"""Radiance pictures (Ward 1991, "Real pixels"): RGBE or XYZE, eight orientations, EXPOSURE divided out."""

from __future__ import annotations

import re

import imagecodecs
import numpy as np

from engine.colour import srgb_from_xyz
from engine.errors import InputError
from engine.files.untrusted import AGAIN
from engine.images.raster import Raster, check_size

SIGNATURES = (b"#?RADIANCE", b"#?RGBE")

_HEADER_LIMIT = 65536
_RESOLUTION = re.compile(rb"([+-])([XY]) (\d{1,9}) ([+-])([XY]) (\d{1,9})\n")
_CANONICAL = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n"
_WIDTHS_WITH_RUNS = range(8, 32768)


def read_hdr(content: bytes, name: str) -> Raster:
    header, _, rest = content[:_HEADER_LIMIT].partition(b"\n\n")
    size = _RESOLUTION.match(rest)
    if size is None or {size[2], size[5]} != {b"X", b"Y"}:
        raise InputError(name, "is a damaged Radiance picture (its size is missing)", AGAIN)
    lines, columns = int(size[3]), int(size[6])
    check_size(name, columns, lines, 12, len(content))
    body = content[len(header) + 2 + size.end() :]
    _check_body(body, lines, columns, name)
    samples = imagecodecs.rgbe_decode(_CANONICAL % (lines, columns) + body)
    samples = _upright(samples, size) / np.float32(_exposure(header, name))
    if b"FORMAT=32-bit_rle_xyze" in header:
        samples = srgb_from_xyz(samples).astype(np.float32)
    return Raster(samples, None, 32, "linear", "HDR")


def _check_body(body: bytes, lines: int, columns: int, name: str) -> None:
    """Refuse what the decoder would misread: too little data, and the run-length coding used before 1991."""
    if body[:2] == b"\2\2" and columns in _WIDTHS_WITH_RUNS:
        return
    if len(body) < 4 * lines * columns:
        if b"\1\1\1" in body:
            raise InputError(
                name, "uses the run-length coding of Radiance before 1991", "Save it again as .hdr or .exr"
            )
        raise InputError(name, "is an incomplete Radiance picture: it ends before its picture does", AGAIN)


def _upright(samples: np.ndarray, size: re.Match[bytes]) -> np.ndarray:
    """First axis down and second to the right, from the directions in which lines and pixels were stored."""
    if size[1] == (b"+" if size[2] == b"Y" else b"-"):
        samples = samples[::-1]
    if size[4] == (b"+" if size[5] == b"Y" else b"-"):
        samples = samples[:, ::-1]
    return samples if size[2] == b"Y" else samples.swapaxes(0, 1)


def _exposure(header: bytes, name: str) -> float:
    product = 1.0
    for value in re.findall(rb"^EXPOSURE=(.*)$", header, re.MULTILINE):
        product *= float(value)
    if not 1e-30 < product < 1e30:
        raise InputError(name, f"says its exposure is {product}", "Correct the EXPOSURE lines of its header")
    return product
