"""What the cost model said of a setting beforehand, held against what was then measured.

A figure is compared where both numbers are above 0: the model says nothing of a bake that a mode does not have.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from engine.tradeoff.point import Point

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


def compared(points: Sequence[Point]) -> list[Miss]:
    """Every figure that was predicted and measured, the worst first."""
    found = [
        Miss(point, name, float(value), float(getattr(point, name)))
        for point in points
        for name, value in point.predicted.items()
        if value > 0.0 and getattr(point, name) > 0.0
    ]
    return sorted(found, key=lambda each: -each.factor)


def checked(points: Sequence[Point]) -> dict[str, Any]:
    """How many figures came out within `FACTOR`, and the misses, the worst first, as JSON."""
    found = compared(points)
    outside = [each.as_json() for each in found if not each.is_within]
    return {"compared": len(found), "within": len(found) - len(outside), "factor": FACTOR, "misses": outside}


def predicted_json(predicted: Mapping[str, float]) -> dict[str, float | None]:
    """`predicted_frame_s` and so on; None where nothing was said."""
    return {f"predicted_{name}": predicted.get(name) for name in FIGURES}
