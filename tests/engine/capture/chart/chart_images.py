"""Photographs of a colour chart, drawn: illuminants, a camera's own colours, perspective, vignetting and noise."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from engine.capture.chart.reference import REFERENCE_RGB

#: Linear Rec. 709 of a white under illuminant A, D50 and a cold LED, before any white balance.
ILLUMINANTS = {"A": (1.55, 0.92, 0.35), "D50": (1.12, 0.99, 0.76), "LED": (0.85, 1.0, 1.25)}

#: What a camera sees of linear Rec. 709: its channels overlap.
CAMERA = np.array([[0.70, 0.25, 0.05], [0.12, 0.78, 0.10], [0.03, 0.22, 0.75]])

_PATCH, _GAP = 80, 12


def flat_chart(colours: Any = REFERENCE_RGB) -> Any:
    """The chart from the front, linear, with a black frame, 4 rows of 6 patches."""
    step = _PATCH + _GAP
    chart = np.full((4 * step + 3 * _GAP, 6 * step + 3 * _GAP, 3), 0.03)
    for at, colour in enumerate(colours):
        top, left = 2 * _GAP + at // 6 * step, 2 * _GAP + at % 6 * step
        chart[top : top + _PATCH, left : left + _PATCH] = colour
    return chart


def photograph(
    rng: np.random.Generator,
    illuminant: str = "D50",
    colours: Any = REFERENCE_RGB,
    side: int = 700,
    noise: float = 0.004,
) -> Any:
    """Linear camera colours (H, W, 3) of a chart on a grey, structured ground, and its corners in the image (4, 2)."""
    chart = flat_chart(colours)
    height, width = round(side * 0.75), side
    ground = cv2.resize(
        rng.uniform(0.1, 0.35, (height // 8, width // 8)), (width, height), interpolation=cv2.INTER_CUBIC
    )
    image = np.repeat(ground[..., None], 3, axis=2) * rng.uniform(0.8, 1.1, 3)
    size = rng.uniform(0.45, 0.8) * width
    angle, (h, w) = rng.uniform(-np.pi, np.pi), chart.shape[:2]
    if size * np.hypot(1, h / w) > 0.98 * height:
        angle = rng.uniform(-0.25, 0.25) + rng.choice([0, np.pi])
        size = min(size, 0.85 * height * w / h * 0.9)
    box = np.array([[-1, -h / w], [1, -h / w], [1, h / w], [-1, h / w]]) * size / 2
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    corners = box @ turn.T + rng.uniform(-0.07, 0.07, (4, 2)) * size / 2 + np.array([width, height]) / 2
    corners += np.clip(4 - corners.min(axis=0), 0, None) - np.clip(
        corners.max(axis=0) - [width - 5, height - 5], 0, None
    )
    source = np.array([[0, 0], [w, 0], [w, h], [0, h]], np.float32)
    warp = cv2.getPerspectiveTransform(source, corners.astype(np.float32))
    laid = cv2.warpPerspective(chart, warp, (width, height), flags=cv2.INTER_AREA)
    mask = cv2.warpPerspective(np.ones((h, w)), warp, (width, height))[..., None]
    image = image * (1 - mask) + laid * mask
    y, x = np.mgrid[:height, :width] / width - [[[0.5 * height / width]], [[0.5]]]
    vignetting = 1.0 - rng.uniform(0.2, 0.8) * (x**2 + y**2) + rng.uniform(-0.15, 0.15) * x
    seen = (image * ILLUMINANTS[illuminant] * vignetting[..., None]) @ CAMERA.T * rng.uniform(0.35, 0.6)
    seen += rng.normal(0, noise, seen.shape) * np.sqrt(np.maximum(seen, 0.01))
    return seen.astype(np.float32), corners
