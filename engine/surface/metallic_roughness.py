"""The reflectance that PBR maps stand for: glTF 2.0, Appendix B.3, with the reflectance f0 of dielectrics beside it.

    F0 = f0 (1 − metallic) + base_colour metallic,   F = F0 + (1 − F0)(1 − h·wi)⁵,   alpha = roughness²,
    f  = (1 − F)(1 − metallic) base_colour / π + F D G / (4 n·l n·v),

G the product of two Smith terms. At f0 = 0.04 this is the model `metallic-roughness` of `engine.brdf`, for one
material at each point. Directions are in the frame of the surface, normal +z. Bound by arithmetic, some 60 ns a point.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.multiple_scattering import SMOOTHEST, multiple_scattering, schlick_mean

Floats = NDArray[np.float64]


def lobe_and_grazing(wi: Floats, wo: Floats, roughness: ArrayLike) -> tuple[Floats, Floats]:
    """D G / (4 n·l n·v) in 1/sr and (1 − h·wi)⁵, (N,) each, for unit directions (N, 3) above the surface."""
    alpha2 = np.maximum(np.asarray(roughness, np.float64), SMOOTHEST) ** 4
    both = wi + wo
    half = both / np.linalg.norm(both, axis=-1, keepdims=True)
    height2 = np.minimum(half[..., 2] ** 2, 1.0)
    distribution = alpha2 / (np.pi * (1.0 - height2 + alpha2 * height2) ** 2)
    shadowing = _smith(wi[..., 2], alpha2) * _smith(wo[..., 2], alpha2)
    grazing = (1.0 - np.clip(np.sum(half * wi, axis=-1), 0.0, 1.0)) ** 5
    return distribution / shadowing, grazing


def reflectance(
    wi: Floats,
    wo: Floats,
    base_colour: ArrayLike,
    roughness: ArrayLike,
    metallic: ArrayLike,
    f0: ArrayLike,
    scatters_again: bool = False,
) -> Floats:
    """f (N, 3) in 1/sr without the cosine, 0 where a direction is below the surface.

    `base_colour` is (N, 3) or (3,), the others are (N,) or a number; directions are unit vectors (N, 3). With
    `scatters_again`, light that facets scatter more than once is added (`engine.brdf.models.multiple_scattering`).
    """
    wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
    seen = (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
    up = np.array([0.0, 0.0, 1.0])
    wi, wo = np.where(seen[..., None], wi, up), np.where(seen[..., None], wo, up)
    lobe, grazing = lobe_and_grazing(wi, wo, roughness)
    base = np.asarray(base_colour, np.float64)
    metal = np.asarray(metallic, np.float64)[..., None]
    at_normal = np.asarray(f0, np.float64)[..., None] * (1.0 - metal) + base * metal
    fresnel = at_normal + (1.0 - at_normal) * grazing[..., None]
    value = (1.0 - fresnel) * ((1.0 - metal) / np.pi * base) + fresnel * lobe[..., None]
    if scatters_again:
        value = value + multiple_scattering_of(wi[..., 2], wo[..., 2], roughness, at_normal)
    return np.asarray(np.where(seen[..., None], value, 0.0))


def multiple_scattering_of(cosine_i: Floats, cosine_o: Floats, roughness: ArrayLike, f0: Floats) -> Floats:
    """Light that facets scatter more than once, (N, 3) in 1/sr without the cosine, for f0 (N, 3)."""
    alpha = np.maximum(np.asarray(roughness, np.float64), SMOOTHEST) ** 2
    return np.moveaxis(multiple_scattering(cosine_i, cosine_o, alpha, schlick_mean(np.moveaxis(f0, -1, 0))), 0, -1)


def _smith(cosine: Floats, alpha2: Floats) -> Floats:
    """cos θ + √(α² + (1 − α²) cos²θ): two such make G / (4 n·l n·v) the inverse of their product."""
    return np.asarray(cosine + np.sqrt(alpha2 + (1.0 - alpha2) * cosine**2))
