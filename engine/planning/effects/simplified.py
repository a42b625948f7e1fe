"""A BRDF without one of its effects: what is drawn, and baked, where a plan skips it.

Each is a Brdf like any other, so that the error of skipping is the difference of two radiances.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.analysis import albedo
from engine.brdf.models.diffuse import Lambert
from engine.brdf.models.sampling import sampler_of
from engine.core.cached import remember
from engine.core.directions import Vectors, surface_direction

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf

#: Azimuths over which a brushed BRDF is averaged.
TURNS = 8

#: Polar angles at which albedos are known, and directions for each.
ANGLES, COUNT = 10, 512


@dataclass(frozen=True, eq=False)
class Albedos:
    """`theta` (A,) rad and `value` (A, 3), what is reflected of a beam from there; `mean` (3,) of even light."""

    theta: NDArray[np.float64]
    value: NDArray[np.float64]
    mean: NDArray[np.float64]

    def rise(self, cosine: ArrayLike) -> NDArray[np.float64]:
        """(...) albedo at the normal over that at `cosine` (...), at most 1; the three colours together."""
        level = self.value.mean(axis=1)
        at = np.interp(np.arccos(np.clip(cosine, 0.0, 1.0)), self.theta, level)
        return np.minimum(1.0, np.where(at > 0.0, level[0] / np.where(at > 0.0, at, 1.0), 1.0))


@remember(8)
def albedos(brdf: Brdf) -> Albedos:
    """The albedos of `brdf`; some 30 ms, and remembered."""
    at, share = np.polynomial.legendre.leggauss(ANGLES - 1)
    theta = np.concatenate([[0.0], 0.25 * np.pi * (1.0 + at)])
    turns = np.array([0.0]) if brdf.isotropic else np.arange(4) * np.pi / 4.0
    beams = surface_direction(theta[:, None], turns[None, :])
    value = albedo(brdf, beams, sampler=sampler_of(brdf), count=COUNT).mean(axis=1)
    weight = share * np.sin(2.0 * theta[1:])
    mean = weight @ value[1:] / weight.sum()
    return Albedos(theta, value, mean)


@remember(8)
def lambertian(brdf: Brdf) -> Lambert:
    """The Lambertian BRDF that reflects as much of even light."""
    red, green, blue = np.clip(albedos(brdf).mean, 0.0, 1.0)
    return Lambert((float(red), float(green), float(blue)))


@dataclass(frozen=True)
class _Without:
    """Interface that all simplified BRDFs share with the BRDF that they derive from."""

    brdf: Brdf

    @property
    def isotropic(self) -> bool:
        return bool(self.brdf.isotropic)

    @property
    def reciprocal(self) -> bool:
        return False

    @property
    def energy_conserving(self) -> bool:
        return bool(self.brdf.energy_conserving)

    @property
    def name(self) -> str:
        return f"{type(self).__name__}({getattr(self.brdf, 'name', '') or self.brdf})"


@dataclass(frozen=True)
class Unbrushed(_Without):
    """The mean of a BRDF over turns of both directions about the normal."""

    @property
    def isotropic(self) -> bool:
        return True

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
        angles = np.arange(TURNS) * 2.0 * np.pi / TURNS + 0.1
        return np.asarray(sum(self.brdf.f(_turn(wi, angle), _turn(wo, angle)) for angle in angles) / TURNS)


@dataclass(frozen=True)
class WithoutRetro(_Without):
    """A BRDF that sends no more back towards the light's side than across it.

    Of brushed ones that is not separated from their brushing, and they stay as they are.
    """

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
        value = np.asarray(self.brdf.f(wi, wo))
        if not self.isotropic:
            return value
        back = (wi[..., :2] * wo[..., :2]).sum(axis=-1) > 0.0
        if back.any():
            value = value.copy()
            one, other = (self.brdf.f(across(wi[back], wo[back], side), wo[back]) for side in (1.0, -1.0))
            value[back] = np.minimum(value[back], 0.5 * (one + other))
        return value


@dataclass(frozen=True)
class WithoutRise(_Without):
    """A BRDF whose albedo does not rise towards grazing views, as Fresnel's factor makes it."""

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        share = albedos(self.brdf).rise(np.asarray(wo, np.float64)[..., 2])
        return np.asarray(self.brdf.f(wi, wo) * share[..., None])


def _turn(direction: Vectors, angle: float) -> Vectors:
    """`direction` (..., 3) rotated about +z."""
    x, y, z = np.moveaxis(direction, -1, 0)
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([cosine * x - sine * y, sine * x + cosine * y, z], axis=-1)


def across(wi: Vectors, wo: Vectors, side: float) -> Vectors:
    """`wi` (N, 3) at its own height, but at a right angle to the azimuth of `wo` (N, 3)."""
    length = np.hypot(wo[..., 0], wo[..., 1])
    radius = np.hypot(wi[..., 0], wi[..., 1]) / np.where(length > 0.0, length, 1.0)
    return np.stack([-side * radius * wo[..., 1], side * radius * wo[..., 0], wi[..., 2]], axis=-1)


@dataclass(frozen=True)
class Glossy(_Without):
    """A BRDF that is looked up as if it depended on the view, whether or not it does."""

    @property
    def reciprocal(self) -> bool:
        return bool(self.brdf.reciprocal)

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        return np.asarray(self.brdf.f(wi, wo))


class GlossyLambert(Lambert):
    """Lambert's BRDF, with its exact spherical harmonics, that is baked as if it depended on the view."""


@dataclass(frozen=True)
class Brushed(Glossy):
    """A BRDF that is looked up as if it depended on turns about the normal, whether or not it does."""

    @property
    def isotropic(self) -> bool:
        return False
