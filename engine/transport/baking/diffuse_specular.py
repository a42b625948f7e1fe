"""A BRDF in two parts: the diffuse one, which transport in vectors serves, and the glossy one, which lobes are for.

    f(wi, wo) = colour / π · g(cos θ_i) g(cos θ_o) + glossy(wi, wo)

g is 1 for every model but Ashikhmin and Shirley's, whose diffuse part gives way to the highlight towards grazing:
g(c) = 1 − (1 − c/2)⁵. Models with a diffuse reflectance kd beside their highlight are cut there, exactly. Of others the
diffuse part is the least value over pairs of directions that are not grazing; what is left may then fall below 0 at
grazing angles, and the two parts still sum to f.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.models.diffuse import Lambert
from engine.brdf.models.model import DiffusePart as DiffusePart
from engine.brdf.models.model import Model
from engine.core.directions import Vectors, surface_direction

#: Directions that the least value is sought over: not lower than this, in so many steps around.
LOWEST, TURNS = np.radians(70.0), 12


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
    own = brdf.glossy() if isinstance(brdf, Model) else None
    glossy = Rest(brdf, diffuse) if own is None else own
    return diffuse, glossy if np.any(np.abs(_values(glossy)) > 1e-9) else None


def diffuse_part(brdf: Brdf) -> DiffusePart:
    """The diffuse part alone; some 5 µs for models that are cut by their formula."""
    own = brdf.diffuse() if isinstance(brdf, Model) else None
    if own is not None:
        return own
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
