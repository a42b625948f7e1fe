"""Diffuse models. GLSL counterparts: resources/shaders/brdf/."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.evaluate import channels, evaluate
from engine.core.directions import Vectors
from engine.core.params import Colour, check, param


@dataclass(frozen=True)
class Lambert:
    """f = albedo / π."""

    albedo: Colour = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Fraction of the light that is reflected.")

    isotropic: ClassVar[bool] = True
    reciprocal: ClassVar[bool] = True
    energy_conserving: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check(self)

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        return evaluate(lambda _wi, _wo: channels(self.albedo) / np.pi, wi, wo)


@dataclass(frozen=True)
class OrenNayar:
    """f = albedo/π (A + B max(0, cos Δφ) sin α tan β), the qualitative model of Oren1994.

    A = 1 − 0.5 σ²/(σ² + 0.33), B = 0.45 σ²/(σ² + 0.09), α and β the larger and the smaller polar angle. The angles
    cancel: cos Δφ sin α tan β is (wi_x wo_x + wi_y wo_y) / max(wi_z, wo_z), which is 0 at the normal, where Δφ is
    undefined, and needs no sine near it.
    """

    albedo: Colour = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Reflectance of the facets.")
    sigma_deg: float = param(30.0, 0.0, 90.0, unit="°", doc="Standard deviation of the facets' slope angle.")

    isotropic: ClassVar[bool] = True
    reciprocal: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check(self)

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

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        return evaluate(self._formula, wi, wo)

    def _formula(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        facing, retro = self.coefficients
        along = np.maximum(wi[0] * wo[0] + wi[1] * wo[1], 0.0) / np.maximum(wi[2], wo[2])
        return channels(self.albedo) * ((facing + retro * along) / np.pi)
