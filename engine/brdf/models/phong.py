"""The modified Phong model (Lewis1993) and Blinn–Phong, normalised. GLSL counterparts: resources/shaders/brdf/.

0⁰ is 1, as in numpy: exponent 0 makes Phong's lobe the constant ks / π.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from engine.brdf.models.evaluate import (
    diffuse_and_highlight,
    power_of_one_minus,
    reflects_no_more_than_it_receives,
    sum_of_directions,
)
from engine.brdf.models.model import Model
from engine.brdf.models.sampling import Lobes, grey
from engine.brdf.models.sampling_lobes import HalfVectorLobe, PowerHalfVectors, PowerLobe
from engine.core.params import Colour, param


@dataclass(frozen=True)
class Phong(Model):
    """f = kd/π + ks (n + 2)/(2π) max(0, r·wo)^n with r the mirror direction of wi (Lewis1993)."""

    name: ClassVar[str] = "phong"
    label: ClassVar[str] = "Phong"
    diffuse_parameter: ClassVar[str] = "kd"

    kd: Colour = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Diffuse reflectance.")
    ks: Colour = param((0.2, 0.2, 0.2), 0.0, 1.0, doc="Strength of the highlight.")
    exponent: float = param(20.0, 0.0, 1e6, doc="Sharpness of the highlight.", slider=(1.0, 1000.0), log=True)

    @property
    def energy_conserving(self) -> bool:
        """The lobe's albedo is ks at normal incidence and less elsewhere."""
        return reflects_no_more_than_it_receives(self.kd, self.ks)

    def sampling_lobes(self) -> Lobes:
        return [(PowerLobe(self.exponent), grey(self.ks))], grey(self.kd)

    def formula(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        """1 − r·wo is half the square of r − wo."""
        deficit = 0.5 * ((wi[0] + wo[0]) ** 2 + (wi[1] + wo[1]) ** 2 + (wi[2] - wo[2]) ** 2)
        lobe = (self.exponent + 2.0) / (2.0 * np.pi) * power_of_one_minus(deficit, self.exponent)
        return diffuse_and_highlight(self.kd, self.ks, lobe)


@dataclass(frozen=True)
class BlinnPhong(Model):
    """f = kd/π + ks (n + 2)(n + 4)/(8π (2^(−n/2) + n)) (n·h)^n."""

    name: ClassVar[str] = "blinn-phong"
    label: ClassVar[str] = "Blinn–Phong"
    diffuse_parameter: ClassVar[str] = "kd"

    kd: Colour = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Diffuse reflectance.")
    ks: Colour = param((0.2, 0.2, 0.2), 0.0, 1.0, doc="Strength of the highlight.")
    exponent: float = param(80.0, 0.0, 1e6, doc="Sharpness of the highlight.", slider=(1.0, 1000.0), log=True)

    @property
    def energy_conserving(self) -> bool:
        """The lobe's albedo is ks at normal incidence and less elsewhere."""
        return reflects_no_more_than_it_receives(self.kd, self.ks)

    @property
    def normalisation(self) -> float:
        n = self.exponent
        return (n + 2.0) * (n + 4.0) / (8.0 * np.pi * (2.0 ** (-n / 2.0) + n))

    def sampling_lobes(self) -> Lobes:
        facets = PowerHalfVectors(self.exponent, self.exponent)
        return [(HalfVectorLobe(facets), grey(self.ks))], grey(self.kd)

    def formula(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        _, _, deficit = sum_of_directions(wi, wo)
        return diffuse_and_highlight(self.kd, self.ks, self.normalisation * power_of_one_minus(deficit, self.exponent))
