"""Kernel that halves the planes of a directional map through the radiance that they stand for.

Bound by arithmetic: for each texel and value of a light K multiplications and a look-up, for each texel that is made a
power and K more; 0.8 µs of one core a texel for 16 lights and 15 planes.
"""

from __future__ import annotations

import numpy as np

from engine.core.kernels import parallel, prange, scalar


@parallel
def halve(
    planes: np.ndarray,
    functions: np.ndarray,
    inverse: np.ndarray,
    table: np.ndarray,
    steps: np.float32,
    result: np.ndarray,
) -> None:
    """Fill `result` (K, h, w) float32 from `planes` (K, H, W) uint8 or float32; all else is float32.

    A value of a light is functions (M, 1 + K) of 1 and the planes, as a code, and `inverse` (C, M) gives the first C
    planes back, which are corrected by what the code of the mean differs from the mean of codes.
    `table` holds radiance at `steps` to a code. A texel is the mean of those below it, with the shares of their areas'
    middles where a side is odd.
    """
    count, height, width = planes.shape
    rows, columns = result.shape[1:]
    values = len(functions)
    for row in prange(rows):
        top, below = _between(row, height, rows)
        mean, texel, plain = np.empty(values, np.float32), np.empty(count, np.float32), np.empty(count, np.float32)
        for column in range(columns):
            left, right = _between(column, width, columns)
            mean[:], plain[:] = 0.0, 0.0
            for corner in range(4):
                down, along = corner // 2, corner % 2
                share = (below if down else np.float32(1.0) - below) * (right if along else np.float32(1.0) - right)
                if share == 0.0:
                    continue
                for k in range(count):
                    texel[k] = planes[k, top + down, left + along]
                    plain[k] += share * texel[k]
                for m in range(values):
                    code = functions[m, 0]
                    for k in range(count):
                        code += functions[m, 1 + k] * texel[k]
                    mean[m] += share * _radiance(code, table, steps)
            for m in range(values):
                code = functions[m, 0]
                for k in range(count):
                    code += functions[m, 1 + k] * plain[k]
                mean[m] = _code(mean[m]) - code
            for k in range(count):
                made = plain[k]
                if k < len(inverse):
                    for m in range(values):
                        made += inverse[k, m] * mean[m]
                result[k, row, column] = made


@scalar
def _between(place: int, size: int, smaller: int) -> tuple[int, np.float32]:
    """The first of two texels of `size` that lie around a texel of `smaller`, and the share of the second."""
    at = (place + 0.5) * size / smaller - 0.5
    first = min(int(at), max(size - 2, 0))
    return first, np.float32(at - first)


@scalar
def _radiance(code: np.float32, table: np.ndarray, steps: np.float32) -> np.float32:
    place = min(max(code, np.float32(0.0)) * steps, np.float32(len(table) - 1))
    at = min(int(place), len(table) - 2)
    return table[at] + (place - np.float32(at)) * (table[at + 1] - table[at])


@scalar
def _code(radiance: np.float32) -> np.float32:
    if radiance <= np.float32(0.0031308):
        return np.float32(255.0 * 12.92) * radiance
    return np.float32(255.0) * (np.float32(1.055) * radiance ** np.float32(1.0 / 2.4) - np.float32(0.055))
