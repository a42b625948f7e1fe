"""The anisotropic Phong model of Ashikhmin and Shirley. GLSL twin: resources/shaders/brdf/ashikhmin-shirley.glsl."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.evaluate import channels, evaluate
from engine.brdf.highlight import power_of_one_minus, schlick, sum_of_directions
from engine.directions import Vectors
from engine.params import Colour, check, param


@dataclass(frozen=True)
class AshikhminShirley:
    """Highlight and diffuse part share the light (Ashikhmin and Shirley 2000).

    f = √((nu+1)(nv+1))/(8π) (n·h)^e / ((h·wi) max(n·l, n·v)) (ks + (1−ks)(1−h·wi)⁵)
        + 28 kd/(23π) (1−ks) (1−(1−n·l/2)⁵) (1−(1−n·v/2)⁵), with e = (nu hx² + nv hy²)/(1 − hz²).

    1 − hz² is hx² + hy², which does not cancel; e is undefined at h = n, where n·h = 1 and the power is 1 whatever
    e is. 1 − (1−y)⁵ is a polynomial in y without cancellation.
    """

    kd: Colour = param((0.5, 0.5, 0.5), 0.0, 1.0, doc="Diffuse reflectance under the highlight.")
    ks: Colour = param((0.05, 0.05, 0.05), 0.0, 1.0, doc="Reflectance of the highlight at normal incidence.")
    nu: float = param(100.0, 0.0, 1e6, doc="Sharpness along the tangent.", slider=(1.0, 1000.0), log=True)
    nv: float = param(100.0, 0.0, 1e6, doc="Sharpness across the tangent.", slider=(1.0, 1000.0), log=True)

    isotropic: ClassVar[bool] = False
    reciprocal: ClassVar[bool] = True
    #: A direction drawn by the highlight weighs at most F, and reflects upwards only if h·wi > cos(theta_i)/2; so the
    #: albedo is at most ks + (1−ks) ((1−c/2)⁵ + kd (1−(1−c/2)⁵)) <= 1 for c = cos(theta_i), whatever the parameters.
    energy_conserving: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check(self)

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        return evaluate(self._formula, wi, wo)

    def _formula(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        both, length, deficit = sum_of_directions(wi, wo)
        x2, y2 = both[0] ** 2, both[1] ** 2
        across = x2 + y2
        exponent = (self.nu * x2 + self.nv * y2) / np.where(across > 0.0, across, 1.0)
        lobe = np.sqrt((self.nu + 1.0) * (self.nv + 1.0)) / (4.0 * np.pi) * power_of_one_minus(deficit, exponent)
        lobe /= length * np.maximum(wi[2], wo[2])
        kd, ks = channels(self.kd), channels(self.ks)
        under = 28.0 / (23.0 * np.pi) * (_gain(0.5 * wi[2]) * _gain(0.5 * wo[2]))
        return lobe * ks + (1.0 - ks) * (lobe * schlick(wi, wo, length) + kd * under)


def _gain(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """1 − (1 − y)⁵."""
    return y * (5.0 + y * (-10.0 + y * (10.0 + y * (y - 5.0))))
