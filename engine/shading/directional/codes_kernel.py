"""Kernels that write photographs as codes of 8-bit sRGB: radiance, and codes of files by one table for each channel.

Roots, table and channels of radiance are loops of their own, which the compiler turns into vector instructions: 1 ns
for each value on one core, and .4 of a table alone. Blocks that stay in the cache are written on several threads side
by side.
"""

from __future__ import annotations

import numpy as np

from engine.core.kernels import scalar


@scalar
def write_codes(
    radiance: np.ndarray, first: int, table: np.ndarray, brightest: np.float32, pivot: np.ndarray, codes: np.ndarray
) -> None:
    """Fill `codes` (3 N, texels) float32 from texels of `radiance` (N, many, 3) float32, less `pivot` (3 N,) float32.

    `first` is the first of these texels.

    `table` (E,) float32 holds codes at equal steps of the square root of radiance, from 0 to that of `brightest`, as
    which brighter values count. What is not a number counts as 0.
    """
    count, texels, begin = len(radiance), codes.shape[1], 3 * first
    scale, dark, one = np.float32((len(table) - 1) / np.sqrt(brightest)), np.float32(0.0), np.uint32(1)
    last = np.uint32(len(table) - 2)  # unsigned, as a place from the end would have to be told apart
    row = np.empty(3 * texels, np.float32)
    for photograph in range(count):
        values = radiance[photograph].reshape(3 * radiance.shape[1])
        for at in range(3 * texels):
            value = values[begin + at]
            row[at] = np.sqrt(min(value, brightest) if value > dark else dark) * scale
        for at in range(3 * texels):
            place = row[at]
            entry = min(np.uint32(place), last)
            below = table[entry]
            row[at] = below + (place - np.float32(entry)) * (table[entry + one] - below)
        for channel in range(3):
            line = 3 * photograph + channel
            for texel in range(texels):
                codes[line, texel] = row[3 * texel + channel] - pivot[line]


@scalar
def look_up_codes(pixels: np.ndarray, first: int, last: int, tables: np.ndarray, codes: np.ndarray) -> None:
    """Fill `codes` (3 N, texels) float32 from rows of `pixels` (N, H, W, 1 or 3) uint8, from `first` to before `last`.

    `tables` (3 N, 256) float32 have the codes of each photograph and channel. Bound by the lookups.
    """
    width, second, third = pixels.shape[2], min(1, pixels.shape[3] - 1), pixels.shape[3] - 1
    for photograph in range(pixels.shape[0]):
        of_red, of_green, of_blue = tables[3 * photograph], tables[3 * photograph + 1], tables[3 * photograph + 2]
        for row in range(first, last):
            start = (row - first) * width
            red = codes[3 * photograph, start : start + width]
            green = codes[3 * photograph + 1, start : start + width]
            blue = codes[3 * photograph + 2, start : start + width]
            line = pixels[photograph, row]
            for column in range(width):
                red[column] = of_red[line[column, 0]]
                green[column] = of_green[line[column, second]]
                blue[column] = of_blue[line[column, third]]
