"""A colour chart in a photograph: OpenCV's module mcc finds its patches, in perspective and upside down.

Cost: a tenth of a second for the small image in which it is looked for.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.capture.chart.correction import ColourCorrection, fit_correction
from engine.core.colour import to_display8
from engine.images.encode import encode_png

#: Longest side of the image in which a chart is looked for.
_SIDE = 1000

#: Share of a patch that is measured, around its middle, and of clipped samples from which it does not count.
_INNER, _CLIPPED = 0.7, 0.02

#: Side of a crop of a patch in pixels, and what it shows over the patch.
_CROP_PX, _SHOWN = 48, 1.6


@dataclass(frozen=True, eq=False)
class Chart:
    """A chart that was found.

    Attributes
    ----------
    corners : (24, 4, 2) x and y of the corners of each patch in the photograph.
    colours : (24, 3) mean linear colour of each, NaN where it is clipped.
    """

    corners: NDArray[np.float64]
    colours: NDArray[np.float64]

    @property
    def positions(self) -> NDArray[np.float64]:
        """(24, 2) the middle of each patch."""
        middle: NDArray[np.float64] = self.corners.mean(axis=1)
        return middle


def find_chart(radiance: NDArray[np.float32], saturated: NDArray[np.bool_]) -> tuple[Chart, ColourCorrection] | None:
    """Find a classic chart of 24 patches in linear `radiance` (H, W, 3), and fit its colours; None without any.

    Patches whose colours no correction brings near those of a chart (a chessboard, another chart) are none.
    """
    height, width = saturated.shape
    scale = min(1.0, _SIDE / max(height, width))
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    small = cv2.resize(radiance, size, interpolation=cv2.INTER_AREA)
    bright = float(np.quantile(small.max(axis=-1), 0.995))
    if not bright > 0.0:
        return None
    detector = cv2.mcc.CCheckerDetector.create()
    detector.setColorChartType(cv2.mcc.MCC24)
    if not detector.process(np.ascontiguousarray(to_display8(small / bright)[..., ::-1]), 1):
        return None
    found = np.asarray(detector.getBestColorChecker().getColorCharts(), np.float64).reshape(-1, 4, 2)
    if len(found) != 24 or not np.isfinite(found).all():
        return None
    corners = (found + 0.5) * [width / size[0], height / size[1]] - 0.5
    chart = Chart(corners, _measure(radiance, saturated, corners))
    correction = fit_correction(chart.colours, chart.positions)
    if correction is None:
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        exposure = float(np.nanmedian(correction.measured / chart.colours))
    return chart, replace(correction, crops=tuple(_crop(radiance, patch, exposure) for patch in corners))


def _crop(radiance: NDArray[np.float32], corners: NDArray[np.float64], exposure: float) -> bytes:
    """A PNG of a patch with what is around it, upright as the chart lies, in display colours `exposure` times as
    bright."""
    middle = corners.mean(axis=0)
    around = (middle + _SHOWN * (corners - middle)).astype(np.float32)
    square = np.array([[0, 0], [_CROP_PX, 0], [_CROP_PX, _CROP_PX], [0, _CROP_PX]], np.float32) - np.float32(0.5)
    side = max(float(np.linalg.norm(around[1] - around[0])), float(np.linalg.norm(around[2] - around[1])))
    blur = 0.4 * side / _CROP_PX
    left, top = np.maximum(np.floor(around.min(axis=0)).astype(int) - 8, 0)
    right, bottom = np.ceil(around.max(axis=0)).astype(int) + 9
    part = np.ascontiguousarray(radiance[top:bottom, left:right] * np.float32(exposure))
    if 0 in part.shape:
        part, left, top = np.zeros((1, 1, 3), np.float32), 0, 0
    if blur > 0.5:
        part = cv2.GaussianBlur(part, (0, 0), blur)
    matrix = cv2.getPerspectiveTransform(around - np.array([left, top], np.float32), square)
    return encode_png(to_display8(cv2.warpPerspective(part, matrix, (_CROP_PX, _CROP_PX), flags=cv2.INTER_LINEAR)))


def _measure(
    radiance: NDArray[np.float32], saturated: NDArray[np.bool_], corners: NDArray[np.float64]
) -> NDArray[np.float64]:
    colours = np.full((len(corners), 3), np.nan)
    for at, patch in enumerate(corners):
        middle = patch.mean(axis=0)
        inner = (middle + _INNER * (patch - middle)).astype(np.float32)
        left, top = np.maximum(np.floor(inner.min(axis=0)).astype(int), 0)
        right, bottom = np.ceil(inner.max(axis=0)).astype(int) + 1
        part = radiance[top:bottom, left:right]
        if 0 in part.shape:
            continue
        mask = np.zeros(part.shape[:2], np.uint8)
        cv2.fillConvexPoly(mask, np.rint(inner - [left, top]).astype(np.int32), 1)
        inside = mask.astype(bool)
        if inside.sum() >= 4 and saturated[top:bottom, left:right][inside].mean() <= _CLIPPED:
            colours[at] = part[inside].mean(axis=0, dtype=np.float64)
    return colours
