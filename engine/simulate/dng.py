"""Bayer DNG files, written by hand so that every sample and level in them is known (Adobe DNG 1.4; TIFF 6.0).

One uncompressed strip of 16-bit samples, little-endian, with black level per site, white level, colour matrix and
exposure. The camera's colours are those of linear sRGB, each divided by its white-balance gain, so that a converter
that applies `neutral` and the matrix gives back the linear sRGB image.
Not through tifffile, which writes no Exif directory, where the exposure stands.
Cost: one copy of the mosaic.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import SRGB_FROM_XYZ

#: Channel of each site of the 2 x 2 pattern, row by row: R G / G B.
RGGB = ((0, 1), (1, 2))

_BYTE, _ASCII, _SHORT, _LONG, _RATIONAL, _SRATIONAL = 1, 2, 3, 4, 5, 10
_CODES = {_BYTE: "B", _SHORT: "H", _LONG: "I"}


@dataclass(frozen=True)
class Levels:
    """Meaning of a raw sample: value = (sample - black of its site) / (white - black).

    Attributes
    ----------
    black : black level of each site of the pattern, row by row.
    white : sample at which a site is full.
    neutral : camera colour of a white surface, at most 1 in each channel; its inverse is the white balance.
    """

    black: tuple[tuple[int, int], tuple[int, int]] = ((512, 512), (512, 512))
    white: int = 16383
    neutral: tuple[float, float, float] = (0.5, 1.0, 0.625)

    def __post_init__(self) -> None:
        if not 0 <= max(map(max, self.black)) < self.white <= 65535:
            raise ValueError(f"black {self.black} must be below white {self.white}, which must fit 16 bits")
        if not all(0 < channel <= 1 for channel in self.neutral):
            raise ValueError(f"neutral {self.neutral} must lie in (0, 1]")


def mosaic(image: NDArray[np.float32], neutral: Sequence[float]) -> NDArray[np.float32]:
    """(H, W) camera signal behind the RGGB filters of an (H, W, 3) linear sRGB image, not clipped."""
    signal = np.empty(image.shape[:2], np.float32)
    for row, channels in enumerate(RGGB):
        for column, channel in enumerate(channels):
            signal[row::2, column::2] = image[row::2, column::2, channel] * np.float32(neutral[channel])
    return signal


def quantise(signal: NDArray[np.float32], levels: Levels) -> NDArray[np.uint16]:
    """Samples of a signal in [0, 1]: black and white levels applied, rounded to nearest, held within [0, white]."""
    samples = np.empty(signal.shape, np.uint16)
    for row in (0, 1):
        for column in (0, 1):
            black = levels.black[row][column]
            site = np.rint(black + signal[row::2, column::2].astype(np.float64) * (levels.white - black))
            samples[row::2, column::2] = np.clip(site, 0, levels.white)
    return samples


def dng_bytes(
    samples: NDArray[np.uint16], levels: Levels, *, exposure_s: float, model: str = "Lightarc virtual light arc"
) -> bytes:
    """The DNG file of an (H, W) RGGB mosaic."""
    rows, columns = samples.shape
    data = np.ascontiguousarray(samples, "<u2").tobytes()
    exposure = Fraction(exposure_s).limit_denominator(1_000_000)
    matrix = [neutral * value for neutral, row in zip(levels.neutral, SRGB_FROM_XYZ, strict=True) for value in row]
    pattern = [channel for row in RGGB for channel in row]
    entries: dict[int, tuple[int, Any]] = {
        254: (_LONG, [0]),
        256: (_LONG, [columns]),
        257: (_LONG, [rows]),
        258: (_SHORT, [16]),
        259: (_SHORT, [1]),
        262: (_SHORT, [32803]),
        271: (_ASCII, "Lightarc"),
        272: (_ASCII, model),
        273: (_LONG, [_HEADER_BYTES]),
        274: (_SHORT, [1]),
        277: (_SHORT, [1]),
        278: (_LONG, [rows]),
        279: (_LONG, [len(data)]),
        284: (_SHORT, [1]),
        33421: (_SHORT, [2, 2]),
        33422: (_BYTE, pattern),
        34665: (_LONG, [0]),
        50706: (_BYTE, [1, 4, 0, 0]),
        50707: (_BYTE, [1, 1, 0, 0]),
        50708: (_ASCII, model),
        50713: (_SHORT, [2, 2]),
        50714: (_SHORT, [black for row in levels.black for black in row]),
        50717: (_LONG, [levels.white]),
        50721: (_SRATIONAL, [Fraction(value).limit_denominator(100_000) for value in matrix]),
        50728: (_RATIONAL, [Fraction(value).limit_denominator(100_000) for value in levels.neutral]),
        50778: (_SHORT, [21]),
    }
    start = _HEADER_BYTES + len(data) + len(data) % 2
    exif = _directory(
        {33434: (_RATIONAL, [exposure]), 33437: (_RATIONAL, [Fraction(8)]), 34855: (_SHORT, [100])}, start
    )
    entries[34665] = (_LONG, [start])
    main = _directory(entries, start + len(exif))
    header = struct.pack("<2sHI", b"II", 42, start + len(exif))
    return b"".join([header, data, b"\0" * (len(data) % 2), exif, main])


_HEADER_BYTES = 8


def _directory(entries: dict[int, tuple[int, Any]], offset: int) -> bytes:
    """An image file directory that lies at `offset`, followed by the values that do not fit into its entries."""
    table, values = b"", b""
    after = offset + 2 + 12 * len(entries) + 4
    for tag, (kind, value) in sorted(entries.items()):
        packed = _pack(kind, value)
        count = len(packed) if kind == _ASCII else len(value)
        if len(packed) > 4:
            field = struct.pack("<I", after + len(values))
            values += packed + b"\0" * (len(packed) % 2)
        else:
            field = packed.ljust(4, b"\0")
        table += struct.pack("<HHI", tag, kind, count) + field
    return struct.pack("<H", len(entries)) + table + struct.pack("<I", 0) + values


def _pack(kind: int, value: Any) -> bytes:
    if kind == _ASCII:
        return bytes(value, "ascii") + b"\0"
    if kind in (_RATIONAL, _SRATIONAL):
        code = "<ii" if kind == _SRATIONAL else "<II"
        return b"".join(struct.pack(code, number.numerator, number.denominator) for number in value)
    return struct.pack(f"<{len(value)}{_CODES[kind]}", *value)
