"""The rig that lit a capture: distance of its lamps, intensity of each, and room light, estimated from photographs.

A texel at the position p of the image (widths from its middle) whose albedo times normal is b has, under lamp i in the
direction l_i with the gain g_i, the radiance

    R_i = g_i b·v_i / |v_i|³ + b·a,    v_i = l_i − s p

where s is the inverse of the distance of the lamps in widths and a the room light. b is eliminated texel by texel by
weighted least squares (variable projection, Golub1973); s, log g_i and a follow by Gauss-Newton steps on what remains.
Weights leave out shadows and highlights: first by rank, then by Tukey's biweight, wider below than above.

The normal equations of the log gains are a diagonal less a product of rank three per texel, so that an iteration costs
one matrix product of (N, 3 T) with its transpose: 20 ms for 1500 texels of 64 photographs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: The terms that can be estimated.
TERMS = ("distance", "gains", "ambient")

#: Rounds of reweighting, Gauss-Newton steps in each, and the change of weights' scale at which they end.
ROUNDS, STEPS = 6, 2

#: Biweight: deviations below and above the fit at which a photograph of a texel no longer counts.
BELOW, ABOVE = 4.0, 3.0

#: Prior deviations: of the inverse distance, of the logarithm of gains, and of room light over the lamps.
PRIOR_NEARNESS, PRIOR_GAIN, PRIOR_AMBIENT = 1.0, 0.7, 0.3

#: Largest inverse distance: a lamp at 0.8 widths.
MAX_NEARNESS = 1.25

#: Mean weight below which the gain of a lamp is not heard, and its largest logarithm over the others'.
UNHEARD, MAX_LOG_GAIN = 0.25, 2.0

#: Share of the photographs of a texel, those with the least residuals, that judge a fit.
JUDGED = 0.7


@dataclass(frozen=True, eq=False)
class Sample:
    """Texels of a capture.

    Attributes
    ----------
    values : (T, N) radiance of each texel over its mean over photographs.
    usable : (T, N) where it is not clipped.
    positions : (T, 2) right and up from the middle of the image, in widths of the image.
    brightness : (T,) the means.
    block : (T,) part of the image in which each texel lies, from 0.
    """

    values: Array
    usable: NDArray[np.bool_]
    positions: Array
    brightness: Array
    block: NDArray[np.int64]

    def of(self, chosen: NDArray[np.bool_]) -> Sample:
        """The texels `chosen` (T,)."""
        return Sample(
            self.values[chosen],
            self.usable[chosen],
            self.positions[chosen],
            self.brightness[chosen],
            self.block[chosen],
        )


@dataclass(frozen=True, eq=False)
class Rig:
    """Terms of a rig.

    Attributes
    ----------
    nearness : inverse of the distance of the lamps in widths of the image, 0 for distant ones.
    log_gains : (N,) logarithm of the intensity of each lamp over the geometric mean.
    ambient : (3,) room light as a vector, over the irradiance of a lamp.
    """

    nearness: float
    log_gains: Array
    ambient: Array

    @staticmethod
    def plain(count: int) -> Rig:
        """Distant, equal lamps in a dark room."""
        return Rig(0.0, np.zeros(count), np.zeros(3))


@dataclass(frozen=True, eq=False)
class Fit:
    """A rig fitted to a sample.

    Attributes
    ----------
    rig : the terms.
    albedo_normals : (T, 3) albedo times normal of each texel.
    weights : (T, N) of each photograph of each texel.
    covariance : (K, K) of nearness, ambient (3) and log gains (N), zero for terms that were not fitted; by the scatter
        of scores over blocks of the image, so that errors that neighbours share count.
    """

    rig: Rig
    albedo_normals: Array
    weights: Array
    covariance: Array


def lamp_vectors(directions: Array, positions: Array, nearness: float) -> Array:
    """(T, N, 3) irradiance of each texel by each lamp, as a vector towards the lamp."""
    towards = directions[None] - nearness * np.pad(positions, ((0, 0), (0, 1)))[:, None]
    return np.asarray(towards / (towards**2).sum(axis=-1, keepdims=True) ** 1.5)


def fit(sample: Sample, directions: Array, terms: Sequence[str], start: Rig | None = None) -> Fit:
    """Fit `terms` of a rig whose lamps stand in `directions` (N, 3); the other terms are as in `start`."""
    rig = start or Rig.plain(len(directions))
    weights = _rank(sample)
    free = _free(terms, len(directions))
    for _ in range(ROUNDS):
        heard = free.copy()
        if "gains" in terms:
            unheard = weights.sum(axis=0) < UNHEARD * sample.usable.sum(axis=0)
            rig = _with_unheard(sample, directions, rig, weights, unheard)
            heard[4:] &= ~unheard
        for _ in range(STEPS if free.any() else 0):
            rig, _, _ = _step(sample, directions, rig, weights, heard)
        found, residuals = solve(sample, directions, rig, weights)
        weights = _biweights(sample, residuals)
    covariance = np.zeros((len(free), len(free)))
    if free.any():
        _, inverse, scores = _step(sample, directions, rig, weights, free)
        covariance[np.ix_(free, free)] = inverse @ (scores.T @ scores) @ inverse
    found, _ = solve(sample, directions, rig, weights)
    return Fit(rig, found, weights, covariance)


def _with_unheard(sample: Sample, directions: Array, rig: Rig, weights: Array, unheard: NDArray[np.bool_]) -> Rig:
    """`rig` with gains of lamps that hardly a weight speaks for, by the median over texels: a lamp that is weaker or
    stronger than all others is everywhere at the end of the rank."""
    if not unheard.any():
        return rig
    _, residuals = solve(sample, directions, rig, weights)
    model = sample.values - residuals
    lit = sample.usable & (model > 0.1) & (sample.values > 0.0)
    ratio = np.where(lit, sample.values / np.where(lit, model, 1.0), np.nan)
    log_gains = rig.log_gains.copy()
    for lamp in np.flatnonzero(unheard & (lit.sum(axis=0) > 10)):
        log_gains[lamp] += np.log(np.nanmedian(ratio[:, lamp]))
    return replace(rig, log_gains=np.clip(log_gains - log_gains.mean(), -MAX_LOG_GAIN, MAX_LOG_GAIN))


def solve(sample: Sample, directions: Array, rig: Rig, weights: Array) -> tuple[Array, Array]:
    """Albedo times normal (T, 3) by weighted least squares, and residuals (T, N)."""
    design = _design(sample, directions, rig)
    found = np.asarray(np.linalg.solve(*_normal_equations(design, weights, sample.values))[..., 0], np.float64)
    return found, sample.values - (design @ found[..., None])[..., 0]


def measure_held_out(sample: Sample, directions: Array, rig: Rig, weights: Array | None = None) -> Array:
    """(T, N) residuals of photographs that are left out, each in turn, by the others of its texel."""
    if weights is None:
        weights = _rank(sample)
        for _ in range(ROUNDS):
            weights = _biweights(sample, solve(sample, directions, rig, weights)[1])
    design = _design(sample, directions, rig)
    matrix, right = _normal_equations(design, weights, sample.values)
    inverse = np.linalg.inv(matrix)
    residuals = sample.values - (design @ (inverse @ right))[..., 0]
    leverage = weights * np.einsum("tni,tij,tnj->tn", design, inverse, design, optimize=True)
    return np.asarray(residuals / np.maximum(1.0 - leverage, 0.05))


def typical(residuals: Array, usable: NDArray[np.bool_]) -> Array:
    """(T,) root mean square of the least `JUDGED` of the residuals of each texel, which shadows do not reach."""
    squares = np.sort(np.where(usable, residuals**2, np.inf), axis=1)
    count = np.maximum(1, (JUDGED * usable.sum(axis=1)).astype(np.int64))
    kept = np.arange(squares.shape[1])[None] < count[:, None]
    return np.asarray(np.sqrt(np.where(kept, squares, 0.0).sum(axis=1) / count))


def _design(sample: Sample, directions: Array, rig: Rig) -> Array:
    vectors = lamp_vectors(directions, sample.positions, rig.nearness)
    return np.asarray(vectors * np.exp(rig.log_gains)[None, :, None] + rig.ambient)


def _normal_equations(design: Array, weights: Array, values: Array) -> tuple[Array, Array]:
    weighted = (design * weights[..., None]).swapaxes(1, 2)
    matrix = weighted @ design
    trace = np.einsum("tii->t", matrix)
    matrix += (1e-7 * trace + 1e-12)[:, None, None] * np.eye(3)
    return matrix, weighted @ values[..., None]


def _free(terms: Sequence[str], count: int) -> NDArray[np.bool_]:
    unknown = set(terms) - set(TERMS)
    if unknown:
        raise ValueError(f"unknown terms {sorted(unknown)}; choose from {', '.join(TERMS)}")
    return np.array(["distance" in terms, *["ambient" in terms] * 3, *["gains" in terms] * count])


def _rank(sample: Sample) -> Array:
    """Weights (T, N) without the darkest and the brightest fifth of each texel."""
    usable = sample.usable
    number = usable.sum(axis=1)
    tail = np.where(number - 2 * (number // 5) >= 4, number // 5, 0)
    order = np.argsort(np.where(usable, sample.values, np.inf), axis=1)
    rank = np.empty_like(order)
    np.put_along_axis(rank, order, np.arange(order.shape[1])[None], axis=1)
    return np.asarray((rank >= tail[:, None]) & (rank < (number - tail)[:, None]), np.float64)


def _biweights(sample: Sample, residuals: Array) -> Array:
    usable = np.where(sample.usable, np.abs(residuals), np.nan)
    usable[~sample.usable.any(axis=1)] = 0.0
    deviation = 1.4826 * np.nanmedian(usable, axis=1, keepdims=True)
    deviation = np.maximum(deviation, 2e-3)
    off = residuals / (deviation * np.where(residuals < 0.0, BELOW, ABOVE))
    return np.asarray(np.where(sample.usable & (np.abs(off) < 1.0), (1.0 - off**2) ** 2, 0.0))


def _step(
    sample: Sample, directions: Array, rig: Rig, weights: Array, free: NDArray[np.bool_]
) -> tuple[Rig, Array, Array]:
    """A Gauss-Newton step: the rig, the inverse of its normal equations, and scores (blocks, K) of free parameters."""
    count = len(directions)
    gains = np.exp(rig.log_gains)
    flat = np.pad(sample.positions, ((0, 0), (0, 1)))[:, None]
    towards = directions[None] - rig.nearness * flat
    squared = (towards**2).sum(axis=-1, keepdims=True)
    vectors = towards / squared**1.5
    by_nearness = -flat / squared**1.5 + 3.0 * towards * (towards * flat).sum(axis=-1, keepdims=True) / squared**2.5
    design = vectors * gains[None, :, None] + rig.ambient
    root = np.sqrt(weights)
    matrix, right = _normal_equations(design, weights, sample.values)
    found = np.linalg.solve(matrix, right)[..., 0]
    residuals = root * (sample.values - (design @ found[..., None])[..., 0])
    lower = np.linalg.cholesky(matrix)
    basis = np.linalg.solve(lower, (design * root[..., None]).swapaxes(1, 2))  # (T, 3, N), orthonormal rows
    lit = root * gains * (vectors @ found[..., None])[..., 0]
    dense = np.empty((*lit.shape, 4))
    dense[..., 0] = root * gains * (by_nearness @ found[..., None])[..., 0]
    dense[..., 1:] = root[..., None] * found[:, None]
    along = basis @ dense  # (T, 3, 4)
    along_gains = basis * lit[:, None]  # (T, 3, N)
    normal = np.empty((4 + count, 4 + count))
    flat_gains = along_gains.reshape(-1, count)
    flat_dense = along.reshape(-1, 4)
    normal[:4, :4] = dense.reshape(-1, 4).T @ dense.reshape(-1, 4) - flat_dense.T @ flat_dense
    normal[:4, 4:] = np.einsum("tnk,tn->kn", dense, lit) - flat_dense.T @ flat_gains
    normal[4:, :4] = normal[:4, 4:].T
    normal[4:, 4:] = np.diag((lit**2).sum(axis=0)) - flat_gains.T @ flat_gains
    blocks = int(sample.block.max()) + 1
    scores = np.zeros((blocks, 4 + count))
    np.add.at(scores[:, :4], sample.block, np.einsum("tnk,tn->tk", dense, residuals))
    np.add.at(scores[:, 4:], sample.block, lit * residuals)
    variance = float((residuals**2).sum() / max(weights.sum() - 3.0 * len(found), 1.0)) + 1e-12
    prior = variance / np.array([PRIOR_NEARNESS**2, *[PRIOR_AMBIENT**2] * 3, *[PRIOR_GAIN**2] * count])
    state = np.array([rig.nearness, *rig.ambient, *rig.log_gains])
    normal += np.diag(prior)
    normal[4:, 4:] += float(np.abs(np.diag(normal)[4:]).mean())  # the mean of log gains is that of the albedo
    gradient = scores.sum(axis=0) - prior * state
    inverse = np.asarray(np.linalg.inv(normal[np.ix_(free, free)]), np.float64)
    state[free] += np.clip(inverse @ gradient[free], -0.3, 0.3)
    log_gains = np.clip(state[4:] - state[4:].mean(), -MAX_LOG_GAIN, MAX_LOG_GAIN)
    nearness = float(np.clip(state[0], 0.0, MAX_NEARNESS))
    return replace(rig, nearness=nearness, ambient=state[1:4], log_gains=log_gains), inverse, scores[:, free]
