"""The energy that the Gaussian fit lowers, term by term, and its gradient (Green2006 Eq. 6).

The fit itself works view by view (`engine.transport.gaussian.fitting.vertex_kernel`); this is the whole, written as in
the paper, to say what was reached and to prove what the fit does. Terms as `engine.transport.gaussian.fitting.fit` has
them: the distance relative to the data, averages over neighbouring views that reflect, and max(−⟨a, b⟩, 0)² for
Green2006 Eq. 10.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.transport.gaussian.fitting.fit import FitSettings, TransportSamples
from engine.transport.gaussian.fitting.lobes import gaussian
from engine.transport.gaussian.fitting.views import VIEWS, view_neighbours

Array = NDArray[np.float64]

#: Views darker than this share of the brightest, by root mean square, count less than others.
DIM = 0.01


@dataclass(frozen=True, eq=False)
class Energies:
    """The four terms of a vertex with their weights, and the derivatives of their sum.

    Attributes
    ----------
    data, mean_alignment, sigma_alignment, spatial : alpha D, beta M, gamma V and delta S, summed over views.
    weight : (92, L, 3), mean : (92, L, 3) along the sphere, sigma : (92, L): derivatives.
    """

    data: float
    mean_alignment: float
    sigma_alignment: float
    spatial: float
    weight: Array
    mean: Array
    sigma: Array

    @property
    def total(self) -> float:
        return self.data + self.mean_alignment + self.sigma_alignment + self.spatial


def energies(
    samples: TransportSamples, weight: Array, mean: Array, sigma: Array, near_mean: Array, settings: FitSettings
) -> Energies:
    """The energies of one vertex with lobes weight (92, L, 3), unit mean (92, L, 3), sigma (92, L).

    `samples` are those of the vertex alone; `near_mean` (K, 92, L, 3) are the means of neighbours that are done.
    """
    slope_weight, slope_mean, slope_sigma = np.zeros(weight.shape), np.zeros(mean.shape), np.zeros(sigma.shape)
    rows = [slice(samples.start[view], samples.start[view + 1]) for view in range(VIEWS)]
    square = np.array([(samples.area[row, None] * samples.value[row] ** 2).sum() for row in rows])
    lit = square > 0.0
    data = 0.0
    for view in np.flatnonzero(lit):
        scale = settings.data / max(square[view], DIM**2 * square.max())
        parts = _distance(samples, rows[view], weight[view], mean[view], sigma[view])
        data += scale * parts[0]
        for slope, part in zip((slope_weight, slope_mean, slope_sigma), parts[1:], strict=True):
            slope[view] += scale * part
    aligned_mean, by_mean = _alignment(mean, lit)
    aligned_sigma, by_sigma = _alignment(sigma[..., None], lit)
    spatial, by_arrangement = spatial_energy(mean[lit], near_mean[:, lit])
    slope_mean += settings.mean_alignment * by_mean
    slope_mean[lit] += settings.spatial * by_arrangement
    slope_sigma += settings.sigma_alignment * by_sigma[..., 0]
    slope_mean -= np.einsum("vli,vli->vl", slope_mean, mean)[..., None] * mean
    return Energies(
        data,
        settings.mean_alignment * aligned_mean,
        settings.sigma_alignment * aligned_sigma,
        settings.spatial * spatial,
        slope_weight,
        slope_mean,
        slope_sigma,
    )


def _distance(
    samples: TransportSamples, row: slice, weight: Array, mean: Array, sigma: Array
) -> tuple[float, Array, Array, Array]:
    """Green2006 Eq. 7 as an integral over the sphere, and its derivatives by weights, means and widths of one view."""
    direction, area = samples.direction[row, None], samples.area[row]
    value = gaussian(direction, mean, sigma)
    left = value @ weight - samples.value[row]
    by_weight = 2.0 * np.einsum("s,sl,sc->lc", area, value, left)
    pull = 2.0 * np.einsum("s,sl,lc,sc->sl", area, value, weight, left)
    apart = direction - mean
    by_mean = np.einsum("sl,sli->li", pull, apart) / sigma[:, None] ** 2
    by_sigma = np.einsum("sl,sl->l", pull, (apart**2).sum(axis=-1)) / sigma**3
    return float((area[:, None] * left**2).sum()), by_weight, by_mean, by_sigma


def _alignment(values: Array, lit: NDArray[np.bool_]) -> tuple[float, Array]:
    """Green2006 Eq. 8 and Green2006 Eq. 9: Σ |average of the neighbours − own|² over views that reflect, and its
    derivatives.

    `values` (92, L, D). Only neighbours that reflect count; a view without any has no term.
    """
    neighbours, _ = view_neighbours()
    beside = (neighbours >= 0) & lit[neighbours]
    count = beside.sum(axis=1)
    counted = lit & (count > 0)
    share = beside / np.maximum(count, 1)[:, None]
    unlike = np.where(counted[:, None, None], np.einsum("vk,vkld->vld", share, values[neighbours]) - values, 0.0)
    slope = -2.0 * unlike
    np.add.at(slope, neighbours, 2.0 * share[:, :, None, None] * unlike[:, None])
    return float((unlike**2).sum()), slope


def spatial_energy(mean: Array, near_mean: Array) -> tuple[float, Array]:
    """Green2006 Eq. 10 as it was meant, Σ max(−⟨a, b⟩, 0)², and its derivatives by `mean` (…, L, 3).

    a and b are differences of the means of a pair of lobes, here and at each neighbour, `near_mean` (K, …, L, 3). As
    printed, Σ max((−⟨a, b⟩)², 0), the square is never negative, so agreement would cost as much as flipping.
    """
    total, slope = 0.0, np.zeros(mean.shape)
    lobes = mean.shape[-2]
    for one in range(lobes):
        for other in range(one + 1, lobes):
            a = mean[..., one, :] - mean[..., other, :]
            b = near_mean[..., one, :] - near_mean[..., other, :]
            flipped = np.maximum(-np.einsum("...i,k...i->k...", a, b), 0.0)
            total += float((flipped**2).sum())
            by_a = -2.0 * np.einsum("k...,k...i->...i", flipped, b)
            slope[..., one, :] += by_a
            slope[..., other, :] -= by_a
    return total, slope
