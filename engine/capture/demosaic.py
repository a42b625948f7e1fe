"""Full colour from a colour filter array, in floating point, so that negative samples and the mean survive.

Bayer mosaics: Malvar, He and Cutler 2004, "High-quality linear interpolation for demosaicing of Bayer-patterned color
images", figure 2. Other mosaics (X-Trans): normalised convolution (Knutsson and Westin 1993) with a 5×5 tent. Both
are linear, so noise that averages to black still does. Cost: 24 megapixels 0.5 s; works in strips of rows.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_GREEN = np.array([[0, 0, -1, 0, 0], [0, 0, 2, 0, 0], [-1, 2, 4, 2, -1], [0, 0, 2, 0, 0], [0, 0, -1, 0, 0]]) / 8
_SAME_ROW = (
    np.array([[0, 0, 0.5, 0, 0], [0, -1, 0, -1, 0], [-1, 4, 5, 4, -1], [0, -1, 0, -1, 0], [0, 0, 0.5, 0, 0]]) / 8
)
_DIAGONAL = (
    np.array([[0, 0, -1.5, 0, 0], [0, 2, 0, 2, 0], [-1.5, 0, 6, 0, -1.5], [0, 2, 0, 2, 0], [0, 0, -1.5, 0, 0]]) / 8
)
_TENT = np.outer([1, 2, 3, 2, 1], [1, 2, 3, 2, 1]).astype(np.float32)

#: Samples that enter a pixel of a Bayer mosaic lie within two steps of it.
FOOTPRINT = (np.abs(np.arange(-2, 3))[:, None] + np.abs(np.arange(-2, 3)) <= 2).astype(np.uint8)

_STRIP_ROWS = 512
_HALO = 2


def demosaic(mosaic: NDArray[np.float32], colours: NDArray[np.integer]) -> NDArray[np.float32]:
    """Full colour (H, W, 3) of a mosaic (H, W).

    `colours` (P, Q) repeats over the mosaic from its row 0, column 0 and says 0, 1 or 2 (red, green, blue) per site.
    """
    interpolate = _bayer if is_bayer(colours) else _normalised
    height = mosaic.shape[0]
    full = np.empty((*mosaic.shape, 3), np.float32)
    padded = cv2.copyMakeBorder(mosaic, *(_HALO,) * 4, cv2.BORDER_REFLECT_101)
    start_colours = np.roll(colours, (_HALO, _HALO), axis=(0, 1))
    for start in range(0, height, _STRIP_ROWS):
        stop = min(start + _STRIP_ROWS, height)
        strip = padded[start : stop + 2 * _HALO]
        shifted = np.roll(start_colours, -start, axis=0)
        full[start:stop] = interpolate(strip, shifted)[_HALO:-_HALO, _HALO:-_HALO]
    return full


def is_bayer(colours: NDArray[np.integer]) -> bool:
    """True for a 2×2 array with two greens on a diagonal."""
    if colours.shape != (2, 2) or sorted(colours.ravel()) != [0, 1, 1, 2]:
        return False
    return bool(colours[0, 0] == colours[1, 1] == 1 or colours[0, 1] == colours[1, 0] == 1)


def spread(saturated: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels that a saturated sample (H, W) enters when the mosaic is interpolated."""
    return cv2.dilate(saturated.astype(np.uint8), FOOTPRINT, borderValue=0).astype(bool)


def _bayer(mosaic: NDArray[np.float32], colours: NDArray[np.integer]) -> NDArray[np.float32]:
    full = np.empty((*mosaic.shape, 3), np.float32)
    green, same_row, same_column, diagonal = (
        cv2.filter2D(mosaic, cv2.CV_32F, kernel) for kernel in (_GREEN, _SAME_ROW, _SAME_ROW.T, _DIAGONAL)
    )
    for row, column in np.ndindex(2, 2):
        site = np.s_[row::2, column::2]
        own = colours[row, column]
        full[site][..., own] = mosaic[site]
        if own == 1:
            full[site][..., colours[row, 1 - column]] = same_row[site]
            full[site][..., colours[1 - row, column]] = same_column[site]
        else:
            full[site][..., 1] = green[site]
            full[site][..., 2 - own] = diagonal[site]
    return full


def _normalised(mosaic: NDArray[np.float32], colours: NDArray[np.integer]) -> NDArray[np.float32]:
    """Tent-weighted mean of the samples of each colour around a pixel; the pixel's own colour is kept."""
    rows, columns = (-(-size // period) for size, period in zip(mosaic.shape, colours.shape, strict=True))
    sites = np.tile(colours, (rows, columns))[: mosaic.shape[0], : mosaic.shape[1]]
    planes = []
    for colour in range(3):
        here = (sites == colour).astype(np.float32)
        total = cv2.filter2D(mosaic * here, cv2.CV_32F, _TENT)
        weight = cv2.filter2D(here, cv2.CV_32F, _TENT)
        planes.append(np.where(here > 0, mosaic, total / np.maximum(weight, 1)))
    return np.stack(planes, axis=-1)
