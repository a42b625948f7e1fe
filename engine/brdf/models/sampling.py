"""Importance sampling of BRDFs: directions towards the light, drawn where f cos(theta_i) is large.

A sampler is made once for a BRDF and serves every viewer:

    sampler = sampler_of(brdf)
    wi = sampler.sample(wo, u)          # (N, 3) for wo (N, 3) and u (N, 3) uniform in [0, 1)
    density = sampler.pdf(wi, wo)       # (N,) in 1/sr, over the whole sphere of wi

The mean of f cos(theta_i) / density over such directions is the albedo towards wo. Every sampler is a mixture of
lobes, with shares that do not depend on wo; a cosine lobe is always among them, so that no direction that reflects is
left out. A lobe may send directions below the horizon: f is 0 there, the density is not.

A model states its lobes in closed form (`Model.sampling_lobes`). A BRDF that samples itself (its own `sample` and
`pdf`, as measurements in an adaptive parametrisation have) is one of the lobes of its mixture. Every other BRDF is
sampled from two tables of its values: one over the half vector, which resolves narrow highlights, one over the
direction itself, which finds the others.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.sampling_lobes import (
    CosineLobe,
    Evaluable,
    HalfVectorLobe,
    Mixture,
    Sampler,
    TabulatedHalfVectors,
    TabulatedLobe,
)
from engine.core.cached import cached_property
from engine.core.colour import luminance
from engine.core.directions import Vectors

#: Share of the cosine lobe in every mixture: it bounds the weight f cos / pdf where the other lobes miss something.
COSINE_SHARE = 0.2

#: Least part of all energy for which a lobe has a share: less than this would be lost to rounding beside the others.
MIN_ENERGY = 1e-9

#: Reflection of Schlick's Fresnel term under even light beside f0: the mean of (1 − cos)^5, 1/21, and more.
FRESNEL = 0.05

#: Lobes with their energies, and the diffuse energy beside them.
Lobes = tuple[list[tuple[Sampler, float]], float]


class Reflectance:
    """The verbs that every BRDF of Lightarc has beside `f`: `eval`, `sample` and `pdf`."""

    def eval(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Evaluate the BRDF: `f` by the name that other renderers give it.

        Parameters
        ----------
        wi, wo : array_like, shape (..., 3)
            Unit directions towards the light and the viewer in the surface frame, whose normal is (0, 0, 1).

        Returns
        -------
        ndarray, shape (..., 3)
            Values in 1/sr, without the cosine.
        """
        own: Any = self
        return np.asarray(own.f(wi, wo))

    def sample(self, wo: ArrayLike, u: ArrayLike) -> Vectors:
        """Draw directions towards the light, mostly where f cos(theta_i) is large.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            Unit directions towards the viewer, above the surface.
        u : array_like, shape (..., 3)
            Random numbers, uniform in [0, 1).

        Returns
        -------
        ndarray, shape (..., 3)
            Unit directions. A few may lie below the horizon, where the BRDF is 0 and the density is not.
        """
        shape = np.broadcast_shapes(np.shape(wo), np.shape(u))
        flat = (np.broadcast_to(np.asarray(each, np.float64), shape).reshape(-1, 3) for each in (wo, u))
        return self._sampler.sample(*flat).reshape(shape)

    def pdf(self, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float64]:
        """Evaluate the density at which `sample` draws.

        Parameters
        ----------
        wi, wo : array_like, shape (..., 3)
            Unit directions towards the light and the viewer.

        Returns
        -------
        ndarray, shape (...)
            Density in 1/sr over the whole sphere of `wi`.
        """
        shape = np.broadcast_shapes(np.shape(wi), np.shape(wo))
        flat = (np.broadcast_to(np.asarray(each, np.float64), shape).reshape(-1, 3) for each in (wi, wo))
        return self._sampler.pdf(*flat).reshape(shape[:-1])

    @cached_property
    def _sampler(self) -> Sampler:
        own: Any = self
        return sampler_of(own)


def samples_itself(brdf: object) -> bool:
    """Return whether a BRDF brings `sample` and `pdf` of its own, other than those of `Reflectance`."""
    own = (getattr(type(brdf), name, None) for name in ("sample", "pdf"))
    return all(
        one not in (None, common) for one, common in zip(own, (Reflectance.sample, Reflectance.pdf), strict=True)
    )


def sampler_of(brdf: Evaluable) -> Sampler:
    """The sampler of any BRDF: its closed form where there is one, else tables of its values (about 0.1 s)."""
    own: Any = brdf
    if samples_itself(brdf):
        return mixture([(own, 1.0)])
    lobes = own.sampling_lobes() if hasattr(own, "sampling_lobes") else None
    if lobes is not None:
        return mixture(*lobes)
    return mixture([(HalfVectorLobe(TabulatedHalfVectors.of(brdf)), 0.5), (TabulatedLobe.of(brdf), 0.5)])


def mixture(lobes: list[tuple[Sampler, float]], diffuse: float = 0.0) -> Mixture:
    """The lobes by their energy beside a cosine lobe, whose share is the diffuse energy's or COSINE_SHARE if larger."""
    whole = diffuse + sum(energy for _, energy in lobes)
    used = [(lobe, energy) for lobe, energy in lobes if energy > MIN_ENERGY * whole]
    total = sum(energy for _, energy in used)
    if not used:
        return Mixture((CosineLobe(),), (1.0,))
    cosine = max(COSINE_SHARE, diffuse / (diffuse + total))
    shares = [(1.0 - cosine) * (energy / total) for _, energy in used]
    return Mixture((CosineLobe(), *(lobe for lobe, _ in used)), (1.0 - sum(shares), *shares))


def grey(colour: ArrayLike) -> float:
    """The luminance of a colour."""
    return float(luminance(colour))
