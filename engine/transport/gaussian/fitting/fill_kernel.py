"""The compiled loops of the Gaussian fit: means and widths where nothing is reflected, so that views interpolate well.

Views of a vertex that reflect nothing, below its horizon or in full shadow, are where Green2006 Eq. 8 and
Green2006 Eq. 9 vanish: each is the average of its neighbours. A vertex that reflects nothing at all takes
over its neighbours.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar
from engine.transport.gaussian.fitting.view_kernel import cholesky, solve

Bools = NDArray[np.bool_]
Indices = NDArray[np.integer]
Floats = NDArray[np.floating]

#: Width of lobes where nothing is reflected anywhere, in rad.
UNKNOWN = 0.5


@scalar
def fill_views(lit: Bools, mean: Floats, sigma: Floats, neighbours: Indices) -> None:
    """Give views that are not lit means and widths (92, L, …) that are harmonic: each the average of its neighbours.

    Means are brought to the sphere, and then each to the direction of its neighbours' average until nothing moves.
    Some view must be lit.
    """
    views, lobes = sigma.shape
    number, count = np.full(views, -1, np.int64), 0
    for view in range(views):
        if not lit[view]:
            number[view] = count
            count += 1
    matrix, right = np.zeros((count, count)), np.zeros((4 * lobes, count))
    for view in range(views):
        if lit[view]:
            continue
        row = number[view]
        for k in range(neighbours.shape[1]):
            other = neighbours[view, k]
            if other < 0:
                continue
            matrix[row, row] += 1.0
            if not lit[other]:
                matrix[row, number[other]] -= 1.0
                continue
            for lobe in range(lobes):
                for axis in range(3):
                    right[4 * lobe + axis, row] += mean[other, lobe, axis]
                right[4 * lobe + 3, row] += sigma[other, lobe]
    cholesky(matrix, count)
    for part in range(4 * lobes):
        solve(matrix, count, right[part])
    for view in range(views):
        if lit[view]:
            continue
        row = number[view]
        for lobe in range(lobes):
            sigma[view, lobe] = right[4 * lobe + 3, row]
            length = math.sqrt(
                right[4 * lobe, row] ** 2 + right[4 * lobe + 1, row] ** 2 + right[4 * lobe + 2, row] ** 2
            )
            for axis in range(3):
                mean[view, lobe, axis] = (
                    right[4 * lobe + axis, row] / length if length > 1e-9 else (1.0 if axis == 2 else 0.0)
                )
    _settle_means(lit, mean, neighbours)


@scalar
def _settle_means(lit: Bools, mean: Floats, neighbours: Indices) -> None:
    views, lobes = len(lit), mean.shape[1]
    average = np.empty(3)
    for _ in range(2000):
        farthest = 0.0
        for view in range(views):
            if lit[view]:
                continue
            for lobe in range(lobes):
                for axis in range(3):
                    average[axis] = 0.0
                for k in range(neighbours.shape[1]):
                    other = neighbours[view, k]
                    if other >= 0:
                        for axis in range(3):
                            average[axis] += mean[other, lobe, axis]
                length = math.sqrt(average[0] ** 2 + average[1] ** 2 + average[2] ** 2)
                if length < 1e-9:
                    continue
                for axis in range(3):
                    place = average[axis] / length
                    farthest = max(farthest, abs(place - mean[view, lobe, axis]))
                    mean[view, lobe, axis] = place
        if farthest < 1e-9:
            break


@scalar
def fill_dark(near_mean: Floats, near_sigma: Floats, directions: Floats, mean: Floats, sigma: Floats) -> None:
    """Means and widths of a vertex that reflects nothing: those of its neighbours on average, else its views."""
    views, lobes = sigma.shape
    for view in range(views):
        for lobe in range(lobes):
            sigma[view, lobe] = UNKNOWN
            for axis in range(3):
                mean[view, lobe, axis] = directions[view, axis]
            if len(near_sigma) == 0:
                continue
            length, total = 0.0, 0.0
            for axis in range(3):
                part = 0.0
                for near in range(len(near_sigma)):
                    part += near_mean[near, view, lobe, axis]
                mean[view, lobe, axis] = part
                length += part * part
            for near in range(len(near_sigma)):
                total += near_sigma[near, view, lobe]
            sigma[view, lobe] = total / len(near_sigma)
            for axis in range(3):
                mean[view, lobe, axis] = (
                    mean[view, lobe, axis] / math.sqrt(length) if length > 1e-12 else directions[view, axis]
                )
