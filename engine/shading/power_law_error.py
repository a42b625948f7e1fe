"""Error of a compressed shading map against its slices: figures, a map of errors, and the worst texels.

The error of a texel is the root mean square over slices and channels of slice minus reconstruction, in units of
radiance. Cost: one power per texel, channel and slice, about 20 ns each.
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.core.steps import Step, Steps
from engine.shading.power_law import TILE_TEXELS, PowerLawMap, power
from engine.shading.shading_map import ShadingMap
from engine.storage.scratch import release


class Texel(NamedTuple):
    """A texel and its error, in units of radiance."""

    row: int
    column: int
    error: float


def worst_texels(power_law: PowerLawMap, count: int = 10) -> tuple[Texel, ...]:
    """The `count` texels with the largest errors, worst first; of equal ones the upper left first."""
    errors = power_law.error_map.ravel()
    count = min(count, errors.size)
    if count < 1:
        return ()
    limit = np.partition(errors, errors.size - count)[errors.size - count]
    candidates = np.flatnonzero(errors >= limit)
    worst = candidates[np.argsort(-errors[candidates], kind="stable")[:count]]
    rows, columns = np.unravel_index(worst, power_law.error_map.shape)
    return tuple(Texel(int(r), int(c), float(power_law.error_map[r, c])) for r, c in zip(rows, columns, strict=True))


def measure(power_law: PowerLawMap, shading_map: ShadingMap) -> Steps[PowerLawMap]:
    """`power_law` with the errors that it has against the slices it was made from; kept tiles have none."""
    count, height, width, _ = shading_map.slices.shape
    shares = np.linspace(0.0, 1.0, count)
    error_map = np.empty((height, width), np.float32)
    total = np.zeros(3)
    kept = power_law.kept.covers(height, width) if power_law.kept is not None else np.zeros((height, width), np.bool_)
    for rows in bands(height, width):
        squares = _squares(power_law, shading_map.slices[:, rows], shares, rows)
        squares[kept[rows]] = 0.0
        error_map[rows] = np.sqrt(squares.mean(axis=2) / count)
        total += squares.sum(axis=(0, 1))
        release(shading_map.slices)
        yield Step(rows.stop / height, "measuring the error")
    mean_squares = total / (height * width * count)
    rms = math.sqrt(mean_squares.mean())
    return dataclasses.replace(power_law, rms=rms, rms_per_channel=np.sqrt(mean_squares), error_map=error_map)


def bands(height: int, width: int) -> list[slice]:
    """Rows of an image in bands of about 50 ms of work."""
    rows = max(1, TILE_TEXELS // width)
    return [slice(start, min(start + rows, height)) for start in range(0, height, rows)]


def _squares(
    power_law: PowerLawMap, slices: NDArray[np.float32], shares: NDArray[np.float64], rows: slice
) -> NDArray[np.float64]:
    """(rows, W, 3) sum over slices of squared differences."""
    squares = np.zeros(slices.shape[1:])
    for image, share in zip(slices, shares, strict=True):
        squares += (power(power_law.scale[rows], power_law.exponent[rows], share) - image) ** 2
    return squares
