"""Kernel of the linearisation: each slice is a weighted sum of photographs, row by row.

Bounded by memory bandwidth: each photograph is read about twice and each slice written once. Every texel and every
row sum is computed by itself, so the result does not depend on tile size or thread count.
"""

from __future__ import annotations

import numpy as np

from engine.core.kernels import parallel, prange


@parallel
def linearise_rows(
    radiance: np.ndarray,
    saturated: np.ndarray,
    photographs: np.ndarray,
    weights: np.ndarray,
    luminance: np.ndarray,
    start: int,
    slices: np.ndarray,
    clipped: np.ndarray,
    sums: np.ndarray,
) -> None:
    """Fill the rows of all slices from `start` on.

    Parameters
    ----------
    radiance : (N, rows, W, 3) float32; saturated : (N, rows, W) bool; of the rows that are filled.
    photographs, weights : (S, M), the photographs that each slice sums and their weights; unused places weigh 0.
    luminance : (3,) weights of the channels.
    slices : (S, H, W, 3) float32, written. clipped : (S, H, W) bool, zero at first, written.
    sums : (S, H) float64, written: the sum of luminance over each row, of the rounded values.
    """
    width = radiance.shape[2]
    flat_in = radiance.reshape(radiance.shape[0], radiance.shape[1], 3 * width)
    flat_out = slices.reshape(slices.shape[0], slices.shape[1], 3 * width)
    for given in prange(radiance.shape[1]):
        row = start + given
        line = np.empty(3 * width, np.float64)
        for index in range(slices.shape[0]):
            line[:] = weights[index, 0] * flat_in[photographs[index, 0], given]
            for place in range(1, photographs.shape[1]):
                if weights[index, place] > 0.0:
                    line += weights[index, place] * flat_in[photographs[index, place], given]
            flat_out[index, row] = line
            for place in range(photographs.shape[1]):
                if weights[index, place] > 0.0:
                    clipped[index, row] |= saturated[photographs[index, place], given]
            red, green, blue = 0.0, 0.0, 0.0
            for column in range(width):
                red += slices[index, row, column, 0]
                green += slices[index, row, column, 1]
                blue += slices[index, row, column, 2]
            sums[index, row] = luminance[0] * red + luminance[1] * green + luminance[2] * blue
