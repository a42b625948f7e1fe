"""Spherical Gaussians, and the lobes made of them that stand for the transport of a vertex towards a view.

Green2006 Eq. 4, with G(w; mu, sigma) = exp((w·mu − 1) / sigma²), sigma in rad. It is
1 at its mean and falls like a flat Gaussian of that deviation where sigma is small. We compute it from the distance,
exp(−|w − mu|² / (2 sigma²)): near the mean w·mu − 1 has lost its digits, which in float32 costs a tenth of the height
at sigma = 1e-3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.light.gaussian_prefilter import WIDEST, gaussian_integral, texel_width

Array = NDArray[np.float64]

#: Narrowest and widest Gaussian in rad: half a texel of a cube map of 6 × 512², and the widest that maps are filtered
#: for; a wider one is nearly a constant.
NARROWEST, WIDEST_LOBE = 0.5 * texel_width(512), WIDEST


@dataclass(frozen=True, eq=False)
class Lobes:
    """Transport of V vertices towards N views as sums of L Gaussians: T(w) ≈ Σ weight · G(w; mean, sigma).

    T holds BRDF, cosine and visibility: radiance per incident radiance and steradian. So the radiance towards a
    view is Σ weight · gaussian_integral(sigma) · (the prefiltered environment at mean and sigma).

    Attributes
    ----------
    weight : (V, N, L, 3) float32 ≥ 0, linear RGB in 1/sr; 0 where nothing is reflected.
    mean : (V, N, L, 3) float32 unit vectors in the world; defined where the weight is 0 too.
    sigma : (V, N, L) float32 in rad, from `NARROWEST` to `WIDEST_LOBE`.
    """

    weight: NDArray[np.float32]
    mean: NDArray[np.float32]
    sigma: NDArray[np.float32]

    def __post_init__(self) -> None:
        shape = self.sigma.shape
        if self.sigma.ndim != 3 or self.weight.shape != (*shape, 3) or self.mean.shape != (*shape, 3):
            raise ValueError("weights, means and widths of lobes do not fit together")

    def __len__(self) -> int:
        return len(self.sigma)

    @property
    def count(self) -> int:
        """Lobes for each vertex and view."""
        return self.sigma.shape[2]

    def energy(self) -> Array:
        """(V, N, 3) integrals of the sums over the sphere: the radiance under an even light of 1."""
        result: Array = np.einsum("vnlc,vnl->vnc", self.weight.astype(np.float64), gaussian_integral(self.sigma))
        return result

    def values(self, direction: ArrayLike) -> Array:
        """The sums (V, N, ..., 3) at unit vectors `direction` (V, N, ..., 3), or (..., 3) for all alike."""
        at = np.asarray(direction, np.float64)
        if at.shape[:2] != self.sigma.shape[:2] or at.ndim < 3:
            at = np.broadcast_to(at, (*self.sigma.shape[:2], *at.shape))
        extra = (1,) * (at.ndim - 3)
        total = np.zeros(at.shape)
        for lobe in range(self.count):
            mean, sigma, weight = (array[:, :, lobe] for array in (self.mean, self.sigma, self.weight))
            mean, weight = (array.reshape(*array.shape[:2], *extra, 3) for array in (mean, weight))
            total += gaussian(at, mean, sigma.reshape(*sigma.shape, *extra))[..., None] * weight
        return total


def gaussian(direction: ArrayLike, mean: ArrayLike, sigma: ArrayLike) -> Array:
    """G (...) at unit vectors `direction` (..., 3) for unit `mean` (..., 3) and `sigma` (...) in rad, all broadcast."""
    apart = np.asarray(direction, np.float64) - np.asarray(mean, np.float64)
    exponent = -0.5 * np.einsum("...i,...i->...", apart, apart) / np.asarray(sigma, np.float64) ** 2
    result: Array = np.exp(exponent)
    return result
