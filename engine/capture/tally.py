"""Counts and sums over a photograph, taken in one pass over its bands while it is written.

Cost: bound by memory: one read of the pixels, 24 megapixels in 0.03 s. One thread takes it, because the threads of many
short parallel loops wait actively after each (libgomp), on cores that decoders need.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.capture.report import BLACK
from engine.core.colour import LUMINANCE
from engine.core.kernels import scalar

#: Weights of the channels in luminance, in single precision.
LUMINANCE32 = np.asarray(LUMINANCE, np.float32)


@dataclass(eq=False)
class Tally:
    """Sums by rows, so that bands of any height agree; `grid` holds every `step`-th pixel of rows and columns."""

    step: int
    rows: list[NDArray[np.float64]] = field(default_factory=list)
    clipped: int = 0
    black: int = 0
    grid: list[NDArray[np.float32]] = field(default_factory=list)

    def add(self, band: NDArray[np.float32], mask: NDArray[np.bool_], first: int) -> None:
        """Count the band (rows, W, 3) and its saturation mask that begin at row `first` of the image."""
        sums = np.empty((band.shape[0], 3))
        counts = np.empty((band.shape[0], 2), np.int64)
        _sum(band, mask, LUMINANCE32, np.float32(BLACK), sums, counts)
        self.join(sums, counts, band[-first % self.step :: self.step, :: self.step].copy())

    def join(self, sums: NDArray[np.float64], counts: NDArray[np.int64], grid: NDArray[np.float32]) -> None:
        """Add sums (rows, 3), numbers (any, 2) of clipped and of black pixels, and the grid of the next rows."""
        self.rows.append(sums)
        clipped, black = counts.sum(axis=0)
        self.clipped += int(clipped)
        self.black += int(black)
        self.grid.append(grid)

    def mean_radiance(self, pixels: int) -> float:
        """Mean luminance over all `pixels`."""
        total = [math.fsum(channel) for channel in np.concatenate(self.rows).T]
        return float(np.dot(total, LUMINANCE)) / pixels


@scalar
def _sum(
    band: np.ndarray, mask: np.ndarray, weights: np.ndarray, black: np.float32, sums: np.ndarray, counts: np.ndarray
) -> None:
    """Bound by the read of the band."""
    for row in range(band.shape[0]):
        red, green, blue = 0.0, 0.0, 0.0
        clipped, dark = 0, 0
        for column in range(band.shape[1]):
            r, g, b = band[row, column, 0], band[row, column, 1], band[row, column, 2]
            red += r
            green += g
            blue += b
            clipped += mask[row, column]
            dark += r * weights[0] + g * weights[1] + b * weights[2] < black
        sums[row, 0], sums[row, 1], sums[row, 2] = red, green, blue
        counts[row, 0], counts[row, 1] = clipped, dark
