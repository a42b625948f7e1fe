"""The compiled loops of the Gaussian fit: one view, and the moments of its samples that everything follows from.

A view of L lobes has 3 L parameters that are not linear: for each lobe two steps of the mean in its tangent plane and
one of log sigma, the first two in units of sigma. Weights are linear; given the others, the best ones that are not
negative are found exactly, for each colour by itself (variable projection, Golub1973). Steps are those of
Levenberg and Marquardt on what is left when weights follow, and are taken only where they lower the energy.

The samples of a view are read once for each step tried: the products of the 4 L functions (the Gaussians and their
derivatives) with each other and with the data. That bounds the time: some 30 ns for a sample and one lobe.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar
from engine.transport.gaussian.fitting.lobes import NARROWEST, WIDEST_LOBE

Floats = NDArray[np.floating]

#: A Gaussian is not evaluated where it is below 2e-16.
FAR = 72.0

#: Farthest step of a mean in rad, and of log sigma.
LONGEST, STEEPEST = 0.5, 1.0

#: Samples must give the integral of the square of a Gaussian to this factor.
COARSE = 1.6

#: A step that promises less than this share of the energy, or of the square of the transport, is not taken.
ENOUGH, ROUNDING = 1e-6, 1e-15


@scalar
def tangents(mean: Floats, axes: Floats) -> None:
    """Two unit vectors `axes` (2, 3) that stand upright on `mean` (3,) and each other (Duff2017)."""
    x, y, z = mean[0], mean[1], mean[2]
    sign = 1.0 if z >= 0.0 else -1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    axes[0, 0], axes[0, 1], axes[0, 2] = 1.0 + sign * x * x * a, sign * b, -sign * x
    axes[1, 0], axes[1, 1], axes[1, 2] = b, sign + y * y * a, -y


@scalar
def copy_lobes(
    mean: Floats, sigma: Floats, weight: Floats, to_mean: Floats, to_sigma: Floats, to_weight: Floats
) -> None:
    """Copy lobes (L, …), as many as there are."""
    for lobe in range(len(sigma)):
        to_sigma[lobe] = sigma[lobe]
        for axis in range(3):
            to_mean[lobe, axis], to_weight[lobe, axis] = mean[lobe, axis], weight[lobe, axis]


@scalar
def moments(
    direction: Floats,
    value: Floats,
    area: Floats,
    mean: Floats,
    sigma: Floats,
    axes: Floats,
    functions: Floats,
    gram: Floats,
    cross: Floats,
) -> None:
    """Fill `gram` (4L, 4L), lower triangle, and `cross` (4L, 3) for samples (S, ...), and `axes` (L, 2, 3).

    Functions: the L Gaussians, then for each the derivatives by its three parameters. `functions` (4L,) is room.
    """
    lobes = len(sigma)
    count = 4 * lobes
    for lobe in range(lobes):
        tangents(mean[lobe], axes[lobe])
    if lobes == 1:
        _moments_of_one(direction, value, area, mean[0], sigma[0], axes[0], gram, cross)
        return
    for i in range(count):
        for j in range(i + 1):
            gram[i, j] = 0.0
        for c in range(3):
            cross[i, c] = 0.0
    for s in range(len(area)):
        x, y, z = direction[s, 0], direction[s, 1], direction[s, 2]
        near = False
        for lobe in range(lobes):
            inverse = 1.0 / sigma[lobe]
            dx, dy, dz = x - mean[lobe, 0], y - mean[lobe, 1], z - mean[lobe, 2]
            q = (dx * dx + dy * dy + dz * dz) * inverse * inverse
            at = lobes + 3 * lobe
            if q > FAR:
                functions[lobe] = functions[at] = functions[at + 1] = functions[at + 2] = 0.0
                continue
            near = True
            g = math.exp(-0.5 * q)
            functions[lobe] = g
            functions[at] = g * inverse * (x * axes[lobe, 0, 0] + y * axes[lobe, 0, 1] + z * axes[lobe, 0, 2])
            functions[at + 1] = g * inverse * (x * axes[lobe, 1, 0] + y * axes[lobe, 1, 1] + z * axes[lobe, 1, 2])
            functions[at + 2] = g * q
        if not near:
            continue
        red, green, blue = value[s, 0], value[s, 1], value[s, 2]
        for i in range(count):
            weighted = area[s] * functions[i]
            cross[i, 0] += weighted * red
            cross[i, 1] += weighted * green
            cross[i, 2] += weighted * blue
            for j in range(i + 1):
                gram[i, j] += weighted * functions[j]


@scalar
def _moments_of_one(
    direction: Floats,
    value: Floats,
    area: Floats,
    mean: Floats,
    sigma: float,
    axes: Floats,
    gram: Floats,
    cross: Floats,
) -> None:
    """`moments` of one lobe, with its sums in registers: four fifths of the time, half of which are exponentials."""
    inverse = 1.0 / sigma
    mx, my, mz = mean[0], mean[1], mean[2]
    ax, ay, az = axes[0, 0] * inverse, axes[0, 1] * inverse, axes[0, 2] * inverse
    bx, by, bz = axes[1, 0] * inverse, axes[1, 1] * inverse, axes[1, 2] * inverse
    limit = FAR / (inverse * inverse)
    g00 = g10 = g11 = g20 = g21 = g22 = g30 = g31 = g32 = g33 = 0.0
    c00 = c01 = c02 = c10 = c11 = c12 = c20 = c21 = c22 = c30 = c31 = c32 = 0.0
    for s in range(len(area)):
        x, y, z = direction[s, 0], direction[s, 1], direction[s, 2]
        dx, dy, dz = x - mx, y - my, z - mz
        q = dx * dx + dy * dy + dz * dz
        if q > limit:
            continue
        q *= inverse * inverse
        f0 = math.exp(-0.5 * q)
        f1, f2, f3 = f0 * (x * ax + y * ay + z * az), f0 * (x * bx + y * by + z * bz), f0 * q
        w0, w1, w2, w3 = area[s] * f0, area[s] * f1, area[s] * f2, area[s] * f3
        g00 += w0 * f0
        g10 += w1 * f0
        g11 += w1 * f1
        g20 += w2 * f0
        g21 += w2 * f1
        g22 += w2 * f2
        g30 += w3 * f0
        g31 += w3 * f1
        g32 += w3 * f2
        g33 += w3 * f3
        red, green, blue = value[s, 0], value[s, 1], value[s, 2]
        c00 += w0 * red
        c01 += w0 * green
        c02 += w0 * blue
        c10 += w1 * red
        c11 += w1 * green
        c12 += w1 * blue
        c20 += w2 * red
        c21 += w2 * green
        c22 += w2 * blue
        c30 += w3 * red
        c31 += w3 * green
        c32 += w3 * blue
    gram[0, 0], gram[1, 0], gram[1, 1] = g00, g10, g11
    gram[2, 0], gram[2, 1], gram[2, 2] = g20, g21, g22
    gram[3, 0], gram[3, 1], gram[3, 2], gram[3, 3] = g30, g31, g32, g33
    cross[0, 0], cross[0, 1], cross[0, 2] = c00, c01, c02
    cross[1, 0], cross[1, 1], cross[1, 2] = c10, c11, c12
    cross[2, 0], cross[2, 1], cross[2, 2] = c20, c21, c22
    cross[3, 0], cross[3, 1], cross[3, 2] = c30, c31, c32


@scalar
def integral(sigma: float) -> float:
    """∫ G over the sphere."""
    return -2.0 * math.pi * sigma * sigma * math.expm1(-2.0 / (sigma * sigma))


@scalar
def is_resolved(gram: Floats, sigma: Floats, weight: Floats) -> bool:
    """True if the samples lie densely enough for each lobe that has weight: they give the integral of its square.

    A lobe between samples costs nothing there, however high; one on a single sample is as narrow as one likes.
    """
    for lobe in range(len(sigma)):
        if weight[lobe, 0] + weight[lobe, 1] + weight[lobe, 2] > 0.0:
            share = gram[lobe, lobe] / integral(sigma[lobe] * math.sqrt(0.5))
            if not 1.0 / COARSE < share < COARSE:
                return False
    return True


@scalar
def cholesky(matrix: Floats, size: int) -> bool:
    """The lower factor of the first `size` rows in place; False where a pivot is lost to rounding."""
    for i in range(size):
        for j in range(i + 1):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            if i == j:
                if not total > 1e-13 * abs(matrix[i, i]):
                    return False
                matrix[i, i] = math.sqrt(total)
            else:
                matrix[i, j] = total / matrix[j, j]
    return True


@scalar
def solve(factor: Floats, size: int, vector: Floats) -> None:
    """Solve with a factor of `cholesky`, in place."""
    for i in range(size):
        for k in range(i):
            vector[i] -= factor[i, k] * vector[k]
        vector[i] /= factor[i, i]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            vector[i] -= factor[k, i] * vector[k]
        vector[i] /= factor[i, i]


@scalar
def best_weights(gram: Floats, cross: Floats, lobes: int, weight: Floats) -> float:
    """Fill `weight` (L, 3) ≥ 0 with the least-squares weights; returns the distance less the square of the data.

    For each colour all sets of lobes that may be lit are tried, which is exact: there are seven at most.
    """
    total = 0.0
    small, right, best = np.empty((3, 3)), np.empty(3), np.empty(3)
    chosen = np.empty(3, np.int64)
    for c in range(3):
        lowest = 0.0
        for lobe in range(3):
            best[lobe] = 0.0
        for lit in range((1 << lobes) - 1, 0, -1):
            count = 0
            for lobe in range(lobes):
                if lit >> lobe & 1 and gram[lobe, lobe] > 0.0:
                    chosen[count] = lobe
                    count += 1
            for i in range(count):
                right[i] = cross[chosen[i], c]
                for j in range(i + 1):
                    small[i, j] = gram[chosen[i], chosen[j]]
            if count == 0 or not cholesky(small, count):
                continue
            solve(small, count, right)
            value, allowed = 0.0, True
            for i in range(count):
                value -= right[i] * cross[chosen[i], c]
                allowed = allowed and right[i] >= 0.0
            if allowed and value < lowest:
                lowest = value
                for lobe in range(3):
                    best[lobe] = 0.0
                for i in range(count):
                    best[chosen[i]] = right[i]
            if allowed and lit == (1 << lobes) - 1:
                break
        for lobe in range(lobes):
            weight[lobe, c] = best[lobe]
        total += lowest
    return total


@scalar
def data_gradient(gram: Floats, cross: Floats, lobes: int, weight: Floats, scale: float, gradient: Floats) -> None:
    """Fill `gradient` (3L,) of the distance times `scale` by the parameters; weights are at their best."""
    for lobe in range(lobes):
        for p in range(3):
            at = lobes + 3 * lobe + p
            total = 0.0
            for c in range(3):
                residual = -cross[at, c]
                for other in range(lobes):
                    residual += weight[other, c] * gram[at, other]
                total += weight[lobe, c] * residual
            gradient[3 * lobe + p] = 2.0 * scale * total


@scalar
def data_hessian(gram: Floats, lobes: int, weight: Floats, scale: float, hessian: Floats) -> None:
    """Fill the lower triangle of `hessian` (3L, 3L): that of Gauss and Newton, with the weights eliminated."""
    size = 3 * lobes
    for i in range(size):
        for j in range(i + 1):
            product = 0.0
            for c in range(3):
                product += weight[i // 3, c] * weight[j // 3, c]
            hessian[i, j] = 2.0 * scale * product * gram[lobes + i, lobes + j]
    small, columns = np.empty((3, 3)), np.empty((size, 3))
    chosen = np.empty(3, np.int64)
    for c in range(3):
        count = 0
        for lobe in range(lobes):
            if weight[lobe, c] > 0.0:
                chosen[count] = lobe
                count += 1
        for i in range(count):
            for j in range(i + 1):
                small[i, j] = gram[chosen[i], chosen[j]]
        if count == 0 or not cholesky(small, count):
            continue
        for i in range(size):
            for k in range(count):
                entry = weight[i // 3, c] * gram[lobes + i, chosen[k]]
                for m in range(k):
                    entry -= small[k, m] * columns[i, m]
                columns[i, k] = entry / small[k, k]
        for i in range(size):
            for j in range(i + 1):
                for k in range(count):
                    hessian[i, j] -= 2.0 * scale * columns[i, k] * columns[j, k]


@scalar
def pulls_value(pull: Floats, arrangements: Floats, mean: Floats, sigma: Floats) -> float:
    """The energies beside the distance that depend on one view.

    `pull` (L + 1, 4): for each lobe the mean and width that neighbouring views draw it to; then the strengths of both,
    and delta. `arrangements` (K, P, 3): of K neighbouring vertices the differences of means of the P pairs of lobes.
    """
    lobes = len(sigma)
    total = 0.0
    for lobe in range(lobes):
        for axis in range(3):
            total += pull[lobes, 0] * (mean[lobe, axis] - pull[lobe, axis]) ** 2
        total += pull[lobes, 1] * (sigma[lobe] - pull[lobe, 3]) ** 2
    return total + pull[lobes, 2] * spatial_value(arrangements, mean)


@scalar
def spatial_value(arrangements: Floats, mean: Floats) -> float:
    """Green2006 Eq. 10 with the square outside the max, where it bends: Σ max(−⟨a, b⟩, 0)² over pairs and
    neighbours."""
    total = 0.0
    for near in range(len(arrangements)):
        pair = 0
        for one in range(len(mean)):
            for other in range(one + 1, len(mean)):
                product = 0.0
                for axis in range(3):
                    product += (mean[one, axis] - mean[other, axis]) * arrangements[near, pair, axis]
                if product < 0.0:
                    total += product * product
                pair += 1
    return total


@scalar
def add_pulls(
    pull: Floats, arrangements: Floats, mean: Floats, sigma: Floats, axes: Floats, gradient: Floats, hessian: Floats
) -> None:
    """Add the derivatives of `pulls_value` to those of the distance."""
    lobes = len(sigma)
    for lobe in range(lobes):
        along = 0.0
        for axis in range(3):
            along += mean[lobe, axis] * pull[lobe, axis]
        for p in range(2):
            at, slope = 3 * lobe + p, 0.0
            for axis in range(3):
                slope -= axes[lobe, p, axis] * pull[lobe, axis]
            gradient[at] += 2.0 * pull[lobes, 0] * sigma[lobe] * slope
            hessian[at, at] += 2.0 * pull[lobes, 0] * sigma[lobe] ** 2 * max(along, 0.0)
        at = 3 * lobe + 2
        gradient[at] += 2.0 * pull[lobes, 1] * (sigma[lobe] - pull[lobe, 3]) * sigma[lobe]
        hessian[at, at] += 2.0 * pull[lobes, 1] * sigma[lobe] ** 2
    if pull[lobes, 2] > 0.0:
        _add_spatial(pull[lobes, 2], arrangements, mean, sigma, axes, gradient, hessian)


@scalar
def _add_spatial(
    delta: float, arrangements: Floats, mean: Floats, sigma: Floats, axes: Floats, gradient: Floats, hessian: Floats
) -> None:
    slope = np.empty(3 * len(sigma))
    for near in range(len(arrangements)):
        pair = 0
        for one in range(len(mean)):
            for other in range(one + 1, len(mean)):
                difference = arrangements[near, pair]
                pair += 1
                product = 0.0
                for axis in range(3):
                    product += (mean[one, axis] - mean[other, axis]) * difference[axis]
                if product >= 0.0:
                    continue
                for i in range(len(slope)):
                    slope[i] = 0.0
                for p in range(2):
                    for axis in range(3):
                        slope[3 * one + p] += sigma[one] * axes[one, p, axis] * difference[axis]
                        slope[3 * other + p] -= sigma[other] * axes[other, p, axis] * difference[axis]
                for i in range(len(slope)):
                    gradient[i] += 2.0 * delta * product * slope[i]
                    for j in range(i + 1):
                        hessian[i, j] += 2.0 * delta * slope[i] * slope[j]


@scalar
def move(mean: Floats, sigma: Floats, axes: Floats, step: Floats, new_mean: Floats, new_sigma: Floats) -> None:
    """The lobes after a step (3L,), none longer than `LONGEST` or steeper than `STEEPEST`, widths within bounds."""
    for lobe in range(len(sigma)):
        across, along = step[3 * lobe] * sigma[lobe], step[3 * lobe + 1] * sigma[lobe]
        length = math.sqrt(across * across + along * along)
        if length > LONGEST:
            across, along = across * LONGEST / length, along * LONGEST / length
        square = 0.0
        for axis in range(3):
            place = mean[lobe, axis] + across * axes[lobe, 0, axis] + along * axes[lobe, 1, axis]
            new_mean[lobe, axis] = place
            square += place * place
        for axis in range(3):
            new_mean[lobe, axis] /= math.sqrt(square)
        steep = min(max(step[3 * lobe + 2], -STEEPEST), STEEPEST)
        new_sigma[lobe] = min(max(sigma[lobe] * math.exp(steep), NARROWEST), WIDEST_LOBE)


@scalar
def refine(
    direction: Floats,
    value: Floats,
    area: Floats,
    square: float,
    scale: float,
    pull: Floats,
    arrangements: Floats,
    mean: Floats,
    sigma: Floats,
    weight: Floats,
    iterations: int,
) -> tuple[float, float]:
    """Lower the energy of one view in place, by so many steps at most; returns what it was and what it is.

    Parameters
    ----------
    direction, value, area : the samples (S, ...). square : the integral of the square of the data.
    scale : what the distance counts times. pull, arrangements : as in `pulls_value`.
    mean, sigma, weight : (L, 3), (L,), (L, 3); the weights that are given do not matter.
    """
    lobes = len(sigma)
    size = 3 * lobes
    axes, new_axes = np.empty((lobes, 2, 3)), np.empty((lobes, 2, 3))
    functions = np.empty(4 * lobes)
    gram, new_gram = np.empty((4 * lobes, 4 * lobes)), np.empty((4 * lobes, 4 * lobes))
    cross, new_cross = np.empty((4 * lobes, 3)), np.empty((4 * lobes, 3))
    new_mean, new_sigma, new_weight = np.empty((lobes, 3)), np.empty(lobes), np.empty((lobes, 3))
    gradient, step = np.empty(size), np.empty(size)
    hessian, damped = np.empty((size, size)), np.empty((size, size))
    moments(direction, value, area, mean, sigma, axes, functions, gram, cross)
    distance = scale * (square + best_weights(gram, cross, lobes, weight))
    while not is_resolved(gram, sigma, weight) and _widen(sigma):
        moments(direction, value, area, mean, sigma, axes, functions, gram, cross)
        distance = scale * (square + best_weights(gram, cross, lobes, weight))
    energy = distance + pulls_value(pull, arrangements, mean, sigma)
    before = energy
    damping, tries, fresh = 1e-3, 0, True
    while tries < iterations:
        if fresh:
            data_gradient(gram, cross, lobes, weight, scale, gradient)
            data_hessian(gram, lobes, weight, scale, hessian)
            add_pulls(pull, arrangements, mean, sigma, axes, gradient, hessian)
            _hold_bounds(sigma, gradient, hessian)
            fresh = False
        promised = _step(gradient, hessian, damping, damped, step)
        if promised <= ENOUGH * energy or promised <= ROUNDING * scale * square:
            break
        tries += 1
        move(mean, sigma, axes, step, new_mean, new_sigma)
        moments(direction, value, area, new_mean, new_sigma, new_axes, functions, new_gram, new_cross)
        distance = scale * (square + best_weights(new_gram, new_cross, lobes, new_weight))
        new_energy = distance + pulls_value(pull, arrangements, new_mean, new_sigma)
        if new_energy < energy and is_resolved(new_gram, new_sigma, new_weight):
            fresh = True
            damping = max(damping * (0.2 if energy - new_energy > 0.25 * promised else 1.0), 1e-9)
            energy = new_energy
            copy_lobes(new_mean, new_sigma, new_weight, mean, sigma, weight)
            gram, new_gram = new_gram, gram
            cross, new_cross = new_cross, cross
            axes, new_axes = new_axes, axes
        else:
            damping *= 8.0
            if damping > 1e8:
                break
    return before, energy


@scalar
def _widen(sigma: Floats) -> bool:
    """Make all lobes wider by a quarter; False where none can be."""
    possible = False
    for lobe in range(len(sigma)):
        possible = possible or sigma[lobe] < WIDEST_LOBE
        sigma[lobe] = min(1.25 * sigma[lobe], WIDEST_LOBE)
    return possible


@scalar
def _hold_bounds(sigma: Floats, gradient: Floats, hessian: Floats) -> None:
    """Let no width that is at a bound leave it by the next step."""
    for lobe in range(len(sigma)):
        at = 3 * lobe + 2
        outwards = (sigma[lobe] <= NARROWEST and gradient[at] > 0.0) or (
            sigma[lobe] >= WIDEST_LOBE and gradient[at] < 0.0
        )
        if outwards:
            gradient[at] = 0.0
            for j in range(at):
                hessian[at, j] = 0.0
            for i in range(at + 1, len(gradient)):
                hessian[i, at] = 0.0


@scalar
def _step(gradient: Floats, hessian: Floats, damping: float, damped: Floats, step: Floats) -> float:
    """Fill the damped step; returns by how much the quadratic model falls."""
    size = len(gradient)
    largest = 0.0
    for i in range(size):
        largest = max(largest, hessian[i, i])
    while True:
        for i in range(size):
            for j in range(i):
                damped[i, j] = hessian[i, j]
            damped[i, i] = hessian[i, i] * (1.0 + damping) + 1e-12 * largest + 1e-300
            step[i] = -gradient[i]
        if cholesky(damped, size):
            break
        damping = max(damping, 1e-12) * 10.0
        if damping > 1e12:
            return 0.0
    solve(damped, size, step)
    promised = 0.0
    for i in range(size):
        row = 0.5 * hessian[i, i] * step[i]
        for j in range(i):
            row += hessian[i, j] * step[j]
        promised -= step[i] * (gradient[i] + row)
    return promised
