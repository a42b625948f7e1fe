"""Height from slopes: the Poisson equation weighted with the uncertainty of each slope.

The height h minimises Σ w (Δh − s)² over all pairs of neighbours, s being the mean of the slopes of both and w the
inverse of its variance: a slope that shadows or highlights hide counts for little. The normal equations are
Dᵀ W D h = Dᵀ W s, solved by conjugate gradients. Equal weights make them an equation that cosine transforms solve
exactly (Frankot1988 does so with Fourier transforms and nothing else): it is the start and the preconditioner. Scaling
it by the weights of each texel would mix fine detail of the weights into broad waves of the height, which then converge
last. The mean of the height is zero; its plane is that of the slopes.

Bound by the transforms: two for each iteration, some 0.2 s per megatexel. Memory: seven arrays in double precision.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage

from engine.core.steps import Step, Steps, part

Array = NDArray[np.float64]

#: Error over that of a flat surface, in the norm of slopes, at which iterations end, and their number at most.
TOLERANCE, ITERATIONS = 1e-4, 200

#: Variances are kept within these multiples of their median.
RANGE = (0.05, 1e3)

#: Texels over which errors of slopes are taken to be alike.
ALIKE = 2.0

#: Deviation of a lens's blur in texels, of a photograph that keeps half the contrast of 0.42 periods per texel.
LENS = 0.45

#: Surfaces that are drawn for the uncertainty, and the longer side in which they are solved.
DRAWN, COARSE = 12, 192


def height_from_slopes(right: Array, up: Array, variance: Array) -> Steps[Array]:
    """(H, W) height in widths of a texel, of mean zero.

    `right` and `up` (H, W) are dh/dx and dh/dy, x to the right of the image and y up; `variance` (H, W) is that of
    either, inf where a slope is not known.
    """
    variance = _bound(variance)
    across = _weight(variance[:, :-1], variance[:, 1:])
    down = _weight(variance[:-1], variance[1:])
    wanted_across = 0.5 * (right[:, :-1] + right[:, 1:])
    wanted_down = -0.5 * (up[:-1] + up[1:])
    inverse = _inverse_eigenvalues(*right.shape)

    def evenly(flow: Array) -> Array:
        """The solution for equal weights."""
        return np.asarray(fft.idctn(inverse * fft.dctn(flow, norm="ortho", workers=2), norm="ortho", workers=2))

    height = evenly(_divergence(wanted_across, wanted_down))
    flat = _divergence(across * wanted_across, down * wanted_down)
    enough = TOLERANCE**2 * float((flat * evenly(flat)).sum())
    residual = flat - _divergence(across * np.diff(height, axis=1), down * np.diff(height, axis=0))
    direction, before = np.zeros_like(height), 1.0
    for iteration in range(ITERATIONS):
        yield Step(iteration / ITERATIONS, "solving for the height")
        conditioned = evenly(residual)
        now = float((residual * conditioned).sum())
        if now <= enough:
            break
        direction = conditioned + (now / before if iteration else 0.0) * direction
        before = now
        applied = _divergence(across * np.diff(direction, axis=1), down * np.diff(direction, axis=0))
        step = now / float((direction * applied).sum())
        height += step * direction
        residual -= step * applied
    return np.asarray(height - height.mean())


def disagreement(height: Array, right: Array, up: Array, variance: Array) -> Array:
    """(H, W) factor, 1 or more, by which squared errors of slopes exceed their `variance`, as the height shows.

    Slopes of a surface are those of some height: of the two slopes of a texel one is checked by its neighbours, so the
    squared residuals of the height over their variances are on average a half where errors are as stated.
    """
    variance = _bound(variance)
    across = np.diff(height, axis=1) - 0.5 * (right[:, :-1] + right[:, 1:])
    down = np.diff(height, axis=0) + 0.5 * (up[:-1] + up[1:])
    across *= across * _weight(variance[:, :-1], variance[:, 1:])
    down *= down * _weight(variance[:-1], variance[1:])
    total, number = np.zeros_like(height), np.zeros_like(height)
    for squares, ends in ((across, np.s_[:, 1:]), (across, np.s_[:, :-1]), (down, np.s_[1:]), (down, np.s_[:-1])):
        total[ends] += squares
        number[ends] += 1.0
    blurred = ndimage.gaussian_filter(total / np.maximum(number, 1.0), ALIKE, mode="nearest")
    return np.maximum(2.0 * blurred, 1.0)


def lens_variance(values: NDArray[np.float32], blur: float = LENS**2) -> NDArray[np.float32]:
    """(H, W) variance of a map (H, W) by what a lens has mixed into each texel from its neighbours.

    A Gaussian of the variance σ² = `blur`, in squared texels, adds σ²/2 ∇²x to x.
    """
    bend = 0.5 * blur * ndimage.laplace(values, mode="nearest")
    return np.asarray(ndimage.gaussian_filter(bend * bend, ALIKE, mode="nearest"), np.float32)


def shift_variance(values: NDArray[np.float32], shift: float) -> NDArray[np.float32]:
    """(H, W) variance of a map (H, W) that may lie beside its place by the standard deviation `shift`, in texels."""
    squares = sum(np.square(np.gradient(values, axis=axis)) for axis in (0, 1))
    return np.asarray(0.5 * shift**2 * ndimage.gaussian_filter(squares, ALIKE, mode="nearest"), np.float32)


def estimate_unresolved(slope: NDArray[np.float32], blur: float = LENS**2) -> NDArray[np.float32]:
    """(H, W) that GGX alpha² seems to grow by, as slopes (H, W, 2) differ within what a lens and a texel show as one.

    Slopes of Beckmann's facets, as which those of GGX are taken here, have the variance alpha²/2 along each axis, to
    which the surface's own adds (Olano2010): a gradient g is the variance (σ² + 1/12) g² to a Gaussian of the variance
    σ² = `blur` and a square of side 1.
    """
    squares = sum(np.square(np.gradient(slope[..., of], axis=along)) for of in (0, 1) for along in (0, 1))
    return np.asarray((blur + 1.0 / 12.0) * ndimage.gaussian_filter(squares, ALIKE, mode="nearest"), np.float32)


def height_deviation(variance: Array) -> Steps[Array]:
    """(H, W) standard deviation of the height where slopes have independent errors of `variance` (H, W).

    Slopes are drawn and solved for on a coarse grid, since errors of height are broad; half a texel's own slope is
    added. Errors that many texels share, such as those of a lamp's direction, are not in it.
    """
    height, width = variance.shape
    factor = max(1, -(-max(height, width) // COARSE))
    variance = _bound(variance)
    rows, columns = -(-height // factor), -(-width // factor)
    padded = np.pad(variance, ((0, rows * factor - height), (0, columns * factor - width)), "edge")
    coarse = padded.reshape(rows, factor, columns, factor).mean(axis=(1, 3)) / factor**2
    random = np.random.default_rng(1)
    squares = np.zeros_like(coarse)
    for draw in range(DRAWN):
        right, up = np.sqrt(coarse) * random.standard_normal((2, *coarse.shape))
        solving = height_from_slopes(right, up, coarse)
        squares += (yield from part(solving, draw / DRAWN, (draw + 1) / DRAWN)) ** 2
    spread = ndimage.gaussian_filter(squares / DRAWN, 0.02 * max(coarse.shape), mode="nearest") * factor**2
    place = [
        np.clip((np.arange(size) + 0.5) / factor - 0.5, 0, count - 1)
        for size, count in ((height, rows), (width, columns))
    ]
    broad = ndimage.map_coordinates(spread, np.meshgrid(*place, indexing="ij"), order=1)
    return np.asarray(np.sqrt(broad + 0.25 * variance))


def _bound(variance: Array) -> Array:
    known = variance[np.isfinite(variance)]
    middle = float(np.median(known)) if known.size else 1.0
    return np.clip(variance, RANGE[0] * middle + 1e-12, RANGE[1] * middle + 1e-9)


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


def _inverse_eigenvalues(rows: int, columns: int) -> Array:
    """Inverse eigenvalues of Dᵀ D for cosines (H, W), 0 for the mean."""
    by_row = 2.0 - 2.0 * np.cos(np.pi * np.arange(rows) / rows)
    by_column = 2.0 - 2.0 * np.cos(np.pi * np.arange(columns) / columns)
    values = by_row[:, None] + by_column[None, :]
    values[0, 0] = np.inf
    return np.asarray(1.0 / values)
