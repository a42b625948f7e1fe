"""The modified Phong model (Lewis 1993) and Blinn–Phong, normalised. GLSL twins: resources/shaders/brdf/.

Both raise a cosine to a power. The cosine c near 1 is what matters at high exponents, and there 1 − c is known far
better than c; so the power is taken as exp(n log1p(−(1 − c))) with 1 − c from differences of components. For unit
vectors this is the printed formula; the relative error stays near (2 + n |ln c|) u. 0⁰ is 1, as in numpy: exponent 0
makes Phong's lobe the constant ks / π.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.diffuse import above_horizon
from engine.directions import Vectors
from engine.params import Colour, check, param


def power_of_one_minus(deficit: NDArray[np.float64], exponent: float) -> NDArray[np.float64]:
    """max(0, 1 − deficit)^exponent for deficit >= 0, with 0⁰ = 1."""
    if exponent == 0.0:
        return np.ones_like(deficit)
    positive = deficit < 1.0
    return np.where(positive, np.exp(exponent * np.log1p(-np.where(positive, deficit, 0.0))), 0.0)


def _reflects_no_more_than_it_receives(kd: Colour, ks: Colour) -> bool:
    return all(diffuse + specular <= 1.0 for diffuse, specular in zip(kd, ks, strict=True))


@dataclass(frozen=True)
class Phong:
    """f = kd/π + ks (n + 2)/(2π) max(0, r·wo)^n with r the mirror direction of wi (Lewis 1993)."""

    kd: Colour = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Diffuse reflectance.")
    ks: Colour = param((0.2, 0.2, 0.2), 0.0, 1.0, doc="Strength of the highlight.")
    exponent: float = param(20.0, 0.0, 1e6, doc="Sharpness of the highlight.", slider=(1.0, 1000.0), log=True)

    isotropic: ClassVar[bool] = True
    reciprocal: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check(self)

    @property
    def energy_conserving(self) -> bool:
        """The lobe's albedo is ks at normal incidence and less elsewhere."""
        return _reflects_no_more_than_it_receives(self.kd, self.ks)

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        wi, wo, visible = above_horizon(wi, wo)
        difference = wi * (-1.0, -1.0, 1.0) - wo
        lobe = power_of_one_minus(0.5 * np.sum(difference**2, axis=-1), self.exponent)
        lobe *= (self.exponent + 2.0) / (2.0 * np.pi)
        value = np.asarray(self.kd) / np.pi + np.asarray(self.ks) * lobe[..., None]
        return np.where(visible[..., None], value, 0.0)


@dataclass(frozen=True)
class BlinnPhong:
    """f = kd/π + ks (n + 2)(n + 4)/(8π (2^(−n/2) + n)) (n·h)^n."""

    kd: Colour = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Diffuse reflectance.")
    ks: Colour = param((0.2, 0.2, 0.2), 0.0, 1.0, doc="Strength of the highlight.")
    exponent: float = param(80.0, 0.0, 1e6, doc="Sharpness of the highlight.", slider=(1.0, 1000.0), log=True)

    isotropic: ClassVar[bool] = True
    reciprocal: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check(self)

    @property
    def energy_conserving(self) -> bool:
        """The lobe's albedo is ks at normal incidence and less elsewhere."""
        return _reflects_no_more_than_it_receives(self.kd, self.ks)

    @property
    def normalisation(self) -> float:
        n = self.exponent
        return (n + 2.0) * (n + 4.0) / (8.0 * np.pi * (2.0 ** (-n / 2.0) + n))

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        wi, wo, visible = above_horizon(wi, wo)
        sum_of_both = np.where(visible[..., None], wi + wo, (0.0, 0.0, 1.0))
        across = sum_of_both[..., 0] ** 2 + sum_of_both[..., 1] ** 2
        length = np.sqrt(across + sum_of_both[..., 2] ** 2)
        lobe = power_of_one_minus(across / (length * (length + sum_of_both[..., 2])), self.exponent)
        lobe *= self.normalisation
        value = np.asarray(self.kd) / np.pi + np.asarray(self.ks) * lobe[..., None]
        return np.where(visible[..., None], value, 0.0)
