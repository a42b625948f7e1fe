"""Detail that photographs share: whether they show anything of the size of a pixel.

A surface has about as much detail in one octave as in the next, and so have its photographs in focus: simulated and
real ones have 0.6 to 1.5 times the variance in the finest octave that they have in the one above. Out of focus by a
Gaussian of 1.5 pixels it is 0.17 to 0.35. What photographs under different lights have in common is no noise, so that
noise does not pass for detail. A sample can be smooth as well; pixels cannot tell which it is.
Cost: 4 ms of one core a photograph.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.core.health import Finding, Verdict
from engine.core.side_by_side import list_side_by_side

#: Deviations in pixels of the Gaussians between which an octave of detail lies, from none at all on.
_SCALES = (0.0, 1.0, 2.0, 4.0, 8.0)

#: Variance of an octave over that of the two above it, below both of which it holds no detail, and the least variance
#: that counts, in units of the mean.
_OF_NEXT, _OF_SECOND, _LEAST = 0.4, 0.16, 1e-5


def about_detail(windows: Sequence[NDArray[np.float32]]) -> list[Finding]:
    """A note where photographs, of which `windows` (h, w) of luminance are the middle, show no fine detail.

    They must show the same pixels of the sample: a camera that moved takes fine detail away from what is in common.
    """
    size = find_finest(windows)
    if size is None or size == 1:
        return []
    text = (
        f"No photograph shows detail of less than {size} pixels: the sample is smooth there, or all are out of focus; "
        "stated errors do not count detail that is not seen"
    )
    return [Finding(Verdict.NOTE, text)]


def find_finest(windows: Sequence[NDArray[np.float32]]) -> int | None:
    """Size in pixels of the finest detail that photographs have in common: 1, 4, 8, or None where it is not told."""
    lit = [window / window.mean(dtype=np.float64) for window in windows if window.size and window.mean() > 1e-4]
    if len(lit) < 2 or min(lit[0].shape) < 4 * _SCALES[-1]:
        return None
    bands = zip(*list_side_by_side(_take_apart, lit), strict=True)
    octaves = [_compare(np.stack(each)) for each in bands]
    for size, fine, above, second in zip((1, 4), octaves, octaves[1:], octaves[2:], strict=False):
        if second < _LEAST:
            return None
        if fine >= _OF_NEXT * above or fine >= _OF_SECOND * second:
            return size
    return 8


def _take_apart(window: NDArray[np.floating]) -> list[NDArray[np.float64]]:
    """The octaves of an image, flat."""
    import cv2

    levels = [np.asarray(window, np.float64)]
    levels += [cv2.GaussianBlur(levels[0], (0, 0), scale) for scale in _SCALES[1:]]
    return [(fine - coarse).ravel() for fine, coarse in itertools.pairwise(levels)]


def _compare(bands: NDArray[np.float64]) -> float:
    """The mean covariance of images (N, n) with each other, less what chance makes of their variances."""
    covariance = np.atleast_2d(np.cov(bands))
    deviation = np.sqrt(np.diag(covariance))
    by_chance = np.outer(deviation, deviation) / np.sqrt(bands.shape[1])
    pairs = np.triu_indices(len(bands), 1)
    return float(np.maximum(np.abs(covariance) - by_chance, 0.0)[pairs].mean())
