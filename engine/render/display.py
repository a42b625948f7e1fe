"""From an image of linear radiance and coverage to what a user sees; the counterpart of
resources/shaders/tonemap.frag."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.colour import OPERATORS, Operator, srgb_decode, srgb_encode, to_display8, tone_map
from engine.core.errors import UsageError

#: The ends of the scale of a signed difference, after Okabe and Ito, and its middle, sRGB-coded.
BLUE, ORANGE, GREY = (0.0, 0.447, 0.698), (0.902, 0.624, 0.0), (0.86, 0.86, 0.86)


@dataclass(frozen=True)
class Display:
    """Display of linear radiance: exposure in EV, tone mapping, and the display-linear colour behind the model."""

    exposure_ev: float = 0.0
    operator: Operator = "neutral"
    background: tuple[float, float, float] = (0.0123, 0.0123, 0.0123)

    def __post_init__(self) -> None:
        if self.operator not in OPERATORS or not -40.0 <= self.exposure_ev <= 40.0:
            raise UsageError(
                f"tone mapping {self.operator!r} or exposure {self.exposure_ev} EV (−40 … 40) is not possible"
            )


def display(image: NDArray[np.float32], display: Display) -> NDArray[np.uint8]:
    """sRGB-coded uint8 (H, W, 3) of an image (H, W, 4): radiance times coverage, and coverage."""
    coverage = image[..., 3:]
    background = np.asarray(display.background, np.float32)
    return to_display8(_show(image, display) * coverage + background * (1.0 - coverage))


def display_apart(image: NDArray[np.float32], display: Display) -> NDArray[np.uint8]:
    """sRGB-coded uint8 (H, W, 4) of an image without what is behind it: its own colour, and coverage as opacity."""
    opacity = np.round(255.0 * np.clip(image[..., 3:], 0.0, 1.0)).astype(np.uint8)
    return np.concatenate([to_display8(_show(image, display)), opacity], axis=-1)


def _show(image: NDArray[np.float32], display: Display) -> NDArray[np.float32]:
    """The display-linear colour of what covers each pixel, as if it covered all of it."""
    coverage = image[..., 3:]
    with np.errstate(over="ignore"):
        radiance = image[..., :3] / np.where(coverage > 0.0, coverage, 1.0)
    return np.clip(tone_map(radiance, display.exposure_ev, display.operator), 0.0, 1.0)


def diverging(share: ArrayLike) -> NDArray[np.uint8]:
    """(..., 3) uint8 of shares in [−1, 1] of a scale, cut off beyond; what is not a number is grey as 0 is."""
    share = np.clip(np.nan_to_num(np.asarray(share, np.float64)), -1.0, 1.0)[..., None]
    grey = srgb_decode(list(GREY))
    far = np.where(share < 0.0, srgb_decode(list(BLUE)), srgb_decode(list(ORANGE)))
    return np.asarray(np.round(255.0 * srgb_encode(grey + np.abs(share) * (far - grey))), np.uint8)
