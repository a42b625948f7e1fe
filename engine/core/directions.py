"""Directions: (..., 3) float64 unit vectors that point away from the surface.

Two frames occur. In the world +Y is up; its angles are theta from +Y and phi from +Z towards +X, so that the default
camera, which looks along −Z, is at theta = 90°, phi = 0. In the surface frame the normal is +z and the tangent +x.

A brushed surface has its direction by tangents from texture coordinates, or by frames along any direction.

The tangent is dP/du, the direction in which u grows, and the bitangent n × t: frames are right-handed also where the
texture is mirrored, which the sign beside the tangent tells. Where texture coordinates say nothing (no area in the
texture, or neighbours that cancel) the tangent is that of `world_from_tangent`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vectors = NDArray[np.float64]


def dot(a: ArrayLike, b: ArrayLike) -> Vectors:
    """Scalar product over the last axis, (..., 3) × (..., 3) → (...)."""
    return np.einsum("...i,...i->...", np.asarray(a, np.float64), np.asarray(b, np.float64))


def normalize(vectors: ArrayLike, fallback: ArrayLike = (0.0, 0.0, 1.0)) -> Vectors:
    """Unit vectors (..., 3); `fallback` where the length is zero or not finite, so that no NaN is made."""
    vectors = np.asarray(vectors, np.float64)
    with np.errstate(invalid="ignore", over="ignore"):
        length = np.sqrt(dot(vectors, vectors))[..., None]
    usable = np.isfinite(length) & (length > 0.0)
    unit = np.where(usable, vectors, 0.0) / np.where(usable, length, 1.0)
    return np.where(usable, unit, fallback)


def world_direction(theta: float, phi: float) -> Vectors:
    """The world direction (3,) at `theta` from +Y and `phi` from +Z towards +X, both in radians."""
    return np.array([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)])


def world_angles(direction: ArrayLike) -> tuple[float, float]:
    """(theta, phi) in radians of a world direction; the inverse of `world_direction`, phi = 0 at the poles."""
    x, y, z = np.asarray(direction, np.float64)
    return float(np.arctan2(np.hypot(x, z), y)), float(np.arctan2(x, z)) if x or z else 0.0


def surface_direction(theta: ArrayLike, phi: ArrayLike = 0.0) -> Vectors:
    """The surface-frame direction (..., 3) at polar angle `theta` from the normal, azimuth `phi` from the tangent."""
    theta, phi = np.broadcast_arrays(np.asarray(theta, np.float64), np.asarray(phi, np.float64))
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def world_from_tangent(normal: ArrayLike) -> Vectors:
    """Frames (..., 3, 3) with columns tangent, bitangent, normal: the stereographic frame of Wang2004, 3.1.

    Its factor 1 / (1 + n_y) cancels near its one singularity n = (0, −1, 0); for n_y < 0 we use the equal
    1 + n_y = (n_x² + n_z²) / (1 − n_y), and at the singularity itself the limit along n_x = 0.
    """
    n = np.asarray(normal, np.float64)
    x, y, z = n[..., 0], n[..., 1], n[..., 2]
    across = x * x + z * z
    at_pole = (across == 0.0) & (y < 0.0)
    denominator = np.where(y < 0.0, across / np.where(y < 0.0, 1.0 - y, 1.0), 1.0 + y)
    scale = np.where(at_pole, 0.0, 1.0 / np.where(at_pole, 1.0, denominator))
    tangent = np.stack([1.0 - x * x * scale, -x, -x * z * scale], axis=-1)
    bitangent = np.where(
        at_pole[..., None], (0.0, 0.0, 1.0), np.stack([x * z * scale, z, z * z * scale - 1.0], axis=-1)
    )
    return np.stack([tangent, bitangent, n], axis=-1)


#: A direction whose part in the surface is smaller than this share of it counts as one along the normal.
ALONG_NORMAL = 1e-6


def frames_along(normal: ArrayLike, direction: ArrayLike) -> Vectors:
    """Frames (..., 3, 3) with columns tangent, bitangent, normal, their determinant +1.

    The tangent is `direction` (..., 3), of any length, projected into the plane of the unit `normal` (..., 3). Where
    that leaves nothing, or is not finite, it is the tangent of `world_from_tangent`.
    """
    n, along = np.broadcast_arrays(np.asarray(normal, np.float64), np.asarray(direction, np.float64))
    along = normalize(along, fallback=(0.0, 0.0, 0.0))
    inside = along - dot(n, along)[..., None] * n
    usable = np.sqrt(dot(inside, inside)) > ALONG_NORMAL
    frames = world_from_tangent(n)
    tangent = normalize(inside)
    # once more, because where little is left the first projection has lost digits
    tangent = normalize(tangent - dot(n, tangent)[..., None] * n)
    tangent = np.where(usable[..., None], tangent, frames[..., 0])
    bitangent = np.where(usable[..., None], np.cross(n, tangent), frames[..., 1])
    return np.stack([tangent, bitangent, n], axis=-1)


def uv_tangents(
    positions: NDArray[np.float64], normals: NDArray[np.float32], uv: NDArray[np.float32], faces: NDArray[np.int32]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit tangents (V, 3) of vertices, weighted by the area of the faces that meet there, and signs (V,).

    The sign is −1 where the texture is seen mirrored: v then grows against n × t.
    """
    corners, texture = positions[faces], uv[faces].astype(np.float64)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    one, two = texture[:, 1] - texture[:, 0], texture[:, 2] - texture[:, 0]
    area_in_texture = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    sign = np.sign(area_in_texture)
    grows = normalize(first * two[:, 1:] - second * one[:, 1:], fallback=(0.0, 0.0, 0.0)) * sign[:, None]
    directed = np.cross(first, second)
    area = np.sqrt(dot(directed, directed))
    vertex, count = faces.ravel(), len(positions)
    parts = np.column_stack([grows, sign]) * area[:, None]
    summed = np.stack([np.bincount(vertex, np.repeat(part, 3), count) for part in parts.T], axis=-1)
    frames = frames_along(normalize(normals), summed[:, :3])
    return frames[..., 0], np.where(summed[:, 3] < 0.0, -1.0, 1.0)
