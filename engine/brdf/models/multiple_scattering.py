"""Light that facets of GGX scatter more than once, which one reflection loses (Kulla2017).

A mirror of many facets, F = 1, reflects the albedo E(μ) after one reflection, with μ the cosine of a direction; what it
loses leaves after further ones, and is returned as the reciprocal lobe

    f = F̄ (1 − E(μ_i)) (1 − E(μ_o)) / (π (1 − Ē)),    Ē = 2 ∫ E μ dμ,
    F̄ = F_m² Ē / (1 − F_m (1 − Ē)),

with F_m the mean of Fresnel's term over all directions. E depends on Smith's term: there is one for glTF's GGX, whose
shadowing is the product of two terms, and one for the height-correlated term. Both are polynomials fitted to
quadrature from below, for roughness √α from 0.02 to 1: a white mirror returns 99 to 100 % of the light. GLSL
counterparts: resources/shaders/brdf/multiple_scattering.glsl and openpbr_layers.glsl. Bound by arithmetic, some 15 ns a
direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: Least roughness that the fit describes: a smoother one loses less than 2e-6 of light from all sides.
SMOOTHEST = 0.02


@dataclass(frozen=True, eq=False)
class Facets:
    """Share of light that facets of GGX with F = 1 lose by one reflection, with s = μ/(μ + α) and r = √α.

    Attributes
    ----------
    lost : (6, 5) coefficients c of 1 − E = (1 − s)² Σ c sⁱ rʲ.
    mean_lost, mean_log : coefficients of 1 − Ē = α² (Σ c rʲ + c ln r).
    """

    lost: Floats
    mean_lost: tuple[float, ...]
    mean_log: float

    def loss(self, cosine: ArrayLike, alpha: ArrayLike) -> Floats:
        """1 − E for cosines in [0, 1] and widths alpha in [0.0004, 1], which broadcast."""
        cosine, alpha = np.asarray(cosine, np.float64), np.asarray(alpha, np.float64)
        root, share = np.sqrt(alpha), cosine / (cosine + alpha)
        value: Floats = np.zeros(())
        for row in self.lost[::-1]:
            value = value * share + np.polyval(row[::-1], root)
        return np.asarray(np.maximum((1.0 - share) ** 2 * value, 0.0))

    def mean_loss(self, alpha: ArrayLike) -> Floats:
        """1 − Ē for widths alpha in [0.0004, 1]: the share that is lost of light from all sides alike."""
        root = np.sqrt(np.asarray(alpha, np.float64))
        return np.asarray(root**4 * (np.polyval(self.mean_lost[::-1], root) + self.mean_log * np.log(root)))


#: Facets with the product of two Smith terms.
SEPARABLE = Facets(
    np.array(
        [
            [0.010, 0.456, -1.475, 2.287, -0.899],
            [0.581, -2.409, 3.963, 0.468, -0.758],
            [1.211, -8.421, 37.538, -62.622, 25.925],
            [-9.349, 79.890, -284.447, 400.000, -126.242],
            [23.078, -115.584, 350.285, -400.000, -1.991],
            [-15.464, 43.709, -94.766, 43.018, 170.569],
        ]
    ),
    (0.9378, 11.7371, -52.2862, 105.2860, -119.4194, 72.3249, -17.9577),
    -0.6869,
)

#: Facets with Smith's height-correlated term.
CORRELATED = Facets(
    np.array(
        [
            [-0.051, 0.412, -1.145, 1.298, -0.514],
            [0.927, -6.520, 16.931, -15.875, 8.764],
            [-1.957, 27.925, -79.914, 94.568, -60.129],
            [-0.204, -18.654, 42.627, -65.560, 147.274],
            [13.166, -10.436, -23.419, 197.341, -396.618],
            [-11.805, 4.042, 68.600, -265.685, 400.000],
        ]
    ),
    (-0.8008, 25.0674, -107.6096, 226.4853, -261.2855, 156.8873, -38.1516),
    -1.0537,
)


def schlick_mean(f0: ArrayLike) -> Floats:
    """F_m of Schlick's term: F0 + (1 − F0)/21."""
    return np.asarray(np.add(f0, np.subtract(1.0, f0) / 21.0))


def multiple_scattering(
    cosine_i: ArrayLike, cosine_o: ArrayLike, alpha: ArrayLike, fresnel: ArrayLike, facets: Facets = SEPARABLE
) -> Floats:
    """The lobe (..., N) in 1/sr, without the cosine.

    Parameters
    ----------
    cosine_i, cosine_o : (N,) cosines towards the light and the viewer, in [0, 1].
    alpha : (N,) or a number, width of GGX in [0.0004, 1].
    fresnel : (..., N) or what broadcasts to it, the mean F_m of Fresnel's term, in [0, 1].
    """
    lost = facets.mean_loss(alpha)
    again = further_reflectance(fresnel, lost)
    return np.asarray(again * (facets.loss(cosine_i, alpha) * facets.loss(cosine_o, alpha) / (np.pi * lost)))


def further_reflectance(fresnel: ArrayLike, lost: ArrayLike) -> Floats:
    """F̄, the share of the light that one reflection loses which leaves after further ones, for 1 − Ē `lost`."""
    fresnel = np.asarray(fresnel, np.float64)
    return np.asarray(fresnel * fresnel * (1.0 - np.asarray(lost)) / (1.0 - fresnel * lost))
