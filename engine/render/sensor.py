"""The sensor of the virtual light arc: a dark signal, noise, and the files into which its signal is written.

A signal x (1 = white level) has noise of the variance noise^2 (0.99 x + 0.01): photons, and a floor of reading. The
dark signal is a pattern that is the same in every photograph whatever its exposure: columns of different offset, and
the glow of an amplifier at the right edge.
Cost: 60 ms per megatexel for the noise, 0.2 s for coding and compressing it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.colour import srgb_encode
from engine.files.atomic import write_bytes
from engine.images.encode import rgb_channels, write_exr, write_tiff16
from engine.render import dng
from engine.render.arc import LightArc
from engine.render.lens import falloff

#: Levels of RAW files by the bits of their samples; every site of the pattern has a black level of its own.
LEVELS = {
    12: dng.Levels(black=((254, 256), (257, 255)), white=4095),
    14: dng.Levels(black=((510, 512), (515, 509)), white=16383),
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


def dimmed(arc: LightArc, radiance: NDArray[np.float32]) -> NDArray[np.float32]:
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
        signal = with_noise(dng.mosaic(light, levels.neutral) + dark, strength, key)
        write_bytes(path, dng.dng_bytes(dng.quantised(signal, levels), levels, exposure_s=exposure_s))
        return
    signal = with_noise(light + dark[..., None], strength, key)
    if arc.format == "exr":
        write_exr(path, rgb_channels(signal))
        return
    coded = srgb_encode(np.clip(signal.astype(np.float64), 0, 1))
    write_tiff16(path, np.rint(coded * 65535).astype(np.uint16), transfer="srgb")
