"""The two-dimensional Haar transform of the faces of a cube map, orthonormal and non-standard.

Each level replaces blocks of 2 × 2 values p q / r s by one value at half the size and three details (Mallat's order):

    mean   (p + q + r + s)/2        across (p − q + r − s)/2
    down   (p + q − r − s)/2        both   (p − q − r + s)/2

and goes on with the means until one is left, the 'scaling' coefficient: the sum over the face divided by its edge. In
the square of coefficients the means of a level lie in the upper left quarter, `across` right of them, `down` below
and `both` diagonally. Halving is exact in binary floating point: integers of b bits on an edge of 2^k need b + 2k bits.

An index numbers the coefficients of all faces from coarse to fine: the six scaling coefficients first, then level by
level, face by face, `across`, `down`, `both`, row by row. What is large is near the front, which keeps look-ups in
fast memory, and the scaling coefficients are known by index < 6.

Cost: about 4 additions for each value, bound by memory for large batches.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange, scalar
from engine.core.quickselect import nth_smallest

FACES = 6

#: Edges of a cube face: powers of two whose coefficients a 16-bit index can number; 64 is the largest.
EDGES = (2, 4, 8, 16, 32, 64)

#: Largest edge, whether a power of two or not, of which six squares can be numbered in 16 bits.
LARGEST_EDGE = 104


def check_edge(edge: int) -> None:
    """ValueError for an edge that wavelets cannot have: above 104 (16-bit indices) or no power of two."""
    if edge > LARGEST_EDGE:
        raise ValueError(
            f"a cube edge of {edge} has {FACES * edge * edge:,} coefficients, more than the 65,536 that 16-bit indices "
            f"can number; the largest edge is {LARGEST_EDGE}, the largest power of two 64"
        )
    if edge not in EDGES:
        raise ValueError(f"a cube edge of {edge} is not possible; wavelets need a power of two from 2 to 64")


def haar(images: NDArray[Any]) -> NDArray[Any]:
    """Coefficients (..., N, N) of `images` (..., N, N), float32 or float64, which stay as they are.

    ValueError where N is not a power of two, or the images are not square.
    """
    return _transform(images, forwards=True)


def inverse_haar(coefficients: NDArray[Any]) -> NDArray[Any]:
    """The images (..., N, N) of which `coefficients` (..., N, N) are the transform."""
    return _transform(coefficients, forwards=False)


def _transform(images: NDArray[Any], forwards: bool) -> NDArray[Any]:
    images = np.asarray(images)
    if images.dtype not in (np.float32, np.float64):
        images = images.astype(np.float64)
    if images.ndim < 2 or images.shape[-1] != images.shape[-2]:
        raise ValueError(f"the Haar transform needs squares, not {images.shape[-2:]}")
    edge = images.shape[-1]
    if edge < 1 or edge & (edge - 1):
        raise ValueError(f"the Haar transform needs an edge that is a power of two, not {edge}")
    result = np.array(images, order="C")
    flat = result.reshape(-1, edge, edge)
    if edge > 1 and len(flat):
        (_forwards if forwards else _backwards)(flat)
    return result


@scalar
def _down(square: NDArray[np.floating], scratch: NDArray[np.floating], size: int) -> None:
    """One level of one square in place; `scratch` holds at least `size` × `size` values."""
    half = size // 2
    one = square.dtype.type(0.5)
    for i in range(half):
        for j in range(half):
            p, q = square[2 * i, 2 * j], square[2 * i, 2 * j + 1]
            r, s = square[2 * i + 1, 2 * j], square[2 * i + 1, 2 * j + 1]
            scratch[i, j] = one * ((p + q) + (r + s))
            scratch[i, half + j] = one * ((p - q) + (r - s))
            scratch[half + i, j] = one * ((p + q) - (r + s))
            scratch[half + i, half + j] = one * ((p - q) - (r - s))
    for i in range(size):
        for j in range(size):
            square[i, j] = scratch[i, j]


@scalar
def _up(square: NDArray[np.floating], scratch: NDArray[np.floating], size: int) -> None:
    """The inverse of `_down`."""
    half = size // 2
    one = square.dtype.type(0.5)
    for i in range(half):
        for j in range(half):
            mean, across = square[i, j], square[i, half + j]
            down, both = square[half + i, j], square[half + i, half + j]
            scratch[2 * i, 2 * j] = one * ((mean + across) + (down + both))
            scratch[2 * i, 2 * j + 1] = one * ((mean - across) + (down - both))
            scratch[2 * i + 1, 2 * j] = one * ((mean + across) - (down + both))
            scratch[2 * i + 1, 2 * j + 1] = one * ((mean - across) - (down - both))
    for i in range(size):
        for j in range(size):
            square[i, j] = scratch[i, j]


@parallel
def _forwards(squares: NDArray[np.floating]) -> None:
    for n in prange(len(squares)):
        scratch = np.empty_like(squares[n])
        size = squares.shape[1]
        while size > 1:
            _down(squares[n], scratch, size)
            size //= 2


@parallel
def _backwards(squares: NDArray[np.floating]) -> None:
    for n in prange(len(squares)):
        scratch = np.empty_like(squares[n])
        size = 2
        while size <= squares.shape[1]:
            _up(squares[n], scratch, size)
            size *= 2


@cache
def places(edge: int) -> NDArray[np.int64]:
    """(6 · edge²,) where each index lies in the coefficients (6, edge, edge), as face · edge² + row · edge + column."""
    check_edge(edge)
    grid = np.arange(FACES * edge * edge).reshape(FACES, edge, edge)
    parts = [grid[:, :1, :1].reshape(-1)]
    size = 1
    while size < edge:
        low, high = slice(0, size), slice(size, 2 * size)
        details = np.stack([grid[:, low, high], grid[:, high, low], grid[:, high, high]], axis=1)
        parts.append(details.reshape(-1))
        size *= 2
    order = np.concatenate(parts)
    order.flags.writeable = False
    return order


def cube_coefficients(radiance: NDArray[Any]) -> NDArray[Any]:
    """Coefficients (6 · N², C) by index of the faces (6, N, N, C) of a cube map."""
    edge = radiance.shape[1]
    squares = haar(np.moveaxis(np.asarray(radiance), -1, 0))
    return np.ascontiguousarray(squares.reshape(len(squares), -1)[:, places(edge)].T)


def cube_of_coefficients(coefficients: NDArray[Any]) -> NDArray[Any]:
    """The faces (6, N, N, C) of which `coefficients` (6 · N², C) are those by index."""
    edge = round((len(coefficients) / FACES) ** 0.5)
    squares = np.empty((coefficients.shape[1], len(coefficients)), coefficients.dtype)
    squares[:, places(edge)] = coefficients.T
    images = inverse_haar(squares.reshape(-1, FACES, edge, edge))
    return np.ascontiguousarray(np.moveaxis(images, 0, -1))


def strongest(coefficients: NDArray[Any], count: int) -> NDArray[np.int64]:
    """The `count` indices (fewer where there are fewer that are not 0) of the largest rows of `coefficients` (M, C).

    A row counts by the sum of its squares, so that no other choice leaves a smaller squared error; ties go to the
    lower index. The indices come in rising order. ValueError for a negative count.
    """
    if count < 0:
        raise ValueError(f"a number of coefficients is not negative, as {count} is")
    planes = np.ascontiguousarray(np.asarray(coefficients, np.float64).T)
    kept = np.empty(min(count, planes.shape[1]), np.int64)
    value, scratch = np.empty((2, candidates(count)))
    return kept[: select(planes, kept, value, scratch, np.empty(len(value), np.int64))]


def candidates(count: int) -> int:
    """Room that `select` needs to choose so many: so much that it rarely has to thin out."""
    return 2 * count + 256


@scalar
def select(
    planes: NDArray[np.floating],
    kept: NDArray[np.integer],
    value: NDArray[np.floating],
    scratch: NDArray[np.floating],
    index: NDArray[np.integer],
) -> int:
    """Fill `kept` with the indices of the strongest columns of `planes` (C, M), in rising order; how many there are.

    Columns of 0 are never kept, ties go to the lower index. `value`, `scratch` and `index` are of a length of
    `candidates`. Columns are gone through once: those that beat the weakest of the best so far are held, and thinned
    out to the best whenever `value` is full. What is large is near the front, so that happens a few times only.
    """
    wanted = len(kept)
    if wanted == 0:
        return 0
    held = 0
    bar: float | np.floating = planes.dtype.type(0.0)
    for m in range(planes.shape[1]):
        total = planes[0, m] * planes[0, m]
        for p in range(1, len(planes)):
            total += planes[p, m] * planes[p, m]
        if total > bar:
            value[held], index[held] = total, m
            held += 1
            if held == len(value):
                bar = _thin(value, scratch, index, held, wanted)
                held = wanted
    if held > wanted:
        _thin(value, scratch, index, held, wanted)
        held = wanted
    for n in range(held):
        kept[n] = index[n]
    return held


@scalar
def _thin(
    value: NDArray[np.floating], scratch: NDArray[np.floating], index: NDArray[np.integer], held: int, wanted: int
) -> float:
    """Leave the `wanted` strongest of `held` candidates in their order, ties to the first; the weakest of them."""
    for n in range(held):
        scratch[n] = value[n]
    bar = nth_smallest(scratch, held, held - wanted)
    equal = wanted
    for n in range(held):
        if value[n] > bar:
            equal -= 1
    count = 0
    for n in range(held):
        tie = value[n] == bar and equal > 0
        if tie:
            equal -= 1
        if tie or value[n] > bar:
            value[count], index[count] = value[n], index[n]
            count += 1
    return bar
