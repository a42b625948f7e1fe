"""From sensor samples to linear radiance: black and white levels, saturation, white balance, exposure merge.

Radiance is float32 with 1 = white level. Black is subtracted in floating point and keeps its sign: noise around
black averages to 0 only if its negative half survives (test_R1). Reductions accumulate in float64 (test_R10).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.colour import LUMINANCE
from engine.core.errors import UsageError

_BLOCK_ROWS = 256


def linearise(samples: NDArray[np.integer], black: ArrayLike, white: ArrayLike) -> NDArray[np.float32]:
    """(samples − black) / (white − black) per site of the colour filter array, signed, float32.

    Parameters
    ----------
    samples : (H, W) integers as read out, or (H, W, C).
    black, white : scalars, or (P, Q) levels that repeat over the image, the first at the image's row 0, column 0.

    Raises UsageError, naming both levels, where white ≤ black or a level is not finite.
    """
    blacks, whites = np.broadcast_arrays(*np.atleast_2d(np.asarray(black, float), np.asarray(white, float)))
    scales = level_scale(blacks, whites)
    radiance = np.empty(samples.shape, np.float32)
    rows, columns = blacks.shape
    for row in range(rows):
        for column in range(columns):
            site = np.s_[row::rows, column::columns]
            radiance[site] = (samples[site].astype(np.float64) - blacks[row, column]) * scales[row, column]
    return radiance


def level_scale(black: NDArray[np.float64], white: NDArray[np.float64]) -> NDArray[np.float64]:
    """1 / (white - black), or UsageError, naming both levels, where white ≤ black or a level is not finite."""
    bad = ~(np.isfinite(black) & np.isfinite(white) & (white > black))
    if bad.any():
        raise UsageError(f"white level {white[bad][0]:g} is not above black level {black[bad][0]:g}")
    return 1 / (white - black)


def at_white(samples: NDArray[np.integer], white: ArrayLike) -> NDArray[np.bool_]:
    """True where a sample reaches the white level of its site; shapes as in `linearise`."""
    whites = np.atleast_2d(np.asarray(white, float))
    mask = np.empty(samples.shape, bool)
    rows, columns = whites.shape
    for row in range(rows):
        for column in range(columns):
            site = np.s_[row::rows, column::columns]
            mask[site] = samples[site] >= whites[row, column]
    return mask


def white_balance(multipliers: Sequence[float]) -> NDArray[np.float64] | None:
    """Multipliers (3,) with green = 1, or None where one is zero, negative, not finite or absurd (over 100 : 1)."""
    values = np.asarray(multipliers, float)[:3]
    if values.shape != (3,) or not np.isfinite(values).all() or (values <= 0).any():
        return None
    balanced: NDArray[np.float64] = values / values[1]
    return balanced if balanced.max() <= 100 and balanced.min() >= 0.01 else None


def balance_matrix(camera: NDArray[np.float64], multipliers: NDArray[np.float64]) -> NDArray[np.float32]:
    """The matrix (3, 3) that balances colours of the camera by `multipliers` (3,) and takes them to linear sRGB."""
    return np.asarray((camera * multipliers).astype(np.float32))


def mean_radiance(image: NDArray[np.float32]) -> float:
    """Mean luminance of a linear image (H, W, 3), accumulated in float64, a block of rows at a time."""
    total = np.zeros(3)
    for start in range(0, image.shape[0], _BLOCK_ROWS):
        total += image[start : start + _BLOCK_ROWS].sum(axis=(0, 1), dtype=np.float64)
    return float(total @ LUMINANCE / (image.shape[0] * image.shape[1]))


@dataclass(frozen=True, eq=False)
class Merged:
    """Several exposures as one: radiance per second of exposure (H, W, 3), and where no exposure could tell.

    `saturated` (H, W): at white in every exposure; its radiance is the largest that was measured, a lower bound.
    `black` (H, W): not above black in any channel of any exposure; its radiance is 0.
    """

    radiance: NDArray[np.float32]
    saturated: NDArray[np.bool_]
    black: NDArray[np.bool_]


class ExposureMerge:
    """Merges exposures one after the other; only sums are kept.

    Weighted mean of sample / exposure over unsaturated samples; the weight is the exposure time, which is optimal for
    photon noise, so the mean is the sum of samples over the sum of times.
    """

    def __init__(self) -> None:
        self._total = self._brightest = np.empty((0, 0, 3), np.float32)
        self._time = np.empty((0, 0), np.float32)

    def add(self, radiance: NDArray[np.float32], saturated: NDArray[np.bool_], exposure_s: float) -> None:
        """Add radiance (H, W, 3) and mask (H, W) of one exposure.

        Raises ValueError for another size than before, or for a time that is not positive and finite.
        """
        if not (math.isfinite(exposure_s) and exposure_s > 0):
            raise ValueError(f"exposure time {exposure_s} s is not positive")
        if not self._time.size:
            self._total, self._brightest = np.zeros_like(radiance), np.zeros_like(radiance)
            self._time = np.zeros(saturated.shape, np.float32)
        if radiance.shape != self._total.shape or saturated.shape != self._time.shape:
            raise ValueError(f"exposures differ in size: {radiance.shape} and {self._total.shape}")
        for band in _bands(saturated.shape[0]):
            self._total[band] += np.where(saturated[band][..., None], 0, radiance[band])
            self._time[band] += np.where(saturated[band], 0, np.float32(exposure_s))
            per_second = radiance[band] / np.float32(exposure_s)
            np.maximum(self._brightest[band], per_second, out=self._brightest[band])

    def merge(self) -> Merged:
        """All that was added as one; nothing can be added afterwards. Raises ValueError for no exposures."""
        if not self._time.size:
            raise ValueError("no exposures to merge")
        unseen = self._time == 0
        black = np.zeros_like(unseen)
        for band in _bands(unseen.shape[0]):
            hidden = unseen[band][..., None]
            mean = self._total[band] / np.where(hidden, 1, self._time[band][..., None])
            black[band] = ~unseen[band] & (self._brightest[band] <= 0).all(axis=-1)
            self._total[band] = np.where(hidden, self._brightest[band], mean)
            self._total[band][black[band]] = 0
        return Merged(self._total, unseen, black)


def merge_exposures(
    exposures: Iterable[tuple[NDArray[np.float32], NDArray[np.bool_], float]],
) -> Merged:
    """`ExposureMerge` of all (radiance (H, W, 3), saturated (H, W), exposure_s), one in memory at a time."""
    merge = ExposureMerge()
    for radiance, saturated, exposure_s in exposures:
        merge.add(radiance, saturated, exposure_s)
    return merge.merge()


def _bands(height: int) -> list[slice]:
    return [np.s_[first : first + _BLOCK_ROWS] for first in range(0, height, _BLOCK_ROWS)]
