"""CIE L*a*b* and the colour difference ΔE2000 of the CIE (CIE 15:2018; Sharma2005)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: XYZ of the reference white of print and of colour charts (ICC.1:2022).
D50 = np.array([0.9642, 1.0, 0.8249])

_KNEE = 6.0 / 29.0


def lab_from_xyz(xyz: ArrayLike, white: NDArray[np.float64] = D50) -> NDArray[np.float64]:
    """L*, a*, b* (…, 3) of XYZ (…, 3) under `white`; the straight part of the curve goes on below 0."""
    share = np.asarray(xyz, np.float64) / white
    f = np.where(share > _KNEE**3, np.cbrt(np.maximum(share, 0.0)), share / (3.0 * _KNEE**2) + 4.0 / 29.0)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)


def xyz_from_lab(lab: ArrayLike, white: NDArray[np.float64] = D50) -> NDArray[np.float64]:
    """Inverse of `lab_from_xyz`."""
    lightness, a, b = np.moveaxis(np.asarray(lab, np.float64), -1, 0)
    y = (lightness + 16.0) / 116.0
    f = np.stack([y + a / 500.0, y, y - b / 200.0], axis=-1)
    xyz: NDArray[np.float64] = white * np.where(f > _KNEE, f**3, 3.0 * _KNEE**2 * (f - 4.0 / 29.0))
    return xyz


def delta_e_2000(one: ArrayLike, other: ArrayLike) -> NDArray[Any]:
    """Difference ΔE2000 (…) of two colours in L*, a*, b* (…, 3), with all weights 1."""
    (l1, a1, b1), (l2, a2, b2) = (np.moveaxis(np.asarray(each, np.float64), -1, 0) for each in (one, other))
    mean_chroma = (np.hypot(a1, b1) + np.hypot(a2, b2)) / 2
    stretch = 1.5 - 0.5 * np.sqrt(mean_chroma**7 / (mean_chroma**7 + 25.0**7))
    c1, c2 = np.hypot(stretch * a1, b1), np.hypot(stretch * a2, b2)
    h1, h2 = (np.degrees(np.arctan2(b, stretch * a)) % 360 for a, b in ((a1, b1), (a2, b2)))
    chromatic = c1 * c2 > 0
    turn = np.where(chromatic, (h2 - h1 + 180) % 360 - 180, 0.0)
    turn = np.where(chromatic & (h2 - h1 == 180), 180.0, turn)
    hue = 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn) / 2)
    far = np.abs(h1 - h2) > 180
    mean_hue = np.where(chromatic, (h1 + h2 + np.where(far, np.where(h1 + h2 < 360, 360.0, -360.0), 0.0)) / 2, h1 + h2)
    lightness, chroma = (l1 + l2) / 2, (c1 + c2) / 2
    cosine = np.cos(np.radians([mean_hue - 30, 2 * mean_hue, 3 * mean_hue + 6, 4 * mean_hue - 63]))
    weight = 1 - 0.17 * cosine[0] + 0.24 * cosine[1] + 0.32 * cosine[2] - 0.20 * cosine[3]
    of_l = (l2 - l1) / (1 + 0.015 * (lightness - 50) ** 2 / np.sqrt(20 + (lightness - 50) ** 2))
    of_c = (c2 - c1) / (1 + 0.045 * chroma)
    of_h = hue / (1 + 0.015 * chroma * weight)
    blue = 60 * np.exp(-(((mean_hue - 275) / 25) ** 2))
    rotation = -np.sin(np.radians(blue)) * 2 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
    return np.sqrt(np.maximum(of_l**2 + of_c**2 + of_h**2 + rotation * of_c * of_h, 0.0))
