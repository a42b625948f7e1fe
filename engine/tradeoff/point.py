"""One setting, measured on one scene: how far its picture is from the reference, and what it takes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from engine.effects.setting import Number, Setting
from engine.tradeoff.prediction import FIGURES, predicted_json

#: What a setting can cost, the name of the figure in JSON, and what it is called beside an axis.
COSTS: Mapping[str, tuple[str, str]] = {
    "frame": ("frame_s", "Time of a frame"),
    "relight": ("relight_s", "Time to relight"),
    "bake": ("bake_s", "Time to bake"),
    "memory": ("memory_bytes", "Memory"),
}

#: Figures of a point that have to be numbers from 0.
_FIGURES = (
    "error_rmse_rel",
    "error_flip",
    "error_uncertainty",
    "frame_s",
    "relight_s",
    "bake_s",
    "memory_bytes",
    "size_bytes",
)


@dataclass(frozen=True)
class Point:
    """What a setting gives and takes; ValueError for figures that are not finite numbers from 0.

    Attributes
    ----------
    error_rmse_rel : relative RMSE of linear radiance against the reference, without the noise of the reference.
    error_flip : mean ꟻLIP against it, in [0, 1].
    error_uncertainty : `error_rmse_rel` is right within ± this in 95 % of all cases.
    frame_s : a frame from another camera; relight_s : what comes before it under a turned light; bake_s : what comes
        before any of it, from the model and the reflectance on.
    memory_bytes : held while frames are drawn, beside the model; size_bytes : of the file that keeps the bake.
    predicted : what the cost model said beforehand of some of these (`engine.tradeoff.prediction.FIGURES`).
    """

    setting: Setting
    error_rmse_rel: float
    error_flip: float
    error_uncertainty: float
    frame_s: float
    relight_s: float
    bake_s: float
    memory_bytes: int
    size_bytes: int
    predicted: Mapping[str, float] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        for name in _FIGURES:
            value = getattr(self, name)
            if not (isinstance(value, int | float) and math.isfinite(value) and value >= 0):
                raise ValueError(f"{name} = {value!r} is not a number from 0")
        strange = [name for name in self.predicted if name not in FIGURES]
        if strange or not all(isinstance(x, int | float) and 0 <= x < math.inf for x in self.predicted.values()):
            raise ValueError(f"{dict(self.predicted)} are no predicted figures")
        object.__setattr__(self, "predicted", MappingProxyType(dict(self.predicted)))

    @property
    def mode(self) -> str:
        return self.setting.mode

    @property
    def knobs(self) -> Mapping[str, Number]:
        return self.setting.knobs

    def cost(self, axis: str) -> float:
        """Seconds or bytes on one of the axes of `COSTS`."""
        return float(getattr(self, COSTS[axis][0]))

    def as_json(self) -> dict[str, Any]:
        figures = {name: getattr(self, name) for name in _FIGURES}
        return {**self.setting.as_json(), **figures, **predicted_json(self.predicted)}
