"""Directions: (..., 3) float64 unit vectors that point away from the surface.

Two frames occur. In the world +Y is up; its angles are theta from +Y and phi from +Z towards +X, so that the default
camera, which looks along −Z, is at theta = 90°, phi = 0. In the surface frame the normal is +z and the tangent +x.
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
    """Frames (..., 3, 3) with columns tangent, bitangent, normal: the stereographic frame of Wang et al. 2004, 3.1.

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
