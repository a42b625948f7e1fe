"""Signed differences as colours: orange where an image is brighter than its reference, blue where it is darker."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.colour import luminance
from engine.render.display import diverging

Pixels = NDArray[np.uint8]

#: The share of the largest differences that is cut off at the ends of the scale.
CUT = 0.005

#: The least difference that a scale ends at.
MINIMUM = 1e-6

_STRIP, _BAR, _EDGE = 56, 12, 12
_FIELD, _INK = (36, 36, 36), (222, 222, 222)


def compute_signed_difference(a: NDArray[Any], b: NDArray[Any]) -> tuple[NDArray[np.float64], float]:
    """Luminance (H, W) of `a` less that of `b`, images (H, W, 3) of linear light, and a round scale for it."""
    apart = np.asarray(luminance(np.asarray(a, np.float64)) - luminance(np.asarray(b, np.float64)), np.float64)
    return apart, scale_of(apart)


def scale_of(apart: ArrayLike) -> float:
    """1, 2 or 5 times a power of ten that all but `CUT` of the differences (those that are not 0) keep below."""
    size = np.abs(np.asarray(apart, np.float64))
    size = size[np.isfinite(size) & (size > 0.0)]
    value = float(np.quantile(size, 1.0 - CUT)) if size.size else 0.0
    if not value > MINIMUM:
        return MINIMUM
    decade = 10.0 ** np.floor(np.log10(value))
    return float(next(step * decade for step in (1.0, 2.0, 5.0, 10.0) if step * decade >= value * (1.0 - 1e-9)))


def label(apart: NDArray[np.float64], scale: float) -> Pixels:
    """The image of differences (H, W) at full colour at ±`scale`, and under it the scale as a bar with figures.

    It is at least 256 pixels wide.
    """
    height, width = apart.shape
    whole = np.full((height + _STRIP, max(width, 256), 3), _FIELD, np.uint8)
    left = (whole.shape[1] - width) // 2
    whole[:height, left : left + width] = diverging(apart / scale)
    bar = slice(height + _EDGE, height + _EDGE + _BAR), slice(_EDGE, whole.shape[1] - _EDGE)
    whole[bar] = diverging(np.linspace(-1.0, 1.0, whole[bar].shape[1]))
    for share, words in ((0.0, f"−{scale:g}"), (0.5, "luminance, A − B"), (1.0, f"+{scale:g}")):
        _write(whole, words, share)
    return whole


def _write(whole: Pixels, words: str, share: float) -> None:
    """Set `words` under the bar; `share` 0, 0.5 or 1 is where, and the part of them that is left of that place."""
    face = cv2.FontFace("sans")
    wide = cv2.getTextSize((0, 0), words, (0, 0), face, 15, 400)[2]
    x = _EDGE + share * (whole.shape[1] - 2 * _EDGE) - share * wide
    cv2.putText(whole, words, (round(x), whole.shape[0] - 12), _INK, face, 15, 400)
