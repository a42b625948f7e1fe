"""Kernel that rounds the values of planes to eight bits.

Bound by memory: 1 ns for each value on one core. Pieces are rounded on several threads side by side.
"""

from __future__ import annotations

import numpy as np

from engine.core.kernels import scalar

#: Sums that are taken side by side, as one alone would wait for each addition.
_LANES = 8


@scalar
def round_values(
    values: np.ndarray,
    first: int,
    low: np.ndarray,
    step: np.ndarray,
    inside: np.ndarray,
    planes: np.ndarray,
    squares: np.ndarray,
) -> None:
    """Write `values` (K, texels) float32 into the rows from `first` on of `planes` (K, H, W) uint8, as the nearest code
    of low + step · code, from 0 to 255; `low` and `step` (K,) are float32.

    `squares` (K,) float64 is filled with the sums over texels `inside` (H, W) of the squares of what that changes, in
    steps.
    """
    count, width = values.shape[0], planes.shape[2]
    dark, bright, lanes = np.float32(0.0), np.float32(255.0), np.empty(_LANES)
    apart = np.empty(width, np.float32)
    for plane in range(count):
        lanes[:] = 0.0
        for row in range(values.shape[1] // width):
            line, into = values[plane, row * width : (row + 1) * width], planes[plane, first + row]
            counts = inside[first + row]
            for at in range(width):
                value = (line[at] - low[plane]) / step[plane]
                code = min(max(np.rint(value), dark), bright)
                into[at] = np.uint8(code)
                apart[at] = code - value if counts[at] else dark
            whole = width - width % _LANES
            for at in range(0, whole, _LANES):
                for lane in range(_LANES):
                    lanes[lane] += np.float64(apart[at + lane]) ** 2
            for at in range(whole, width):
                lanes[0] += np.float64(apart[at]) ** 2
        squares[plane] = lanes.sum()
