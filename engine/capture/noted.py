"""Small things that are kept of a photograph: enough to judge it and to calibrate the rig without its pixels.

Cost: 24 megapixels take 0.1 s on one thread, most of it for the image that alignment compares.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.capture.registration.texture import Grey, reduce, reduction
from engine.capture.report import middle, noise_and_sharpness, window_of
from engine.core.colour import LUMINANCE

_THUMBNAIL_SIDE = 256


@dataclass(frozen=True, eq=False)
class Noted:
    """A photograph in small.

    Attributes
    ----------
    noise_and_sharpness : those of its middle (`engine.capture.report`).
    window : (h, w) luminance of the middle, where noise is told from detail.
    thumbnail, clipped : (h, w, 3) linear light and (h, w) share of clipped pixels, at most 256 pixels a side.
    grey : luminance at the size at which photographs are compared, None where nothing is aligned.
    """

    noise_and_sharpness: tuple[float, float]
    window: NDArray[np.float32]
    thumbnail: NDArray[np.float32]
    clipped: NDArray[np.float32]
    grey: Grey | None


def note(radiance: NDArray[np.float32], saturated: NDArray[np.bool_], *, with_grey: bool = True) -> Noted:
    """Note the small things of a photograph with this radiance (H, W, 3), `saturated` (H, W)."""
    luminance = luminance_of(middle(radiance))
    grey = reduce_luminance(radiance) if with_grey else None
    return Noted(noise_and_sharpness(luminance), window_of(luminance), small(radiance), small(saturated), grey)


def luminance_of(radiance: NDArray[np.float32]) -> Grey:
    """The luminance (H, W) of linear light (H, W, 3)."""
    luminance = radiance[..., 0] * np.float32(LUMINANCE[0])
    for channel in (1, 2):
        luminance += radiance[..., channel] * np.float32(LUMINANCE[channel])
    return luminance


def reduce_luminance(radiance: NDArray[np.float32]) -> Grey:
    """The luminance of an image at the size at which photographs are compared."""
    return luminance_of(reduce(radiance, reduction(*radiance.shape[:2])))


def small(radiance: NDArray[np.float32] | NDArray[np.bool_]) -> NDArray[np.float32]:
    """An image of at most `_THUMBNAIL_SIDE`, from some four samples to a pixel along each side; shares of a mask."""
    height, width = radiance.shape[:2]
    scale = min(1.0, _THUMBNAIL_SIDE / max(height, width))
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    step = max(1, math.floor(0.25 / scale))
    some = np.ascontiguousarray(radiance[::step, ::step], np.float32)
    return cv2.resize(some, size, interpolation=cv2.INTER_AREA)
