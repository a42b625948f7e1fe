"""The 24 patches of the classic ColorChecker, as X-Rite publishes them for charts made since the end of 2014.

CIE L*a*b* under D50, for the observer of 2°. Charts differ from these by about 0.5 ΔE2000, older ones by up to 2.
"""

from __future__ import annotations

import numpy as np

from engine.core.colour import D65, SRGB_FROM_XYZ, adaptation
from engine.core.colour_difference import D50, xyz_from_lab

ROWS, COLUMNS = 4, 6

#: Names and L*, a*, b* row by row, from the dark skin to the black.
PATCHES: tuple[tuple[str, tuple[float, float, float]], ...] = (
    ("dark skin", (37.54, 14.37, 14.92)),
    ("light skin", (64.66, 19.27, 17.50)),
    ("blue sky", (49.32, -3.82, -22.54)),
    ("foliage", (43.46, -12.74, 22.72)),
    ("blue flower", (54.94, 9.61, -24.79)),
    ("bluish green", (70.48, -32.26, -0.37)),
    ("orange", (62.73, 35.83, 56.50)),
    ("purplish blue", (39.43, 10.75, -45.17)),
    ("moderate red", (50.57, 48.64, 16.67)),
    ("purple", (30.10, 22.54, -20.87)),
    ("yellow green", (71.77, -24.13, 58.19)),
    ("orange yellow", (71.51, 18.24, 67.37)),
    ("blue", (28.37, 15.42, -49.80)),
    ("green", (54.38, -39.72, 32.27)),
    ("red", (42.43, 51.05, 28.62)),
    ("yellow", (81.80, 2.67, 80.41)),
    ("magenta", (50.63, 51.28, -14.12)),
    ("cyan", (49.57, -29.71, -28.32)),
    ("white", (95.19, -1.03, 2.93)),
    ("neutral 8", (81.29, -0.57, 0.44)),
    ("neutral 6.5", (66.89, -0.75, -0.06)),
    ("neutral 5", (50.76, -0.13, 0.14)),
    ("neutral 3.5", (35.63, -0.46, -0.48)),
    ("black", (20.64, 0.07, -0.46)),
)
NAMES = tuple(name for name, _ in PATCHES)

#: Positions of the neutral patches, from white to black.
NEUTRAL = tuple(range(18, 24))
WHITE = NEUTRAL[0]

LAB = np.array([lab for _, lab in PATCHES])

#: Linear Rec. 709 (24, 3), 1 for a perfect white.
REFERENCE_RGB = xyz_from_lab(LAB) @ (SRGB_FROM_XYZ @ adaptation(D50, D65)).T
