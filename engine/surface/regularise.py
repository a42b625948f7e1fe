"""Roughness and metallic of texels that the photographs do not decide: from their neighbours.

Roughness is filtered by its own reliability (Lee1980): m + k (r − m), m being the mean of the neighbours weighted with
their inverse variance and k = 1 − v / s² the share of the local variance s² that noise of the variance v does not
explain. The stated variance misses what makes single texels differ, so v is at least half the mean squared difference
of neighbours: structure is broader than a texel, grains of salt and pepper are not.

Whether a texel is a metal is a Potts model with the evidence of each texel in squared deviations: the mean evidence of
the neighbours, limited for each, counts as much as `NEIGHBOURS` texels. Strong evidence of a texel stands.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.surface.bands import filter_in_bands, list_bands, smooth

Plane = NDArray[np.float64]
Map = NDArray[np.float32]

#: Deviation of the Gaussian of neighbours, in texels.
NEAR = 2.0

#: Rows that a texel depends on above and below, as means of squares about a mean reach twice as far as the Gaussian.
AROUND = 16

#: Largest evidence of one neighbour in squared deviations, and texels as which all neighbours count together.
LIMIT, NEIGHBOURS = 9.0, 6.0


def smooth_roughness(roughness: Map, sigma: Map, outside: NDArray[np.bool_]) -> tuple[Map, Map]:
    """(H, W) roughness and its deviation, of those that were found (H, W); texels `outside` (H, W) do not count."""
    found, deviation = np.empty_like(roughness), np.empty_like(sigma)
    for band, rows, inner in list_bands(len(roughness), AROUND):
        of_band = _smooth_band(roughness[rows], sigma[rows], outside[rows])
        found[band], deviation[band] = (each[inner] for each in of_band)
    return found, deviation


def _smooth_band(roughness: Map, sigma: Map, outside: NDArray[np.bool_]) -> tuple[Map, Map]:
    values = roughness.astype(np.float64)
    inside = (~outside).astype(np.float64)
    stated = np.maximum(sigma.astype(np.float64), 0.01) ** 2
    weight = inside / stated
    total = np.maximum(_near(weight), 1e-12)
    mean = _near(weight * values) / total
    spread = _near(weight * (values - mean) ** 2) / total
    noise = np.maximum(stated, _difference_of_neighbours(values, inside))
    kept = np.clip(1.0 - noise / np.maximum(spread, 1e-12), 0.0, 1.0)
    # a texel that is known far better than its surroundings stands
    kept = np.maximum(kept, np.clip(1.0 - stated / np.maximum(0.25 * noise, 1e-12), 0.0, 1.0) * (stated < 0.02**2))
    found = mean + kept * (values - mean)
    moved = np.maximum(sigma.astype(np.float64) ** 2, kept**2 * noise + (1.0 - kept) ** 2 * spread)
    keep = outside | (_near(inside) < 1e-6)
    return (
        np.where(keep, roughness, found).astype(np.float32),
        np.where(keep, sigma, np.minimum(np.sqrt(moved), 0.5)).astype(np.float32),
    )


def weigh_neighbours(evidence: Map, threshold: float, outside: NDArray[np.bool_]) -> Map:
    """(H, W) evidence of its own that a texel needs to be a metal, `threshold` where its neighbours say nothing."""

    def weigh(evidence: Map, outside: NDArray[np.bool_]) -> Map:
        inside = (~outside).astype(np.float64)
        over = np.clip(evidence.astype(np.float64) - threshold, -LIMIT, LIMIT) * inside
        mean = _near(over) / np.maximum(_near(inside), 1e-6)
        return np.asarray(threshold - NEIGHBOURS * mean, np.float32)

    return np.asarray(filter_in_bands(weigh, AROUND, evidence, outside))


def _near(values: Plane) -> Plane:
    return np.asarray(smooth(values, NEAR))


def _difference_of_neighbours(values: Plane, inside: Plane) -> Plane:
    """(H, W) half of the mean squared difference of neighbours: the variance of what differs from texel to texel."""
    squares, number = np.zeros_like(values), np.zeros_like(values)
    for one, other in ((np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1])):
        both = inside[one] * inside[other]
        found = 0.5 * both * (values[one] - values[other]) ** 2
        for end in (one, other):
            squares[end] += found
            number[end] += both
    return np.asarray(_near(squares) / np.maximum(_near(number), 1e-6))
