"""Kernels of the power-law fit: the global minimum over K of sum_i (s_i - k x_i^K)^2, x_i = i / (S - 1), per texel.

The SSE depends on the samples only through the correlation c(K) = sum s_i x_i^K, and on the positions through the
energy E(K) = sum x_i^2K: it is k^2 E - 2 k c and a constant. Kautz2004 Sec. 5 try K with a large step, and
again with a small one near the best. Here the large step is a product with tabulated x_i^K, and Halley's iteration
replaces the small one. Where the grid shows two minima both are followed
(`test_P10_minima_that_the_grid_confuses_are_both_followed`).

Bounded by arithmetic: per texel and channel 27 S multiply-adds on the grid and mostly 2 S exponentials. Everything
runs on `LANES` texels and channels side by side, in loops that compilers turn into vector instructions: no branches,
one work array whose parts lie at constant distances, and an exponential in plain arithmetic. No lane looks at
another, so tiles and threads do not change the result.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import parallel, prange, scalar

#: Outcome for a texel and channel: regular, black throughout, K held at 0 or at its cap, or k held at its limit.
REGULAR, BLACK, FLAT, CAPPED, HELD = range(5)

#: Largest k in units of the brightest slice, clipped or not, where the last slice does not count: one dark sample below
#: clipped ones would fit any k.
MAX_EXTRAPOLATED = 4.0

#: The grid starts at K = 0 with steps of START * RATIO; further on its steps are RATIO of K.
START, RATIO = 0.05, 0.3

#: Halley's iteration converges cubically: after a step that is this share of K it is exact to rounding. Halving
#: ends at the second size.
LAST_STEP, LAST_HALVING = 3e-6, 1e-14
MAX_STEPS = 60

#: A second minimum is followed where its SSE is this near to the lowest, in squares of the brightest sample.
MARGIN = 0.01

LANES = 96

INVERSE_FACTORIALS = tuple(1.0 / math.factorial(order) for order in range(13))

#: Parts of the work array of `scan`: the node before, whether the SSE falls towards it, and the two lowest minima: SSE
#: and place on the grid.
BEFORE, FALLS, FIRST, FIRST_PLACE, SECOND, SECOND_PLACE, SCANNED = (part * LANES for part in range(7))

#: Parts of the work array of `polish`: K, its bracket, k, the SSE less its constant, whether the iteration goes on, and
#: c and E with their first three derivatives.
AT, LOW, HIGH, SCALE, VALUE, BUSY, C, C1, C2, C3, E, E1, E2, E3, POLISHED = (part * LANES for part in range(15))


def largest_exponent(slices: int) -> float:
    """Cap of K: there the slice below the brightest, and so every darker one, is below 1/1024 of the scale."""
    return max(128.0, 7.0 * (slices - 1))


def exponent_grid(slices: int) -> NDArray[np.float64]:
    """(G,) trial exponents from 0 to the cap. Two slices do not determine K: then it is 1."""
    if slices == 2:
        return np.ones(1)
    top = math.log1p(largest_exponent(slices) / START)
    return START * np.expm1(np.linspace(0.0, top, math.ceil(top / RATIO) + 1))


def log_positions(slices: int) -> NDArray[np.float64]:
    """(S - 1,) ln x_i of the slices above the black one."""
    return np.log(np.arange(1, slices) / (slices - 1))


@scalar
def exponential(x: float) -> float:
    """e^x for -700 <= x <= 0, to 2 ulp, in arithmetic alone: 2^n e^r with |r| <= ln 2 / 2 and a Taylor series.

    Adding 1.5 * 2^52 rounds to an integer, which then stands in the low bits of the sum.
    """
    shifted = x * 1.4426950408889634 + 6755399441055744.0
    whole = shifted - 6755399441055744.0
    r = (x - whole * 0.6931471803691238) - whole * 1.9082149292705877e-10
    series = INVERSE_FACTORIALS[12]
    for order in range(11, -1, -1):
        series = series * r + INVERSE_FACTORIALS[order]
    bits = (np.float64(shifted).view(np.int64) + 1023) << 52
    return series * np.int64(bits).view(np.float64)


@scalar
def scan(samples: np.ndarray, counts: np.ndarray, free: np.ndarray, grid: np.ndarray, powers: np.ndarray) -> np.ndarray:
    """The two lowest minima of the SSE on the grid: (SCANNED,) float32, in the parts that are named above.

    In single precision, which is enough to see where they are. Samples (n, LANES) have a brightest of 1, counts and
    `powers` (n, G), x_i^K, are float32 too; `free` (LANES,) is 1 where k is fitted to each K.
    """
    last = samples.shape[0] - 1
    whole = counts.min() > 0.0
    minima = np.zeros(SCANNED, np.float32)
    minima[BEFORE : BEFORE + LANES] = np.inf
    minima[FALLS : FALLS + LANES] = 1.0
    minima[FIRST : FIRST + LANES] = np.inf
    minima[SECOND : SECOND + LANES] = np.inf
    cross = np.empty(LANES, np.float32)
    objective = np.empty((grid.size, LANES), np.float32)
    for node in range(grid.size):
        value = objective[node]
        cross[:] = 0.0
        value[:] = 0.0
        for i in range(last + 1):
            power = powers[i, node]
            for lane in range(LANES):
                cross[lane] += samples[i, lane] * power
            if whole:
                value[0] += power * power
            else:
                for lane in range(LANES):
                    value[lane] += counts[i, lane] * power * power
        if whole:
            value[:] = value[0]
        for lane in range(LANES):
            c, e, k = cross[lane], value[lane], samples[last, lane]
            value[lane] = -c * c / e if free[lane] > 0.0 else k * (k * e - c - c)
        remember(value, np.float32(node - 1), minima)
    cross[:] = np.inf
    remember(cross, np.float32(grid.size - 1), minima)
    for lane in range(LANES):
        minima[FIRST_PLACE + lane] += vertex(objective, int(minima[FIRST_PLACE + lane]), lane)
        minima[SECOND_PLACE + lane] += vertex(objective, int(minima[SECOND_PLACE + lane]), lane)
    return minima


@scalar
def vertex(objective: np.ndarray, node: int, lane: int) -> np.float32:
    """Vertex of the parabola through a node and its neighbours, in nodes from it; 0 at the ends."""
    if not 0 < node < objective.shape[0] - 1:
        return np.float32(0.0)
    before, here, after = objective[node - 1, lane], objective[node, lane], objective[node + 1, lane]
    bend = (before - here) + (after - here)
    return np.float32(0.5) * (before - after) / bend if bend > 0.0 else np.float32(0.0)


@scalar
def remember(value: np.ndarray, node: np.float32, minima: np.ndarray) -> None:
    """Record the two lowest minima: if `value` rises after falling, the node before it was a minimum."""
    for lane in range(LANES):
        before = minima[BEFORE + lane]
        first, second = minima[FIRST + lane], minima[SECOND + lane]
        first_node, second_node = minima[FIRST_PLACE + lane], minima[SECOND_PLACE + lane]
        minimum = (minima[FALLS + lane] > 0.0) & (value[lane] >= before)
        lowest = minimum & (before < first)
        next_lowest = minimum & (before < second)
        minima[SECOND + lane] = first if lowest else before if next_lowest else second
        minima[SECOND_PLACE + lane] = first_node if lowest else node if next_lowest else second_node
        minima[FIRST + lane] = before if lowest else first
        minima[FIRST_PLACE + lane] = node if lowest else first_node
        minima[FALLS + lane] = np.float32(1.0) if value[lane] < before else np.float32(0.0)
        minima[BEFORE + lane] = value[lane]


@scalar
def differentiate(samples: np.ndarray, counts: np.ndarray, log_x: np.ndarray, work: np.ndarray) -> None:
    """Write c, E and their first three derivatives at K into `work`."""
    last = samples.shape[0] - 1
    work[C1 : C3 + LANES] = 0.0
    work[E1 : E3 + LANES] = 0.0
    for lane in range(LANES):
        work[C + lane] = samples[last, lane]
        work[E + lane] = counts[last, lane]
    for i in range(last):
        log_power = log_x[i]
        for lane in range(LANES):
            power = exponential(max(-700.0, work[AT + lane] * log_power))
            c = samples[i, lane] * power
            e = counts[i, lane] * power * power
            work[C + lane] += c
            work[E + lane] += e
            c *= log_power
            e *= 2.0 * log_power
            work[C1 + lane] += c
            work[E1 + lane] += e
            c *= log_power
            e *= 2.0 * log_power
            work[C2 + lane] += c
            work[E2 + lane] += e
            work[C3 + lane] += c * log_power
            work[E3 + lane] += e * (2.0 * log_power)


@scalar
def step(free: np.ndarray, grid: np.ndarray, work: np.ndarray) -> None:
    """One bracketed step of Halley's iteration towards the minimum of the SSE.

    It seeks the zero of F = k E'/2 - c', which has the sign of d SSE / dK; where k is `free`, so k = c / E and its own
    change drops out of F, that of E F. No step is longer than the grid's there, so the basin is not left. Where the
    iteration is of no use, the step goes to the middle of the bracket, or downhill to an end of the grid.
    """
    lowest, highest = grid[0], grid[grid.size - 1]
    for lane in range(LANES):
        at, low, high = work[AT + lane], work[LOW + lane], work[HIGH + lane]
        c, c1, c2, c3 = work[C + lane], work[C1 + lane], work[C2 + lane], work[C3 + lane]
        e, e1, e2, e3 = work[E + lane], work[E1 + lane], work[E2 + lane], work[E3 + lane]
        fixed = work[SCALE + lane]
        own = free[lane]
        a = own * c + (1.0 - own) * fixed
        b = own * e + (1.0 - own)
        k = c / e if own > 0.0 else fixed
        f = 0.5 * a * e1 - c1 * b
        f1 = 0.5 * a * e2 - 0.5 * own * c1 * e1 - c2 * b
        f2 = 0.5 * a * e3 - 1.5 * own * c2 * e1 - c3 * b
        high = at if f > 0.0 else high
        low = low if f > 0.0 else at
        slope = f1 - 0.5 * f * f2 / (f1 if f1 > 0.0 else 1.0)
        target = at - f / (slope if slope > 0.0 else 1.0)
        inside = (f1 > 0.0) & (slope > 0.0) & (target >= low) & (target <= high)
        near = START + at
        end = high if f < 0.0 else low
        untried = ((f < 0.0) & (high == highest)) | ((f > 0.0) & (low == lowest))
        wanted = target if inside else end if untried else 0.5 * (low + high)
        move = 0.0 if f == 0.0 else min(max(wanted - at, -RATIO * near), RATIO * near)
        work[VALUE + lane] = k * (k * e - 2.0 * c)
        work[SCALE + lane] = k + own * move * (c1 - k * e1) / e
        work[AT + lane] = at + move
        work[LOW + lane] = low
        work[HIGH + lane] = high
        work[BUSY + lane] = 1.0 if abs(move) > (LAST_STEP * near if inside else LAST_HALVING) else 0.0


@scalar
def polish(
    samples: np.ndarray, counts: np.ndarray, free: np.ndarray, places: np.ndarray, grid: np.ndarray, log_x: np.ndarray
) -> np.ndarray:
    """Follow each lane from its place on the grid to the minimum: (POLISHED,) with K, k and SSE less its constant."""
    last = samples.shape[0] - 1
    work = np.empty(POLISHED)
    for lane in range(LANES):
        node = int(places[lane])
        work[AT + lane] = grid[node] + (places[lane] - node) * (grid[min(node + 1, grid.size - 1)] - grid[node])
        work[LOW + lane] = grid[0]
        work[HIGH + lane] = grid[grid.size - 1]
        work[SCALE + lane] = samples[last, lane]
    for _ in range(MAX_STEPS):
        differentiate(samples, counts, log_x, work)
        step(free, grid, work)
        if work[BUSY : BUSY + LANES].max() == 0.0:
            break
    return work


@scalar
def polish_second(
    samples: np.ndarray,
    counts: np.ndarray,
    free: np.ndarray,
    minima: np.ndarray,
    grid: np.ndarray,
    log_x: np.ndarray,
    work: np.ndarray,
) -> None:
    """Follow the second minimum of the grid too, where it is nearly as low, and keep it in `work` where it is lower."""
    lanes = np.flatnonzero(minima[SECOND : SECOND + LANES] <= minima[FIRST : FIRST + LANES] + np.float32(MARGIN))
    if lanes.size == 0:
        return
    packed, packed_counts = np.zeros(samples.shape), np.ones(samples.shape)
    packed_free, places = np.zeros(LANES), np.zeros(LANES, np.float32)
    for place in range(lanes.size):
        lane = lanes[place]
        packed[:, place] = samples[:, lane]
        packed_counts[:, place] = counts[:, lane]
        packed_free[place] = free[lane]
        places[place] = minima[SECOND_PLACE + lane]
    second = polish(packed, packed_counts, packed_free, places, grid, log_x)
    for place in range(lanes.size):
        if second[VALUE + place] < work[VALUE + lanes[place]]:
            for part in (AT, SCALE, VALUE):
                work[part + lanes[place]] = second[part + place]


@scalar
def fit_lanes(
    samples: np.ndarray,
    counts: np.ndarray,
    held: np.ndarray,
    least_squares: bool,
    grid: np.ndarray,
    log_x: np.ndarray,
    powers: np.ndarray,
) -> np.ndarray:
    """Fit LANES texels and channels: (POLISHED,) with K, k and the SSE of what counts.

    Parameters
    ----------
    samples : (S - 1, LANES) float64 >= 0, the slices above the black one; 0 where a sample does not count.
    counts : (S - 1, LANES) float64, 1 where a sample counts and 0 elsewhere, at least one of each column.
    held : (LANES,) bool, k is the last sample whatever the choice of k.
    least_squares : k minimises the SSE; else k is the last sample, unless that is 0 or does not count.
    grid, log_x : `exponent_grid`, `log_positions`. powers : (S - 1, G) float32, x_i^K on the grid.
    """
    last = samples.shape[0] - 1
    free, brightest, constant = np.empty(LANES), np.zeros(LANES), np.zeros(LANES)
    for i in range(last + 1):
        for lane in range(LANES):
            sample = samples[i, lane]
            brightest[lane] = sample if sample > brightest[lane] else brightest[lane]
            constant[lane] += sample * sample
    normalised = np.empty(samples.shape, np.float32)
    for i in range(last + 1):
        for lane in range(LANES):
            normalised[i, lane] = samples[i, lane] / (brightest[lane] if brightest[lane] > 0.0 else 1.0)
    for lane in range(LANES):
        free[lane] = 1.0 if (least_squares and not held[lane]) or samples[last, lane] == 0.0 else 0.0
    minima = scan(normalised, counts.astype(np.float32), free, grid, powers)
    work = polish(samples, counts, free, minima[FIRST_PLACE : FIRST_PLACE + LANES], grid, log_x)
    polish_second(samples, counts, free, minima, grid, log_x, work)
    for lane in range(LANES):
        work[VALUE + lane] = max(0.0, constant[lane] + work[VALUE + lane])
        if brightest[lane] == 0.0:
            work[AT + lane], work[SCALE + lane] = 1.0, 0.0
    return work


@scalar
def load(
    slices: np.ndarray, excluded: np.ndarray, row: int, left: int, samples: np.ndarray, counts: np.ndarray
) -> bool:
    """Fill the lanes from a row of slices; True where the SSE of what counts is that of the slices themselves.

    A negative sample counts as 0; one that is excluded or not finite does not count, but where fewer than two would
    remain all count.
    """
    plain = True
    samples[:] = 0.0
    counts[:] = 1.0
    for lane in range(min(LANES, slices.shape[2] - left)):
        column = left + lane
        plain &= slices[0, row, column] == 0.0
        used = 0
        for i in range(samples.shape[0]):
            sample = slices[i + 1, row, column]
            use = math.isfinite(sample) and not (excluded.shape[1] > 0 and excluded[i + 1, row, column // 3])
            used += use
            plain &= use and sample >= 0.0
            counts[i, lane] = use
            samples[i, lane] = sample if use and sample > 0.0 else 0.0
        if used < 2:
            for i in range(samples.shape[0]):
                sample = slices[i + 1, row, column]
                counts[i, lane] = 1.0
                samples[i, lane] = sample if math.isfinite(sample) and sample > 0.0 else 0.0
    return plain


@scalar
def hold(
    slices: np.ndarray, row: int, left: int, samples: np.ndarray, counts: np.ndarray, held: np.ndarray, work: np.ndarray
) -> np.bool_:
    """Let k be its limit where it lies above and the last slice does not count; True where it is so anywhere."""
    last = samples.shape[0] - 1
    for lane in range(min(LANES, slices.shape[2] - left)):
        brightest = np.float32(0.0)
        for i in range(samples.shape[0]):
            sample = slices[i + 1, row, left + lane]
            if math.isfinite(sample) and sample > brightest:
                brightest = sample
        limit = MAX_EXTRAPOLATED * brightest
        if counts[last, lane] == 0.0 and work[SCALE + lane] > limit:
            samples[last, lane], counts[last, lane], held[lane] = limit, 1.0, True
    return held.any()


@scalar
def measure(slices: np.ndarray, row: int, left: int, log_x: np.ndarray, work: np.ndarray) -> None:
    """Replace the SSE of what counts by that of all slices."""
    for lane in range(min(LANES, slices.shape[2] - left)):
        total = np.float64(slices[0, row, left + lane]) ** 2
        for i in range(log_x.size):
            fitted = work[SCALE + lane] * math.exp(work[AT + lane] * log_x[i])
            total += (slices[i + 1, row, left + lane] - fitted) ** 2
        work[VALUE + lane] = total


@parallel
def fit_rows(
    slices: np.ndarray,
    excluded: np.ndarray,
    least_squares: bool,
    grid: np.ndarray,
    log_x: np.ndarray,
    start: int,
    stop: int,
    scale: np.ndarray,
    exponent: np.ndarray,
    squares: np.ndarray,
    outcomes: np.ndarray,
) -> None:
    """Fit rows [start, stop) of a shading map.

    Parameters
    ----------
    slices : (S, H, 3 W) float32. excluded : (S, H, W) bool, samples that do not count, or (S, 0, 0) for none.
    grid, log_x : `exponent_grid`, `log_positions`.
    scale, exponent : (H, 3 W) float32, written.
    squares : (>= stop - start, 3 W) float32, written: of each row that is fitted, the sum over all slices of
        (slice - k x^K)^2.
    outcomes : (H, 5) int64, zero at first, written: how often each outcome occurs in a row.
    """
    count, width = slices.shape[0] - 1, slices.shape[2]
    powers = np.empty((count, grid.size), np.float32)
    for i in range(count):
        for node in range(grid.size):
            powers[i, node] = math.exp(grid[node] * log_x[i])
    for row in prange(start, stop):
        samples, counts = np.empty((count, LANES)), np.empty((count, LANES))
        for left in range(0, width, LANES):
            plain = load(slices, excluded, row, left, samples, counts)
            held = np.zeros(LANES, np.bool_)
            work = fit_lanes(samples, counts, held, least_squares, grid, log_x, powers)
            if not plain and hold(slices, row, left, samples, counts, held, work):
                work = fit_lanes(samples, counts, held, least_squares, grid, log_x, powers)
            if not plain:
                measure(slices, row, left, log_x, work)
            for lane in range(min(LANES, width - left)):
                k, at = work[SCALE + lane], work[AT + lane]
                outcome = BLACK if k == 0.0 else FLAT if at == 0.0 else CAPPED if at == grid[-1] else REGULAR
                outcome = HELD if held[lane] else outcome
                outcomes[row, outcome] += 1
                scale[row, left + lane] = k
                exponent[row, left + lane] = at
                squares[row - start, left + lane] = work[VALUE + lane]
