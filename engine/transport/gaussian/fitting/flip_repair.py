"""Views whose lobes still disagree with neighbours once they are numbered well, fitted anew from what is beside them.

A view by itself may have found another arrangement that is as near to the data: side by side where its neighbours are
one inside the other, or turned by half a turn. It starts from the lobes of each neighbouring vertex and view, with more
weight on their arrangement (Green2006 Eq. 10), and takes what leaves the fewest flips at hardly more distance.

Bound by exponentials, as the fit; few views are concerned (1 % of a bust of 1,617 vertices and two lobes).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar
from engine.transport.gaussian.fitting.lobe_matching import compare
from engine.transport.gaussian.fitting.vertex_kernel import arrange, leave_over, set_pull, sums
from engine.transport.gaussian.fitting.view_kernel import moments, refine

Bools = NDArray[np.bool_]
Indices = NDArray[np.int64]
Floats = NDArray[np.floating]

#: Steps of a start, and how many times the weight of Green2006 Eq. 10 counts.
STEPS, FIRM = 20, 10.0

#: Distance that is taken for fewer flips: so many times that of before, and so much more.
LOOSE, SLACK = 1.1, 0.01


@scalar
def count_flips_of(
    vertex: int, view: int, weight: Floats, mean: Floats, sigma: Floats, near: Indices, neighbours: Indices,
    orders: Indices,
) -> int:  # fmt: skip
    """Flips between a view of a vertex and the views beside it, and the same view of the vertices `near` (K,)."""
    w, m, s = weight[vertex, view], mean[vertex, view], sigma[vertex, view]
    flips = 0
    for other in near:
        flips += max(compare(w, m, s, weight[other, view], mean[other, view], sigma[other, view], orders), 0)
    for beside in neighbours[view]:
        if beside >= 0:
            found = compare(w, m, s, weight[vertex, beside], mean[vertex, beside], sigma[vertex, beside], orders)
            flips += max(found, 0)
    return flips


@scalar
def repair_vertex(
    vertex: int, start: Indices, direction: Floats, value: Floats, area: Floats, lit: Bools, energy: Floats,
    near: Indices, neighbours: Indices, orders: Indices, strengths: Floats, weight: Floats, mean: Floats,
    sigma: Floats, error: Floats, preserving: Floats,
) -> int:  # fmt: skip
    """Fit the flipped views of a vertex anew, in place; how many have changed.

    `start` (93,) bounds the samples of each view, `lit` (92,) and `energy` (92, 3) are the vertex's own, `near` (K,)
    its neighbours, `strengths` alpha, beta, gamma, delta; the others are the arrays of all vertices (`Fit`).
    """
    views, lobes = sigma.shape[1:]
    own_mean, own_sigma = mean[vertex].astype(np.float64), sigma[vertex].astype(np.float64)
    near_mean = np.empty((len(near), views, lobes, 3))
    for k in range(len(near)):
        near_mean[k] = mean[near[k]]
    pull = np.zeros((lobes + 1, 4))
    arrangements = np.zeros((len(near), lobes * (lobes - 1) // 2, 3))
    axes, functions = np.empty((lobes, 2, 3)), np.empty(4 * lobes)
    gram, cross = np.empty((4 * lobes, 4 * lobes)), np.empty((4 * lobes, 3))
    trial_mean, trial_sigma, trial_weight = np.empty((lobes, 3)), np.empty(lobes), np.empty((lobes, 3))
    spare, left = np.empty(3), np.empty(2)
    changed = 0
    for view in range(views):
        fewest = count_flips_of(vertex, view, weight, mean, sigma, near, neighbours, orders) if lit[view] else 0
        if fewest == 0:
            continue
        before = fewest
        best_weight, best_mean = weight[vertex, view].copy(), mean[vertex, view].copy()
        best_sigma, best_error = sigma[vertex, view].copy(), np.array([error[vertex, view], preserving[vertex, view]])
        allowed = LOOSE * error[vertex, view] + SLACK
        rows = slice(start[view], start[view + 1])
        square = sums(value[rows], area[rows], spare)
        set_pull(view, lit, own_mean, own_sigma, neighbours, strengths[1], strengths[2], FIRM * strengths[3], pull)
        arrange(near_mean, view, arrangements)
        for way in range(len(near) + neighbours.shape[1] + 1):
            if way < len(near):
                trial_mean[:], trial_sigma[:] = mean[near[way], view], sigma[near[way], view]
            else:
                beside = neighbours[view, way - len(near)] if way < len(near) + neighbours.shape[1] else view
                if beside < 0 or not lit[beside]:
                    continue
                trial_mean[:], trial_sigma[:] = own_mean[beside], own_sigma[beside]
            refine(
                direction[rows], value[rows], area[rows], square, strengths[0] / square, pull, arrangements,
                trial_mean, trial_sigma, trial_weight, STEPS,
            )  # fmt: skip
            moments(direction[rows], value[rows], area[rows], trial_mean, trial_sigma, axes, functions, gram, cross)
            leave_over(gram, cross, square, energy[view], trial_sigma, trial_weight, left)
            if left[0] > allowed:
                continue
            weight[vertex, view], mean[vertex, view], sigma[vertex, view] = trial_weight, trial_mean, trial_sigma
            flips = count_flips_of(vertex, view, weight, mean, sigma, near, neighbours, orders)
            if flips < fewest or (flips == fewest < before and left[0] < best_error[0]):
                fewest, best_error[:] = flips, left
                best_weight[:], best_mean[:], best_sigma[:] = trial_weight, trial_mean, trial_sigma
        weight[vertex, view], mean[vertex, view], sigma[vertex, view] = best_weight, best_mean, best_sigma
        own_mean[view], own_sigma[view] = best_mean, best_sigma
        error[vertex, view], preserving[vertex, view] = best_error
        changed += fewest < before
    return changed
