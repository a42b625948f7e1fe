"""The lens of the virtual light arc: blur, exact shifts and turns of a periodic image, and fall-off to the corners.

A shift by d multiplies the spectrum by exp(-2 pi i f d) and a Gaussian of deviation s by exp(-2 pi^2 s^2 f^2) (f in
periods per texel), so any fraction of a texel is as sharp as a whole one, and the mean is kept exactly. A turn is
sampled from the spline of degree five through the texels, whose error is below 0.1 % of any wave of four texels.
Cost: two real Fourier transforms of each channel, 0.1 s per megatexel on one thread; 0.6 s more for a turn.

The sensor of the virtual light arc: a dark signal, noise, and the files into which its signal is written.

A signal x (1 = white level) has noise of the variance noise^2 (0.99 x + 0.01): photons, and a floor of reading. The
dark signal is a pattern that is the same in every photograph whatever its exposure: columns of different offset, and
the glow of an amplifier at the right edge.
Cost: 60 ms per megatexel for the noise, 0.2 s for coding and compressing it.

Bayer DNG files, written by hand so that every sample and level in them is known (Adobe DNG 1.4; TIFF 6.0).

One uncompressed strip of 16-bit samples, little-endian, with black level per site, white level, colour matrix and
exposure. The camera's colours are those of linear sRGB, each divided by its white-balance gain, so that a converter
that applies `neutral` and the matrix gives back the linear sRGB image.
Not through tifffile, which writes no Exif directory, where the exposure stands.
Cost: one copy of the mosaic.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage

from engine.core.colour import SRGB_FROM_XYZ, srgb_encode
from engine.images.encode import rgb_channels, write_exr, write_tiff16
from engine.simulate.arc import LightArc
from engine.storage.atomic import write_bytes

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


def blur(image: NDArray[np.float32], deviation: float, right: float = 0.0, down: float = 0.0) -> NDArray[np.float32]:
    """(H, W, 3) periodic `image` blurred by a Gaussian and moved, all in texels, without negative radiance.

    The transform of an image with sharp edges undershoots by less than 1 % for deviations of one texel and more;
    what is below zero is set to zero.
    """
    rows, columns = image.shape[:2]
    f_row, f_column = fft.fftfreq(rows), fft.rfftfreq(columns)
    by_row = np.exp(-2 * (np.pi * deviation * f_row) ** 2 - 2j * np.pi * f_row * down)
    by_column = np.exp(-2 * (np.pi * deviation * f_column) ** 2 - 2j * np.pi * f_column * right)
    transfer = (by_row[:, None] * by_column).astype(np.complex64)
    moved = np.empty_like(image)
    for channel in range(image.shape[2]):
        spectrum = fft.rfft2(image[..., channel], workers=2)
        moved[..., channel] = fft.irfft2(spectrum * transfer, s=(rows, columns), workers=2)
    return np.maximum(moved, 0, out=moved)


def rotate(image: NDArray[np.float32], angle: float, right: float, down: float, step: int = 1) -> NDArray[np.float32]:
    """(H / step, W / step, 3) periodic `image` rotated about its middle, then moved, at every `step`-th place.

    `angle` is in radians, counter-clockwise as seen; shifts are in texels. A result stands for the middle of its
    `step` x `step` texels.
    """
    rows, columns = image.shape[:2]
    row, column = np.mgrid[0 : rows // step, 0 : columns // step] * step + 0.5 * step
    x, y = column - right - columns / 2, row - down - rows / 2
    source_column = math.cos(angle) * x - math.sin(angle) * y + columns / 2 - 0.5
    source_row = math.sin(angle) * x + math.cos(angle) * y + rows / 2 - 0.5
    planes = [
        ndimage.map_coordinates(image[..., channel], (source_row, source_column), np.float32, 5, "grid-wrap")
        for channel in range(image.shape[2])
    ]
    return np.maximum(np.stack(planes, axis=-1), 0)


def falloff(height: int, width: int, loss: float) -> NDArray[np.float32]:
    """(H, W) share of the light that reaches the sensor: cos^4 of the angle off the axis, 1 - `loss` in the corners.

    The angle's tangent grows in proportion to the distance from the middle, as for a lens without distortion, so with
    q = (1 - loss)^(-1/2) - 1 the share at the share s of the way to the corners is (1 + q s^2)^(-2).
    """
    if not 0.0 <= loss < 1.0:
        raise ValueError(f"a lens cannot lose {loss:g} of the light in the corners")
    x = (2 * np.arange(width) + 1 - width)[None, :]
    y = (2 * np.arange(height) + 1 - height)[:, None]
    squared = (x * x + y * y) / (width * width + height * height)
    return ((1 + ((1 - loss) ** -0.5 - 1) * squared) ** -2).astype(np.float32)


#: Levels of RAW files by the bits of their samples; every site of the pattern has a black level of its own.
LEVELS = {
    12: Levels(black=((254, 256), (257, 255)), white=4095),
    14: Levels(black=((510, 512), (515, 509)), white=16383),
}

_READING_SHARE = 0.01


def with_noise(signal: NDArray[np.float32], noise: float, key: tuple[int, ...]) -> NDArray[np.float32]:
    """`signal` (1 = white level) with sensor noise; negative values stay. `key` seeds the generator."""
    if noise == 0.0:
        return signal
    variance = (1 - _READING_SHARE) * np.maximum(signal, 0) + _READING_SHARE
    draw = np.random.default_rng(key).standard_normal(signal.shape, np.float32)
    return signal + np.float32(noise) * np.sqrt(variance) * draw


def dark_signal(size: int, mean: float, seed: int) -> NDArray[np.float32]:
    """(size, size) what the sensor reports without light, on average `mean`."""
    place = (np.arange(size) + 0.5) / size
    columns = np.random.default_rng((seed, 4)).uniform(-0.2, 0.2, size)
    shape = 0.7 + 1.5 * place**4 + columns - columns.mean()
    return np.broadcast_to((mean * shape / shape.mean()).astype(np.float32), (size, size))


def dim(arc: LightArc, radiance: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W, 3) what the lens leaves of `radiance`."""
    return radiance * falloff(arc.size, arc.size, arc.corner_loss)[..., None] if arc.corner_loss else radiance


def write_photograph(
    arc: LightArc,
    path: Path,
    light: NDArray[np.float32],
    exposure_s: float,
    key: tuple[int, ...],
    noise: float | None = None,
) -> None:
    """Write what the sensor makes of `light` (H, W, 3), linear sRGB in units of the white level.

    `key` seeds the noise, whose strength is that of the arc where `noise` is None.
    """
    strength = arc.noise if noise is None else noise
    dark = dark_signal(arc.size, arc.dark, arc.seed)
    if arc.format == "dng":
        levels = LEVELS[arc.raw_bits]
        signal = with_noise(mosaic(light, levels.neutral) + dark, strength, key)
        write_bytes(path, dng_bytes(quantise(signal, levels), levels, exposure_s=exposure_s))
        return
    signal = with_noise(light + dark[..., None], strength, key)
    if arc.format == "exr":
        write_exr(path, rgb_channels(signal))
        return
    coded = srgb_encode(np.clip(signal.astype(np.float64), 0, 1))
    write_tiff16(path, np.rint(coded * 65535).astype(np.uint16), transfer="srgb")
