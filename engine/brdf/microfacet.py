"""Microfacet models. GLSL twins: resources/shaders/brdf/."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from engine.brdf.diffuse import above_horizon
from engine.directions import Vectors, dot
from engine.params import Colour, check, param


@dataclass(frozen=True)
class Ggx:
    """f = kd/π + F D G₂/(4 n·l n·v): Walter et al. 2007 with Schlick's Fresnel term and Smith's height-correlated G₂.

    `alpha` is the width itself, not its root. D is written α²/(π (sin²θ_h + α² cos²θ_h)²) and G₂ over the four
    cosines (Heitz 2014) so that neither cancels at small alpha or at the horizon; h·wi is |wi + wo| / 2, which does not
    change when the two are exchanged.
    """

    kd: Colour = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Diffuse reflectance.")
    alpha: float = param(0.3, 1e-4, 1.0, doc="Width of the highlight.", slider=(0.02, 1.0), log=True)
    f0: Colour = param((0.04, 0.04, 0.04), 0.0, 1.0, doc="Reflectance at normal incidence.")

    isotropic: ClassVar[bool] = True
    reciprocal: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check(self)

    @property
    def energy_conserving(self) -> bool:
        """The specular part alone is; a diffuse part beside it exceeds 1 towards grazing, where F goes to 1."""
        return not any(self.kd)

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        wi, wo, visible = above_horizon(wi, wo)
        wi = np.where(visible[..., None], wi, (0.0, 0.0, 1.0))
        wo = np.where(visible[..., None], wo, (0.0, 0.0, 1.0))
        alpha2 = self.alpha**2
        half = wi + wo
        length = np.sqrt(dot(half, half))
        half = half / length[..., None]
        width = half[..., 0] ** 2 + half[..., 1] ** 2 + alpha2 * half[..., 2] ** 2
        distribution = alpha2 / (np.pi * width**2)
        visibility = 0.5 / (wi[..., 2] * _slope_length(wo, alpha2) + wo[..., 2] * _slope_length(wi, alpha2))
        grazing = np.maximum(1.0 - 0.5 * length, 0.0)
        fresnel = np.asarray(self.f0) + (1.0 - np.asarray(self.f0)) * (grazing**5)[..., None]
        value = np.asarray(self.kd) / np.pi + fresnel * (distribution * visibility)[..., None]
        return np.where(visible[..., None], value, 0.0)


def _slope_length(direction: Vectors, alpha2: float) -> np.ndarray:
    """√(cos²θ + α² sin²θ)."""
    x, y, z = np.moveaxis(direction, -1, 0)
    return np.sqrt(z * z + alpha2 * (x * x + y * y))
