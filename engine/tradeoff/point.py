"""One setting, measured on one scene: how far its image is from the reference, and what it takes.

Costs that the cost model predicted for a setting, compared with the measured ones.

A figure is compared where both numbers are above 0: the model says nothing of a bake that a mode does not have.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from engine.planning.costs.setting import Setting
from engine.scene.mode import Number

#: A prediction within this factor of what is measured is right (spec 05).
FACTOR = 1.5

#: The figures of a point that are predicted.
FIGURES = ("frame_s", "relight_s", "bake_s", "size_bytes")


@dataclass(frozen=True)
class Miss:
    """A figure of a point that was predicted: `factor` ≥ 1 is the larger of both over the smaller."""

    point: Point
    figure: str
    predicted: float
    measured: float

    @property
    def factor(self) -> float:
        return math.exp(abs(math.log(self.predicted / self.measured)))

    @property
    def is_within(self) -> bool:
        return self.factor <= FACTOR

    def as_json(self) -> dict[str, Any]:
        figures = {"figure": self.figure, "predicted": self.predicted, "measured": self.measured}
        return {**self.point.setting.as_json(), **figures, "factor": self.factor}


def compare_with(points: Sequence[Point]) -> list[Miss]:
    """Every figure that was predicted and measured, the worst first."""
    found = [
        Miss(point, name, float(value), float(getattr(point, name)))
        for point in points
        for name, value in point.predicted.items()
        if value > 0.0 and getattr(point, name) > 0.0
    ]
    return sorted(found, key=lambda each: -each.factor)


def check(points: Sequence[Point]) -> dict[str, Any]:
    """Number of figures within `FACTOR`, and the misses, the worst first, as JSON."""
    found = compare_with(points)
    outside = [each.as_json() for each in found if not each.is_within]
    return {"compared": len(found), "within": len(found) - len(outside), "factor": FACTOR, "misses": outside}


def encode_prediction(predicted: Mapping[str, float]) -> dict[str, float | None]:
    """`predicted_frame_s` and so on; None where nothing was said."""
    return {f"predicted_{name}": predicted.get(name) for name in FIGURES}


#: Costs of a setting, the name of each figure in JSON, and its label beside an axis.
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
    """Errors and costs of a setting; ValueError for figures that are not finite numbers from 0.

    Attributes
    ----------
    error_rmse_rel : relative RMSE of linear radiance against the reference, without the noise of the reference.
    error_flip : mean ꟻLIP against it, in [0, 1].
    error_uncertainty : `error_rmse_rel` is right within ± this in 95 % of all cases.
    frame_s : a frame from another camera; relight_s : what comes before it under a rotated environment; bake_s :
        what comes before any of it, from the model and the BRDF on.
    memory_bytes : held while frames are drawn, beside the model; size_bytes : of the file that keeps the bake.
    another_s : a bake of another BRDF on the same model, whose visibility is kept; None where that takes no bake.
    predicted : what the cost model said beforehand of some of these (`engine.tradeoff.point.FIGURES`).
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
    another_s: float | None = None

    def __post_init__(self) -> None:
        for name in _FIGURES:
            value = getattr(self, name)
            if not (isinstance(value, int | float) and math.isfinite(value) and value >= 0):
                raise ValueError(f"{name} = {value!r} is not a number from 0")
        if self.another_s is not None and not 0.0 <= self.another_s < math.inf:
            raise ValueError(f"another_s = {self.another_s!r} is not a number from 0")
        strange = [name for name in self.predicted if name not in FIGURES]
        if strange or not all(isinstance(x, int | float) and 0 <= x < math.inf for x in self.predicted.values()):
            raise ValueError(f"{dict(self.predicted)} are not predicted figures")
        object.__setattr__(self, "predicted", MappingProxyType(dict(self.predicted)))

    @property
    def mode(self) -> str:
        return self.setting.mode

    @property
    def parameters(self) -> Mapping[str, Number]:
        return self.setting.parameters

    def cost(self, axis: str) -> float:
        """Seconds or bytes on one of the axes of `COSTS`."""
        return float(getattr(self, COSTS[axis][0]))

    def as_json(self) -> dict[str, Any]:
        figures = {name: getattr(self, name) for name in _FIGURES}
        figures["another_brdf_s"] = self.another_s
        return {**self.setting.as_json(), **figures, **encode_prediction(self.predicted)}
