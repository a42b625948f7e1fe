"""Diffuse models. GLSL twins: resources/shaders/brdf/."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from engine.directions import Vectors
from engine.params import Colour, check, param


def above_horizon(wi: ArrayLike, wo: ArrayLike) -> tuple[Vectors, Vectors, np.ndarray]:
    """`wi` and `wo` broadcast to one shape (..., 3) float64, and where both are strictly above the surface (...)."""
    wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
    return wi, wo, (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)


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
        wi, wo, visible = above_horizon(wi, wo)
        return np.where(visible[..., None], np.asarray(self.albedo) / np.pi, 0.0)
