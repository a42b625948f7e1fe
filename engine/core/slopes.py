"""The height whose slopes are given, by cosine transforms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft

Array = NDArray[np.float64]


def integrate_slopes(right: Array, up: Array) -> Array:
    """Height (H, W) in texels, of mean 0, by least squares of its differences (Frankot1988).

    `right` and `up` (H, W) are dh/dx to the right and dh/dy upwards, finite; row 0 is on top. The slope between two
    texels is the mean of theirs, and none leads across the border.
    """
    across, down = 0.5 * (right[:, 1:] + right[:, :-1]), -0.5 * (up[1:] + up[:-1])
    flow = np.zeros_like(right)
    flow[:, 1:] += across
    flow[:, :-1] -= across
    flow[1:] += down
    flow[:-1] -= down
    rows, columns = flow.shape
    values = (2.0 - 2.0 * np.cos(np.pi * np.arange(rows) / rows))[:, None] + (
        2.0 - 2.0 * np.cos(np.pi * np.arange(columns) / columns)
    )
    values[0, 0] = np.inf
    return np.asarray(fft.idctn(fft.dctn(flow, norm="ortho") / values, norm="ortho"))
