"""Rotation of spherical harmonics, exact for every angle (Kautz2002 appendix, with M_ij for its M_ii).

The function f rotated by R is f(R^-1 s), so the coefficients of two rotations follow M(R1 R2) = M(R1) M(R2). A rotation
is taken apart as Rz(alpha) Ry(beta) Rz(gamma). About z, pairs of coefficients turn by m times the angle. About y, we
turn about z in the world in which y and z have changed places: Ry(beta) = S Rz(-beta) S (Pinchon and Hoggan, *Rotation
matrices for real spherical harmonics*, 2007). S is its own inverse, and its coefficients (`swap`) are found once by
quadrature that is exact for polynomials; three quarters of them are 0. The paper turns by 90 degrees about x in its
place, which takes two matrices.
"""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.transport.sh import kernel as sh_kernel
from engine.transport.sh.basis import band_values, check_order, order_of

#: A matrix that is further than this from the nearest rotation is refused: float32 frames are nearer.
LOOSEST = 1e-5

Array = NDArray[np.float64]


def nearest_rotation(matrix: ArrayLike) -> tuple[Array, float]:
    """The rotation (3, 3) nearest to `matrix`, and their distance |R - matrix| (Frobenius).

    Raises ValueError for what has no nearest rotation: reflections, singular matrices, numbers that are not finite.
    """
    given = np.asarray(matrix, np.float64)
    if given.shape != (3, 3) or not np.isfinite(given).all():
        raise ValueError(f"a rotation is a matrix of 3 × 3 finite numbers, got {given.tolist()}")
    left, size, right = np.linalg.svd(given)
    if size[2] <= 1e-6 * size[0]:
        raise ValueError("the matrix is singular, and no rotation is nearest to it")
    if np.linalg.det(left @ right) < 0.0:
        raise ValueError("the matrix is a reflection (its determinant is negative), not a rotation")
    nearest = left @ right
    return nearest, float(np.linalg.norm(nearest - given))


def rotation(order: int, matrix: ArrayLike) -> Array:
    """The block-diagonal matrix (order^2, order^2) that rotates coefficients by `matrix` (3, 3).

    Orthogonal to rounding, exactly 0 outside the bands, and exactly the identity for the identity. Raises ValueError
    for a reflection and for a matrix that is further than `LOOSEST` from a rotation; `nearest_rotation` mends those.
    """
    blocks = band_rotations(order, matrix)
    whole = np.zeros((order * order, order * order))
    for degree, block in enumerate(blocks):
        band = slice(degree * degree, (degree + 1) ** 2)
        whole[band, band] = block
    return whole


def rotate(coefficients: ArrayLike, matrix: ArrayLike) -> Array:
    """`coefficients` (order^2,) or (..., order^2, C) of the function rotated by `matrix` (3, 3); as `rotation`."""
    values = np.asarray(coefficients, np.float64)
    columns = values[:, None] if values.ndim == 1 else values
    order = order_of(columns.shape[-2])
    rotated = np.empty_like(columns)
    for degree, block in enumerate(band_rotations(order, matrix)):
        band = slice(degree * degree, (degree + 1) ** 2)
        rotated[..., band, :] = block @ columns[..., band, :]
    return rotated[:, 0] if values.ndim == 1 else rotated


def band_rotations(order: int, matrix: ArrayLike) -> list[Array]:
    """The blocks (2 l + 1, 2 l + 1) of `rotation`."""
    given = np.asarray(matrix, np.float64)
    _, distance = nearest_rotation(given)
    if distance > LOOSEST:
        raise ValueError(f"the matrix differs by {distance:.3g} from the nearest rotation; take that one instead")
    if given[0, 2] == 0.0 and given[1, 2] == 0.0 and given[2, 2] > 0.0:
        about_z = given[:2, 0] / np.hypot(*given[:2, 0])
        return [_about_z(degree, *about_z) for degree in range(check_order(order))]
    pairs = np.empty((3, 2))
    sh_kernel.euler_pairs(given, pairs)
    blocks = []
    for degree in range(check_order(order)):
        alpha, beta, gamma = (_about_z(degree, *pair) for pair in pairs)
        mirror = swap(degree)
        blocks.append(alpha @ (mirror @ beta.T @ mirror) @ gamma)
    return blocks


def _about_z(degree: int, cosine: float, sine: float) -> Array:
    """The block of a rotation about z by the angle of this cosine and sine."""
    turn = np.cumprod(np.full(degree, complex(cosine, sine)))
    block = np.zeros((2 * degree + 1, 2 * degree + 1))
    block[degree, degree] = 1.0
    plus, minus = degree + 1 + np.arange(degree), degree - 1 - np.arange(degree)
    block[plus, plus] = block[minus, minus] = turn.real
    block[plus, minus], block[minus, plus] = -turn.imag, turn.imag
    return block


@cache
def swap(degree: int) -> Array:
    """(2 l + 1, 2 l + 1) coefficients of f(x, z, y) from those of f(x, y, z) in band l; symmetric, its own inverse.

    Products of two functions of one band are alike at opposite points, so the upper half of the sphere is enough. The
    time grows as l^4: all bands of order 15 take 20 ms, and of order 64 about 2 s, once.
    """
    z, weight = np.polynomial.legendre.leggauss(degree + 1)
    z, weight = z[(degree + 1) // 2 :], weight[(degree + 1) // 2 :] * 2.0
    weight[0] *= 1.0 if degree % 2 else 0.5  # of an odd number of points one is on the equator
    azimuth = np.arange(2 * degree + 1) * 2.0 * np.pi / (2 * degree + 1)
    across = np.sqrt(1.0 - z * z)[:, None]
    up = np.broadcast_to(z[:, None], (len(z), 2 * degree + 1))
    points = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), up], axis=-1).reshape(-1, 3)
    here = band_values(degree + 1, degree, points)
    there = band_values(degree + 1, degree, points[:, [0, 2, 1]])
    area = np.repeat(weight, 2 * degree + 1) * 2.0 * np.pi / (2 * degree + 1)
    block = here.T @ (there * area[:, None])
    block = 0.5 * (block + block.T)
    block[np.abs(block) < 1e-14] = 0.0
    block = 1.5 * block - 0.5 * block @ block @ block  # Newton's step towards block @ block = 1
    block.flags.writeable = False
    return block


@lru_cache(maxsize=8)
def _swap_rows(order: int, dtype: str) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.floating]]:
    """The rows of `swap` for all bands: where each starts, and index and weight of its entries that are not 0."""
    index, weight, length = [], [], []
    for degree in range(order):
        for row in swap(degree):
            entries = np.flatnonzero(np.abs(row) > 1e-15)
            index.append(entries + degree * degree)
            weight.append(row[entries])
            length.append(len(entries))
    return np.append(0, np.cumsum(length)), np.concatenate(index), np.concatenate(weight).astype(dtype)


def rotate_into_frames(coefficients: NDArray[np.floating], frames: NDArray[np.floating]) -> NDArray[np.floating]:
    """Functions of the world as functions of each of `frames`: (V, order^2, C).

    Parameters
    ----------
    coefficients : (order^2, C) of one function for all frames, or (V, order^2, C) of one each; float32 or float64,
        which is also the type of the sums and of the result. C is 3 for light, order^2 for the columns of a transfer.
    frames : (V, 3, 3) with columns tangent, bitangent, normal; each is taken for a rotation, without a check.

    50,000 frames at order 5 take 6 ms in float32 and 8 ms in float64 on two cores.
    """
    return _rotate(coefficients, frames, True)


def rotate_from_frames(coefficients: NDArray[np.floating], frames: NDArray[np.floating]) -> NDArray[np.floating]:
    """Functions of each of `frames` as functions of the world: the inverse of `rotate_into_frames`."""
    return _rotate(coefficients, frames, False)


def _rotate(coefficients: NDArray[np.floating], frames: NDArray[np.floating], into: bool) -> NDArray[np.floating]:
    values = np.ascontiguousarray(coefficients if coefficients.ndim == 3 else coefficients[None])
    if values.dtype not in (np.float32, np.float64):
        values = values.astype(np.float64)
    if frames.shape[1:] != (3, 3) or len(values) not in (1, len(frames)):
        raise ValueError(f"coefficients {coefficients.shape} and frames {frames.shape} do not fit together")
    order = order_of(values.shape[1])
    out = np.empty((len(frames), *values.shape[1:]), values.dtype)
    rows = _swap_rows(order, values.dtype.name)
    sh_kernel.rotate_many(values, np.ascontiguousarray(frames), into, order, *rows, out)
    return out
