"""Rows of a least-squares matrix B whose entries are bilinear weights of texels, and sums over them.

Sparse: a row has four entries for each look-up of its sample. No sum depends on the number of threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Rows(NamedTuple):
    """Rows of B for one texture: `texel` (N, E) int32, indices into the flat texture, `weight` (N, E), and its size."""

    texel: NDArray[np.int32]
    weight: Floats
    size: int


def rows_of(look_ups: Sequence[Floats], size: int) -> Rows:
    """Bilinear weights at coordinates (N, 2) in [−1, 1] of a texture whose outermost texels lie at ±1.

    Each look-up's four weights sum to 1; what lies outside counts as on the edge. ValueError for a size below 2.
    """
    if size < 2:
        raise ValueError(f"a texture needs at least 2 texels a side, not {size}")
    count, entries = len(look_ups[0]), 4 * len(look_ups)
    rows = Rows(np.empty((count, entries), np.int32), np.empty((count, entries)), size)
    for number, coordinates in enumerate(look_ups):
        _weights(np.ascontiguousarray(coordinates, np.float64), size, rows.texel, rows.weight, 4 * number)
    return rows


def count_touched(rows: Rows) -> int:
    """Number of texels that samples touch: the unknowns of a term."""
    return int(find_reached_texels(rows).sum())


def find_reached_texels(rows: Rows) -> Mask:
    reached = np.zeros(rows.size**2, np.bool_)
    _mark(rows.texel, rows.weight, reached)
    return reached


def predict(rows: Rows, texture: Floats) -> Floats:
    """B y (N, 3) of one texture (n, n, 3)."""
    out = np.empty((len(rows.texel), 3))
    _apply(rows.texel, rows.weight, np.ascontiguousarray(texture.reshape(-1, 3)), out)
    return out


@scalar
def _weights(coordinates: np.ndarray, size: int, index: np.ndarray, weight: np.ndarray, first: int) -> None:
    for i in range(len(coordinates)):
        u = min(max(0.5 * (coordinates[i, 0] + 1.0) * (size - 1), 0.0), size - 1.0)
        v = min(max(0.5 * (coordinates[i, 1] + 1.0) * (size - 1), 0.0), size - 1.0)
        column, row = min(int(u), size - 2), min(int(v), size - 2)
        a, b = u - column, v - row
        corner = row * size + column
        index[i, first], weight[i, first] = corner, (1.0 - a) * (1.0 - b)
        index[i, first + 1], weight[i, first + 1] = corner + 1, a * (1.0 - b)
        index[i, first + 2], weight[i, first + 2] = corner + size, (1.0 - a) * b
        index[i, first + 3], weight[i, first + 3] = corner + size + 1, a * b


@scalar
def _mark(index: np.ndarray, weight: np.ndarray, reached: np.ndarray) -> None:
    for i in range(len(index)):
        for e in range(index.shape[1]):
            if weight[i, e] > 0.0:
                reached[index[i, e]] = True


@scalar
def second_differences(size: int, reached: np.ndarray, strength: float) -> tuple[np.ndarray, np.ndarray]:
    index = np.zeros((3 * size * size, 4), np.int32)
    weight = np.zeros((3 * size * size, 4))
    count = 0
    steps = np.array([[0, 1, 2, 2], [0, size, 2 * size, 2 * size], [0, 1, size, size + 1]])
    factors = np.array([[1.0, -2.0, 1.0, 0.0], [1.0, -2.0, 1.0, 0.0], [1.0, -1.0, -1.0, 1.0]])
    factors[2] *= np.sqrt(2.0)
    across, down = np.array([2, 0, 1]), np.array([0, 2, 1])
    for row in range(size):
        for column in range(size):
            texel = row * size + column
            for kind in range(3):
                if column + across[kind] >= size or row + down[kind] >= size:
                    continue
                touched = True
                for e in range(4):
                    touched = touched and reached[texel + steps[kind, e]]
                if touched:
                    for e in range(4):
                        index[count, e] = texel + steps[kind, e]
                        weight[count, e] = strength * factors[kind, e]
                    count += 1
    return index[:count], weight[:count]


@scalar
def add_products(
    texel_a: np.ndarray, weight_a: np.ndarray, texel_b: np.ndarray, weight_b: np.ndarray, block: np.ndarray
) -> None:
    for i in range(len(texel_a)):
        for a in range(texel_a.shape[1]):
            factor = weight_a[i, a]
            row = block[texel_a[i, a]]
            for b in range(texel_b.shape[1]):
                row[texel_b[i, b]] += factor * weight_b[i, b]


@scalar
def _add_own(texel: np.ndarray, weight: np.ndarray, block: np.ndarray) -> None:
    """Add half of BᵀB: of each pair of entries one order, of each entry with itself half."""
    for i in range(len(texel)):
        for a in range(texel.shape[1]):
            factor = weight[i, a]
            row = block[texel[i, a]]
            for b in range(a):
                row[texel[i, b]] += factor * weight[i, b]
            row[texel[i, a]] += 0.5 * factor * factor


def own_products(rows: Rows) -> Floats:
    """BᵀB (T, T) of one texture."""
    half = np.zeros((rows.size**2, rows.size**2))
    _add_own(rows.texel, rows.weight, half)
    return half + half.T


def products(a: Rows, b: Rows) -> Floats:
    """Aᵀ B (Ta, Tb) of the rows of two textures for the same samples."""
    block = np.zeros((a.size**2, b.size**2))
    add_products(a.texel, a.weight, b.texel, b.weight, block)
    return block


@scalar
def _add_moments(texel: np.ndarray, weight: np.ndarray, values: np.ndarray, sums: np.ndarray) -> None:
    for i in range(len(texel)):
        red, green, blue = values[i, 0], values[i, 1], values[i, 2]
        for e in range(texel.shape[1]):
            row, factor = sums[texel[i, e]], weight[i, e]
            row[0] += factor * red
            row[1] += factor * green
            row[2] += factor * blue


def moments(rows: Rows, values: Floats) -> Floats:
    """Bᵀ v (T, 3) for v (N, 3)."""
    sums = np.zeros((rows.size**2, 3))
    _add_moments(rows.texel, rows.weight, values, sums)
    return sums


@scalar
def _apply(texel: np.ndarray, weight: np.ndarray, texture: np.ndarray, out: np.ndarray) -> None:
    for i in range(len(texel)):
        red, green, blue = 0.0, 0.0, 0.0
        for e in range(texel.shape[1]):
            row, factor = texture[texel[i, e]], weight[i, e]
            red += factor * row[0]
            green += factor * row[1]
            blue += factor * row[2]
        out[i, 0], out[i, 1], out[i, 2] = red, green, blue
