"""Correction for lamp, lens and sensor: the dark frame, the flat field and the near lamp, divided out.

    radiance = (sample - dark) * gain,    gain = mean(flat - dark) / (flat - dark)

The mean of the flat field is kept, so that calibrated and plain photographs of a capture have the same scale. A lamp
at distance d from the middle of the sample, at elevation e, lights the point p of the sample with an irradiance
proportional to cos(theta) / |v|^2 = d sin(e) / |v|^3, v = lamp - p; a distant one with sin(e) / d^2. Their quotient
(|v| / d)^3 is the gain. It is exact for the irradiance of the plane; that the direction of the light changes over the
sample is not undone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.core.kernels import scalar

#: Parts of a flat field darker than this fraction of its mean tell more of noise than of light.
DARKEST_FLAT = 0.05

_BAND_ROWS = 256


def flat_field_gain(
    flat: NDArray[np.float32], dark: NDArray[np.float32] | None = None
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Gain (H, W, 3) that makes a photograph of an even white surface even, and where it cannot be known (H, W).

    `flat` and `dark` are linear and of one size. Unknown are texels where a channel of the flat field is below
    `DARKEST_FLAT` of its mean; their gain is 1. Raises UsageError for different sizes or a flat field without light.
    """
    if dark is not None and dark.shape != flat.shape:
        raise UsageError(f"the dark frame is {dark.shape[1]} x {dark.shape[0]} pixels, the flat field "
                         f"{flat.shape[1]} x {flat.shape[0]}")  # fmt: skip
    bands = [np.s_[first : first + _BAND_ROWS] for first in range(0, flat.shape[0], _BAND_ROWS)]
    mean = sum(_light(flat, dark, band).sum(axis=(0, 1)) for band in bands) / (flat.shape[0] * flat.shape[1])
    if not (mean > 0).all():
        raise UsageError("the flat field is not brighter than the dark frame")
    gain, unknown = np.ones_like(flat), np.zeros(flat.shape[:2], bool)
    for band in bands:
        light = _light(flat, dark, band)
        unknown[band] = (light < DARKEST_FLAT * mean).any(axis=-1)
        np.divide(mean, light, out=gain[band], where=~unknown[band][..., None], casting="same_kind")
    return gain, unknown


def _light(flat: NDArray[np.float32], dark: NDArray[np.float32] | None, band: slice) -> NDArray[np.float64]:
    light: NDArray[np.float64] = flat[band].astype(np.float64)
    return light if dark is None else light - dark[band]


def near_lamp_gain(
    height: int,
    width: int,
    distance: float,
    elevation: float,
    azimuth: float = 0.0,
    rows: tuple[int, int] | None = None,
) -> NDArray[np.float32]:
    """(H, W) gain that makes the light of a near lamp as even as that of a distant one; 1 in the middle.

    Parameters
    ----------
    distance : from the middle of the image to the lamp, in widths of the image, > 0.5.
    elevation, azimuth : of the lamp seen from the middle, radians; azimuth 0 = right, pi/2 = up in the image.
    rows : the first row and the one after the last of a band, None for all.
    """
    across, along = lamp_distances(height, width, distance, elevation, azimuth, rows)
    gain = np.empty((len(along), width), np.float32)
    _cube_distances(across, along, gain)
    return gain


def lamp_distances(
    height: int,
    width: int,
    distance: float,
    elevation: float,
    azimuth: float = 0.0,
    rows: tuple[int, int] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Parts of the squared distance of the lamp in units of that from the middle, (W,) and (H,), whose sums to the
    power of 3/2 are `near_lamp_gain`."""
    if not distance > 0.5:
        raise ValueError(f"a lamp at {distance:g} widths of the image would touch the sample")
    level = np.cos(elevation)
    lamp = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
    x = (np.arange(width) + 0.5) / width - 0.5
    y = 0.5 * height / width - (np.arange(*(rows or (0, height))) + 0.5) / width
    x, y = x / distance, y / distance
    return (lamp[0] - x) ** 2, (lamp[1] - y) ** 2 + lamp[2] ** 2


@scalar
def _cube_distances(across: np.ndarray, along: np.ndarray, cubes: np.ndarray) -> None:
    """Fill `cubes` (H, W) with the cubes of lengths whose squares are sums of `across` (W,) and `along` (H,)."""
    for row in range(len(along)):
        for column in range(len(across)):
            squared = across[column] + along[row]
            cubes[row, column] = squared * np.sqrt(squared)
