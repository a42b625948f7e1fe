"""From a picture of linear radiance and coverage to what a person sees; the twin of resources/shaders/tonemap.frag."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.colour import OPERATORS, Operator, to_display8, tone_map


@dataclass(frozen=True)
class Display:
    """How linear radiance is shown: exposure in EV, tone mapping, and the display-linear colour behind the model."""

    exposure_ev: float = 0.0
    operator: Operator = "neutral"
    background: tuple[float, float, float] = (0.0123, 0.0123, 0.0123)

    def __post_init__(self) -> None:
        if self.operator not in OPERATORS or not -40.0 <= self.exposure_ev <= 40.0:
            raise ValueError(
                f"tone mapping {self.operator!r} or exposure {self.exposure_ev} EV (−40 … 40) is not possible"
            )


def displayed(picture: NDArray[np.float32], display: Display) -> NDArray[np.uint8]:
    """sRGB-coded uint8 (H, W, 3) of a picture (H, W, 4): radiance times coverage, and coverage."""
    coverage = picture[..., 3:]
    radiance = picture[..., :3] / np.where(coverage > 0.0, coverage, 1.0)
    shown = np.clip(tone_map(radiance, display.exposure_ev, display.operator), 0.0, 1.0)
    background = np.asarray(display.background, np.float32)
    return to_display8(shown * coverage + background * (1.0 - coverage))
