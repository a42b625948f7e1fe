"""One positive term for direct light: the normalised decomposition of Kautz1999, "Interactive rendering
with arbitrary BRDFs using separable approximations".

    g_i = (Σ_j w_j M_ij^p)^(1/p)        h_j = Σ_i w_i M_ij / g_i        M_ij ≈ s g_i h_j

The first texture is the norm of each row and the second the mean of the rows after division by it. Both are positive,
so nothing is clamped, and a product of two texture look-ups is all that a light needs. w is the cosine weight of each
texel, and one number s fits the product to the matrix by least squares. The norm p ∈ {1, 2, ∞} is searched: p = 1 keeps
the energy, p = ∞ the highlight, and which is nearest depends on the BRDF.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.core.steps import Step, Steps, part
from engine.factor.brdf_matrix import BrdfMatrix, brdf_matrix
from engine.factor.errors import Reference
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable import texel_weights
from engine.factor.separable_factors import Parametrisation, SeparableFactors

Floats = NDArray[np.float64]

#: The norms of a row that are tried.
NORMS = (1.0, 2.0, float("inf"))


def normalise(
    brdf: Brdf, hemisphere_map: HemisphereMap, parametrisation: Parametrisation, reference: Reference
) -> Steps[SeparableFactors]:
    """The term of `brdf` with the lowest cosine-weighted error among `NORMS`; ValueError for values not finite."""
    matrix = yield from part(brdf_matrix(brdf, hemisphere_map, parametrisation), 0.0, 0.7)
    channels = [np.maximum(whole(matrix, channel), 0.0) for channel in range(3)]
    tried = []
    for index, norm in enumerate(NORMS):
        yield Step(0.7 + 0.3 * index / len(NORMS), f"averaging rows of norm {norm:g}")
        pairs = [_term(values, *texel_weights(hemisphere_map, parametrisation, "cosine"), norm) for values in channels]
        first, second = (
            hemisphere_map.image(np.stack(side, axis=-1))[None].astype(np.float32) for side in zip(*pairs, strict=True)
        )
        tried.append(SeparableFactors(hemisphere_map, parametrisation, first, second, brdf.isotropic))
    return min(tried, key=lambda factors: reference.rms(factors)[0])


def whole(matrix: BrdfMatrix, channel: int) -> Floats:
    """(n, n): every row of the matrix, also those that were not sampled because they mirror others."""
    ones = np.ones(matrix.rows.shape[2])
    parts = [sector.right(sector.left(sector.matrix).T).T for sector in matrix.sectors(channel, ones, ones)]
    total: Floats = np.sum(parts, axis=0)
    return total


def _term(values: Floats, rows: Floats, columns: Floats, norm: float) -> tuple[Floats, Floats]:
    """g (n,) with the factor s, and h (n,), for weights that are squares of `rows` and `columns`."""
    row_share, column_share = rows**2 / (rows**2).sum(), columns**2 / (columns**2).sum()
    if np.isinf(norm):
        sizes = values.max(axis=1)
    else:
        sizes = (values**norm @ column_share) ** (1.0 / norm)
    lit = sizes > 0.0
    mean = row_share[lit] @ (values[lit] / sizes[lit, None])
    energy = (row_share @ sizes**2) * (column_share @ mean**2)
    scale = float((row_share * sizes) @ values @ (column_share * mean)) / energy if energy > 0.0 else 0.0
    return scale * sizes, mean
