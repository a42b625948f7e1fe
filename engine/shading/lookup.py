"""Addressing shared by both kinds of shading map: where r lies in [0, r_max], and which texels a coordinate touches.

Coordinates are in texels with centres at half-integers, row 0 on top, and repeat beyond the image, as a texture with
linear filtering and repeat wrapping does. Pure numpy; time and memory grow with the number of look-ups.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Value for r above r_max: the brightest slice as it is, or multiplied by r / r_max.
Above = Literal["clamp", "scale"]

Indices = NDArray[np.int64]
Numbers = NDArray[np.float64]


def share_and_gain(r: ArrayLike, r_max: float, above: Above) -> tuple[Numbers, Numbers]:
    """Split r into its share of r_max, in [0, 1], and the gain >= 1 of what is looked up there.

    Both are continuous in r. What is not a positive finite number (NaN, infinity, negative r) has share 0, black.
    """
    if above not in ("clamp", "scale"):
        raise ValueError(f"above is 'clamp' or 'scale', not {above!r}")
    ratio = np.asarray(r, dtype=np.float64) / r_max
    ratio = np.where(np.isfinite(ratio) & (ratio > 0), ratio, 0.0)
    gain = np.maximum(ratio, 1.0) if above == "scale" else np.ones_like(ratio)
    return np.minimum(ratio, 1.0), gain


def layer_at(share: ArrayLike, slices: int) -> tuple[Indices, Numbers]:
    """The slice at or below a share of r_max in [0, 1], and how far it is to the next one, in [0, 1]."""
    layer = np.asarray(share, dtype=np.float64) * (slices - 1)
    lower = np.minimum(np.floor(layer).astype(np.int64), slices - 2)
    return lower, layer - lower


def neighbours(
    row: ArrayLike, column: ArrayLike, height: int, width: int
) -> Iterator[tuple[Indices, Indices, Numbers]]:
    """The four texels around each coordinate as (rows, columns, weights); the weights sum to 1."""
    rows = _along(row, height)
    columns = _along(column, width)
    for row_index, row_weight in rows:
        for column_index, column_weight in columns:
            yield row_index, column_index, row_weight * column_weight


def _along(coordinate: ArrayLike, size: int) -> tuple[tuple[Indices, Numbers], tuple[Indices, Numbers]]:
    coordinate = np.asarray(coordinate, dtype=np.float64)
    if not np.isfinite(coordinate).all():
        raise ValueError("texel coordinates must be finite")
    position = np.mod(coordinate - 0.5, size)
    first = np.floor(position)
    fraction = position - first
    index = first.astype(np.int64)
    return (index % size, 1.0 - fraction), ((index + 1) % size, fraction)
