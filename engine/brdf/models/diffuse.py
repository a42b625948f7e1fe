"""Diffuse models. GLSL counterparts: resources/shaders/brdf/."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from engine.brdf.models.evaluate import channels
from engine.brdf.models.model import Model
from engine.brdf.models.sampling import Lobes
from engine.core.params import Colour, param


@dataclass(frozen=True)
class Lambert(Model):
    """f = albedo / π."""

    name: ClassVar[str] = "lambert"
    label: ClassVar[str] = "Lambert"
    diffuse_parameter: ClassVar[str] = "albedo"

    albedo: Colour = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Fraction of the light that is reflected.")

    energy_conserving: ClassVar[bool] = True

    def sampling_lobes(self) -> Lobes:
        return [], 1.0

    def formula(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        return channels(self.albedo) / np.pi


@dataclass(frozen=True)
class OrenNayar(Model):
    """f = albedo/π (A + B max(0, cos Δφ) sin α tan β), the qualitative model of Oren1994.

    A = 1 − 0.5 σ²/(σ² + 0.33), B = 0.45 σ²/(σ² + 0.09), α and β the larger and the smaller polar angle. The angles
    cancel: cos Δφ sin α tan β is (wi_x wo_x + wi_y wo_y) / max(wi_z, wo_z), which is 0 at the normal, where Δφ is
    undefined, and needs no sine near it.
    """

    name: ClassVar[str] = "oren-nayar"
    label: ClassVar[str] = "Oren–Nayar"

    albedo: Colour = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Reflectance of the facets.")
    sigma_deg: float = param(30.0, 0.0, 90.0, unit="°", doc="Standard deviation of the facets' slope angle.")

    @property
    def energy_conserving(self) -> bool:
        """The albedo is largest, albedo (A + B/2), at grazing; small roughness takes that above the facets' own."""
        facing, retro = self.coefficients
        return max(self.albedo) * max(facing, facing + 0.5 * retro) <= 1.0

    @property
    def coefficients(self) -> tuple[float, float]:
        """A and B."""
        variance = np.radians(self.sigma_deg) ** 2
        return float(1.0 - 0.5 * variance / (variance + 0.33)), float(0.45 * variance / (variance + 0.09))

    def sampling_lobes(self) -> Lobes:
        return [], 1.0

    def formula(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        facing, retro = self.coefficients
        along = np.maximum(wi[0] * wo[0] + wi[1] * wo[1], 0.0) / np.maximum(wi[2], wo[2])
        return channels(self.albedo) * ((facing + retro * along) / np.pi)
