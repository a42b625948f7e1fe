"""A complete BRDF model from outside the package: this file and `minnaert.glsl` beside it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from lightarc import Colour, Model, param

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Minnaert(Model):
    """f = albedo / π (cos θ_i cos θ_o)^(k − 1) for k >= 1 (Minnaert1941)."""

    name: ClassVar[str] = "minnaert"
    label: ClassVar[str] = "Minnaert"
    shader: ClassVar[Path | None] = Path(__file__).with_suffix(".glsl")
    energy_conserving: ClassVar[bool] = True

    albedo: Colour = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Fraction of the light that is reflected.")
    k: float = param(1.2, 1.0, 4.0, doc="Darkening towards the limb.")

    def formula(self, wi: Floats, wo: Floats) -> Floats:
        values: Floats = np.array(self.albedo)[:, None] / np.pi * (wi[2] * wo[2]) ** (self.k - 1.0)
        return values
