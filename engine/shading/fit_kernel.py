"""Kernels of the power-law fit: the global minimum over K of sum_i (s_i - k x_i^K)^2, x_i = i / (S - 1), per texel.

The SSE depends on the samples only through the correlation c(K) = sum s_i x_i^K, and on the positions through the
energy E(K) = sum x_i^2K: it is k^2 E - 2 k c and a constant. Kautz et al. 2004, section 5 try K with a large step, and
again with a small one near the best. Here the large step is a product with tabulated x_i^K. Around each minimum on
that grid c and E are Taylor series in K, whose coefficients are one more small product with a table, and Newton's
iteration on them replaces the small step: K is exact to rounding, and no exponential is evaluated per texel. Where
the grid shows several minima each is followed and the lowest kept (`test_P10_the_lower_of_two_minima_is_found`).

Bounded by arithmetic: some 100 S multiply-adds per texel and channel, in float64. Every texel is computed by itself,
so tiles and threads do not change the result.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.kernels import parallel, prange, scalar

#: What became of a texel and channel: regular, black throughout, K held at 0 or at its cap, or too few samples for K.
REGULAR, BLACK, FLAT, CAPPED, UNDETERMINED = range(5)

#: The grid starts at K = 0 with a step of START * RATIO; further on its steps are RATIO of K. A series of ORDER terms
#: about a node is exact to (RATIO / 2)^ORDER, 1e-14, half a step away.
START, RATIO, ORDER = 0.05, 0.2, 12

#: Newton converges quadratically: after a step this small K is exact to rounding.
LAST_STEP = 1e-6
MOST_STEPS = 60


class Tables(NamedTuple):
    """What the fit of every texel shares; n = S - 1 slices above the black one, G trial exponents."""

    exponents: NDArray[np.float64]  #: (G,) from 0 to the cap
    powers: NDArray[np.float64]  #: (n, G) x_i^K
    series: NDArray[np.float64]  #: (G, ORDER, n) Taylor coefficients of x_i^(K + d) in d
    squares: NDArray[np.float64]  #: (G, ORDER, n) those of its square
    unit: int  #: the node nearest K = 1


def largest_exponent(slices: int) -> float:
    """Cap of K: there the slice below the brightest, and so every darker one, is below 1/1024 of the scale."""
    return max(128.0, 7.0 * (slices - 1))


def tabulate(slices: int) -> Tables:
    """The tables for a shading map of `slices` slices; a few hundred kilobytes."""
    top = math.log1p(largest_exponent(slices) / START)
    exponents = START * np.expm1(np.linspace(0.0, top, math.ceil(top / RATIO) + 1))
    log_x = np.log(np.arange(1, slices) / (slices - 1))
    orders = np.arange(ORDER)[:, None]
    factorials = np.cumprod(np.maximum(orders, 1), axis=0)
    powers = np.exp(np.outer(log_x, exponents))
    series = powers.T[:, None] * (log_x**orders / factorials)
    squares = powers.T[:, None] ** 2 * ((2.0 * log_x) ** orders / factorials)
    return Tables(exponents, powers, series, squares, int(np.abs(exponents - 1.0).argmin()))


@scalar
def scan(samples, use, scale, free, tables, objective, energy):  # type: ignore[no-untyped-def]
    """Write the SSE, less its constant, at every trial exponent into `objective`; `energy` is work space."""
    for node in range(objective.size):
        objective[node] = 0.0
        energy[node] = 0.0
    for i in range(samples.size):
        if use[i]:
            sample = samples[i]
            for node in range(objective.size):
                power = tables.powers[i, node]
                objective[node] += sample * power
                energy[node] += power * power
    for node in range(objective.size):
        cross = objective[node]
        if free:
            objective[node] = -cross * cross / energy[node]
        else:
            objective[node] = scale * (scale * energy[node] - 2.0 * cross)


@scalar
def expand(samples, use, node, tables, cross, energy):  # type: ignore[no-untyped-def]
    """Write the (ORDER,) Taylor coefficients of c and E about a trial exponent."""
    for order in range(ORDER):
        c, e = 0.0, 0.0
        for i in range(samples.size):
            if use[i]:
                c += samples[i] * tables.series[node, order, i]
                e += tables.squares[node, order, i]
        cross[order] = c
        energy[order] = e


@scalar
def evaluate(coefficients, offset):  # type: ignore[no-untyped-def]
    """A polynomial with its first and second derivative."""
    value, slope, half_curvature = 0.0, 0.0, 0.0
    for order in range(ORDER - 1, -1, -1):
        half_curvature = half_curvature * offset + slope
        slope = slope * offset + value
        value = value * offset + coefficients[order]
    return value, slope, 2.0 * half_curvature


@scalar
def polish(cross, energy, low, offset, high, scale, free):  # type: ignore[no-untyped-def]
    """The minimum about a node by Newton within low <= offset <= high: (offset, k, SSE less its constant).

    F = k E'/2 - c' has the sign of d SSE / dK. A `free` k is c / E, the least-squares scale of that K; how it grows
    with K drops out of F but not of its derivative.
    """
    value = 0.0
    for _ in range(MOST_STEPS):
        c, c1, c2 = evaluate(cross, offset)
        e, e1, e2 = evaluate(energy, offset)
        growth = 0.0
        if free:
            scale = c / e
            growth = (c1 - scale * e1) / e
        value = scale * (scale * e - 2.0 * c)
        first = 0.5 * scale * e1 - c1
        second = 0.5 * (scale * e2 + growth * e1) - c2
        if first > 0.0:
            high = offset
        else:
            low = offset
        step = -first / second if second > 0.0 else math.inf
        last_step = LAST_STEP
        if not low <= offset + step <= high:
            step = 0.5 * (low + high) - offset
            last_step = 0.0
        offset += step
        scale += growth * step
        if abs(step) <= last_step:
            break
    return offset, scale, value


@scalar
def at_boundary(cross, energy, node, end, scale, free):  # type: ignore[no-untyped-def]
    """Whether the SSE rises from K = 0, or falls towards the cap, so that the end of the grid is the minimum."""
    if 0 < node < end:
        return False
    first = 0.5 * (cross[0] / energy[0] if free else scale) * energy[1] - cross[1]
    return first >= 0.0 if node == 0 else first <= 0.0


@scalar
def fit_texel(samples, use, least_squares, tables, work):  # type: ignore[no-untyped-def]
    """Fit one texel and channel: (k, K, node of the grid near K, outcome).

    Parameters
    ----------
    samples : (S - 1,) float64 >= 0, the slices above the black one. use : (S - 1,) bool, which of them count.
    least_squares : k minimises the SSE; else k is the last sample, unless that is 0 or does not count.
    tables : `tabulate(S)`. work : (4, G) float64, work space.
    """
    end = tables.exponents.size - 1
    last, brightest, used = samples.size - 1, 0.0, 0
    for i in range(samples.size):
        if use[i]:
            used += 1
            brightest = max(brightest, samples[i])
    if brightest == 0.0:
        return 0.0, 1.0, tables.unit, BLACK
    if used == 1:
        for i in range(samples.size):
            if use[i]:
                return samples[i] / power(tables, tables.unit, i, 1.0), 1.0, tables.unit, UNDETERMINED
    free = least_squares or not use[last] or samples[last] == 0.0
    objective, cross, energy = work[0], work[2], work[3]
    scan(samples, use, samples[last], free, tables, objective, work[1])
    margin = objective.min() + 0.01 * brightest * brightest
    lowest, scale, exponent, nearest = math.inf, 0.0, 0.0, 0
    for node in range(end + 1):
        if objective[node] > margin:
            continue
        before, here, after = objective[max(node - 1, 0)], objective[node], objective[min(node + 1, end)]
        if (node == 0 or here < before) and here <= after:
            at = tables.exponents[node]
            low, high = tables.exponents[max(node - 1, 0)] - at, tables.exponents[min(node + 1, end)] - at
            expand(samples, use, node, tables, cross, energy)
            offset, k, value = 0.0, samples[last], here
            if at_boundary(cross, energy, node, end, k, free):
                k = cross[0] / energy[0] if free else k
            else:
                bend = before - 2.0 * here + after
                offset = 0.5 * (before - after) / bend * (high if before > after else -low) if bend > 0.0 else 0.0
                offset, k, value = polish(cross, energy, low, offset, high, k, free)
            if value < lowest:
                lowest, scale, exponent, nearest = value, k, at + offset, node
    outcome = FLAT if exponent == 0.0 else CAPPED if exponent == tables.exponents[end] else REGULAR
    return scale, exponent, nearest, outcome


@scalar
def power(tables, node, i, exponent):  # type: ignore[no-untyped-def]
    """x_i^K for K near a node."""
    offset = exponent - tables.exponents[node]
    value = 0.0
    for order in range(ORDER - 1, -1, -1):
        value = value * offset + tables.series[node, order, i]
    return value


@parallel
def fit_rows(slices, excluded, least_squares, tables, start, stop, scale, exponent, squares, outcomes):  # type: ignore[no-untyped-def]
    """Fit rows [start, stop) of a shading map.

    Parameters
    ----------
    slices : (S, H, W, 3) float32; a negative sample counts as 0, one that is not finite does not count.
    excluded : (S, H, W) bool, samples that do not count, or (S, 0, 0) for none; where fewer than two samples would
        remain, all count.
    scale, exponent : (H, W, 3) float32, written.
    squares : (H, W, 3) float32, written: sum over all slices of (slice - k x^K)^2 with the stored k and K.
    outcomes : (H, 5) int64, zero at first, written: how often each outcome occurs in a row.
    """
    count = slices.shape[0] - 1
    for row in prange(start, stop):
        samples = np.empty(count)
        finite = np.empty(count, np.bool_)
        use = np.empty(count, np.bool_)
        work = np.empty((4, max(tables.exponents.size, ORDER)))
        for column in range(slices.shape[2]):
            for channel in range(3):
                kept = 0
                for i in range(count):
                    sample = slices[i + 1, row, column, channel]
                    finite[i] = math.isfinite(sample)
                    samples[i] = sample if finite[i] and sample > 0.0 else 0.0
                    use[i] = finite[i] and not (excluded.shape[1] > 0 and excluded[i + 1, row, column])
                    kept += use[i]
                if kept < 2:
                    use[:] = finite
                k, at, node, outcome = fit_texel(samples, use, least_squares, tables, work)
                scale[row, column, channel] = k
                exponent[row, column, channel] = at
                outcomes[row, outcome] += 1
                k = np.float64(scale[row, column, channel])
                at = np.float64(exponent[row, column, channel])
                total = np.float64(slices[0, row, column, channel]) ** 2
                for i in range(count):
                    residual = slices[i + 1, row, column, channel] - k * power(tables, node, i, at)
                    total += residual * residual
                squares[row, column, channel] = total
