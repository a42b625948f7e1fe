"""Functions of the direction of light by which photographs are described: polynomials and harmonics."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors

Array = NDArray[np.float64]


def polynomial(lights: Vectors) -> Array:
    """(N, 6) the functions of polynomial texture maps (Malzbender2001)."""
    x, y = lights[:, 0], lights[:, 1]
    return np.stack([x * x, y * y, x * y, x, y, np.ones_like(x)], axis=1)


def hsh(lights: Vectors) -> Array:
    """(N, 9) hemispherical harmonics of orders 0 to 2 (Gautron2004), but for their factors."""
    cosine = np.clip(lights[:, 2], 0.0, 1.0)
    phi = np.arctan2(lights[:, 1], lights[:, 0])
    z = 2.0 * cosine - 1.0
    rise = np.sqrt(np.maximum(1.0 - z**2, 0.0))
    return np.stack(
        [
            *(np.ones_like(z), rise * np.cos(phi), z, rise * np.sin(phi)),
            *(rise**2 * np.cos(2.0 * phi), z * rise * np.cos(phi), 3.0 * z**2 - 1.0),
            *(z * rise * np.sin(phi), rise**2 * np.sin(2.0 * phi)),
        ],
        axis=1,
    )


def hemispherical(lights: Vectors) -> Array:
    """(N, 16) hemispherical harmonics of orders 0 to 3, orthonormal over the hemisphere (Gautron2004).

    Signs and order are those of files of reflectance transformation imaging, which hold the first 4, 9 or all 16.
    """
    c = np.clip(lights[:, 2], 0.0, 1.0)
    phi = np.arctan2(lights[:, 1], lights[:, 0])
    root, z, fall = np.sqrt(np.maximum(c - c**2, 0.0)), 2.0 * c - 1.0, c**2 - c
    first, second, third = np.sqrt(6.0 / np.pi) * root, np.sqrt(30.0 / np.pi), np.sqrt(7.0 / (2.0 * np.pi))
    steep, flat = 2.0 * np.sqrt(35.0 / np.pi) * root**3, np.sqrt(210.0 / np.pi) * z * fall
    slow = 2.0 * np.sqrt(21.0 / np.pi) * root * (1.0 + 5.0 * fall)
    return np.stack(
        [
            np.full_like(c, 1.0 / np.sqrt(2.0 * np.pi)),
            *(first * np.cos(phi), np.sqrt(3.0 / (2.0 * np.pi)) * z, first * np.sin(phi)),
            *(second * np.cos(2.0 * phi) * fall, second * np.cos(phi) * z * root),
            np.sqrt(5.0 / (2.0 * np.pi)) * (1.0 + 6.0 * fall),
            *(second * z * root * np.sin(phi), second * fall * np.sin(2.0 * phi)),
            *(steep * np.cos(3.0 * phi), flat * np.cos(2.0 * phi), slow * np.cos(phi)),
            third * (20.0 * c**3 - 30.0 * c**2 + 12.0 * c - 1.0),
            *(slow * np.sin(phi), flat * np.sin(2.0 * phi), steep * np.sin(3.0 * phi)),
        ],
        axis=1,
    )


def spherical(lights: Vectors) -> Array:
    """(N, 9) spherical harmonics of orders 0 to 2, in the order of web viewers: 1, x, z, y, xy, xz, 3 z² − 1, yz,
    y² − x²."""
    x, y, z = lights.T
    first, second = 0.5 * np.sqrt(3.0 / np.pi), 0.5 * np.sqrt(15.0 / np.pi)
    return np.stack(
        [
            np.full_like(x, 0.5 / np.sqrt(np.pi)),
            *(first * x, first * z, first * y),
            *(second * x * y, second * x * z, 0.25 * np.sqrt(5.0 / np.pi) * (3.0 * z * z - 1.0), second * y * z),
            0.5 * second * (y * y - x * x),
        ],
        axis=1,
    )
