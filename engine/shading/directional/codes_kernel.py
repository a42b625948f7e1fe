"""Kernel that writes radiance as codes of 8-bit sRGB, photograph by photograph.

Bound by memory: every value is read once and written once, with two reads of a table that stays in the cache.
"""

from __future__ import annotations

import numpy as np

from engine.core.kernels import parallel, prange


@parallel
def write_codes(radiance, table, brightest, codes):  # type: ignore[no-untyped-def]
    """Fill `codes` (3 N, texels) float32 from `radiance` (N, rows, W, 3) float32.

    `table` (E,) float32 holds codes at equal steps of the square root of radiance, from 0 to that of `brightest`, as
    which brighter values count. What is not a number counts as 0.
    """
    count, rows, width = radiance.shape[:3]
    scale = np.float32((len(table) - 1) / np.sqrt(brightest))
    for line in prange(count * rows):
        photograph, row = line // rows, line % rows
        for column in range(width):
            for channel in range(3):
                value = radiance[photograph, row, column, channel]
                value = min(value, brightest) if value > 0.0 else np.float32(0.0)
                place = np.sqrt(value) * scale
                at = min(int(place), len(table) - 2)
                below = table[at]
                codes[3 * photograph + channel, row * width + column] = below + (place - at) * (table[at + 1] - below)
