"""Light that facets of GGX scatter more than once, which one reflection loses (Kulla2017).

A mirror of many facets, F = 1, reflects the albedo E(μ) after one reflection, with μ the cosine of a direction; what it
loses leaves after further ones, and is returned as the reciprocal lobe

    f = F̄ (1 − E(μ_i)) (1 − E(μ_o)) / (π (1 − Ē)),    Ē = 2 ∫ E μ dμ,
    F̄ = F_m² Ē / (1 − F_m (1 − Ē)),                   F_m = F0 + (1 − F0)/21, the mean of Schlick's term.

E is that of glTF's GGX, whose shadowing is the product of two Smith terms. It is a polynomial fitted to quadrature of
512² directions from below, for roughness √α from 0.02 to 1: a white mirror returns 99.1 to 100 % of the light. GLSL
counterpart: resources/shaders/brdf/multiple_scattering.glsl. Bound by arithmetic, some 15 ns a direction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: Least roughness that the fit describes: a smoother one loses less than 2e-6 of light from all sides.
SMOOTHEST = 0.02

#: Coefficients of sⁱ rʲ, s = μ/(μ + α) and r = √α: 1 − E = (1 − s)² Σ c sⁱ rʲ.
LOSS = np.array(
    [
        [0.010, 0.456, -1.475, 2.287, -0.899],
        [0.581, -2.409, 3.963, 0.468, -0.758],
        [1.211, -8.421, 37.538, -62.622, 25.925],
        [-9.349, 79.890, -284.447, 400.000, -126.242],
        [23.078, -115.584, 350.285, -400.000, -1.991],
        [-15.464, 43.709, -94.766, 43.018, 170.569],
    ]
)

#: Coefficients of rʲ, and of ln r: 1 − Ē = α² (Σ c rʲ + c ln r).
MEAN_LOSS = (0.9378, 11.7371, -52.2862, 105.2860, -119.4194, 72.3249, -17.9577)
MEAN_LOSS_LOG = -0.6869


def loss(cosine: ArrayLike, alpha: ArrayLike) -> Floats:
    """1 − E for cosines in [0, 1] and widths alpha in [0.0004, 1], which broadcast: the share of light that is lost."""
    cosine, alpha = np.asarray(cosine, np.float64), np.asarray(alpha, np.float64)
    root, share = np.sqrt(alpha), cosine / (cosine + alpha)
    value: Floats = np.zeros(())
    for row in LOSS[::-1]:
        value = value * share + np.polyval(row[::-1], root)
    return np.asarray(np.maximum((1.0 - share) ** 2 * value, 0.0))


def mean_loss(alpha: ArrayLike) -> Floats:
    """1 − Ē for widths alpha in [0.0004, 1]: the share that is lost of light from all sides alike."""
    root = np.sqrt(np.asarray(alpha, np.float64))
    return np.asarray(root**4 * (np.polyval(MEAN_LOSS[::-1], root) + MEAN_LOSS_LOG * np.log(root)))


def multiple_scattering(cosine_i: ArrayLike, cosine_o: ArrayLike, alpha: ArrayLike, f0: ArrayLike) -> Floats:
    """The lobe (..., N) in 1/sr, without the cosine.

    Parameters
    ----------
    cosine_i, cosine_o : (N,) cosines towards the light and the viewer, in [0, 1].
    alpha : (N,) or a number, width of GGX in [0.0004, 1].
    f0 : (..., N) or what broadcasts to it, reflectance of the facets at normal incidence, in [0, 1].
    """
    lost, mirror = mean_loss(alpha), np.asarray(f0, np.float64)
    fresnel = mirror + (1.0 - mirror) / 21.0
    again = fresnel * fresnel * (1.0 - lost) / (1.0 - fresnel * lost)
    return np.asarray(again * (loss(cosine_i, alpha) * loss(cosine_o, alpha) / (np.pi * lost)))
