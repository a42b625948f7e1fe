"""Sums of radial basis functions through scattered points, with symmetries, and in boxes where there are many.

    g(x) = Σ_j a_j K(x, x_j)          K(x, y) = mean over the symmetries s of φ(|x − s y| / δ)

Kernels φ: Wendland's (1995), positive definite in up to five dimensions: (1 − r)³₊, or (1 − r)⁵₊(5r + 1), which is
smooth. A symmetry negates some of the coordinates; its signs are +1 and −1.
Above `PATCH_SAMPLES` samples the domain is split into overlapping boxes, each with its own expansion, blended by a
smooth partition of unity (Wendland2005); boxes are split only along coordinates that no symmetry negates,
so that the blend is as symmetric as K. Interpolation and the leave-one-out formula (Rippa1999) carry over exactly.

scipy's RBFInterpolator knows neither symmetries nor leave-one-out errors nor condition numbers, and its only remedy
for many samples, nearest neighbours, is not continuous.
Cost: matrices are bound by their Cholesky factors, evaluation by the distances to the samples, and their images, of one
to four boxes, about 1.2 ns each.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from engine.core.kernels import parallel, prange, scalar
from engine.core.one_thread import one_thread

Floats = NDArray[np.float64]

#: Most samples that one expansion is made of.
PATCH_SAMPLES = 1600

#: Most samples of a box that is not split, and its reach beyond its sides, in their length.
_LEAF_SAMPLES = 600
_OVERLAP = 0.15

#: Reach of the kernels in the coordinates, several times the domain.
_REACH = 4.0


class Solved(NamedTuple):
    """Weights (N, 3), what each sample misses the others by (N, 3), and the condition number in the 1-norm."""

    weights: Floats
    residual: Floats
    condition: float


def solve(matrix: Floats, targets: Floats, smoothing: float) -> Solved | None:
    """The expansion through `targets` (N, 3) with the matrix K (N, N), which gets the ridge `smoothing` in place.

    None where the matrix is singular to rounding.
    """
    matrix[np.diag_indices_from(matrix)] += smoothing
    # Threads that wait for each other take ten times as long where the CPUs are busy otherwise.
    with one_thread():
        factor, failed = lapack.dpotrf(matrix, lower=1, clean=1)
        if failed:
            return None
        lower = lapack.dpotri(factor, lower=1)[0]  # a third of the work of solving for the unit matrix
        inverse = lower + np.tril(lower, -1).T
        if not np.isfinite(inverse).all():
            return None
        weights = lapack.dpotrs(factor, targets, lower=1)[0]
        weights += lapack.dpotrs(factor, targets - matrix @ weights, lower=1)[0]
    condition = float(np.abs(matrix).sum(axis=0).max() * np.abs(inverse).sum(axis=0).max())
    return Solved(weights, weights / np.diag(inverse)[:, None], condition)


class Box(NamedTuple):
    """A box with sides `low` to `high` (D,), endless where infinite, that fades out over `margin` (D,) beyond them."""

    low: Floats
    high: Floats
    margin: Floats

    def weight(self, points: Floats) -> Floats:
        """Weights (N,) before they are made to sum to 1."""
        outside = np.maximum(np.maximum(self.low - points, points - self.high), 0.0) / self.margin
        rest = np.maximum(1.0 - outside, 0.0)
        weights: Floats = np.prod(rest * rest * (3.0 - 2.0 * rest), axis=1)
        return weights


@scalar
def _fade(outside: float) -> float:
    """1 at the side of a box, 0 where its margin ends, with slope 0 at both."""
    rest = max(1.0 - outside, 0.0)
    return rest * rest * (3.0 - 2.0 * rest)


def boxes(points: Floats, signs: Floats) -> Iterator[Box]:
    """Boxes that tile all space, split at medians until each holds at most `_LEAF_SAMPLES` of the points (N, D).

    They are split along coordinates that no symmetry negates, by its `signs` (G, D).
    """
    axes = np.flatnonzero((signs > 0.0).all(axis=0))
    dimensions = points.shape[1]
    endless = np.full(dimensions, np.inf)
    if len(points) <= PATCH_SAMPLES:
        yield Box(-endless, endless, np.ones(dimensions))
        return
    stack = [(-endless, endless, np.arange(len(points)))]
    while stack:
        low, high, members = stack.pop()
        inside = points[members]
        extent = np.ptp(inside, axis=0)
        axis = axes[np.argmax(extent[axes])]
        middle = float(np.median(inside[:, axis]))
        left = inside[:, axis] <= middle
        if len(members) <= _LEAF_SAMPLES or left.all():
            yield Box(low, high, np.maximum(_OVERLAP * extent, 1e-3))
            continue
        below, above = high.copy(), low.copy()
        below[axis] = above[axis] = middle
        stack += [(low, below, members[left]), (above, high, members[~left])]


class Expansion(NamedTuple):
    """The expansion of one box: its samples by number, their weights, and what each misses the others by."""

    box: Box
    members: NDArray[np.intp]
    weights: Floats
    residual: Floats
    condition: float


def expand(
    points: Floats,
    targets: Floats,
    signs: Floats,
    smooth: bool,
    smoothing: float,
    box: Box,
    members: NDArray[np.intp],
) -> Expansion:
    """The expansion in one box, whose samples lie at `points` (N, D) and have the values `targets` (N, 3).

    Where the matrix is singular to rounding, the least ridge that mends it is added to `smoothing`.
    """
    ridge = 0.0
    while True:
        found = solve(kernel_matrix(points, signs, smooth), targets, smoothing + ridge)
        if found is not None:
            return Expansion(box, members, found.weights, found.residual, found.condition)
        ridge = max(10.0 * ridge, 1e-13 * len(points))


def compute_blended_residual(points: Floats, expansions: list[Expansion]) -> Floats:
    """(N, 3) what each of `points` (N, D) misses the prediction from all others by, in the blend of all boxes."""
    channels = expansions[0].residual.shape[1]
    sums, weights = np.zeros((len(points), channels)), np.zeros((len(points), 1))
    for expansion in expansions:
        weight = expansion.box.weight(points[expansion.members])[:, None]
        sums[expansion.members] += weight * expansion.residual
        weights[expansion.members] += weight
    return sums / weights


@dataclass(frozen=True, eq=False)
class Patches:
    """All boxes in one piece, as the kernel wants them.

    `centres` (5, M) are the samples of box after box with all their images, weights (3, M) divided by the number of
    images; those of box b are starts[b] … starts[b + 1]. Sides and margins are (B, 5).
    """

    low: Floats
    high: Floats
    margin: Floats
    starts: NDArray[np.int64]
    centres: Floats
    weights: Floats

    @staticmethod
    def of(points: Floats, expansions: list[Expansion], signs: Floats) -> Patches:
        centres = [(points[part.members] * image) for part in expansions for image in signs]
        weights = [part.weights / len(signs) for part in expansions for _ in signs]
        counts = [len(signs) * len(part.members) for part in expansions]
        return Patches(
            _five(np.array([part.box.low for part in expansions]), -np.inf),
            _five(np.array([part.box.high for part in expansions]), np.inf),
            _five(np.array([part.box.margin for part in expansions]), 1.0),
            np.cumsum([0, *counts]).astype(np.int64),
            np.ascontiguousarray(_five(np.concatenate(centres), 0.0).T),
            np.ascontiguousarray(np.concatenate(weights).T),
        )

    def evaluate(self, points: Floats, smooth: bool) -> Floats:
        """The blended sums (N, 3) at points (N, D); neighbours are taken together, for they share their boxes."""
        points = _five(points, 0.0)
        order = np.argsort(_homes(points, self.low, self.high), kind="stable")
        sums = np.empty((len(points), 3))
        _blend(points[order], self.low, self.high, self.margin, self.starts, self.centres, self.weights, smooth, sums)
        out = np.empty_like(sums)
        out[order] = sums
        return out


def _five(points: Floats, filling: float) -> Floats:
    """Points (N, D) with `filling` for the coordinates that they have not."""
    return np.pad(points, ((0, 0), (0, 5 - points.shape[1])), constant_values=filling)


def kernel_matrix(points: Floats, signs: Floats, smooth: bool) -> Floats:
    """K (N, N) of points (N, D) with each other."""
    out = np.zeros((len(points), len(points)))
    images = np.stack([np.ascontiguousarray(_five(points * image, 0.0).T) for image in signs])
    _matrix(_five(points, 0.0), images, smooth, out)
    return out


@scalar
def _phi(squared: float, smooth: bool) -> float:
    """The kernel for a squared distance."""
    r = np.sqrt(squared) / _REACH
    q = max(1.0 - r, 0.0)
    cube = q * q * q
    return cube * q * q * (5.0 * r + 1.0) if smooth else cube


@parallel
def _matrix(points: Floats, images: Floats, smooth: bool, out: Floats) -> None:
    for row in prange(points.shape[0]):
        a, b, c, d, e = points[row]
        for image in range(images.shape[0]):
            for column in range(points.shape[0]):
                squared = (
                    (a - images[image, 0, column]) ** 2
                    + (b - images[image, 1, column]) ** 2
                    + (c - images[image, 2, column]) ** 2
                    + (d - images[image, 3, column]) ** 2
                    + (e - images[image, 4, column]) ** 2
                )
                out[row, column] += _phi(squared, smooth) / images.shape[0]


@parallel
def _homes(points: Floats, low: Floats, high: Floats) -> NDArray[np.int64]:
    """The first box (N,) in which each point lies."""
    homes = np.zeros(points.shape[0], np.int64)
    for query in prange(points.shape[0]):
        for box in range(low.shape[0]):
            inside = True
            for axis in range(5):
                inside &= low[box, axis] <= points[query, axis] <= high[box, axis]
            if inside:
                homes[query] = box
                break
    return homes


@parallel
def _blend(
    points: Floats,
    low: Floats,
    high: Floats,
    margin: Floats,
    starts: NDArray[np.int64],
    centres: Floats,
    weights: Floats,
    smooth: bool,
    out: Floats,
) -> None:
    # Sixteen points at a time: the inner loop over them has no sum across its turns and becomes vector instructions.
    for tile in prange((points.shape[0] + 15) // 16):
        first, count = 16 * tile, min(16, points.shape[0] - 16 * tile)
        x, sums, share, total = np.zeros((5, 16)), np.zeros((3, 16)), np.zeros(16), np.zeros(16)
        blended = np.zeros((3, 16))
        for lane in range(count):
            for axis in range(5):
                x[axis, lane] = points[first + lane, axis]
        for box in range(low.shape[0]):
            touched = False
            for lane in range(count):
                share[lane] = 1.0
                for axis in range(5):
                    outside = max(low[box, axis] - x[axis, lane], x[axis, lane] - high[box, axis])
                    if outside > 0.0:
                        share[lane] *= _fade(outside / margin[box, axis])
                touched |= share[lane] > 0.0
            if not touched:
                continue
            sums[:] = 0.0
            for centre in range(starts[box], starts[box + 1]):
                a, b, c = centres[0, centre], centres[1, centre], centres[2, centre]
                d, e = centres[3, centre], centres[4, centre]
                red, green, blue = weights[0, centre], weights[1, centre], weights[2, centre]
                for lane in range(16):
                    squared = (
                        (x[0, lane] - a) ** 2
                        + (x[1, lane] - b) ** 2
                        + (x[2, lane] - c) ** 2
                        + (x[3, lane] - d) ** 2
                        + (x[4, lane] - e) ** 2
                    )
                    value = _phi(squared, smooth)
                    sums[0, lane] += value * red
                    sums[1, lane] += value * green
                    sums[2, lane] += value * blue
            for lane in range(count):
                total[lane] += share[lane]
                for channel in range(3):
                    blended[channel, lane] += share[lane] * sums[channel, lane]
        for lane in range(count):
            for channel in range(3):
                out[first + lane, channel] = blended[channel, lane] / total[lane]
