"""Stacks of computed photographs of surfaces whose shape is known, written down without the program's own kernels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.stack import ImageStack

Array = NDArray[np.float64]


def bump(size: int = 48) -> tuple[Array, Array]:
    """Height (H, W) in widths of a texel of a smooth bump, and its normals (H, W, 3) by its derivative."""
    row, column = np.mgrid[:size, :size] + 0.5
    x, y = column - size / 2, size / 2 - row
    width = size / 5
    height = 0.35 * size * 0.5 * np.exp(-(x**2 + y**2) / (2 * width**2))
    return height, normals(-height * x / width**2, -height * y / width**2)


def normals(right: Array, up: Array) -> Array:
    """Unit normals (H, W, 3) of the slopes dh/dx and dh/dy."""
    found = np.stack([-right, -up, np.ones_like(right)], axis=-1)
    return np.asarray(found / np.linalg.norm(found, axis=-1, keepdims=True))


def lights(elevations_deg: tuple[float, ...], azimuths_deg: tuple[float, ...]) -> tuple[Array, Array]:
    """Elevations and azimuths (N,) of all pairs, radians, by rising elevation."""
    pairs = [(np.radians(rise), np.radians(around)) for rise in sorted(elevations_deg) for around in azimuths_deg]
    return np.array([rise for rise, _ in pairs]), np.array([around for _, around in pairs])


def directions(elevation: Array, azimuth: Array) -> Array:
    """(N, 3) unit vectors."""
    return np.stack(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], axis=1
    )


def lambertian(normal: Array, albedo: Any, elevation: Array, azimuth: Array) -> ImageStack:
    """A stack of a diffuse surface under distant lamps, without noise and cast shadows."""
    towards = directions(elevation, azimuth)
    shown = np.maximum(np.einsum("ijk,nk->nij", normal, towards), 0.0)
    return stack(shown[..., None] * np.asarray(albedo), elevation, azimuth)


def stack(radiance: Array, elevation: Array, azimuth: Array | None, **provenance: Any) -> ImageStack:
    """A stack in memory of radiance (N, H, W, 3)."""
    return ImageStack(
        radiance.astype(np.float32),
        np.zeros(radiance.shape[:3], np.bool_),
        elevation,
        azimuth,
        radiance.mean(axis=(1, 2, 3)),
        tuple(f"{index:04}.tif" for index in range(len(radiance))),
        "user",
        provenance,
    )


def angle_deg(one: Any, other: Array) -> Array:
    """(H, W) angles in degrees between unit vectors."""
    cross = np.linalg.norm(np.cross(one, other), axis=-1)
    return np.asarray(np.degrees(np.arctan2(cross, (one * other).sum(axis=-1))))
