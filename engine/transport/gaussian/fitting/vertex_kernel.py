"""The compiled loops of the Gaussian fit: all views of a vertex, from starts to what it leaves over.

A vertex takes these steps. 1. Each view by itself, from starts that come from the data (peak and moments, then what is
left over, halves of a lobe, a narrow lobe in a wide one) and from vertices that are done: the best is kept. 2. Lobes
are numbered so that they agree with those of neighbouring views and vertices. 3. Sweeps over the views (Gauss and
Seidel), each with the pull of its neighbours, which lower the energy of Green2006 Eq. 6 every time. 4. Views that
reflect nothing get weights of 0, and means and widths that are harmonic over the graph of views.
"""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar
from engine.transport.gaussian.fitting.fill_kernel import fill_dark, fill_views
from engine.transport.gaussian.fitting.lobes import NARROWEST, WIDEST_LOBE
from engine.transport.gaussian.fitting.start_kernel import start_view
from engine.transport.gaussian.fitting.view_kernel import (
    add_pulls,
    copy_lobes,
    data_gradient,
    integral,
    moments,
    refine,
)

Bools = NDArray[np.bool_]
Indices = NDArray[np.integer]
Floats = NDArray[np.floating]

#: Views darker than this share of the brightest, by root mean square, count less than others.
DIM = 0.01

#: Share of the brightest from which on a view reflects nothing that could be seen, and the least transport at all, both
#: squared: the far side of a narrow lobe is as small as doubles are, and has no reciprocal.
DARK, DARKEST = 1e-24, 1e-60

#: Steps of a start, of the best start, and of a view in a sweep, in a hurry.
HURRIED = np.array([6, 0, 0], np.int64)

#: A sweep that lowers the energy by less than this share is the last.
SETTLED = 1e-5

#: Most neighbouring vertices that are looked at.
NEAR = 8

#: All ways to number two and three lobes.
ORDERS = tuple(np.array(list(permutations(range(lobes))), np.int64) for lobes in (1, 2, 3))


@scalar
def apart(order: Indices, mean: Floats, sigma: Floats, other_mean: Floats, other_sigma: Floats) -> float:
    """Distance of lobes (L, …) taken in `order` from others: Σ |mean − other|² + (sigma − other)²."""
    total = 0.0
    for lobe in range(len(sigma)):
        own = order[lobe]
        total += (sigma[own] - other_sigma[lobe]) ** 2
        for axis in range(3):
            total += (mean[own, axis] - other_mean[lobe, axis]) ** 2
    return total


@scalar
def reorder(order: Indices, mean: Floats, sigma: Floats, weight: Floats) -> None:
    """Number lobes (L, …) anew in place: that which was `order`[l] becomes l."""
    lobes = len(sigma)
    old_mean, old_sigma, old_weight = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    copy_lobes(mean, sigma, weight, old_mean, old_sigma, old_weight)
    for lobe in range(lobes):
        own = order[lobe]
        sigma[lobe] = old_sigma[own]
        for axis in range(3):
            mean[lobe, axis], weight[lobe, axis] = old_mean[own, axis], old_weight[own, axis]


@scalar
def number_lobes(
    strength: Floats,
    mean: Floats,
    sigma: Floats,
    weight: Floats,
    near_mean: Floats,
    near_sigma: Floats,
    neighbours: Indices,
    orders: Indices,
) -> None:
    """Number the lobes (92, L, …) in place so that neighbouring views, and vertices (K, 92, L, …), agree.

    From the strongest view outwards, each by the views that are done and by the vertices; then again in sweeps, by all
    neighbours, while that helps. `strength` (92,) is 0 for views without transport.
    """
    views = len(sigma)
    done = np.zeros(views, np.bool_)
    for sweep in range(12):
        changed = False
        for turn in range(views):
            view = _next_view(strength, done, neighbours) if sweep == 0 else turn
            if view < 0:
                break
            if not strength[view] > 0.0:
                continue
            best, lowest = 0, np.inf
            for way in range(len(orders)):
                unlike = 0.0
                for near in range(len(near_sigma)):
                    unlike += apart(orders[way], mean[view], sigma[view], near_mean[near, view], near_sigma[near, view])
                for k in range(neighbours.shape[1]):
                    other = neighbours[view, k]
                    if other >= 0 and done[other]:
                        unlike += apart(orders[way], mean[view], sigma[view], mean[other], sigma[other])
                if unlike < lowest - 1e-12:
                    best, lowest = way, unlike
            done[view] = True
            if best > 0:
                changed = True
                reorder(orders[best], mean[view], sigma[view], weight[view])
        if sweep > 0 and not changed:
            break


@scalar
def _next_view(strength: Floats, done: Bools, neighbours: Indices) -> int:
    """The strongest view beside one that is done, else the strongest that is not; −1 where all are."""
    best, highest, beside = -1, 0.0, False
    for view in range(len(strength)):
        if done[view] or not strength[view] > 0.0:
            continue
        joined = False
        for k in range(neighbours.shape[1]):
            other = neighbours[view, k]
            joined = joined or (other >= 0 and done[other])
        if (joined and not beside) or (joined == beside and strength[view] > highest):
            best, highest, beside = view, strength[view], joined
    return best


@scalar
def set_pull(
    view: int,
    lit: Bools,
    mean: Floats,
    sigma: Floats,
    neighbours: Indices,
    beta: float,
    gamma: float,
    delta: float,
    pull: Floats,
) -> None:
    """Fill `pull` (L + 1, 4): all terms of Green2006 Eq. 8 and Green2006 Eq. 9 in which a view takes part, as one
    square.

    The view's own term draws it to the average of its neighbours that reflect; those of its neighbours u, with R of
    their own, to R u minus the rest, with the weight 1 / R².
    """
    lobes = sigma.shape[1]
    for row in range(lobes + 1):
        for axis in range(4):
            pull[row, axis] = 0.0
    total, own = 0.0, 0
    for k in range(neighbours.shape[1]):
        other = neighbours[view, k]
        if other < 0 or not lit[other]:
            continue
        own += 1
        around = 0
        for j in range(neighbours.shape[1]):
            third = neighbours[other, j]
            around += third >= 0 and lit[third]
        share = 1.0 / (around * around)
        total += share
        for lobe in range(lobes):
            for axis in range(3):
                rest = 0.0
                for j in range(neighbours.shape[1]):
                    third = neighbours[other, j]
                    if third >= 0 and lit[third] and third != view:
                        rest += mean[third, lobe, axis]
                pull[lobe, axis] += share * (around * mean[other, lobe, axis] - rest)
            rest = 0.0
            for j in range(neighbours.shape[1]):
                third = neighbours[other, j]
                if third >= 0 and lit[third] and third != view:
                    rest += sigma[third, lobe]
            pull[lobe, 3] += share * (around * sigma[other, lobe] - rest)
    pull[lobes, 2] = delta
    if own == 0:
        return
    for k in range(neighbours.shape[1]):
        other = neighbours[view, k]
        if other >= 0 and lit[other]:
            for lobe in range(lobes):
                for axis in range(3):
                    pull[lobe, axis] += mean[other, lobe, axis] / own
                pull[lobe, 3] += sigma[other, lobe] / own
    total += 1.0
    for lobe in range(lobes):
        for axis in range(4):
            pull[lobe, axis] /= total
    pull[lobes, 0], pull[lobes, 1] = beta * total, gamma * total


@scalar
def arrange(near_mean: Floats, view: int, arrangements: Floats) -> None:
    """Fill `arrangements` (K, P, 3): differences between the means of each pair of lobes of neighbouring vertices."""
    lobes = near_mean.shape[2]
    for near in range(len(near_mean)):
        pair = 0
        for one in range(lobes):
            for other in range(one + 1, lobes):
                for axis in range(3):
                    arrangements[near, pair, axis] = (
                        near_mean[near, view, one, axis] - near_mean[near, view, other, axis]
                    )
                pair += 1


@scalar
def sums(value: Floats, area: Floats, energy: Floats) -> float:
    """Fill `energy` (3,) with the integral of the data; returns that of its square."""
    square = 0.0
    for c in range(3):
        energy[c] = 0.0
    for s in range(len(area)):
        for c in range(3):
            energy[c] += area[s] * value[s, c]
            square += area[s] * value[s, c] * value[s, c]
    return square


@scalar
def leftover(gram: Floats, cross: Floats, square: float, weight: Floats, factor: Floats) -> float:
    """Relative distance between the data and the lobes with weights times `factor` (3,)."""
    distance = square
    for c in range(3):
        for lobe in range(len(weight)):
            distance -= 2.0 * factor[c] * weight[lobe, c] * cross[lobe, c]
            for other in range(len(weight)):
                product = gram[max(lobe, other), min(lobe, other)]
                distance += factor[c] * factor[c] * weight[lobe, c] * weight[other, c] * product
    return math.sqrt(max(distance, 0.0) / square)


@scalar
def leave_over(
    gram: Floats, cross: Floats, square: float, energy: Floats, sigma: Floats, weight: Floats, error: Floats
) -> None:
    """Fill `error` (2,) of one view: its relative distance with the weights given, and with them scaled to `energy`."""
    factor = np.ones(3)
    error[0] = leftover(gram, cross, square, weight, factor)
    for c in range(3):
        obtained = 0.0
        for lobe in range(len(sigma)):
            obtained += weight[lobe, c] * integral(sigma[lobe])
        factor[c] = energy[c] / obtained if obtained > 0.0 else 1.0
    error[1] = leftover(gram, cross, square, weight, factor)


@scalar
def fit_vertex(
    start: Indices,
    direction: Floats,
    value: Floats,
    area: Floats,
    near_mean: Floats,
    near_sigma: Floats,
    strengths: Floats,
    sweeps: int,
    steps: Indices,
    neighbours: Indices,
    directions: Floats,
    orders: Indices,
    weight: Floats,
    mean: Floats,
    sigma: Floats,
    energy: Floats,
    norm: Floats,
    error: Floats,
) -> float:
    """All views of one vertex: fills weight (92, L, 3), mean, sigma, energy (92, 3), norm (92,), error (92, 2).

    `start` (93,) bounds the samples of each view, `near_…` (K, 92, L, …) are neighbouring vertices that are done,
    `strengths` are alpha, beta, gamma, delta, `steps` (3,) those of each start, of the best start, and of a view in a
    sweep. What is filled is 0 before. Returns the largest slope that is left of the energy, each view's by its own
    parameters with widths within their bounds.
    """
    views, lobes = sigma.shape
    square, scale, lit = np.zeros(views), np.zeros(views), np.zeros(views, np.bool_)
    for view in range(views):
        rows = slice(start[view], start[view + 1])
        square[view] = sums(value[rows], area[rows], energy[view])
    brightest = square.max()
    for view in range(views):
        lit[view] = square[view] > max(DARK * brightest, DARKEST)
        if lit[view]:
            norm[view] = math.sqrt(square[view])
        else:
            energy[view] = 0.0
    if not brightest > DARKEST:
        fill_dark(near_mean, near_sigma, directions, mean, sigma)
        return 0.0
    for view in range(views):
        if lit[view]:
            rows = slice(start[view], start[view + 1])
            scale[view] = strengths[0] / max(square[view], DIM * DIM * brightest)
            start_view(
                direction[rows], value[rows], area[rows], square[view], 1.0 / square[view], near_mean[:2, view],
                near_sigma[:2, view], mean[view], sigma[view], weight[view], steps,
            )  # fmt: skip
    if lobes > 1:
        number_lobes(square, mean, sigma, weight, near_mean, near_sigma, neighbours, orders)
    pull = np.zeros((lobes + 1, 4))
    arrangements = np.zeros((len(near_mean), lobes * (lobes - 1) // 2, 3))
    trial_mean, trial_sigma, trial_weight = np.empty((lobes, 3)), np.empty(lobes), np.empty((lobes, 3))
    for sweep in range(sweeps):
        lowered, total = 0.0, 0.0
        for view in range(views):
            if not lit[view]:
                continue
            rows = slice(start[view], start[view + 1])
            set_pull(view, lit, mean, sigma, neighbours, strengths[1], strengths[2], strengths[3], pull)
            arrange(near_mean, view, arrangements)
            before, now = refine(
                direction[rows], value[rows], area[rows], square[view], scale[view], pull, arrangements, mean[view],
                sigma[view], weight[view], steps[2],
            )  # fmt: skip
            if sweep < 2 and pull[lobes, 0] > 0.0:
                _pull_start(pull, trial_mean, trial_sigma)
                other = refine(
                    direction[rows], value[rows], area[rows], square[view], scale[view], pull, arrangements,
                    trial_mean, trial_sigma, trial_weight, steps[0] if lobes > 1 else 0,
                )[1]  # fmt: skip
                if other < now:
                    now = other
                    copy_lobes(trial_mean, trial_sigma, trial_weight, mean[view], sigma[view], weight[view])
            lowered += before - now
            total += now
        if lowered <= SETTLED * total:
            break
    slope = _finish(
        start, direction, value, area, near_mean, strengths, neighbours, square, scale, lit, weight, mean, sigma,
        energy, error,
    )  # fmt: skip
    fill_views(lit, mean, sigma, neighbours)
    return slope


@scalar
def _pull_start(pull: Floats, mean: Floats, sigma: Floats) -> None:
    """A start where the neighbours would have the lobes."""
    for lobe in range(len(sigma)):
        length = 0.0
        for axis in range(3):
            length += pull[lobe, axis] ** 2
        for axis in range(3):
            mean[lobe, axis] = pull[lobe, axis] / math.sqrt(length) if length > 1e-12 else (1.0 if axis == 2 else 0.0)
        sigma[lobe] = min(max(pull[lobe, 3], NARROWEST), WIDEST_LOBE)


@scalar
def _finish(
    start: Indices, direction: Floats, value: Floats, area: Floats, near_mean: Floats, strengths: Floats,
    neighbours: Indices, square: Floats, scale: Floats, lit: Bools, weight: Floats, mean: Floats, sigma: Floats,
    energy: Floats, error: Floats,
) -> float:  # fmt: skip
    """Fill `error` (92, 2), plain and with the energy kept; returns the largest slope that is left."""
    views, lobes = sigma.shape
    axes, functions = np.empty((lobes, 2, 3)), np.empty(4 * lobes)
    gram, cross = np.empty((4 * lobes, 4 * lobes)), np.empty((4 * lobes, 3))
    gradient, hessian = np.empty(3 * lobes), np.zeros((3 * lobes, 3 * lobes))
    pull = np.zeros((lobes + 1, 4))
    arrangements = np.zeros((len(near_mean), lobes * (lobes - 1) // 2, 3))
    steepest = 0.0
    for view in range(views):
        if not lit[view]:
            continue
        rows = slice(start[view], start[view + 1])
        moments(direction[rows], value[rows], area[rows], mean[view], sigma[view], axes, functions, gram, cross)
        leave_over(gram, cross, square[view], energy[view], sigma[view], weight[view], error[view])
        set_pull(view, lit, mean, sigma, neighbours, strengths[1], strengths[2], strengths[3], pull)
        arrange(near_mean, view, arrangements)
        data_gradient(gram, cross, lobes, weight[view], scale[view], gradient)
        add_pulls(pull, arrangements, mean[view], sigma[view], axes, gradient, hessian)
        for lobe in range(lobes):
            for p in range(3):
                slope = gradient[3 * lobe + p]
                low, high = sigma[view, lobe] <= NARROWEST, sigma[view, lobe] >= WIDEST_LOBE
                if p < 2 or not ((low and slope > 0.0) or (high and slope < 0.0)):
                    steepest = max(steepest, abs(slope))
    return steepest
