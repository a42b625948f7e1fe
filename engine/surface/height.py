"""Height from slopes: the Poisson equation weighted with the uncertainty of each slope.

The height h minimises Σ w (Δh − s)² over all pairs of neighbours, s being the mean of the slopes of both and w the
inverse of its variance: a slope that shadows or highlights hide counts for little. The normal equations are
Dᵀ W D h = Dᵀ W s, solved by conjugate gradients. Equal weights make them an equation that cosine transforms solve
exactly (Frankot1988 does so with Fourier transforms and nothing else): it is the start and the preconditioner. Scaling
it by the weights of each texel would mix fine detail of the weights into broad waves of the height, which then converge
last. The mean of the height is zero; its plane is that of the slopes.

Pairs of neighbours across a depth edge (`engine.surface.depth_edges`) have the weight zero, so that the height steps
there and obeys the slopes of each side (Queau2018 compares ways to keep such steps, all of which look for them in the
slopes alone). The equations then leave the height of each region open by a constant, for which the one is taken that
makes the steps along its borders smallest; what is known of the step is nothing.

Bound by the transforms: two for each iteration, some 0.2 s per megatexel. Memory: nine arrays in double precision.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage

from engine.core.steps import Step, Steps, part
from engine.surface.bands import filter_in_bands, smooth
from engine.surface.depth_edges import Division
from engine.surface.height_kernel import add_product, apply_normal, divide_by_eigenvalues, sum_products

Array = NDArray[np.float64]

#: Error over that of a flat surface, in the norm of slopes, at which iterations end, and their number at most.
TOLERANCE, ITERATIONS = 1e-4, 200

#: Variances are kept within these multiples of their median.
RANGE = (0.05, 1e3)

#: Texels over which errors of slopes are taken to be alike, and rows above and below that such a mean of differences of
#: neighbours depends on.
ALIKE, AROUND = 2.0, 9

#: Columns that are transformed at a time, a whole number of pages of each row.
BLOCK = 1024

#: Deviation of a lens's blur in texels, of a photograph that keeps half the contrast of 0.42 periods per texel.
LENS = 0.45

#: Texels around a region, beside a quarter of its size, in which it is solved for.
MARGIN = 8

#: Surfaces that are drawn for the uncertainty, and the longer side in which they are solved.
DRAWN, COARSE = 12, 192


def height_from_slopes(
    right: Array, up: Array, variance: Array, division: Division | None = None, start: Array | None = None
) -> Steps[Array]:
    """(H, W) height in widths of a texel, of mean zero.

    `right` and `up` (H, W) are dh/dx and dh/dy, x to the right of the image and y up; `variance` (H, W) is that of
    either, inf where a slope is not known. Where there is a `division`, the height may step between its regions and
    along its edges. `start` (H, W) is a height from which the iterations start.
    """
    across, down = _weights(variance, division)
    wanted_across = 0.5 * (right[:, :-1] + right[:, 1:])
    wanted_down = -0.5 * (up[:-1] + up[1:])
    if division is None:
        height = yield from _solve(across, down, wanted_across, wanted_down, start)
        return np.asarray(height - height.mean())
    height = np.zeros_like(right)
    boxes = ndimage.find_objects(division.region + 1)
    done, total = 0, sum(_count_texels(box) for box in boxes)
    for number, box in enumerate(boxes):
        # each region by itself, in a box in which its height can go on: equal weights then resemble those of the region
        rows, columns = (_widen(side, size) for side, size in zip(box, right.shape, strict=True))
        inside = division.region[rows, columns] == number
        beside, below = (rows, slice(columns.start, columns.stop - 1)), (slice(rows.start, rows.stop - 1), columns)
        solving = _solve(
            across[beside] * (inside[:, :-1] & inside[:, 1:]),
            down[below] * (inside[:-1] & inside[1:]),
            wanted_across[beside],
            wanted_down[below],
            None if start is None else start[rows, columns],
        )
        found = yield from part(solving, done / total, (done + _count_texels(box)) / total)
        height[rows, columns][inside] = found[inside]
        done += _count_texels(box)
    height = _level(height, division)
    return np.asarray(height - height.mean())


def _count_texels(box: tuple[slice, ...]) -> int:
    return math.prod(side.stop - side.start for side in box)


def _widen(side: slice, size: int) -> slice:
    """A side of a box with `MARGIN` more at both ends, and a quarter of its length, within `size`."""
    more = MARGIN + (side.stop - side.start) // 4
    return slice(max(side.start - more, 0), min(side.stop + more, size))


def _solve(across: Array, down: Array, wanted_across: Array, wanted_down: Array, start: Array | None) -> Steps[Array]:
    """The height (H, W), but for a constant, whose steps to the right and below are nearest to those that are wanted,
    by the weights `across` (H, W − 1) and `down` (H − 1, W)."""

    residual = _divergence(across * wanted_across, down * wanted_down)
    enough = TOLERANCE**2 * sum_products(residual, _solve_evenly(residual))
    if start is None:
        height = _solve_evenly(
            _divergence(np.where(across > 0.0, wanted_across, 0.0), np.where(down > 0.0, wanted_down, 0.0))
        )
    else:
        height = start.copy()
    applied, direction, before = np.empty_like(height), np.zeros_like(height), 1.0
    apply_normal(across, down, height, applied)
    residual -= applied
    for iteration in range(ITERATIONS):
        yield Step(iteration / ITERATIONS, "solving for the height")
        conditioned = _solve_evenly(residual)
        now = sum_products(residual, conditioned)
        if now <= enough:
            break
        direction *= now / before if iteration else 0.0
        direction += conditioned
        before = now
        apply_normal(across, down, direction, applied)
        step = now / sum_products(direction, applied)
        add_product(height, step, direction)
        add_product(residual, -step, applied)
    return height


def _solve_evenly(flow: Array) -> Array:
    """The height (H, W) of a flow (H, W) for equal weights.

    Columns are transformed, divided and transformed back a block at a time, which reads the pages of an array that lies
    in a file but once.
    """
    spectrum = flow.copy()
    _transform(fft.dct, spectrum, 1)
    for first in range(0, spectrum.shape[1], BLOCK):
        block = spectrum[:, first : first + BLOCK]
        _transform(fft.dct, block, 0)
        divide_by_eigenvalues(spectrum, first, first + block.shape[1])
        _transform(fft.idct, block, 0)
    _transform(fft.idct, spectrum, 1)
    return spectrum


def _transform(transform: Callable[..., Array], values: Array, axis: int) -> None:
    """Transform `values` along an axis in place."""
    found = transform(values, axis=axis, norm="ortho", workers=2, overwrite_x=True)
    if not np.may_share_memory(found, values):
        values[:] = found


def disagreement(
    height: Array, right: Array, up: Array, variance: Array, division: Division | None = None
) -> tuple[Array, Array]:
    """(H, W) factor, 1 or more, by which squared errors of slopes exceed their `variance`, as the height shows, and the
    largest difference (H, W) between a step of the height to a neighbour and the slope, in widths of a texel.

    Slopes of a surface are those of some height: of the two slopes of a texel one is checked by its neighbours, so the
    squared residuals of the height over their variances are on average a half where errors are as stated. Across the
    edges of a `division` nothing is compared.
    """
    across = np.diff(height, axis=1) - 0.5 * (right[:, :-1] + right[:, 1:])
    down = np.diff(height, axis=0) + 0.5 * (up[:-1] + up[1:])
    weights = _weights(variance, division)
    total, number, largest = np.zeros_like(height), np.zeros_like(height), np.zeros_like(height)
    for off, weight, ends in (
        (across, weights[0], np.s_[:, 1:]),
        (across, weights[0], np.s_[:, :-1]),
        (down, weights[1], np.s_[1:]),
        (down, weights[1], np.s_[:-1]),
    ):
        total[ends] += off * off * weight
        number[ends] += weight > 0.0
        np.maximum(largest[ends], np.where(weight > 0.0, np.abs(off), 0.0), out=largest[ends])

    def average(total: Array, number: Array) -> Array:
        blurred = smooth(total / np.maximum(number, 1.0), ALIKE)
        if division is not None:
            blurred /= np.maximum(smooth((number > 0.0).astype(np.float64), ALIKE), 0.05)
        return np.asarray(blurred)

    blurred = filter_in_bands(average, AROUND, total, number)
    return np.maximum(2.0 * blurred, 1.0), largest


def lens_variance(values: NDArray[np.float32], blur: float = LENS**2) -> NDArray[np.float32]:
    """(H, W) variance of a map (H, W) by what a lens has mixed into each texel from its neighbours.

    A Gaussian of the variance σ² = `blur`, in squared texels, adds σ²/2 ∇²x to x.
    """

    def measure(values: NDArray[np.float32]) -> NDArray[np.float32]:
        bend = 0.5 * blur * ndimage.laplace(values, mode="nearest")
        return np.asarray(smooth(bend * bend, ALIKE), np.float32)

    return np.asarray(filter_in_bands(measure, AROUND, values))


def shift_variance(values: NDArray[np.float32], shift: float) -> NDArray[np.float32]:
    """(H, W) variance of a map (H, W) that may lie beside its place by the standard deviation `shift`, in texels."""

    def measure(values: NDArray[np.float32]) -> NDArray[np.float32]:
        squares = np.sum([np.square(np.gradient(values, axis=axis)) for axis in (0, 1)], axis=0)
        return np.asarray(0.5 * shift**2 * smooth(squares, ALIKE), np.float32)

    return np.asarray(filter_in_bands(measure, AROUND, values))


def estimate_unresolved(slope: NDArray[np.float32], blur: float = LENS**2) -> NDArray[np.float32]:
    """(H, W) that GGX alpha² seems to grow by, as slopes (H, W, 2) differ within what a lens and a texel show as one.

    Slopes of Beckmann's facets, as which those of GGX are taken here, have the variance alpha²/2 along each axis, to
    which the surface's own adds (Olano2010): a gradient g is the variance (σ² + 1/12) g² to a Gaussian of the variance
    σ² = `blur` and a square of side 1.
    """

    def measure(slope: NDArray[np.float32]) -> NDArray[np.float32]:
        squares = np.sum(
            [np.square(np.gradient(slope[..., of], axis=along)) for of in (0, 1) for along in (0, 1)], axis=0
        )
        return np.asarray((blur + 1.0 / 12.0) * smooth(squares, ALIKE), np.float32)

    return np.asarray(filter_in_bands(measure, AROUND, slope))


def height_deviation(variance: Array, division: Division | None = None) -> Steps[Array]:
    """(H, W) standard deviation of the height where slopes have independent errors of `variance` (H, W).

    Slopes are drawn and solved for on a coarse grid, since errors of height are broad; half a texel's own slope is
    added. Errors that many texels share, such as those of a lamp's direction, are not in it. Where there is a
    `division`, each region is measured from its own mean. On its edges the deviation is inf, since nothing tells which
    side a texel shows.
    """
    height, width = variance.shape
    factor = max(1, -(-max(height, width) // COARSE))
    variance = _bound(variance)
    if division is None:
        coarse, smaller = _pool(variance, factor) / factor**2, None
    else:
        coarse, smaller = _pool_known(variance, division.edges, factor) / factor**2, _pool_division(division, factor)
    random = np.random.default_rng(1)
    squares = np.zeros_like(coarse)
    for draw in range(DRAWN):
        right, up = np.sqrt(coarse) * random.standard_normal((2, *coarse.shape))
        solving = height_from_slopes(right, up, coarse, smaller)
        solved = yield from part(solving, draw / DRAWN, (draw + 1) / DRAWN)
        if smaller is not None:
            solved = solved - _mean_by_region(solved, smaller.region)[smaller.region]
        squares += solved**2
    spread = ndimage.gaussian_filter(squares / DRAWN, 0.02 * max(coarse.shape), mode="nearest") * factor**2
    broad = _enlarge(spread, factor, height, width)
    found = np.asarray(np.sqrt(broad + 0.25 * variance))
    return found if division is None else np.where(division.edges, np.inf, found)


def measure_relief(height: Array, division: Division | None) -> Array:
    """(H, W) root of 0.7 times the square of the height from the mean of its region and 0.3 times that of its root mean
    square: what flattens a relief also moves its mean."""
    region = np.zeros(height.shape, np.int32) if division is None else division.region
    squares = (height - _mean_by_region(height, region)[region]) ** 2
    return np.asarray(np.sqrt(0.7 * squares + 0.3 * _mean_by_region(squares, region)[region]))


def _enlarge(values: Array, factor: int, rows: int, columns: int) -> Array:
    """Values of cells of `factor` texels at each of (rows, columns) texels, linear in between."""
    place = [
        np.clip((np.arange(size) + 0.5) / factor - 0.5, 0, count - 1)
        for size, count in zip((rows, columns), values.shape, strict=True)
    ]
    return np.asarray(ndimage.map_coordinates(values, np.meshgrid(*place, indexing="ij"), order=1))


def _pool(values: Array, factor: int) -> Array:
    """Means of cells of `factor` texels; the last cells repeat the border."""
    rows, columns = (-(-size // factor) for size in values.shape)
    padded = np.pad(values, ((0, rows * factor - values.shape[0]), (0, columns * factor - values.shape[1])), "edge")
    return np.asarray(padded.reshape(rows, factor, columns, factor).mean(axis=(1, 3)))


def _pool_known(values: Array, edges: NDArray[np.bool_], factor: int) -> Array:
    """The same without texels on edges; the median of all where there is no other."""
    whole = 1.0 - _pool(edges.astype(np.float64), factor)
    found = _pool(np.where(edges, 0.0, values), factor) / np.maximum(whole, 1e-9)
    return np.where(whole > 0.01, found, float(np.median(found)))


def _pool_division(division: Division, factor: int) -> Division:
    """The division of cells of `factor` texels; an edge through a cell takes at least half a row of it."""
    share = _pool(division.edges.astype(np.float64), factor)
    middle = [np.minimum(np.arange(0, size, factor) + factor // 2, size - 1) for size in division.region.shape]
    return Division(share * factor > 0.5, division.region[np.ix_(*middle)])


def _bound(variance: Array) -> Array:
    known = variance[np.isfinite(variance)]
    middle = float(np.median(known)) if known.size else 1.0
    return np.clip(variance, RANGE[0] * middle + 1e-12, RANGE[1] * middle + 1e-9)


def _weights(variance: Array, division: Division | None) -> tuple[Array, Array]:
    """Weights of pairs of neighbours beside each other and below each other; 0 across edges of a division."""
    variance = _bound(variance)
    across = _weight(variance[:, :-1], variance[:, 1:])
    down = _weight(variance[:-1], variance[1:])
    if division is not None:
        region, whole = division.region, ~division.edges
        across *= (region[:, :-1] == region[:, 1:]) & whole[:, :-1] & whole[:, 1:]
        down *= (region[:-1] == region[1:]) & whole[:-1] & whole[1:]
    return across, down


def _level(height: Array, division: Division) -> Array:
    """The height (H, W) with texels on edges as those next to them, and with each region raised so that squared steps
    between regions are least."""
    from scipy.sparse import coo_matrix, identity
    from scipy.sparse.linalg import spsolve

    region, edges = division.region, division.edges
    if edges.any() and not edges.all():
        nearest = ndimage.distance_transform_edt(edges, return_distances=False, return_indices=True)
        height, region = height[tuple(nearest)], region[tuple(nearest)]
    count = int(region.max()) + 1
    if count == 1:
        return height
    steps, pairs = [], []
    for one, other in ((np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1])):
        border = region[one] != region[other]
        steps.append((height[one] - height[other])[border])
        pairs.append(np.stack([region[one][border], region[other][border]]))
    (first, second), step = np.concatenate(pairs, axis=1), np.concatenate(steps)
    between = coo_matrix((np.ones(len(step)), (first, second)), (count, count))
    between = (between + between.T).tocsr()
    number = np.arange(count)
    matrix = coo_matrix((np.asarray(between.sum(axis=1)).ravel(), (number, number))) - between
    wanted = np.bincount(second, step, count) - np.bincount(first, step, count)
    raised = np.asarray(spsolve((matrix + 1e-9 * identity(count)).tocsc(), wanted)).reshape(count)
    return np.asarray(height + raised[region])


def _mean_by_region(values: Array, region: NDArray[np.int32]) -> Array:
    """(K,) mean of values (H, W) in each region, 0 for one without a texel."""
    return np.bincount(region.ravel(), values.ravel()) / np.maximum(np.bincount(region.ravel()), 1)


def _weight(one: Array, other: Array) -> Array:
    """Inverse variance of the mean of two slopes."""
    return np.asarray(4.0 / (one + other))


def _divergence(across: Array, down: Array) -> Array:
    """Dᵀ of flows between neighbours."""
    result = np.zeros((across.shape[0], down.shape[1]))
    result[:, 1:] += across
    result[:, :-1] -= across
    result[1:] += down
    result[:-1] -= down
    return result
