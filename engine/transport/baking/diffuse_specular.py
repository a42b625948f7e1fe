"""A BRDF in two parts: the diffuse one, which transport in vectors serves, and the glossy one, which lobes are for.

    f(wi, wo) = colour / π · g(cos θ_i) g(cos θ_o) + glossy(wi, wo)

g is 1 for every model but Ashikhmin and Shirley's, whose diffuse part gives way to the highlight towards grazing:
g(c) = 1 − (1 − c/2)⁵. Models with a diffuse reflectance kd beside their highlight are cut there, exactly. Of others the
diffuse part is the least value over pairs of directions that are not grazing; what is left may then fall below 0 at
grazing angles, and the two parts still sum to f.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.models.diffuse import Lambert
from engine.brdf.models.lafortune import Lafortune, LafortuneThreeLobes
from engine.brdf.models.microfacet import AshikhminShirley, CookTorrance, Ggx, GgxAnisotropic, Ward
from engine.brdf.models.phong import BlinnPhong, Phong
from engine.core.directions import Vectors, surface_direction

#: Models that are kd / π and a highlight.
_SUMS = (BlinnPhong, CookTorrance, Ggx, GgxAnisotropic, Lafortune, LafortuneThreeLobes, Phong, Ward)

_BLACK = (0.0, 0.0, 0.0)

#: Directions that the least value is sought over: not lower than this, in so many steps around.
LOWEST, TURNS = np.radians(70.0), 12


@dataclass(frozen=True)
class DiffusePart:
    """`colour` / π · g(cos θ_i) g(cos θ_o); `grazing` says whether g falls towards grazing, else it is 1."""

    colour: tuple[float, float, float]
    grazing: bool = False

    def gain(self, cosine: ArrayLike) -> NDArray[np.float64]:
        """g (...) of cosines (...), 0 below the horizon where it falls towards it."""
        cosine = np.asarray(cosine, np.float64)
        return 1.0 - (1.0 - 0.5 * np.maximum(cosine, 0.0)) ** 5 if self.grazing else np.ones(cosine.shape)

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
        above = (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
        share = np.where(above, self.gain(wi[..., 2]) * self.gain(wo[..., 2]) / np.pi, 0.0)
        return np.asarray(share[..., None] * np.asarray(self.colour))


@dataclass(frozen=True)
class Rest:
    """Remainder of a BRDF above its least value, for BRDFs without a diffuse part of their own."""

    brdf: Brdf
    diffuse: DiffusePart

    @property
    def isotropic(self) -> bool:
        return self.brdf.isotropic

    @property
    def reciprocal(self) -> bool:
        return self.brdf.reciprocal

    @property
    def energy_conserving(self) -> bool:
        return self.brdf.energy_conserving

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        return self.brdf.f(wi, wo) - self.diffuse.f(wi, wo)


def parts(brdf: Brdf) -> tuple[DiffusePart, Brdf | None]:
    """The diffuse and the glossy part of `brdf`; None where nothing glossy is left."""
    diffuse = diffuse_part(brdf)
    if isinstance(brdf, Lambert):
        return diffuse, None
    model: Any = brdf
    glossy: Brdf = replace(model, kd=_BLACK) if isinstance(brdf, (*_SUMS, AshikhminShirley)) else Rest(brdf, diffuse)
    return diffuse, glossy if np.any(np.abs(_values(glossy)) > 1e-9) else None


def diffuse_part(brdf: Brdf) -> DiffusePart:
    """The diffuse part alone; some 5 µs for models that are cut by their formula."""
    if isinstance(brdf, Lambert):
        return DiffusePart(brdf.albedo)
    if isinstance(brdf, AshikhminShirley):
        red, green, blue = (28.0 / 23.0 * kd * (1.0 - ks) for kd, ks in zip(brdf.kd, brdf.ks, strict=True))
        return DiffusePart((red, green, blue), grazing=True)
    if isinstance(brdf, _SUMS):
        return DiffusePart(brdf.kd)
    red, green, blue = np.pi * np.maximum(_values(brdf).min(axis=0), 0.0)
    return DiffusePart((float(red), float(green), float(blue)))


def _values(brdf: Brdf) -> NDArray[np.float64]:
    """(N, 3) values of f over pairs of directions, mirrored ones among them."""
    theta = np.linspace(0.0, LOWEST, 8)
    wi = surface_direction(theta[:, None], 0.0 if brdf.isotropic else np.array([0.0, 0.7, 1.4])[None, :])
    wo = surface_direction(theta[:, None], 2.0 * np.pi * np.arange(TURNS)[None, :] / TURNS)
    values = brdf.f(wi.reshape(-1, 1, 3), wo.reshape(1, -1, 3)).reshape(-1, 3)
    mirrored = wi.reshape(-1, 3)
    return np.concatenate([values, brdf.f(mirrored, mirrored * (-1.0, -1.0, 1.0))])
