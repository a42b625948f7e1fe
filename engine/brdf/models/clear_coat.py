"""A clear coat as glTF defines it: KHR_materials_clearcoat. GLSL counterpart: resources/shaders/brdf/clear_coat.glsl.

    f = base (1 − w F) + w F D G/(4 n·l n·v),   F = 0.04 + 0.96 (1 − n·v)⁵,   α = roughness²,

with w the weight, n the normal of the coat, which maps of normals of the base leave alone, v to the viewer, D of GGX
and G the product of two Smith terms (glTF 2.0, Appendix B.3). The extension prescribes the mixture and the index 1.5;
F at n·v, in place of h·v, is that of its implementation notes, by which a viewer never sees more light than there is.
It is not reciprocal. Facets of the coat may scatter again all that they lose, as those of the base do (Kulla2017).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.multiple_scattering import SMOOTHEST, multiple_scattering

Floats = NDArray[np.float64]

#: Reflectance of the index 1.5 at normal incidence.
F0 = 0.04


def coat_share(cosine_o: Floats, weight: ArrayLike) -> Any:
    """w F, the share of the mixture that is coat, (n,) for cosines (n,) between its normal and the viewer."""
    grazing = np.clip(1.0 - cosine_o, 0.0, 1.0)
    return np.asarray(weight) * (F0 + (1.0 - F0) * grazing**5)


def coat_lobe(cosine_i: Floats, cosine_o: Floats, sine2_h: Floats, roughness: ArrayLike, again: float = 0.0) -> Any:
    """D G/(4 n·l n·v) (n,) in 1/sr, without F, for cosines above the horizon and sin² (n,) of the half vector.

    `roughness` below 0.02 is taken for 0.02; `again` is the share of light scattered again between facets.
    """
    alpha = np.maximum(roughness, SMOOTHEST) ** 2
    alpha2 = alpha * alpha
    distribution = alpha2 / (np.pi * (sine2_h + alpha2 * (1.0 - sine2_h)) ** 2)
    lobe = distribution / (_smith(cosine_i, alpha2) * _smith(cosine_o, alpha2))
    if again == 0.0:
        return lobe
    return lobe + again * multiple_scattering(cosine_i, cosine_o, alpha, 1.0)


def _smith(cosine: Floats, alpha2: ArrayLike) -> Floats:
    """cos θ + √(α² + (1 − α²) cos²θ): two such make G/(4 n·l n·v) the inverse of their product."""
    square = np.asarray(alpha2, np.float64)
    return np.asarray(cosine + np.sqrt(square + (1.0 - square) * cosine**2))
