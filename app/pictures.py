"""Pictures for the screen, made off the window's thread: 8-bit levels of half size each, and marks on clipped texels.

A view draws the level nearest to its zoom, so that painting costs the pixels on the screen and not those of the
photograph. Work goes in bands of rows, so that memory stays small beside the photograph itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QImage

from engine.colour import to_display8, tone_map
from engine.steps import Step, Steps

BAND_PIXELS = 2**19
SMALLEST = 512

#: Premultiplied BGRA of a clipped texel: Okabe and Ito's vermillion, opaque.
CLIPPED = np.array([0, 94, 213, 255], np.uint8)


@dataclass(frozen=True, eq=False)
class Picture:
    """Levels from full size downwards, each half of the one before; `marks` has the same sizes or is empty."""

    levels: tuple[QImage, ...]
    marks: tuple[QImage, ...] = ()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels of the full picture."""
        return self.levels[0].width(), self.levels[0].height()

    @property
    def bytes(self) -> int:
        """How much memory the picture takes."""
        return sum(image.sizeInBytes() for image in (*self.levels, *self.marks))


def photograph(
    radiance: NDArray[np.float32], saturated: NDArray[np.bool_] | None = None, exposure_ev: float = 0.0
) -> Steps[Picture]:
    """The picture of linear radiance (H, W, 3), sRGB-coded; clipped texels of (H, W) `saturated` are marked."""
    height, width = radiance.shape[:2]
    coded = np.empty((height, width, 3), np.uint8)
    rows = max(1, BAND_PIXELS // width)
    for start in range(0, height, rows):
        band = np.asarray(radiance[start : start + rows])
        coded[start : start + rows] = to_display8(tone_map(band, exposure_ev, "none"))
        yield Step(min(1.0, (start + rows) / height), "preparing the picture")
    marks: tuple[QImage, ...] = ()
    if saturated is not None and saturated.any():
        marks = tuple(_mark_image(level) for level in _halved_marks(np.asarray(saturated, np.uint8)))
    return Picture(tuple(rgb_image(level) for level in _halved(coded)), marks)


def scalar_map(values: NDArray[np.float32], high: float, table: NDArray[np.uint8]) -> Steps[Picture]:
    """The picture of (H, W) values in [0, high] through a colour `table` (256, 3)."""
    yield Step(0.0, "preparing the map")
    index = np.clip(np.nan_to_num(values) * (255.0 / max(high, 1e-30)), 0, 255).astype(np.uint8)
    return Picture(tuple(rgb_image(level) for level in _halved(table[index])))


def rgb_image(pixels: NDArray[np.uint8]) -> QImage:
    """A QImage that owns a copy of (H, W, 3) uint8."""
    height, width = pixels.shape[:2]
    contiguous = np.ascontiguousarray(pixels)
    return QImage(contiguous.data, width, height, 3 * width, QImage.Format.Format_RGB888).convertToFormat(
        QImage.Format.Format_RGB32
    )


def _halved(pixels: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    levels = [pixels]
    while max(levels[-1].shape[:2]) > SMALLEST:
        height, width = levels[-1].shape[:2]
        size = (max(1, width // 2), max(1, height // 2))
        levels.append(np.asarray(cv2.resize(levels[-1], size, interpolation=cv2.INTER_AREA), np.uint8))
    return levels


def _halved_marks(mask: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    """A mark survives every halving, so that a single clipped texel is seen in the fitted picture."""
    levels = [mask]
    while max(levels[-1].shape[:2]) > SMALLEST:
        height, width = (size // 2 * 2 for size in levels[-1].shape)
        even = levels[-1][: max(2, height), : max(2, width)]
        levels.append(even.reshape(height // 2, 2, width // 2, 2).max(axis=(1, 3)))
    return levels


def _mark_image(mask: NDArray[np.uint8]) -> QImage:
    pixels = np.ascontiguousarray(mask[:, :, None] * CLIPPED)
    height, width = mask.shape
    return QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_ARGB32_Premultiplied).copy()
